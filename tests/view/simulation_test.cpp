// What hands do to the viewer's world, and what it tells.
#include "model/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "model/body_columns.h"
#include "model/catalogue.h"
#include "output/user_error.h"
#include "small_scene.h"

namespace psim::view {
namespace {

TEST(ViewSimulation, GrabbedBodyFollowsThePointer) {
  for (const std::uint32_t index : {1u, 3u}) {
    Simulation simulation = make_simulation();
    const Vec2 start = index == 1 ? Vec2{0, -9} : Vec2{12, -9.5};
    simulation.grab(start, 0.1);
    simulation.drag({start.x + 2, start.y + 8});
    for (int frame = 0; frame < 120; ++frame) simulation.step();
    const auto now = body(simulation, index);
    ASSERT_TRUE(now);
    EXPECT_NEAR(now->x, start.x + 2, 0.1);
    EXPECT_NEAR(now->y, start.y + 8, 0.1);
    simulation.let_go();
    for (int frame = 0; frame < 120; ++frame) simulation.step();
    EXPECT_LT(body(simulation, index)->y, -8);
  }
}

// Two springs to an unseen body hold it: nothing of that is seen, counted or left behind.
TEST(ViewSimulation, GrabIsAJointThatGoesWithTheHand) {
  Simulation simulation = make_simulation();
  const Status before = told(simulation);
  simulation.grab({0, -9}, 0.1);
  simulation.drag({0, 0});
  simulation.step();
  Status status = told(simulation);
  EXPECT_EQ(status.world->joint_count(), 2u);
  EXPECT_EQ(status.bodies, 4u);
  EXPECT_TRUE(status.joints->empty());
  ASSERT_NE(status.world->latest_snapshot(), nullptr);
  BodyColumns columns;
  columns.set(*status.world->latest_snapshot(), status.catalogue);
  ASSERT_EQ(columns.size(), 5u);
  EXPECT_EQ(columns.seen(), 4u);
  EXPECT_TRUE(status.catalogue->hidden(columns.looks()[4]));
  EXPECT_TRUE(status.catalogue->kind(4).points.empty());
  simulation.let_go();
  EXPECT_EQ(told(simulation).world->joint_count(), 0u);
  EXPECT_EQ(told(simulation).world->body_count(), 4u);
  simulation.spawn({10, 10}, SpawnShape::box, 1);  // takes the id over
  EXPECT_FALSE(told(simulation).catalogue->hidden(told(simulation).catalogue->look(4)));

  for (const int how : {0, 1, 2, 3}) {
    simulation.grab({-6, -9}, 0.1);
    EXPECT_EQ(told(simulation).world->joint_count(), 2u);
    if (how == 0) simulation.set_settings(told(simulation).settings);
    if (how == 1) simulation.restart();
    if (how == 2) simulation.load("galton");
    if (how == 3) {
      simulation.erase({-6, -9}, 0.1);  // the body that is held, or what holds it
      simulation.step();
    }
    EXPECT_EQ(told(simulation).world->joint_count(), 0u) << how;
    EXPECT_EQ(told(simulation).world->body_count(), told(simulation).bodies) << how;
    simulation.drag({0, 0});
    simulation.step();
    simulation = make_simulation();
  }
}

// A body that is thrown past the pointer comes to rest there and does not go round it.
TEST(ViewSimulation, GrabbedBodyDoesNotCircleThePointer) {
  Simulation simulation = make_simulation();
  simulation.set_gravity({0, 0});
  simulation.grab({0, -9}, 0.1);
  simulation.drag({0, 5});
  for (int frame = 0; frame < 30; ++frame) simulation.step();
  const Status status = told(simulation);
  status.world->set_velocity(status.world->id_of(1), {40, 0}, 0);
  for (int frame = 0; frame < 60; ++frame) simulation.step();
  const auto now = body(simulation, 1);
  EXPECT_NEAR(now->x, 0, 0.05);
  EXPECT_NEAR(now->y, 5, 0.05);
  EXPECT_LT(std::hypot(now->vx, now->vy), 0.1);
}

// The pointer is far below the floor and outside of the world.
TEST(ViewSimulation, GrabbedBodyThatCannotFollowIsPulledWithinBounds) {
  for (const Boundary boundary : {Boundary::walls, Boundary::open, Boundary::periodic}) {
    Scene scene = small_scene();
    scene.world.boundary = boundary;
    if (boundary != Boundary::walls) scene.world.gravity = {0, 0};
    Simulation simulation{scene, best_isa(), 1};
    simulation.grab({0, -9}, 0.1);
    simulation.drag({0, -500});
    for (int frame = 0; frame < 120; ++frame) simulation.step();
    const auto now = body(simulation, 1);
    if (boundary == Boundary::open) {  // it has left, and nothing holds on to it
      EXPECT_FALSE(now);
      EXPECT_EQ(told(simulation).world->body_count(), 3u);
      EXPECT_EQ(told(simulation).bodies, 3u);
      continue;
    }
    ASSERT_TRUE(now);
    if (boundary == Boundary::walls) {
      EXPECT_NEAR(now->y, -9, 0.1);
    }
    if (boundary == Boundary::periodic) {
      EXPECT_NEAR(std::remainder(now->y + 10, 40), 0, 0.1);  // on the seam
    }
    EXPECT_LT(std::hypot(now->vx, now->vy), 0.5);
  }
}

TEST(ViewSimulation, ExplosionPushesAway) {
  Simulation simulation = make_simulation();
  simulation.explode({-3, -9.5}, 5, 10);
  simulation.step();
  EXPECT_LT(body(simulation, 0)->vx, -1);
  EXPECT_GT(body(simulation, 1)->vx, 1);
  EXPECT_EQ(body(simulation, 2)->vx, 0);  // out of reach
}

// The same world goes on; another one has it, too; a restart and another scene do not.
TEST(ViewSimulation, AWellIsOfTheWorldThatRuns) {
  Simulation simulation = make_simulation();
  simulation.set_gravity({0, 0});
  for (int frame = 0; frame < 3; ++frame) simulation.step();
  const Status before = told(simulation);
  EXPECT_TRUE(before.wells->empty());
  simulation.add_well({5, 5}, 300, 100);
  Status status = told(simulation);
  EXPECT_EQ(status.world_serial, before.world_serial);
  ASSERT_EQ(status.wells->size(), 1u);
  EXPECT_EQ(status.wells->front().x, 5);
  EXPECT_EQ(status.message, "");
  EXPECT_TRUE(before.wells->empty());  // what was told stays as it is
  simulation.step();
  EXPECT_GT(body(simulation, 0)->vx, 0);
  EXPECT_GT(body(simulation, 0)->vy, 0);
  simulation.set_settings(status.settings);
  EXPECT_EQ(told(simulation).wells->size(), 1u);
  simulation.add_well({0, 0}, 300, 0);
  EXPECT_EQ(told(simulation).world->desc().fields.size(), 2u);
  simulation.add_well({0, 0}, 300, -1);  // refused, and the world says why
  EXPECT_EQ(told(simulation).wells->size(), 2u);
  EXPECT_NE(told(simulation).message, "");
  simulation.restart();
  EXPECT_TRUE(told(simulation).wells->empty());
  simulation.load("orbits");
  EXPECT_EQ(told(simulation).wells->size(), 1u);
}

TEST(ViewSimulation, SpawnedBodiesWallsAndErasedOnesCount) {
  Simulation simulation = make_simulation();
  for (const SpawnShape shape : {SpawnShape::disc, SpawnShape::box, SpawnShape::polygon, SpawnShape::capsule}) {
    simulation.spawn({-15 + 5.0 * static_cast<int>(shape), 10}, shape, 0.5);
  }
  EXPECT_EQ(told(simulation).bodies, 8u);
  simulation.spawn({-6, -9}, SpawnShape::disc, 0.5);  // no room
  EXPECT_EQ(told(simulation).bodies, 8u);
  simulation.add_wall({-5, 3}, {5, 3});
  EXPECT_EQ(told(simulation).bodies, 9u);
  simulation.erase({-6, -9}, 0.1);
  EXPECT_EQ(told(simulation).bodies, 8u);
  simulation.step();
  simulation.restart();
  EXPECT_EQ(told(simulation).bodies, 4u);
}

// A body that takes the place of one that was erased is not tied to what that one was tied to.
TEST(ViewSimulation, JointsGoWithTheirBodies) {
  Scene scene = small_scene();
  for (const std::size_t b : {std::size_t{1}, std::size_t{2}}) {
    SceneJoint joint;
    joint.a = 0;
    joint.b = b;
    scene.joints.push_back(joint);
  }
  Simulation simulation{scene, best_isa(), 1};
  EXPECT_EQ(told(simulation).joints->size(), 2u);
  simulation.erase({6, -9}, 0.1);  // body 2
  EXPECT_EQ(told(simulation).joints->size(), 1u);
  simulation.spawn({5, 10}, SpawnShape::disc, 0.5);
  ASSERT_TRUE(body(simulation, 2));
  EXPECT_EQ(told(simulation).joints->size(), told(simulation).world->joint_count());
  EXPECT_EQ(told(simulation).joints->front().b, 1u);
}

TEST(ViewSimulation, JointsThatBreakAreGone) {
  Scene scene = small_scene();
  SceneJoint joint;
  joint.a = kWorldSide;
  joint.b = 1;
  joint.joint.anchor_a = {scene.bodies[1].position.x, scene.bodies[1].position.y + 1};
  scene.joints.push_back(joint);
  joint.b = 2;
  joint.joint.anchor_a = {scene.bodies[2].position.x, scene.bodies[2].position.y + 1};
  joint.joint.break_force = 1e-3;
  scene.joints.push_back(joint);
  scene.bodies[1].position.y += 5, scene.bodies[2].position.y += 5;
  Simulation simulation{scene, best_isa(), 1};
  for (int frame = 0; frame < 10; ++frame) simulation.step();
  EXPECT_EQ(told(simulation).world->joint_count(), 1u);
  ASSERT_EQ(told(simulation).joints->size(), 1u);
  EXPECT_EQ(told(simulation).joints->front().b, 1u);
}

TEST(ViewSimulation, NewWorldGoesOnFromThePresentState) {
  Simulation simulation = make_simulation();
  simulation.spawn({3, 20}, SpawnShape::disc, 0.5);
  simulation.explode({-3, -9.5}, 5, 10);
  for (int frame = 0; frame < 20; ++frame) simulation.step();
  simulation.erase({told(simulation).world->body({2, 0})->x, -9}, 0.1);
  const auto before = told(simulation).world->published();
  const std::vector<double> x(before.x.begin(), before.x.end());
  const std::vector<double> vy(before.vy.begin(), before.vy.end());
  Settings settings = told(simulation).settings;
  settings.isa = Isa::scalar;
  settings.threads = 2;
  settings.substeps = 8;
  settings.restitution = 0.5;
  simulation.set_settings(settings);
  const Status status = told(simulation);
  EXPECT_EQ(status.world->isa(), Isa::scalar);
  EXPECT_EQ(status.world->desc().substeps, 8);
  EXPECT_EQ(status.frame, 20u);
  const auto after = status.world->published();
  ASSERT_EQ(after.x.size(), x.size());
  for (std::size_t row = 0; row < x.size(); ++row) {
    EXPECT_NEAR(after.x[row], x[row], 1e-6);
    EXPECT_NEAR(after.vy[row], vy[row], 1e-6);
  }
  EXPECT_NE(status.message.find("new world"), std::string::npos);
}

// What a slider says is what bodies do from then on.
TEST(ViewSimulation, EverySliderActs) {
  const auto change = [](Simulation& simulation, auto&& set) {
    Settings settings = told(simulation).settings;
    set(settings);
    simulation.set_settings(settings);
  };
  {
    Simulation simulation = make_simulation();
    simulation.set_gravity({3, 0});
    for (int frame = 0; frame < 60; ++frame) simulation.step();
    EXPECT_NEAR(body(simulation, 0)->vx, 3, 0.01);
    EXPECT_EQ(told(simulation).settings.gravity.x, 3);
  }
  for (const double restitution : {0.0, 0.8}) {  // of discs that fall again
    Simulation simulation = make_simulation();
    simulation.spawn({0, 0}, SpawnShape::disc, 0.5);
    simulation.step();
    change(simulation, [&](Settings& s) { s.restitution = restitution; });
    double fastest = 0;
    for (int frame = 0; frame < 120; ++frame) {
      simulation.step();
      fastest = std::max(fastest, body(simulation, 4)->vy);
    }
    EXPECT_EQ(fastest > 2, restitution > 0) << fastest;
  }
  for (const double friction : {0.0, 1.0}) {  // of a box on a floor that begins to lean
    Simulation simulation = make_simulation();
    change(simulation, [&](Settings& s) { s.friction = friction; });
    simulation.set_gravity({2, -9.8});
    for (int frame = 0; frame < 60; ++frame) simulation.step();
    EXPECT_EQ(body(simulation, 3)->vx > 0.5, friction == 0) << body(simulation, 3)->vx;
    EXPECT_LE(body(simulation, 3)->vx, 2.05);
  }
  {  // the same world goes on, and a new one takes it over
    Simulation simulation = make_simulation();
    for (int frame = 0; frame < 3; ++frame) simulation.step();
    const std::uint64_t world = told(simulation).world_serial;
    simulation.set_skin(3);
    EXPECT_EQ(told(simulation).settings.skin, 3);
    EXPECT_EQ(told(simulation).world->desc().skin, 3);
    EXPECT_EQ(told(simulation).world_serial, world);
    simulation.step();
    EXPECT_TRUE(told(simulation).steps.back().rebuilt);
    simulation.set_skin(9);  // out of range
    EXPECT_EQ(told(simulation).settings.skin, 3);
    change(simulation, [](Settings& s) { s.substeps = 5; });
    EXPECT_EQ(told(simulation).world->desc().skin, 3);
  }
  {
    Simulation simulation = make_simulation();
    change(simulation, [](Settings& s) { s.substeps = 7; });
    simulation.step();
    EXPECT_EQ(told(simulation).steps.back().detail.substeps, 7);
    change(simulation, [](Settings& s) { s.threads = 3; });
    EXPECT_EQ(told(simulation).world->threads(), 3);
    EXPECT_EQ(told(simulation).world->desc().substeps, 7);
    for (const Isa isa : kAllIsas) {
      if (!isa_available(isa)) continue;
      change(simulation, [isa](Settings& s) { s.isa = isa; });
      simulation.step();
      EXPECT_EQ(told(simulation).world->isa(), isa);
    }
  }
}

TEST(ViewSimulation, ContactsAndForcesAreToldWhereWanted) {
  Simulation simulation = make_simulation();
  for (int frame = 0; frame < 60; ++frame) simulation.step();
  EXPECT_FALSE(told(simulation).touches);
  simulation.set_collect({.contacts = true, .forces = true});
  const Status status = told(simulation);  // without another step
  ASSERT_TRUE(status.touches);
  ASSERT_EQ(status.touches->contacts.size(), 5u);
  ASSERT_EQ(status.touches->forces.size(), 4u);
  const float g = 9.81f, disc = 3.14159f * g, box = 2 * 3 * g;
  for (std::size_t id = 0; id < 4; ++id) EXPECT_NEAR(status.touches->forces[id], id < 3 ? disc : box, 0.1) << id;
  EXPECT_NEAR(status.touches->contacts[0].point.y, -10, 1e-2);
  EXPECT_NEAR(status.touches->contacts[0].ny, -1, 1e-5);
  BodyColumns columns;
  columns.set(*status.world->latest_snapshot(), status.catalogue);
  EXPECT_TRUE(columns.forces().empty());
  columns.set_forces(status.touches->forces);
  ASSERT_EQ(columns.forces().size(), 4u);
  EXPECT_NEAR(columns.forces()[3], box, 0.1);
  EXPECT_NEAR(columns.bright(Colouring::force), disc, 0.1);  // of four bodies nearly the most
  simulation.set_collect({.contacts = false, .forces = true});
  EXPECT_TRUE(told(simulation).touches->contacts.empty());
  simulation.set_collect({});
  EXPECT_FALSE(told(simulation).touches);
}

TEST(ViewSimulation, StripsAndColoursAreToldWhereWanted) {
  Simulation simulation = make_simulation();
  for (int frame = 0; frame < 5; ++frame) simulation.step();
  simulation.add_wall({-5, 3}, {5, 3});  // static: no strip
  simulation.set_collect({.strips = true});
  Status status = told(simulation);
  ASSERT_TRUE(status.touches);
  EXPECT_TRUE(status.touches->contacts.empty());
  EXPECT_EQ(status.touches->groups, (std::vector<float>{0, 0, 0, 0, kNoGroup}));
  simulation.set_collect({.contacts = true, .colours = true});
  status = told(simulation);
  ASSERT_EQ(status.touches->groups.size(), 4u);
  for (const ContactLook& c : status.touches->contacts) {
    EXPECT_NE(c.colour, kNoColour);
    EXPECT_GE(status.touches->groups[c.a], static_cast<float>(c.colour));
  }
  BodyColumns columns;
  columns.set(*status.world->latest_snapshot(), status.catalogue);
  EXPECT_TRUE(columns.groups().empty());
  columns.set_groups({2, kNoGroup});
  EXPECT_EQ(columns.groups(), (std::vector<float>{2, kNoGroup, kNoGroup, kNoGroup}));
}

TEST(ViewSimulation, SceneThatIsNotThereChangesNothing) {
  Simulation simulation = make_simulation();
  const std::uint64_t serial = told(simulation).world_serial;
  simulation.load("no-such-scene");
  EXPECT_EQ(told(simulation).world_serial, serial);
  EXPECT_NE(told(simulation).message.find("no-such-scene"), std::string::npos);
  simulation.load("galton");
  EXPECT_GT(told(simulation).world_serial, serial);
}

}  // namespace
}  // namespace psim::view
