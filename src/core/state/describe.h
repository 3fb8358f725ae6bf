// How saved states and recordings write the small types that several parts of a world share (archive.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "bodies/population.h"
#include "manifolds/manifolds.h"
#include "psim/desc.h"
#include "psim/joint.h"
#include "state/archive.h"

namespace psim {

constexpr std::uint64_t last_of(Enum<BodyType>) { return 2; }
constexpr std::uint64_t last_of(Enum<Boundary>) { return 2; }
constexpr std::uint64_t last_of(Enum<Mixing>) { return 4; }
constexpr std::uint64_t last_of(Enum<Integrator>) { return 3; }
constexpr std::uint64_t last_of(Enum<JointType>) { return 11; }
constexpr std::uint64_t last_of(Enum<kernels::JointKind>) { return 7; }
constexpr std::uint64_t last_of(Enum<kernels::Model>) { return 2; }
constexpr std::uint64_t last_of(Enum<Place>) { return 5; }
constexpr std::uint64_t last_of(Enum<ManifoldPair::StackRole>) { return 2; }
constexpr std::uint64_t last_of(Enum<ManifoldPair::Crossing>) { return 3; }

// ---- the members of a struct, in the order in which they are saved
inline auto fields(Vec2& v) { return std::tie(v.x, v.y); }
inline auto fields(Bounds& b) { return std::tie(b.xmin, b.ymin, b.xmax, b.ymax); }
inline auto fields(LatticePoint& p) { return std::tie(p.x, p.y, p.dx, p.dy); }
inline auto fields(BodyId& id) { return std::tie(id.index, id.generation); }
inline auto fields(Material& m) {
  return std::tie(m.density, m.restitution, m.friction, m.tangent_speed, m.rolling_resistance);
}
inline auto fields(MixingRules& m) { return std::tie(m.restitution, m.friction); }
inline auto fields(Locks& l) { return std::tie(l.x, l.y, l.angle); }
inline auto fields(Filter& f) { return std::tie(f.category, f.mask, f.group); }
inline auto fields(WellField& w) { return std::tie(w.position, w.strength, w.softening, w.exponent, w.range); }
inline auto fields(DragField& d) { return std::tie(d.linear, d.quadratic); }
inline auto fields(BuoyancyField& w) {
  return std::tie(w.region, w.density, w.linear_damping, w.angular_damping, w.flow, w.mask);
}
inline auto fields(WindField& w) { return std::tie(w.velocity, w.density, w.drag, w.lift, w.region, w.mask); }
inline auto fields(WorldDesc& d) {
  return std::tie(d.bounds, d.boundary, d.gravity, d.linear_damping, d.wall, d.mixing, d.dt, d.substeps, d.integrator,
                  d.restitution_threshold, d.sleeping, d.skin, d.fields);
}
inline auto fields(JointId& id) { return std::tie(id.index, id.generation); }
inline auto fields(JointDesc& d) {
  return std::tie(d.type, d.a, d.b, d.anchor_a, d.anchor_b, d.length, d.stiffness, d.damping, d.axis, d.reference,
                  d.lower, d.upper, d.motor_speed, d.motor_limit, d.collide, d.target, d.rest, d.linear_velocity,
                  d.angular_velocity, d.force_limit, d.torque_limit, d.ground_a, d.ground_b, d.ratio, d.joint_a,
                  d.joint_b, d.frequency, d.damping_ratio, d.break_force, d.break_torque, d.user_data,
                  d.linear_stiffness, d.linear_damping, d.correction, d.offset, d.pressure, d.wind_drag, d.wind_lift,
                  d.area);
}

inline auto fields(BodyKind& k) {
  return std::tie(k.first_hull, k.hull_count, k.first_part, k.part_count, k.centre_x, k.centre_y, k.inner,
                  k.locked_gain, k.filter, k.bullet, k.sensor, k.one_way, k.restrained, k.sleepless, k.locks);
}
inline auto fields(FixedBody& f) { return std::tie(f.x, f.y, f.angle, f.radius, f.id, f.first_shape); }
inline auto fields(BodyState& s) { return std::tie(s.id, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type); }
inline auto fields(ManifoldPoint& q) { return std::tie(q.ax, q.ay, q.bx, q.by, q.gap, q.feature); }
inline auto fields(Manifold& m) { return std::tie(m.nx, m.ny, m.count, m.point); }
inline auto fields(Rotor& q) { return std::tie(q.c, q.s); }

inline void one_value(Archive& a, Hull& h) {
  for (int k = 0; k < Hull::kMost; ++k) values(a, h.x[k], h.y[k], h.nx[k], h.ny[k]);
  values(a, h.radius, h.reach, h.inner, h.middle_x, h.middle_y, h.count);
  a.require(h.count >= 0 && h.count <= Hull::kMost && h.radius >= 0 && h.reach >= 0 && h.inner >= 0);
}

inline void one_value(Archive& a, Surface& s) {
  values(a, s.restitution, s.friction, s.tangent_speed, s.rolling_resistance);
  a.require(s.restitution >= 0 && s.restitution <= 1 && s.friction >= 0 && s.rolling_resistance >= 0 &&
            std::isfinite(s.tangent_speed));
}

inline void one_value(Archive& a, PartProperties& p) {
  values(a, p.surface, p.filter, p.sensor, p.one_way_x, p.one_way_y, p.pre_solve, p.user_low, p.user_high);
  a.require(p.sensor <= 1 && p.pre_solve <= 1 && std::fabs(p.one_way_x) <= 1.001f && std::fabs(p.one_way_y) <= 1.001f);
}

inline void one_value(Archive& a, BodyProperties& s) {
  values(a, s.inv_mass, s.mass, s.rim_gain, s.radius, s.gravity_scale, s.restitution, s.friction);
  std::uint32_t kind = s.kind;
  BodyType type = s.type();
  a.index(kMostKinds + std::uint64_t{1}, kind);
  a.value(type);
  s.kind = kind & kMostKinds;
  s.type_bits = static_cast<std::uint8_t>(type);
  a.require(s.inv_mass >= 0 && s.mass >= 0 && s.rim_gain >= 0 && s.radius >= 0 && s.restitution >= 0 &&
            s.restitution <= 1 && s.friction >= 0);
}

/// What a function makes of the elements of a list.
template <class List, class To>
struct Mapped {
  List& list;
  To to;
  std::size_t size() const { return list.size(); }
  decltype(auto) operator[](std::size_t k) const { return std::invoke(to, list[k]); }
};
template <class List, class To>
Mapped(List&, To) -> Mapped<List, To>;

/// Members of the structs in a range, each as a column.
template <class Range, class... Member>
void columns(Archive& a, Range&& structs, Member... member) {
  const auto column = [&](auto of) {
    a.packed(
        structs.size(), [&](std::size_t k) -> auto& { return std::invoke(of, structs[k]); });
  };
  (column(member), ...);
}
template <class Range>
void lattice_points(Archive& a, Range&& points) {
  columns(a, points, &LatticePoint::x, &LatticePoint::y, &LatticePoint::dx, &LatticePoint::dy);
}

/// Entries of a list that nobody uses, each once, in the order in which they will be given away again.
template <class IsFree>
void describe_free(Archive& a, std::vector<std::uint32_t>& list, std::size_t begin, std::size_t end,
                   const IsFree& is_free) {
  a.packed(list, end);
  if (!a.loading()) return;
  std::vector<std::uint8_t> listed(a.ok() ? end : 0);
  for (const std::uint32_t k : list) {
    if (a.ok()) a.require(k >= begin && listed[k]++ == 0);
  }
  for (std::size_t k = begin; k < end && a.ok(); ++k) a.require(is_free(k) == (listed[k] != 0));
  if (a.ok()) list.reserve(end);  // what is given back later needs no memory
}

/// How many bodies are at a place.
inline std::size_t count_of(const BodyStore& b, Place place) {
  const auto is_there = [place](const BodyInfo& info) { return info.place == place; };
  return static_cast<std::size_t>(std::count_if(b.info.data(), b.info.data() + b.id_count, is_there));
}
/// Makes a body that is read the `at`-th of those at a place. False if it is not of them, or is there already.
inline bool put(BodyStore& b, std::uint32_t body, Place place, std::size_t at) {
  if (body >= b.id_count || b.info[body].place != place || b.info[body].slot != kNoSlot) return false;
  b.info[body].slot = static_cast<std::uint32_t>(at);
  return true;
}

/// Who is in a world. `lists`: with where they were when the lists were made.
void describe_population(Archive& a, Population& population, bool lists);
/// The strips of a table and their bodies.
void describe_strips(Archive& a, PairTable& table);

}  // namespace psim
