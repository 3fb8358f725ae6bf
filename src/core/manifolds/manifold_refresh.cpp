// What a step makes of all manifolds: strip by strip the pairs are looked at (manifold_look.cpp), and those that are
// contacts go on to the layout.
#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "base/sort_keys.h"
#include "base/tasks.h"
#include "manifolds/manifolds.h"

namespace psim {

// Runs once all pairs of a strip were looked at.
void Manifolds::finish_strip(const ManifoldParams& params, std::size_t index) {
  StripBlocks& strip = strips_[index];
  const std::span<ManifoldPair> pairs(pairs_.data() + begin_[index], count_of(index));
  for (std::size_t k = 0; k < pairs.size();) {
    std::size_t end = k + 1;
    if (pairs[k].of_piece()) {
      while (end < pairs.size() && pairs[end].of_piece() && pairs[end].b == pairs[k].b) ++end;
      see_fixed(params, pairs.subspan(k, end - k));
    }
    k = end;
  }
  const bool laid = stale_[index] == 0;
  bool stale = !laid;
  strip.ghosts.clear();
  strip.active.clear();
  strip.rewrite.clear();
  for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
    const ManifoldPair& pair = pairs_[k];
    stale |= pair.active != (pair.lane != PairName::kNone);
    if (pair.ghost && !pair.moved) strip.ghosts.push_back(std::uint64_t{pair.b} << 32 | pair.shape);
    if (!pair.active) continue;
    strip.active.push_back(k);
    if (!laid) continue;
    if (!pair.changed && pair.lane / kernels::kBlock < strip.blocks.size()) {
      kernels::ManifoldBlock& c = strip.blocks[pair.lane / kernels::kBlock];
      const std::uint32_t l = pair.lane % kernels::kBlock;
      for (int p = 0; p < pair.manifold.count; ++p) c.point[p].gap[l] = pair.gap[p] + pair.offset[p];
    }
    if (pair.changed || pair.was_stack != ManifoldPair::kNoStack) strip.rewrite.push_back(k);
  }
  stale_[index] = stale;
}

void Manifolds::refresh(const ManifoldParams& params, std::size_t begin, std::size_t end) {
  if (begin == 0) {
    keep_impulses();
    g_ = static_cast<float>(length_of(params.gravity));
    constexpr float kThin = 0.2f;          // the inner radius counts as at least this share of the reach
    constexpr std::size_t kBodies = 1024;  // a job
    run_each(shaped_.size(), kBodies, s_.pool, [&](std::size_t n, std::size_t) {
      const std::size_t i = shaped_[n];
      const Rotor q = rotor_of(s_.bodies.angle[i]);
      rotor_[2 * i] = q.c;
      rotor_[2 * i + 1] = q.s;
      inner_[i] = std::max(kThin * s_.bodies.radius[i], s_.bodies.kind(s_.bodies.id[i]).inner);
    });
  }
  const auto last_of_strip = [&](const Cut& c) { return c.end == begin_[c.strip + 1]; };
  const auto whole = [&](const Cut& c) { return c.begin == begin_[c.strip] && last_of_strip(c); };
  s_.pool.run(end - begin, [&](std::size_t n) {
    Cut& c = cuts_[begin + n];
    c.looks = look(params, {pairs_.data() + c.begin, pairs_.data() + c.end});
    if (whole(c)) finish_strip(params, c.strip);
  });
  for (std::size_t k = begin; k < end; ++k) {
    if (last_of_strip(cuts_[k]) && !whole(cuts_[k])) finish_strip(params, cuts_[k].strip);
  }
  if (end != cuts_.size()) return;
  new_pairs_ = 0;
  looks_ = {};
  for (const Cut& c : cuts_) looks_ += c.looks;
  ghosts_.clear();
  for (std::size_t s = 0; s < strip_count(); ++s) {
    ghosts_.insert(ghosts_.end(), strips_[s].ghosts.begin(), strips_[s].ghosts.end());
  }
  sort_keys(ghosts_.begin(), ghosts_.end());
}

float Manifolds::deepest() const {
  float most = 0;
  for (const ManifoldPair& pair : pairs_) {
    for (int k = 0; pair.active && k < pair.manifold.count; ++k) most = std::fmax(most, -pair.gap[k]);
  }
  return most;
}

}  // namespace psim
