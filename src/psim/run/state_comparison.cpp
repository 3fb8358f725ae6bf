#include "run/state_comparison.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>

namespace psim::cli {
namespace {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a == 0 && b == 0);
}

double distance(double a, double b) {
  const double difference = std::abs(a - b);
  return std::isnan(difference) ? std::numeric_limits<double>::infinity() : difference;
}

}  // namespace

StateView view_of(const PublishedState& state) {
  return {state.id, {state.x, state.y, state.angle, state.vx, state.vy, state.omega}};
}

std::string difference_text(const FirstDifference& first, std::string_view a, std::string_view b) {
  if (!first.field) {
    return fmt::format("body {} is only in {}", first.body, first.only_in_a ? a : b);
  }
  return fmt::format("body {} {}: {} (0x{:016x}) against {} (0x{:016x})", first.body, kStateFields[*first.field],
                     first.a, std::bit_cast<std::uint64_t>(first.a), first.b, std::bit_cast<std::uint64_t>(first.b));
}

void StateComparison::note(const FirstDifference& difference) {
  if (!first_) first_ = difference;
}

void StateComparison::mark(std::uint32_t body) {
  std::bitset<kChunk>& chunk = marked_[body / kChunk];
  if (!chunk[body % kChunk]) ++differing_bodies_;
  chunk.set(body % kChunk);
}

bool StateComparison::same_body(std::uint64_t frame, const StateView& a, std::size_t row_a, const StateView& b,
                                std::size_t row_b) {
  bool same = true;
  const std::uint32_t body = a.id[row_a];
  for (std::size_t i = 0; i < kStateFields.size(); ++i) {
    const double u = a.fields[i][row_a], v = b.fields[i][row_b];
    if (same_bits(u, v)) continue;
    same = false;
    note({frame, body, i, u, v, false});
    if (i >= kFirstVelocityField && frame == first_->frame) motion_differs_at_first_ = true;
    const double difference = distance(u, v);
    if (difference > largest_[i].difference) largest_[i] = {difference, frame, body};
  }
  return same;
}

bool StateComparison::add(std::uint64_t frame, const StateView& a, const StateView& b) {
  bool same = true;
  const auto differs = [&](std::uint32_t body) {
    same = false;
    mark(body);
  };
  std::size_t i = 0, j = 0;
  while (i < a.id.size() || j < b.id.size()) {
    const bool only_a = j == b.id.size() || (i < a.id.size() && a.id[i] < b.id[j]);
    const bool only_b = i == a.id.size() || (j < b.id.size() && b.id[j] < a.id[i]);
    if (only_a || only_b) {
      const std::uint32_t body = only_a ? a.id[i++] : b.id[j++];
      note({frame, body, std::nullopt, 0, 0, only_a});
      differs(body);
      continue;
    }
    if (!same_body(frame, a, i, b, j)) differs(a.id[i]);
    ++i;
    ++j;
  }
  if (!same) ++differing_frames_;
  return same;
}

}  // namespace psim::cli
