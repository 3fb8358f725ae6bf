// Worlds that fall asleep, for the tests. Public API only.
#pragma once

#include "rigid_support.h"

namespace psim::test {

inline std::uint64_t awake(const World& world) {
  std::uint64_t n = 0;
  for (std::uint32_t id = 0; id < world.body_count() + 64; ++id) n += world.is_awake(world.id_of(id));
  return n;
}

/// Until nobody moves but kinematic bodies.
inline void wait_for_rest(World& world, std::uint64_t kinematic = 0, int most = 3600) {
  while (most-- > 0 && world.step().awake > kinematic) {
  }
  ASSERT_GT(most, 0) << "it does not come to rest";
}

inline Placed sleeping_stack(int n) {
  Placed p = stack(n);
  wait_for_rest(*p.world);
  EXPECT_EQ(awake(*p.world), 0u);
  return p;
}

}  // namespace psim::test
