// States of worlds whose bodies are gone while a step was under way.
#include "support.h"

namespace psim::test {
namespace {

// Found by `soak calls`: the slots of before were saved, though nobody has a slot any more, and the state was refused.
TEST(SavedEmptyWorld, IsRestoredWhereverAStepWas) {
  for (std::uint32_t pieces = 1; pieces < 40; pieces += 3) {
    auto world = make(unbounded(200, {0, -9.81}));
    std::vector<BodyId> ids;
    for (int k = 0; k < 600; ++k) ids.push_back(add(*world, disc({1.02 * (k % 25) - 12, 1.02 * (k / 25) - 12})));
    world->step();
    world->set_skin(2);
    StepDetail part;
    part.solves = false;
    part.pieces = pieces;
    world->replay(part);
    world->set_skin(1.5);
    for (const BodyId id : ids) world->remove_body(id);
    std::vector<std::byte> state;
    world->save(state);
    std::string error;
    const auto other = World::from_state(state, {}, error);
    ASSERT_NE(other, nullptr) << pieces << " pieces: " << error;
    for (World* const w : {world.get(), other.get()}) {
      for (int k = 0; k < 50; ++k) add(*w, disc({0.9 * k, 0}));
      for (int k = 0; k < 10; ++k) w->step();
    }
    EXPECT_EQ(world->state_hash(), other->state_hash());
  }
}

}  // namespace
}  // namespace psim::test
