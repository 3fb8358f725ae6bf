// Which two sides a manifold is of, and the materials of these.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "bodies/surroundings.h"

namespace psim {

/// Names a pair: two bodies, or a body and a piece of fixed geometry. A side that is static or kinematic is A; else A
/// has the lower id.
struct PairName {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  std::uint32_t a = kNone, b = kNone;  ///< slots; a is kNone for fixed geometry
  std::uint32_t shape = kNone;         ///< the number of the piece of fixed geometry, or a wall
  std::uint32_t id_a = kNone, id_b = kNone;
  std::uint32_t owner = kNone;  ///< id of the smaller body, which has few such pairs
  std::uint32_t part_a = 0, part_b = 0;
  bool fixed_a = false;  ///< A is static or kinematic
  bool moved = false;    ///< a body of it was renewed: the pair is found anew behind those of the last strip

  bool of_kinematic() const { return fixed_a && !of_piece() && !moved; }
  bool of_piece() const { return a == kNone; }  ///< B meets fixed geometry, sleepers among it
  bool of_wall() const { return of_piece() && shape >= kWallLeft; }
  bool of_sleeper(const StaticShapes& statics) const { return of_piece() && !of_wall() && statics[shape].asleep; }
  bool same(const PairName& o) const {
    return id_a == o.id_a && id_b == o.id_b && shape == o.shape && part_a == o.part_a && part_b == o.part_b &&
           fixed_a == o.fixed_a;
  }
  std::uint32_t mark() const {  ///< a hash that tells most pairs of an owner apart
    return (id_a * 0x9E3779B1u) ^ (id_b * 0x85EBCA77u) ^ (shape * 0xC2B2AE3Du) ^ (part_a << 16) ^ part_b;
  }
};

/// The surfaces of the two sides of a pair.
struct Sides {
  Surface a, b;
  const Surface* decided = nullptr;  ///< what the contact has instead, if the host decided so (decisions.h)
  /// m/s: what the surfaces run, B against A, to the left of the normal from A to B.
  float belt() const { return decided != nullptr ? decided->tangent_speed : a.tangent_speed + b.tangent_speed; }
  float rolling() const {
    return decided != nullptr ? decided->rolling_resistance : std::max(a.rolling_resistance, b.rolling_resistance);
  }
  float friction(const MixingRules& rules) const {
    return decided != nullptr ? decided->friction : mixed(rules.friction, a.friction, b.friction);
  }
  float restitution(const MixingRules& rules) const {
    return decided != nullptr ? decided->restitution : mixed(rules.restitution, a.restitution, b.restitution);
  }
};
/// Of a wall of the world.
inline Surface surface_of(const Material& m) {
  return {coefficient(m.restitution), coefficient(m.friction), coefficient(m.tangent_speed),
          coefficient(m.rolling_resistance)};
}
/// The sides of a pair. Surfaces of a body are read by its properties, which the caller knows: those of A do not count
/// where it is a wall.
inline Sides sides_of(const PairName& pair, const Surroundings& s, const BodyProperties& of_a,
                      const BodyProperties& of_b) {
  const Surface b = s.bodies.surface_of(of_b, pair.part_b);
  if (pair.of_wall()) return {surface_of(s.wall), b, nullptr};
  if (!pair.of_piece()) return {s.bodies.surface_of(of_a, pair.part_a), b, nullptr};
  const StaticShape& piece = s.statics[pair.shape];
  if (piece.special) return {s.bodies.surface_of(of_a, piece.part), b, nullptr};
  return {{piece.restitution, piece.friction, 0, 0}, b, nullptr};
}

}  // namespace psim
