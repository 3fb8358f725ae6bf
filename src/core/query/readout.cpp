#include "query/readout.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/sort_keys.h"
#include "base/tasks.h"
#include "solver/forces.h"

namespace psim {
namespace {

// Mixes 64 bits into a running hash.
std::uint64_t mix(std::uint64_t hash, std::uint64_t value) { return mixed(hash * 0x9E3779B97F4A7C15u + value); }

// Adding zero makes -0 the same as 0. All NaN are alike: their bits differ from one processor to another.
std::uint64_t bits(float v) { return v == v ? std::bit_cast<std::uint32_t>(v + 0.0f) : 0x7FC00000u; }
std::uint64_t bits(double v) { return v == v ? std::bit_cast<std::uint64_t>(v + 0.0) : 0x7FF8000000000000u; }

std::uint64_t pair(std::uint64_t low, std::uint64_t high) { return low | high << 32; }

// The place before, moved to the side of a periodic seam on which `now` is: a body that crosses the seam does not fly
// back through the world between two frames. The period of a world without seams is 0.
float near_to(float now, float before, float period) {
  if (now - before > period / 2) return before + period;
  if (before - now > period / 2) return before - period;
  return before;
}

}  // namespace

std::uint64_t state_hash(const Observed& world) {
  const BodyStore& b = world.bodies;
  b.find_slots();
  std::uint64_t hash = b.living();
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place == Place::none) continue;
    hash = mix(hash, id);
    if (info.place != Place::moving) {
      const BodyState s = world.state_of(id);
      hash = mix(mix(mix(hash, bits(s.x)), bits(s.y)), bits(s.angle));
      continue;
    }
    const std::size_t i = info.slot;
    hash = mix(hash, pair(static_cast<std::uint32_t>(b.pos[2 * i]), static_cast<std::uint32_t>(b.pos[2 * i + 1])));
    hash = mix(hash, pair(bits(b.disp[2 * i]), bits(b.disp[2 * i + 1])));
    hash = mix(hash, pair(bits(b.vel[2 * i]), bits(b.vel[2 * i + 1])));
    if (!b.rim_speed.empty()) hash = mix(mix(hash, bits(b.angle[i])), bits(b.rim_speed[i]));
  }
  return hash;
}

Diagnostics sum_motion(const Observed& world) {
  const BodyStore& b = world.bodies;
  Diagnostics d;
  const Forces wells(world.desc, world.lattice);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place != Place::moving && info.place != Place::asleep) continue;
    const BodyProperties& properties = b.property_table[info.properties];
    if (properties.type() != BodyType::dynamic_body) continue;
    const BodyState s = world.state_of(id);
    const Vec2 at = Vec2{s.x, s.y} + arm_of(b.kinds[properties.kind], s.angle), v{s.vx, s.vy};
    const double m = wide(properties.mass), gain = wide(properties.rim_gain), u = s.omega * s.radius;
    const double weight = m * wide(properties.gravity_scale);
    d.kinetic += m * dot(v, v) / 2 + (gain > 0 ? u * u / gain / 2 : 0);
    d.potential -= weight * dot(world.desc.gravity, at);
    d.potential += weight * wells.potential(at);
    d.momentum_x += m * v.x;
    d.momentum_y += m * v.y;
    d.angular_momentum += m * cross(at, v) + (gain > 0 ? s.omega * s.radius * s.radius / gain : 0);
  }
  return d;
}

PublishedState PublishedColumns::fill(const Observed& world) {
  const BodyStore& b = world.bodies;
  for (std::vector<double>* c : {&x_, &y_, &angle_, &vx_, &vy_, &omega_, &radius_}) {
    c->clear();
    c->reserve(b.living());
  }
  id_.clear();
  type_.clear();
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place == Place::none) continue;
    const BodyState s = world.state_of(id);
    id_.push_back(id);
    x_.push_back(s.x);
    y_.push_back(s.y);
    angle_.push_back(s.angle);
    vx_.push_back(s.vx);
    vy_.push_back(s.vy);
    omega_.push_back(s.omega);
    radius_.push_back(s.radius);
    type_.push_back(s.type);
  }
  return {id_, x_, y_, angle_, vx_, vy_, omega_, radius_, type_};
}

