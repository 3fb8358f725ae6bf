// What a scene does not have is not in the plan and owns no memory; the first body that needs it brings it,
// and it goes with the last one. That it takes no instructions either is tests/absent's to count.
#include <functional>
#include <ostream>

#include "support.h"

namespace psim::test {
namespace {

// Brings something into a world and returns what takes it out again.
using Bring = std::function<std::function<void()>(World&)>;

struct Feature {
  const char* name;
  std::vector<const char*> stages;  // of the plan
  Bring bring;
  std::size_t kept_bytes = 0;  // at most, once it is gone
};

std::ostream& operator<<(std::ostream& out, const Feature& f) { return out << f.name; }

PlanEntry entry(const World& world, std::string_view stage) {
  for (const PlanEntry& e : world.plan()) {
    if (e.stage == stage) return e;
  }
  throw std::runtime_error("no stage " + std::string(stage));
}

// Discs alike on the floor of a rough box, awake.
std::unique_ptr<World> plain() {
  WorldDesc desc = walled({0, 0, 20, 20}, {0, -kG}, material(0, 0.5));
  desc.sleeping = false;
  auto world = make(desc);
  add(*world, lattice(100, {0.5, 0, 19.5, 11}, 0.5, 0, {}));
  run(*world, 10);
  return world;
}

Bring body(BodyDesc desc) {
  return [desc](World& world) {
    const BodyId id = add(world, desc);
    return [&world, id] { EXPECT_TRUE(world.remove_body(id)); };
  };
}

BodyDesc one_more() { return disc({10, 13}); }

template <class Change>
Bring disc_with(const Change& change) {
  BodyDesc desc = one_more();
  change(desc);
  return body(desc);
}

BodyDesc box() {
  BodyDesc desc = one_more();
  desc.shape = BoxShape{1, 1};
  return desc;
}

const std::vector<Feature>& features() {
  static const std::vector<Feature> kAll = {
      {"rotation", {"rotation"}, disc_with([](BodyDesc& d) { d.angular_velocity = 1; })},
      {"friction", {"solver.friction", "rotation"}, disc_with([](BodyDesc& d) { d.material.friction = 0.5; })},
      {"restitution", {"solver.restitution"}, disc_with([](BodyDesc& d) { d.material.restitution = 0.5; })},
      {"joints",
       {"joints", "rotation"},
       [](World& world) {
         JointDesc d;
         d.a = world.id_of(0);
         d.b = world.id_of(1);
         d.collide = true;
         std::string error;
         const JointId id = world.add_joint(d, error);
         EXPECT_EQ(error, "");
         return [&world, id] { EXPECT_TRUE(world.remove_joint(id)); };
       },
       1024},  // what tells old ids from new ones
      {"polygons", {"manifolds", "rotation", "continuous"}, body(box())},
      {"gravity scales", {"forces"}, disc_with([](BodyDesc& d) { d.gravity_scale = 0.5; })},
      {"mixed radii", {"broad_phase.mixed_radii"}, disc_with([](BodyDesc& d) {
         d.shape = DiscShape{0.6};
         d.mass = kPi / 4;
       })},
      {"mixed masses", {"solver.masses", "solver.heavy_loads"}, disc_with([](BodyDesc& d) { d.mass = 100; })},
      {"sleeping",
       {"sleep"},
       [](World& world) {
         world.set_sleeping(true);
         return [&world] { world.set_sleeping(false); };
       }},
      {"fast bodies", {"continuous"}, disc_with([](BodyDesc& d) {
         d.bullet = true;
         d.velocity = {0, -200};
       })},
      {"publish",
       {"publish"},
       [](World& world) {
         world.enable_snapshots(true);
         return [&world] { world.enable_snapshots(false); };
       }},
      {"filters", {"filters"}, disc_with([](BodyDesc& d) { d.filter.mask = 2; })},
      {"events",
       {"events"},
       [](World& world) {
         EventOptions options;
         options.contacts = true;
         world.set_event_options(options);
         return [&world] { world.set_event_options({}); };
       }},
  };
  return kAll;
}

class Features : public testing::TestWithParam<Feature> {};

TEST_P(Features, AreNotThereUntilTheFirstBodyNeedsThemAndGoWithTheLast) {
  auto world = plain();
  const std::uint64_t pairs = world->step().pairs;
  const auto expect_absent = [&](std::size_t most) {
    for (const char* stage : GetParam().stages) {
      EXPECT_FALSE(entry(*world, stage).needed) << stage;
      EXPECT_LE(entry(*world, stage).bytes, most) << stage;
    }
  };
  for (int round = 0; round < 2; ++round) {
    expect_absent(round == 0 ? 0 : GetParam().kept_bytes);
    const std::function<void()> take_out = GetParam().bring(*world);
    for (const char* stage : GetParam().stages) EXPECT_TRUE(entry(*world, stage).needed) << stage;
    run(*world, 40);
    for (const char* stage : GetParam().stages) {
      EXPECT_TRUE(entry(*world, stage).needed) << stage;
      EXPECT_GT(entry(*world, stage).bytes, 0u) << stage;
    }
    take_out();
    for (const char* stage : GetParam().stages) EXPECT_FALSE(entry(*world, stage).needed) << stage;
    run(*world, 40);
    expect_absent(GetParam().kept_bytes);
  }
  EXPECT_GT(world->step().pairs, pairs / 2);
  EXPECT_TRUE(all_finite(*world));
}

// Nothing is there that nobody brought: every other feature's entry stays as it was.
TEST_P(Features, BringNothingElse) {
  auto world = plain();
  const auto before = world->plan();
  const std::function<void()> take_out = GetParam().bring(*world);
  run(*world, 40);
  const auto with = world->plan();
  ASSERT_EQ(with.size(), before.size());
  std::vector<std::string> allowed(GetParam().stages.begin(), GetParam().stages.end());
  if (std::string(GetParam().name) == "polygons") allowed.push_back("broad_phase.mixed_radii");
  for (std::size_t k = 0; k < with.size(); ++k) {
    if (std::find(allowed.begin(), allowed.end(), with[k].stage) != allowed.end()) continue;
    EXPECT_EQ(with[k].needed, before[k].needed) << with[k].stage;
    EXPECT_EQ(with[k].bytes, before[k].bytes) << with[k].stage;
  }
  take_out();
}

// A world that is restored where a feature is on its way in or out goes on with the same bits.
TEST_P(Features, ComeAndGoAlikeInARestoredWorld) {
  auto world = plain();
  auto other = plain();
  std::vector<std::byte> state;
  std::string error;
  const auto pass_on = [&] {
    world->save(state);
    ASSERT_TRUE(other->restore(state, error)) << error;
    EXPECT_EQ(hashes(*world, 20), hashes(*other, 20));
  };
  const std::function<void()> take_out = GetParam().bring(*world);
  pass_on();
  take_out();
  pass_on();
}

INSTANTIATE_TEST_SUITE_P(, Features, testing::ValuesIn(features()), [](const auto& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

// Fields are the world's from the first.
TEST(Plan, HasFieldsOnlyInWorldsWithThem) {
  for (const bool with : {false, true}) {
    WorldDesc desc = walled({0, 0, 20, 20});
    desc.integrator = Integrator::rk4;
    if (with) desc.fields.push_back(WellField{{10, 10}, 50, 1});
    auto world = make(desc);
    add(*world, lattice(100, {0.5, 0, 19.5, 11}, 0.5, 0, {}));
    run(*world, 10);
    for (const char* stage : {"forces", "forces.integrator"}) {
      EXPECT_EQ(entry(*world, stage).needed, with) << stage;
      EXPECT_EQ(entry(*world, stage).bytes != 0, with) << stage;
    }
  }
}

// Discs that friction set turning go on turning when nothing rubs any more.
TEST(Plan, KeepsRotationWhileSomebodyTurns) {
  auto world = make(walled({0, 0, 20, 20}, {0, -kG}, material(0, 0.5)));
  const BodyId rough = add(*world, disc({5, 0.5}, {3, 0}, 0.5, material(0, 0.5)));
  const BodyId spun = add(*world, disc({15, 5}));
  ASSERT_TRUE(world->apply_angular_impulse(spun, 0.1));
  run(*world, 30);
  ASSERT_TRUE(world->remove_body(rough));
  EXPECT_FALSE(entry(*world, "solver.friction").needed);
  EXPECT_TRUE(entry(*world, "rotation").needed);
  const double angle = state(*world, spun).angle;
  run(*world, 30);
  EXPECT_GT(state(*world, spun).angle, angle);
  ASSERT_TRUE(world->remove_body(spun));
  add(*world, disc({15, 5}));
  run(*world, 2);
  EXPECT_FALSE(entry(*world, "rotation").needed);
  EXPECT_EQ(entry(*world, "rotation").bytes, 0u);
}

// The reader of snapshots keeps the one that it has.
TEST(Plan, LeavesTheReaderItsSnapshot) {
  auto world = plain();
  world->enable_snapshots(true);
  run(*world, 3);
  const Snapshot* shot = world->latest_snapshot();
  ASSERT_NE(shot, nullptr);
  const std::vector<float> x = shot->x;
  run(*world, 3);  // a fresh one that the reader does not take
  world->enable_snapshots(false);
  run(*world, 3);
  EXPECT_EQ(world->latest_snapshot(), shot);
  EXPECT_EQ(shot->x, x);
  world->enable_snapshots(true);
  run(*world, 1);
  ASSERT_NE(world->latest_snapshot(), nullptr);
  EXPECT_EQ(world->latest_snapshot()->frame, world->frame());
  EXPECT_EQ(world->latest_snapshot()->x.size(), 100u);
}

}  // namespace
}  // namespace psim::test
