#include "query/readout.h"

#include <bit>
#include <cmath>

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

}  // namespace

std::uint64_t state_hash(const BodySource& source) {
  const BodyStore& b = source.population.bodies;
  b.find_slots();
  std::uint64_t hash = b.living;
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place == Place::none) continue;
    hash = mix(hash, id);
    if (info.place != Place::moving) {
      const BodyState s = source.state_of(id);
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

Diagnostics sum_motion(const BodySource& source, const WorldDesc& desc) {
  const BodyStore& b = source.population.bodies;
  Diagnostics d;
  const Forces wells(desc, source.lattice);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place != Place::moving && info.place != Place::asleep) continue;
    const BodyProperties& properties = b.property_table[info.properties];
    if (properties.type != BodyType::dynamic_body) continue;
    BodyState s = source.state_of(id);
    const Vec2 arm = arm_of(b.kinds[properties.kind], s.angle);
    s.x += arm.x;
    s.y += arm.y;
    const double m = static_cast<double>(properties.mass);
    const double gain = static_cast<double>(properties.rim_gain);
    const double u = s.omega * s.radius;
    d.kinetic += m * (s.vx * s.vx + s.vy * s.vy) / 2 + (gain > 0 ? u * u / gain / 2 : 0);
    const double scale = static_cast<double>(properties.gravity_scale);
    d.potential -= m * scale * (desc.gravity.x * s.x + desc.gravity.y * s.y);
    d.potential += m * scale * wells.potential({s.x, s.y});
    d.momentum_x += m * s.vx;
    d.momentum_y += m * s.vy;
    d.angular_momentum += m * (s.x * s.vy - s.y * s.vx) + (gain > 0 ? s.omega * s.radius * s.radius / gain : 0);
  }
  return d;
}

PublishedState PublishedColumns::fill(const BodySource& source) {
  const BodyStore& b = source.population.bodies;
  for (std::vector<double>* c : {&x_, &y_, &angle_, &vx_, &vy_, &omega_, &radius_}) {
    c->clear();
    c->reserve(b.living);
  }
  id_.clear();
  type_.clear();
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place == Place::none) continue;
    const BodyState s = source.state_of(id);
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

}  // namespace psim
