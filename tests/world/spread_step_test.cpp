// A step whose work is spread over frames: whatever the host does meanwhile, nothing is missed and nothing differs.
#include <algorithm>
#include <cmath>
#include <functional>

#include "support.h"

namespace psim::test {
namespace {

// A heap nearly at rest, its lists made anew in a step spread over frames; in the frame after so many pieces, the host
// does something that throws them away.
class SpreadStep : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  static std::unique_ptr<World> heap() {
    auto world = pile(600);
    world->set_sleeping(false);
    run(*world, 300);
    return world;
  }
  static std::unique_ptr<World> box_heap() {
    auto world = make(walled({0, 0, 30, 80}, {0, -kG}, material(0, 0.5)), best_isa(), 1);
    for (int k = 0; k < 250; ++k) {
      BodyDesc d;
      d.shape = BoxShape{1, 1, 0};
      d.position = {1.2 + 1.1 * (k % 25), 0.6 + 1.05 * (k / 25)};
      d.material = material(0, 0.5);
      add(*world, d);
    }
    run(*world, 60);
    return world;
  }
  static double fastest(World& world) {
    double most = 0;
    const PublishedState s = world.published();
    for (std::size_t k = 0; k < 600; ++k) most = std::max(most, std::hypot(s.vx[k], s.vy[k]));
    return most;
  }
  static StepDetail some(std::uint32_t pieces) {
    StepDetail d;
    d.solves = false;
    d.pieces = pieces;
    return d;
  }
};

TEST_P(SpreadStep, ABodyThatComesMeanwhileLeavesThePileItsImpulses) {
  auto whole = heap(), spread = heap();
  const double before = fastest(*whole);
  const BodyDesc drop = disc({15, 90});
  for (World* world : {whole.get(), spread.get()}) add(*world, drop);
  spread->replay(some(GetParam()));
  spread->diagnostics();
  spread->why_awake(spread->id_of(3));
  add(*spread, disc({5, 90}));
  add(*whole, disc({5, 90}));
  for (int k = 0; k < 5; ++k) {
    whole->step();
    spread->step();
    EXPECT_LT(fastest(*spread), 2 * before + 1e-3) << "frame " << k;
  }
  EXPECT_NEAR(fastest(*spread), fastest(*whole), 1e-3);
}

TEST_P(SpreadStep, GoesOnWithTheSameBitsAsInOneFrame) {
  auto whole = heap(), spread = heap();
  for (World* world : {whole.get(), spread.get()}) add(*world, disc({15, 90}));
  spread->replay(some(GetParam()));
  whole->step();
  spread->step();
  EXPECT_EQ(whole->state_hash(), spread->state_hash());
}

TEST_P(SpreadStep, ABodyThatIsPushedMeanwhileIsNotMissed) {
  auto world = heap();
  const BodyId bullet = add(*world, disc({13, 40}, {}, 0.2));
  world->replay(some(GetParam()));
  world->set_velocity(bullet, {0, -2000}, 0);
  world->step();
  EXPECT_GT(state(*world, bullet).y, 5) << "it flew through the pile";
}

// Whatever comes next: the step goes on, or the host throws away what was made of it.
TEST_P(SpreadStep, ASavedStateGoesOnWithTheSameBits) {
  for (const bool boxes : {false, true}) {
    for (const bool add_before : {false, true}) {
      for (const bool spoil : {false, true}) {
        const auto world = boxes ? box_heap() : heap();
        const auto never_saved = boxes ? box_heap() : heap();
        for (World* w : {world.get(), never_saved.get()}) {
          if (add_before) add(*w, disc({15, 70}));
          w->replay(some(GetParam()));
        }
        std::vector<std::byte> state, again;
        std::string error;
        world->save(state);
        const auto back = World::from_state(state, {available_isas().front(), 3}, error);
        ASSERT_NE(back, nullptr) << error;
        back->save(again);
        EXPECT_TRUE(state == again);
        std::uint64_t hash = 0;
        for (World* w : {never_saved.get(), world.get(), back.get()}) {
          w->replay(some(3));
          if (spoil) w->remove_body(w->id_of(7));
          for (int k = 0; k < 4; ++k) w->replay(some(9));
          for (int k = 0; k < 5; ++k) w->step();
          if (w == never_saved.get()) hash = w->state_hash();
          EXPECT_EQ(w->state_hash(), hash) << (w == back.get() ? "restored" : "saved") << (boxes ? ", boxes" : "")
                                           << (add_before ? ", new lists" : "") << (spoil ? ", spoiled" : "");
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pieces, SpreadStep, ::testing::Values(1u, 2u, 4u, 7u, 11u, 14u, 18u, 22u, 26u, 30u, 40u));

}  // namespace
}  // namespace psim::test
