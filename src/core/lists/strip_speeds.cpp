#include "lists/strip_speeds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace psim {
namespace {

constexpr std::uint32_t kLooks = 64;  // bodies sampled a strip

Vec2 velocity(const BodyStore& b, std::size_t i) {
  return {static_cast<double>(b.vel[2 * i]), static_cast<double>(b.vel[2 * i + 1])};
}

}  // namespace

// The r.m.s. speed about a velocity.
double StripSpeeds::Sum::spread(Vec2 about) const {
  if (!(weight > 0)) return 0;
  const Vec2 common = mean(), off = {common.x - about.x, common.y - about.y};
  const double own = std::fmax(square / weight - common.x * common.x - common.y * common.y, 0);
  return std::sqrt(own + off.x * off.x + off.y * off.y);
}

void StripSpeeds::Box::add(double x, double y) {
  x0 = std::fmin(x0, x), x1 = std::fmax(x1, x);
  y0 = std::fmin(y0, y), y1 = std::fmax(y1, y);
}

void StripSpeeds::Box::add(const Box& o) {
  x0 = std::fmin(x0, o.x0), x1 = std::fmax(x1, o.x1);
  y0 = std::fmin(y0, o.y0), y1 = std::fmax(y1, o.y1);
}

double StripSpeeds::Box::farthest(Vec2 from) const {
  if (x0 > x1) return 0;
  const double dx = std::fmax(x1 - from.x, from.x - x0), dy = std::fmax(y1 - from.y, from.y - y0);
  return std::sqrt(dx * dx + dy * dy);
}

void StripSpeeds::look(const BodyStore& b, const Strip& strip, Stir& out) const {
  out = {};
  const std::uint32_t n = strip.body_end - strip.body_begin;
  const std::uint32_t stride = settings_.uneven ? 1 : std::max(1u, n / kLooks);
  if (settings_.uneven && n != 0) {
    out.low = std::numeric_limits<std::int64_t>::max();
    out.high = std::numeric_limits<std::int64_t>::min();
  }
  for (std::uint32_t i = strip.body_begin; i < strip.body_end; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = velocity(b, i);
    out.bodies.add(1, v.x, v.y);
    if (!settings_.uneven) continue;
    const BodyProperties& properties = b.properties(b.id[i]);
    if (properties.inv_mass > 0) {
      out.masses.add(static_cast<double>(properties.mass), v.x, v.y);
    } else {
      out.heavy.add(v.x, v.y);
    }
    out.low = std::min<std::int64_t>(out.low, b.pos[2 * std::size_t{i} + 1]);
    out.high = std::max<std::int64_t>(out.high, b.pos[2 * std::size_t{i} + 1]);
  }
}

// Adds each large body to the strips that it may touch within the time.
void StripSpeeds::place_large(const BodyStore& b, const Strip& large) {
  const std::size_t strips = stirs_.size();
  low_.resize(strips);
  high_.resize(strips);
  std::int64_t low = std::numeric_limits<std::int64_t>::max(), high = std::numeric_limits<std::int64_t>::min();
  for (std::size_t s = 0; s < strips; ++s) high_[s] = high = std::max(high, stirs_[s].high);
  for (std::size_t s = strips; s-- > 0;) low_[s] = low = std::min(low, stirs_[s].low);
  constexpr std::int64_t kRound = std::int64_t{1} << 32;  // lattice steps around a periodic world
  for (std::uint32_t i = large.body_begin; i < large.body_end; ++i) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = velocity(b, i);
    const double far = static_cast<double>(b.radius[i]) + std::fabs(v.y) * settings_.time;
    const auto reach = static_cast<std::int64_t>(std::fmin(far / settings_.pitch_y, static_cast<double>(kRound))) + 1;
    for (std::int64_t round = settings_.periodic ? -kRound : 0; round <= (settings_.periodic ? kRound : 0);
         round += kRound) {
      const std::int64_t at = b.pos[2 * std::size_t{i} + 1] + round;
      const auto first = std::lower_bound(high_.begin(), high_.end(), at - reach) - high_.begin();
      const auto end = std::upper_bound(low_.begin(), low_.end(), at + reach) - low_.begin();
      for (auto s = first; s < end; ++s) stirs_[static_cast<std::size_t>(s)].heavy.add(v.x, v.y);
    }
  }
}

void StripSpeeds::measure(const BodyStore& b, const std::vector<Strip>& strips, const Settings& settings,
                          WorkerPool& pool) {
  settings_ = settings;
  const std::size_t grid = strips.size() - 1;
  stirs_.resize(grid);
  pool.run(grid, [&](std::size_t s) { look(b, strips[s], stirs_[s]); });
  if (settings.uneven && grid != 0) place_large(b, strips[grid]);
  speed_.resize(strips.size());
  for (std::size_t s = 0; s < grid; ++s) {
    Stir about = stirs_[s];
    const auto join = [&](std::size_t other) {
      about.bodies.add(stirs_[other].bodies);
      about.masses.add(stirs_[other].masses);
      about.heavy.add(stirs_[other].heavy);
    };
    if (s != 0 || settings.periodic) join(s == 0 ? grid - 1 : s - 1);
    if (s + 1 != grid || settings.periodic) join(s + 1 == grid ? 0 : s + 1);
    const Vec2 common = about.bodies.mean();
    speed_[s] = std::fmax(about.bodies.spread(about.masses.weight > 0 ? about.masses.mean() : common),
                          about.heavy.farthest(common));
    if (std::isnan(speed_[s])) speed_[s] = std::numeric_limits<double>::infinity();
  }
  speed_[grid] = std::numeric_limits<double>::infinity();
}

}  // namespace psim
