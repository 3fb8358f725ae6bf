// What is read out of a world: hash, sums, columns. All in id order, so that neither slots nor
// threads show.
#include <bit>
#include <cmath>

#include "world_impl.h"

namespace psim {
namespace {

// Mixes 64 bits into a running hash (constants of SplitMix64; Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  std::uint64_t z = hash * 0x9E3779B97F4A7C15u + value;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

std::uint64_t bits(float v) { return std::bit_cast<std::uint32_t>(v + 0.0f); }    // -0 as 0
std::uint64_t bits(double v) { return std::bit_cast<std::uint64_t>(v + 0.0); }

std::uint64_t pair(std::uint64_t low, std::uint64_t high) { return low | high << 32; }

}  // namespace

std::uint64_t World::state_hash() const {
  const Impl& w = *impl_;
  const BodyStore& b = w.bodies;
  b.find_slots();
  std::uint64_t hash = b.living;
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place == Place::none) continue;
    hash = mix(hash, id);
    if (info.place != Place::moving) {
      const BodyState s = w.state_of(id);
      hash = mix(mix(mix(hash, bits(s.x)), bits(s.y)), bits(s.angle));
      continue;
    }
    const std::size_t i = info.slot;
    hash = mix(hash, pair(static_cast<std::uint32_t>(b.pos[2 * i]),
                          static_cast<std::uint32_t>(b.pos[2 * i + 1])));
    hash = mix(hash, pair(bits(b.disp[2 * i]), bits(b.disp[2 * i + 1])));
    hash = mix(hash, pair(bits(b.vel[2 * i]), bits(b.vel[2 * i + 1])));
    if (!b.spin.empty()) hash = mix(mix(hash, bits(b.angle[i])), bits(b.spin[i]));
  }
  return hash;
}

Diagnostics World::diagnostics() const {
  Impl& w = *impl_;
  const BodyStore& b = w.bodies;
  Diagnostics d;
  const Forces wells(w.desc, w.lattice);
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    const BodyInfo& info = b.info[id];
    if (info.place != Place::moving && info.place != Place::asleep) continue;
    const Surface& surface = b.surfaces[info.surface];
    if (surface.type != BodyType::dynamic_body) continue;
    BodyState s = w.state_of(id);
    const Vec2 arm = arm_of(b.makes[surface.make], s.angle);
    s.x += arm.x;
    s.y += arm.y;
    const double m = static_cast<double>(surface.mass);
    const double gain = static_cast<double>(surface.spin_gain);
    const double u = s.omega * s.radius;
    d.kinetic += m * (s.vx * s.vx + s.vy * s.vy) / 2 + (gain > 0 ? u * u / gain / 2 : 0);
    const double scale = static_cast<double>(surface.gravity_scale);
    d.potential -= m * scale * (w.desc.gravity.x * s.x + w.desc.gravity.y * s.y);
    d.potential += m * scale * wells.potential({s.x, s.y});
    d.momentum_x += m * s.vx;
    d.momentum_y += m * s.vy;
    d.angular_momentum += m * (s.x * s.vy - s.y * s.vx) + (gain > 0 ? s.omega * s.radius * s.radius / gain : 0);
  }
  for (const Sleeper& s : w.sleepers.list) {
    d.max_penetration = std::fmax(d.max_penetration, static_cast<double>(s.depth));
  }
  // Present separations: the narrow phase over the present lists.
  w.settle_lists();
  if (!w.lists_stale && w.contacts_stand() && !w.saved.bare && w.frame != 0) {
    narrow_phase(w.bodies, w.solved, w.shapes, w.walls, w.lattice, 0, w.table, w.contacts, w.kernels, w.pool);
    float deepest = 0;
    for (std::size_t l = 0; l < std::size_t{w.contacts.pair_blocks()} * kernels::kBlock; ++l) {
      deepest = std::fmax(deepest, -w.contacts.gap[l]);
    }
    for (std::size_t l = 0; l < std::size_t{w.contacts.single_blocks()} * kernels::kBlock; ++l) {
      deepest = std::fmax(deepest, -w.contacts.s_gap[l]);
    }
    d.max_penetration = std::fmax(d.max_penetration,
                                  static_cast<double>(std::fmax(deepest, w.manifolds.deepest())));
  }
  return d;
}

PublishedState World::published() {
  Impl& w = *impl_;
  const BodyStore& b = w.bodies;
  for (std::vector<double>* c : {&w.out_x, &w.out_y, &w.out_angle, &w.out_vx, &w.out_vy,
                                 &w.out_omega, &w.out_radius}) {
    c->clear();
    c->reserve(b.living);
  }
  w.out_id.clear();
  w.out_type.clear();
  for (std::uint32_t id = 0; id < b.id_count; ++id) {
    if (b.info[id].place == Place::none) continue;
    const BodyState s = w.state_of(id);
    w.out_id.push_back(id);
    w.out_x.push_back(s.x);
    w.out_y.push_back(s.y);
    w.out_angle.push_back(s.angle);
    w.out_vx.push_back(s.vx);
    w.out_vy.push_back(s.vy);
    w.out_omega.push_back(s.omega);
    w.out_radius.push_back(s.radius);
    w.out_type.push_back(s.type);
  }
  return {w.out_id, w.out_x, w.out_y, w.out_angle, w.out_vx, w.out_vy, w.out_omega, w.out_radius,
          w.out_type};
}

std::size_t World::memory_bytes() const {
  const Impl& w = *impl_;
  return w.memory.bytes + w.bodies.surfaces.bytes() + w.bodies.hulls.bytes() + w.bodies.makes.bytes() +
         w.manifolds.bytes() + w.columns.bytes() + w.joints.bytes() + w.publisher.bytes() + w.queries.bytes() + w.events.bytes() + w.touching.bytes() + w.sleepers.bytes() + w.fixed.capacity() * sizeof(FixedBody) +
         w.renewal.bytes() + w.speeds.bytes() + w.slack.capacity() * sizeof(float) + w.solver.bytes() + w.unprepared.capacity() +
         w.out_id.capacity() * (4 + 1 + 7 * 8) + sizeof(Impl);
}

}  // namespace psim