// ---- snapshots for a renderer

Publisher::Row Publisher::row_of(std::uint32_t id, const Observed& world) {
  const BodyStore& b = world.bodies;
  const BodyInfo& info = b.info[id];
  const auto still = [centre = world.lattice.centre()](const auto& f) -> Row {
    return {static_cast<float>(f.x - centre.x), static_cast<float>(f.y - centre.y), static_cast<float>(f.angle), 0};
  };
  if (info.place == Place::fixed) return still(world.population.fixed[info.slot]);
  if (info.place == Place::frozen) return still(world.population.frozen[info.slot]);
  if (info.place == Place::disabled) return still(world.population.disabled[info.slot].last);
  const auto [place, angle] = world.stand(id);
  const Vec2 at = world.lattice.from_centre(place) - arm_of(b.kind(id), angle);
  Row row{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(angle), 0};
  if (info.place == Place::moving) {
    const float* v = &b.vel[2 * std::size_t{info.slot}];
    row.speed = std::sqrt(v[0] * v[0] + v[1] * v[1]);
  }
  return row;
}

void Publisher::look(const Observed& world) {
  const BodyStore& b = world.bodies;
  b.find_slots();
  last_.resize(b.id_count);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place != Place::none) last_[id] = row_of(id, world);
  }
}

void Publisher::publish(const Observed& world, std::uint64_t frame) {
  const BodyStore& b = world.bodies;
  b.find_slots();
  Snapshot& s = frames_[back_];
  const std::size_t n = b.living();
  s.frame = frame;
  s.origin = world.lattice.centre();
  s.id.resize(n);
  for (std::vector<float>* c : {&s.x, &s.y, &s.x_prev, &s.y_prev, &s.angle, &s.angle_prev, &s.radius, &s.speed}) {
    c->resize(n);
  }
  s.asleep.resize(n);
  std::uint32_t row = 0;
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place != Place::none) s.id[row++] = id;
  }
  const auto period_x = static_cast<float>(world.period().x), period_y = static_cast<float>(world.period().y);
  constexpr std::size_t kRows = 8192;  // a job
  run_each(n, kRows, world.pool, [&](std::size_t r, std::size_t) {
    const std::uint32_t id = s.id[r];
    const Row now = row_of(id, world), before = std::exchange(last_[id], now);
    s.x[r] = now.x;
    s.y[r] = now.y;
    s.x_prev[r] = near_to(now.x, before.x, period_x);
    s.y_prev[r] = near_to(now.y, before.y, period_y);
    s.angle[r] = now.angle;
    s.angle_prev[r] = before.angle;
    s.radius[r] = b.properties(id).radius;
    s.speed[r] = now.speed;
    s.asleep[r] = b.info[id].place == Place::asleep;
  });
  back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & 3u;
}

const Snapshot* Publisher::latest() {
  unsigned seen = middle_.load(std::memory_order_relaxed);
  while ((seen & kFresh) != 0) {  // the flag is gone if release() came between
    if (!middle_.compare_exchange_weak(seen, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) continue;
    front_ = seen & 3u;
    break;
  }
  return frames_[front_].frame != 0 ? &frames_[front_] : nullptr;
}

void Publisher::release() {
  give_back(last_);
  frames_[back_] = {};
  back_ = middle_.exchange(back_, std::memory_order_acq_rel) & 3u;  // there is nothing fresh for the reader
  frames_[back_] = {};
}

std::size_t Publisher::bytes() const {
  std::size_t sum = bytes_of(last_);
  for (const Snapshot& s : frames_) sum += s.id.capacity() * 4 + s.x.capacity() * (4 * 8 + 1);
  return sum;
}

}  // namespace psim
