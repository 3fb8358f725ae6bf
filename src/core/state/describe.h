// How saved states and recordings write the small types that several parts of a world share (archive.h).
#pragma once

#include <tuple>

#include "bodies/body_store.h"
#include "manifolds/manifolds.h"
#include "psim/desc.h"
#include "psim/joint.h"
#include "state/archive.h"

namespace psim {

constexpr std::uint64_t last_of(Enum<BodyType>) { return 2; }
constexpr std::uint64_t last_of(Enum<Boundary>) { return 2; }
constexpr std::uint64_t last_of(Enum<Integrator>) { return 3; }
constexpr std::uint64_t last_of(Enum<JointType>) { return 5; }
constexpr std::uint64_t last_of(Enum<kernels::JointKind>) { return 5; }
constexpr std::uint64_t last_of(Enum<kernels::Model>) { return 2; }
constexpr std::uint64_t last_of(Enum<Place>) { return 4; }
constexpr std::uint64_t last_of(Enum<ManifoldPair::StackRole>) { return 2; }

// ---- the members of a struct, in the order in which they are saved
inline auto fields(Vec2& v) { return std::tie(v.x, v.y); }
inline auto fields(Bounds& b) { return std::tie(b.xmin, b.ymin, b.xmax, b.ymax); }
inline auto fields(LatticePoint& p) { return std::tie(p.x, p.y, p.dx, p.dy); }
inline auto fields(BodyId& id) { return std::tie(id.index, id.generation); }
inline auto fields(Material& m) { return std::tie(m.density, m.restitution, m.friction); }
inline auto fields(Filter& f) { return std::tie(f.category, f.mask, f.group); }
inline auto fields(WellField& w) { return std::tie(w.position, w.strength, w.softening, w.exponent, w.range); }
inline auto fields(DragField& d) { return std::tie(d.linear, d.quadratic); }
inline auto fields(WorldDesc& d) {
  return std::tie(d.bounds, d.boundary, d.gravity, d.linear_damping, d.wall, d.dt, d.substeps, d.integrator,
                  d.restitution_threshold, d.sleeping, d.skin, d.fields);
}
inline auto fields(JointDesc& d) {
  return std::tie(d.type, d.a, d.b, d.anchor_a, d.anchor_b, d.length, d.stiffness, d.damping, d.axis, d.reference,
                  d.lower, d.upper, d.motor_speed, d.motor_limit, d.collide);
}

template <class A>
void one_value(A& a, Hull& h) {
  for (int k = 0; k < Hull::kMost; ++k) values(a, h.x[k], h.y[k], h.nx[k], h.ny[k]);
  values(a, h.radius, h.reach, h.inner, h.count);
  a.require(h.count >= 0 && h.count <= Hull::kMost && h.radius >= 0 && h.reach >= 0 && h.inner >= 0);
}

template <class A>
void one_value(A& a, BodyProperties& s) {
  values(a, s.inv_mass, s.mass, s.rim_gain, s.radius, s.gravity_scale, s.restitution, s.friction);
  std::uint32_t kind = s.kind;
  BodyType type = s.type;
  a.index(kMostKinds + std::uint64_t{1}, kind);
  a.value(type);
  s.kind = kind & kMostKinds;
  s.type = type;
  a.require(s.inv_mass >= 0 && s.mass >= 0 && s.rim_gain >= 0 && s.radius >= 0 && s.restitution >= 0 &&
            s.restitution <= 1 && s.friction >= 0);
}

/// Members of n structs, each as a column: of(k) is the k-th struct.
template <class A, class Of, class... Member>
void columns(A& a, std::size_t n, const Of& of, Member... member) {
  (a.packed(
       n, [&](std::size_t k) -> auto& { return of(k).*member; }),
   ...);
}
template <class A, class Of>
void lattice_points(A& a, std::size_t n, const Of& of) {
  columns(a, n, of, &LatticePoint::x, &LatticePoint::y, &LatticePoint::dx, &LatticePoint::dy);
}

/// Entries of a list that nobody uses, each once, in the order in which they will be given away again.
template <class A, class IsFree>
void describe_free(A& a, std::vector<std::uint32_t>& list, std::size_t begin, std::size_t end, const IsFree& is_free) {
  a.packed(list, end);
  if constexpr (A::kLoading) {
    std::vector<std::uint8_t> listed(a.ok() ? end : 0);
    for (const std::uint32_t k : list) {
      if (a.ok()) a.require(k >= begin && listed[k]++ == 0);
    }
    for (std::size_t k = begin; k < end && a.ok(); ++k) a.require(is_free(k) == (listed[k] != 0));
  }
}

/// Defines a class's describe() for both archives, where it is written outside its header.
#define PSIM_DESCRIBED(Class, ...)                                  \
  template void Class::describe(Saver& __VA_OPT__(, ) __VA_ARGS__); \
  template void Class::describe(Loader& __VA_OPT__(, ) __VA_ARGS__)

}  // namespace psim
