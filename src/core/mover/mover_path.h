// The capsule of a mover on its way through a world, by casts. It keeps the skin, a small distance, from everything: so a
// cast never starts in what the one before came to, and sliding along a wall meets no end of the wall's next piece.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "base/rotor.h"
#include "psim/mover.h"

namespace psim {

/// What a cast meets.
struct Obstacle {
  ShapeCastHit hit;
  double way = 0;  ///< m: how far it is, along the cast
};

class MoverPath {
 public:
  MoverPath(const World& world, const MoverDesc& desc, Vec2 at);

  const World& world;
  const MoverDesc& desc;
  Vec2 up, side;  ///< of length 1: `side` is to the right of `up`
  Vec2 at;        ///< m: the middle of the capsule
  Shape capsule;  ///< upright, about its middle
  QueryFilter filter;
  std::array<MoverTouch, Mover::kMostTouches> touches;
  std::size_t touch_count = 0;

  /// Walks `run` metres to the right along ground with this normal, up slopes and steps; whether it got all the way.
  bool walk(double run, Vec2 normal);
  /// Goes a way through the air, slides along what it meets and takes from the velocity what that takes.
  void fly(Vec2 way, Vec2& velocity);
  /// Looks for ground below and goes down to it: as far as a step if it walked before.
  std::optional<MoverGround> settle(bool walked);
  void touch(const ShapeCastHit& hit);
  bool is_ground(Vec2 normal) const { return dot(normal, up) >= least_rise_; }

 private:
  std::optional<Obstacle> cast(Vec2 way) const;
  double room(const Obstacle& o, Vec2 u, double length) const;
  std::optional<ShapeCastHit> advance(Vec2 way, double& share);
  bool is_walkable(const ShapeCastHit& hit, Vec2 foot, double height, Vec2& face) const;
  bool step_up(double& run);
  Vec2 foot() const { return at - (desc.half_height + desc.radius) * up; }
  // Along ground, to the right.
  static Vec2 along(Vec2 normal) { return {normal.y, -normal.x}; }

  double least_rise_;    // of the normal of ground along `up`
  double slope_ = 0;     // the tangent of the slope limit
  bool wedged_ = false;  // it lies between two surfaces that it cannot stand on
  ShapeCastHit wedge_;   // the second of them, with the normal between both
};

}  // namespace psim
