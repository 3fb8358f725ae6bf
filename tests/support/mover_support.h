// A character in a level, for the tests of movers.
#pragma once

#include "support.h"

namespace psim::test {

inline constexpr double kDt = 1.0 / 60;

inline BodyDesc block(Vec2 at, double width, double height, double angle = 0, BodyType type = BodyType::static_body) {
  BodyDesc body;
  body.type = type;
  body.shape = BoxShape{width, height, 0};
  body.position = at;
  body.angle = angle;
  return body;
}

/// How deep the capsule of a mover is in anything solid from all sides; negative: how far from it.
inline double depth_of(const World& world, const Mover& mover) {
  const MoverDesc& d = mover.desc();
  std::vector<NearHit> near(32);
  const Shape capsule = CapsuleShape{{0, -d.half_height}, {0, d.half_height}, d.radius};
  const std::size_t count = world.nearby(capsule, mover.position(), 0, 1, near);
  for (std::size_t k = 0; k < std::min(count, near.size()); ++k) {
    if (!near[k].one_way) return -near[k].distance;
  }
  return -1;
}

inline double foot(const Mover& mover) { return mover.position().y - mover.desc().half_height - mover.desc().radius; }

/// A game's loop: gravity while it falls, and speed to the right.
inline void walk(World& world, Mover& mover, double speed, int moves, double jump = 0) {
  for (int k = 0; k < moves; ++k) {
    world.step();
    Vec2 v = mover.velocity();
    v.x = speed;
    v.y = jump > 0 && k == 0 ? jump : v.y - kG * kDt;
    ASSERT_TRUE(mover.move(world, v, kDt));
  }
}

inline std::unique_ptr<World> level() {
  auto world = make(unbounded());
  add(*world, ground());
  return world;
}

}  // namespace psim::test
