// Which two sides a manifold is of, the materials of these, and what is known of their contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "bodies/surroundings.h"
#include "collide/collide.h"

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

/// Marks the feature of a point that belongs to another piece of the same floor (manifold_floor.cpp).
inline constexpr std::uint16_t kOfAnotherPiece = 0x8000;

/// A pair, and what is known of its contact.
struct ManifoldPair : PairName {
  std::uint32_t lane = kNone;  ///< 8 block + lane in the blocks of the strip
  // When the hulls were looked at the last time:
  Manifold manifold;
  LatticePoint base;  ///< from A (or 0) to B
  Rotor turn_a, turn_b;
  float margin = -1;  ///< m: gaps up to here were found; < 0: the hulls were never looked at
  float gap[2] = {};  ///< m, now; of a pair that is apart, a bound of what it was when the hulls were looked at
  float impulse[2] = {}, friction[2] = {};
  float round_a = 0, round_b = 0;  ///< m: the radii around the two hulls
  float roll = 0;                  ///< N m s, on B: of the torque against rolling
  bool active = false;             ///< it is a contact in this step, and has a lane
  bool ahead = false;              ///< the bodies are apart, and may meet within the step
  bool flying = false;             ///< B comes too fast for a contact: continuous collision sees to it
  bool ghost = false;              ///< it lies below the plane on which the body rests: no contact
  bool landing = false;            ///< the bodies turn, are apart, and may meet within the step
  bool rocking = false;  ///< it is open in one of two points, much nearer in the other one, and its bodies turn
  bool lasting = false;  ///< the manifold may be kept while bodies move little; without points: it was found so
  bool changed = true;   ///< it changed since it was written into its lane
  /// Whether the pair is in a stack that stands on a moving body, in one on fixed ground, or in none.
  enum StackRole : std::uint8_t { kNoStack, kOnMoving, kOnFixed };
  StackRole stack = kNoStack;
  StackRole was_stack = kNoStack;  ///< the role with which it was written into its lane
  std::uint8_t rest_frames = 0;    ///< frames in which it stays out of stacks
  static constexpr std::uint32_t kColours = 32;
  static constexpr std::uint8_t kAlone = 0xFF;  ///< the pair is solved by itself
  /// The colour of its lane: kColours times the run in StripBlocks::end, plus the colour in the run.
  std::uint8_t colour = kAlone;
  /// Of a pair with a side that is solid from one side, or of which the host is asked: whether the other body meets it, or
  /// goes through it until they are apart; not known while they are not near. kNew: the host was not asked yet, and until
  /// then it meets it.
  enum Crossing : std::uint8_t { kUnknown, kMeets, kPasses, kNew };
  Crossing crossing = kUnknown;
  bool placed = false;  ///< the pair is new, and its bodies hardly move
  bool stands = false;  ///< its bodies hang together with fixed ground, over contacts of shapes
  bool hangs = false;   ///< they hang together with fixed ground, over joints, too
  bool yields = false;  ///< the body below takes half of an impulse in a sweep
  /// Steps since it was a contact, up to kIdle, or 0. Meanwhile it keeps its lane, open, for when it is one again.
  std::uint8_t idle = 0;
  static constexpr std::uint8_t kIdle = 30;
  bool is_idle() const { return !active && idle != 0 && idle < kIdle; }
  std::uint8_t recalled = 0;  ///< points whose impulses are from before a body fell asleep or woke
  // When a side falls asleep or wakes, or the pair joins or leaves a stack, the contact gets another stiffness, and the
  // same load would need another overlap. This difference, m, is added to the gaps. It stays while A sleeps, else it
  // fades.
  float offset[2] = {};
  static constexpr float kUnbalanced = -1, kBalanced = 0;
  float balanced = kBalanced;  ///< the compliance for which the offsets were found

  /// Whether the hulls were looked at and have no smaller gap than gap[0], so that they need not be looked at again until
  /// they have moved by as much.
  bool is_apart() const { return margin >= 0 && manifold.count == 0 && lasting; }
  /// Whether its manifold is that of a floor of several pieces.
  bool of_floor() const { return manifold.count == 2 && (manifold.point[1].feature & kOfAnotherPiece) != 0; }
  /// m, of a pair that has points.
  float least_gap() const { return manifold.count == 2 ? std::min(gap[1], gap[0]) : gap[0]; }
};

/// A pair that was found for new lists.
struct FoundPair : PairName {
  std::uint32_t before = kNone;  ///< its place among the pairs of the index
};

/// Counts the pairs that a strip found. `fresh` is how many of them were not known before.
struct FoundCounts {
  std::uint32_t fresh = 0;
  bool fixed = false, kinematic = false;
};

/// Pairs by owner.
class PairIndex {
 public:
  void make(std::span<const ManifoldPair> pairs, std::uint32_t ids, WorkerPool& pool);
  /// The place of a pair among those of which the index was made, or PairName::kNone.
  std::uint32_t find(const PairName& pair, const std::vector<ManifoldPair>& pairs) const;
  void spare(std::size_t pairs);
  void release() { give_back(first_, entries_, owned_); }
  std::size_t bytes() const { return bytes_of(first_, entries_, owned_); }

 private:
  struct Entry {
    std::uint32_t mark = 0, pair = 0;
  };
  struct Owned {
    std::uint32_t owner = 0, mark = 0;
  };
  std::vector<std::uint32_t> first_;  // by id: the entries of id k are [first_[k], first_[k + 1])
  std::vector<Entry> entries_;
  std::vector<Owned> owned_;  // by pair
};

/// The slots of the bodies of a strip.
struct SlotRange {
  std::uint32_t begin = 0, end = 0;
  bool has(std::uint32_t slot) const { return begin <= slot && slot < end; }
};

/// Whether the points of a manifold lie against the direction in which its edge is read. The direction is the same for
/// both bodies.
inline bool runs_backwards(const Manifold& m) {
  const bool steep = std::fabs(m.nx) > std::fabs(m.ny);
  const float sign = (steep ? m.nx : -m.ny) < 0 ? -1.0f : 1.0f;  // the sign of the tangent (-ny, nx)
  const float x = m.point[1].bx - m.point[0].bx, y = m.point[1].by - m.point[0].by;
  return sign * (m.nx * y - m.ny * x) < 0;
}

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
