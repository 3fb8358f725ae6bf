#include "query/readout.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "solver/forces.h"

namespace psim {
namespace {

// Mixes 64 bits into a running hash (constants of SplitMix64; Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  std::uint64_t z = hash * 0x9E3779B97F4A7C15u + value;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

// Adding zero makes -0 the same as 0.
std::uint64_t bits(float v) { return std::bit_cast<std::uint32_t>(v + 0.0f); }
std::uint64_t bits(double v) { return std::bit_cast<std::uint64_t>(v + 0.0); }

std::uint64_t pair(std::uint64_t low, std::uint64_t high) { return low | high << 32; }

struct Row {
  float x = 0, y = 0, angle = 0, speed = 0;  // m from the lattice centre, radians, m/s
};

Row row_at(const Observed& world, const LatticePoint& place, Vec2 arm, double angle, float speed) {
  const Vec2 at = world.from_centre(place);
  return {static_cast<float>(at.x - arm.x), static_cast<float>(at.y - arm.y), static_cast<float>(angle), speed};
}

Row row_of(std::uint32_t id, const Observed& world) {
  const BodyStore& b = world.bodies;
  const BodyInfo& info = b.info[id];
  const std::size_t i = info.slot;
  if (info.place == Place::moving) {
    const float speed = std::sqrt(b.vel[2 * i] * b.vel[2 * i] + b.vel[2 * i + 1] * b.vel[2 * i + 1]);
    if (b.angle.empty()) return row_at(world, world.place(i), {}, 0, speed);
    return row_at(world, world.place(i), arm_of(b.kind(id), b.angle[i]), b.angle[i], speed);
  }
  if (info.place == Place::asleep) {
    const Sleeper& s = world.sleep.sleepers.list[i];
    return row_at(world, s.at, arm_of(b.kind(id), s.angle), s.angle, 0);
  }
  const auto still = [centre = world.lattice.centre()](const auto& f) -> Row {
    return {static_cast<float>(f.x - centre.x), static_cast<float>(f.y - centre.y), static_cast<float>(f.angle), 0};
  };
  return info.place == Place::fixed ? still(world.population.fixed[i]) : still(world.population.frozen[i]);
}

// The place before, moved to the side of a periodic seam on which `now` is: a body that crosses the seam does not fly
// back through the world between two frames. The period of a world without seams is infinite.
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
    if (properties.type != BodyType::dynamic_body) continue;
    BodyState s = world.state_of(id);
    const Vec2 arm = arm_of(b.kinds[properties.kind], s.angle);
    s.x += arm.x;
    s.y += arm.y;
    const double m = static_cast<double>(properties.mass);
    const double gain = static_cast<double>(properties.rim_gain);
    const double u = s.omega * s.radius;
    d.kinetic += m * (s.vx * s.vx + s.vy * s.vy) / 2 + (gain > 0 ? u * u / gain / 2 : 0);
    const double scale = static_cast<double>(properties.gravity_scale);
    d.potential -= m * scale * (world.desc.gravity.x * s.x + world.desc.gravity.y * s.y);
    d.potential += m * scale * wells.potential({s.x, s.y});
    d.momentum_x += m * s.vx;
    d.momentum_y += m * s.vy;
    d.angular_momentum += m * (s.x * s.vy - s.y * s.vx) + (gain > 0 ? s.omega * s.radius * s.radius / gain : 0);
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

void Publisher::look(const Observed& world) {
  const BodyStore& b = world.bodies;
  b.find_slots();
  for (std::vector<float>* c : {&last_x_, &last_y_, &last_angle_}) c->resize(b.id_count);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place == Place::none) continue;
    const Row row = row_of(id, world);
    last_x_[id] = row.x;
    last_y_[id] = row.y;
    last_angle_[id] = row.angle;
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
  const float far = std::numeric_limits<float>::infinity();
  const auto period_x = world.lattice.wraps() ? static_cast<float>(world.lattice.pitch_x() * 0x1p32) : far;
  const auto period_y = world.lattice.wraps() ? static_cast<float>(world.lattice.pitch_y() * 0x1p32) : far;
  constexpr std::size_t kRows = 8192;
  world.pool.run((n + kRows - 1) / kRows, [&](std::size_t task) {
    for (std::size_t r = task * kRows; r < std::min(n, (task + 1) * kRows); ++r) {
      const std::uint32_t id = s.id[r];
      const Row now = row_of(id, world);
      s.x[r] = now.x;
      s.y[r] = now.y;
      s.x_prev[r] = near_to(now.x, last_x_[id], period_x);
      s.y_prev[r] = near_to(now.y, last_y_[id], period_y);
      s.angle[r] = now.angle;
      s.angle_prev[r] = last_angle_[id];
      s.radius[r] = b.property_table[b.info[id].properties].radius;
      s.speed[r] = now.speed;
      s.asleep[r] = b.info[id].place == Place::asleep;
      last_x_[id] = now.x;
      last_y_[id] = now.y;
      last_angle_[id] = now.angle;
    }
  });
  back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & 3u;
}

const Snapshot* Publisher::latest() {
  unsigned seen = middle_.load(std::memory_order_relaxed);
  while ((seen & kFresh) != 0) {  // the flag is gone if release() came between
    if (!middle_.compare_exchange_weak(seen, front_, std::memory_order_acq_rel, std::memory_order_relaxed)) continue;
    front_ = seen & 3u;
    any_ = true;
    break;
  }
  return any_ ? &frames_[front_] : nullptr;
}

void Publisher::release() {
  for (std::vector<float>* c : {&last_x_, &last_y_, &last_angle_}) std::vector<float>().swap(*c);
  frames_[back_] = {};
  back_ = middle_.exchange(back_, std::memory_order_acq_rel) & 3u;  // there is nothing fresh for the reader
  frames_[back_] = {};
}

std::size_t Publisher::bytes() const {
  std::size_t sum = (last_x_.capacity() * 4) * 3;
  for (const Snapshot& s : frames_) sum += s.id.capacity() * 4 + s.x.capacity() * (4 * 8 + 1);
  return sum;
}

}  // namespace psim
