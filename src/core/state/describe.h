// How saved states and recordings write the small types that several parts of a world share (archive.h).
#pragma once

#include <utility>
#include <variant>

#include "bodies/body_store.h"
#include "manifolds/manifolds.h"
#include "psim/desc.h"
#include "psim/joint.h"
#include "state/archive.h"

namespace psim {

template <>
inline constexpr std::uint64_t kLastOf<BodyType> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Boundary> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Integrator> = 3;
template <>
inline constexpr std::uint64_t kLastOf<JointType> = 5;
template <>
inline constexpr std::uint64_t kLastOf<kernels::JointKind> = 5;
template <>
inline constexpr std::uint64_t kLastOf<kernels::Model> = 2;
template <>
inline constexpr std::uint64_t kLastOf<Place> = 4;
template <>
inline constexpr std::uint64_t kLastOf<ManifoldPair::StackRole> = 2;

template <class A>
void visit(A& a, Vec2& v) {
  numbers(a, v.x, v.y);
}
template <class A>
void visit(A& a, LatticePoint& p) {
  numbers(a, p.x, p.y, p.dx, p.dy);
}
template <class A>
void visit(A& a, BodyId& id) {
  numbers(a, id.index, id.generation);
}

template <class A>
void visit(A& a, Hull& h) {
  for (int k = 0; k < Hull::kMost; ++k) numbers(a, h.x[k], h.y[k], h.nx[k], h.ny[k]);
  numbers(a, h.radius, h.reach, h.inner, h.count);
  a.require(h.count >= 0 && h.count <= Hull::kMost && h.radius >= 0 && h.reach >= 0 && h.inner >= 0);
}

/// A variant, by the number of its alternative: each(alternative).
template <class A, class V, class Each>
void alternatives(A& a, V& v, const Each& each) {
  auto which = static_cast<std::uint8_t>(v.index());
  a.index(std::variant_size_v<V>, which);
  if constexpr (A::kLoading) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      ((which == I ? static_cast<void>(v.template emplace<I>()) : void()), ...);
    }
    (std::make_index_sequence<std::variant_size_v<V>>());
  }
  std::visit(each, v);
}

template <class A>
void visit(A& a, WorldDesc& d) {
  numbers(a, d.bounds.xmin, d.bounds.ymin, d.bounds.xmax, d.bounds.ymax, d.boundary, d.gravity.x, d.gravity.y,
          d.linear_damping, d.wall.density, d.wall.restitution, d.wall.friction, d.dt, d.substeps, d.integrator,
          d.restitution_threshold, d.sleeping, d.skin);
  a.list(d.fields, [&](Field& field) {
    alternatives(a, field, [&](auto& f) {
      if constexpr (std::is_same_v<decltype(f), WellField&>) {
        numbers(a, f.position.x, f.position.y, f.strength, f.softening, f.exponent, f.range);
      } else {
        numbers(a, f.linear, f.quadratic);
      }
    });
  });
}

template <class A>
void visit(A& a, BodyProperties& s) {
  numbers(a, s.inv_mass, s.mass, s.rim_gain, s.radius, s.gravity_scale, s.restitution, s.friction);
  std::uint32_t kind = s.kind;
  BodyType type = s.type;
  a.index(kMostKinds + std::uint64_t{1}, kind);
  a.value(type);
  s.kind = kind & kMostKinds;
  s.type = type;
  a.require(s.inv_mass >= 0 && s.mass >= 0 && s.rim_gain >= 0 && s.radius >= 0 && s.restitution >= 0 &&
            s.restitution <= 1 && s.friction >= 0);
}

template <class A>
void visit(A& a, JointDesc& d) {
  a.value(d.type);
  visit(a, d.a);
  visit(a, d.b);
  visit(a, d.anchor_a);
  visit(a, d.anchor_b);
  maybe(a, d.length);
  numbers(a, d.stiffness, d.damping);
  visit(a, d.axis);
  maybe(a, d.reference);
  maybe(a, d.lower);
  maybe(a, d.upper);
  numbers(a, d.motor_speed, d.motor_limit, d.collide);
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
#define PSIM_DESCRIBED(Class, ...)                      \
  template void Class::describe(Saver&, ##__VA_ARGS__); \
  template void Class::describe(Loader&, ##__VA_ARGS__)

}  // namespace psim
