#include "lists/strip_speeds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr std::uint32_t kLooks = 64;  // bodies sampled a strip
// By chance the means of two strips' samples hardly ever differ by more than this share of the r.m.s. speed.
constexpr double kChance = 0.5;

}  // namespace

// The r.m.s. speed about a velocity.
double StripSpeeds::Sum::spread(Vec2 about) const {
  if (!(weight > 0)) return 0;
  const Vec2 common = mean(), off = common - about;
  const double own = greater(square / weight - common.x * common.x - common.y * common.y, 0);
  return std::sqrt(own + off.x * off.x + off.y * off.y);
}

void StripSpeeds::Box::add(const Box& o) {
  low = {lesser(o.low.x, low.x), lesser(o.low.y, low.y)};
  high = {greater(o.high.x, high.x), greater(o.high.y, high.y)};
}

double StripSpeeds::Box::farthest(Vec2 from) const {
  if (low.x > high.x) return 0;
  return length_of({greater(high.x - from.x, from.x - low.x), greater(high.y - from.y, from.y - low.y)});
}

void StripSpeeds::Stir::look(const BodyStore& b, const Strip& strip, bool uneven) {
  *this = {};
  const std::uint32_t n = strip.body_end - strip.body_begin;
  const std::uint32_t stride = uneven ? 1 : std::max(1u, n / kLooks);
  if (uneven && n != 0) {
    low = std::numeric_limits<std::int64_t>::max();
    high = std::numeric_limits<std::int64_t>::min();
  }
  for (std::uint32_t i = strip.body_begin; i < strip.body_end; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = b.velocity(i);
    bodies.add(1, v);
    if (!uneven) continue;
    const BodyProperties& properties = b.properties(b.id[i]);
    if (properties.inv_mass > 0) {
      masses.add(static_cast<double>(properties.mass), v);
    } else {
      heavy.add({v, v});
    }
    low = std::min<std::int64_t>(low, b.pos[2 * std::size_t{i} + 1]);
    high = std::max<std::int64_t>(high, b.pos[2 * std::size_t{i} + 1]);
  }
}

// Adds each large body to the strips that it may touch within the time. From here on `low` is the lowest row of a strip
// and all after it, `high` the highest of it and all before.
void StripSpeeds::place_large(const Strip& large, double time) {
  const BodyStore& b = s_.bodies;
  for (std::size_t s = 1; s < stirs_.size(); ++s) stirs_[s].high = std::max(stirs_[s].high, stirs_[s - 1].high);
  for (std::size_t s = stirs_.size() - 1; s-- > 0;) stirs_[s].low = std::min(stirs_[s].low, stirs_[s + 1].low);
  constexpr std::int64_t kRound = std::int64_t{1} << 32;  // lattice steps around a periodic world
  const std::int64_t copies = s_.lattice.wraps() ? kRound : 0;
  for (std::uint32_t i = large.body_begin; i < large.body_end; ++i) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = b.velocity(i);
    const double far = static_cast<double>(b.radius[i]) + std::fabs(v.y) * time;
    const auto reach = static_cast<std::int64_t>(lesser(far / s_.lattice.pitch_y(), static_cast<double>(kRound))) + 1;
    for (std::int64_t round = -copies; round <= copies; round += kRound) {
      const std::int64_t at = b.pos[2 * std::size_t{i} + 1] + round;
      const auto end = std::ranges::upper_bound(stirs_, at + reach, {}, &Stir::low);
      for (auto s = std::ranges::lower_bound(stirs_, at - reach, {}, &Stir::high); s < end; ++s) s->heavy.add({v, v});
    }
  }
}

void StripSpeeds::measure(const std::vector<Strip>& strips, bool uneven, double time) {
  const std::size_t grid = strips.size() - 1;
  stirs_.resize(grid);
  s_.pool.run(grid, [&](std::size_t s) { stirs_[s].look(s_.bodies, strips[s], uneven); });
  if (uneven && grid != 0) place_large(strips[grid], time);
  speed_.resize(strips.size());
  closing_.assign(strips.size(), 0);
  for (std::size_t s = 0; s < grid; ++s) {
    Stir about = stirs_[s];
    Box means;
    const auto note = [&](const Sum& bodies) {
      if (bodies.weight > 0) means.add({bodies.mean(), bodies.mean()});
    };
    note(stirs_[s].bodies);
    const auto join = [&](std::size_t other) {
      note(stirs_[other].bodies);
      about.bodies.add(stirs_[other].bodies);
      about.masses.add(stirs_[other].masses);
      about.heavy.add(stirs_[other].heavy);
    };
    if (s != 0 || s_.lattice.wraps()) join(s == 0 ? grid - 1 : s - 1);
    if (s + 1 != grid || s_.lattice.wraps()) join(s + 1 == grid ? 0 : s + 1);
    const Vec2 common = about.bodies.mean();
    speed_[s] = greater(about.bodies.spread(about.masses.weight > 0 ? about.masses.mean() : common),
                        about.heavy.farthest(common));
    if (std::isnan(speed_[s])) speed_[s] = std::numeric_limits<double>::infinity();
    closing_[s] = greater(means.farthest(means.low) - kChance * about.bodies.spread(common), 0);
  }
  speed_[grid] = std::numeric_limits<double>::infinity();
}

}  // namespace psim
