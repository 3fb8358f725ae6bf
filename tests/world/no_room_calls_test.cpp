// Whichever allocation of a call fails, on any thread: the call says so, all is as before, and it can be made again.
#include <gtest/gtest.h>
#include <psim.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "allocation_counter.h"
#include "no_room_yard.h"
#include "psim/recording.h"
#include "psim/scene.h"
#include "support.h"

namespace psim::test {
namespace {

// All that a call may not change, unless it is done.
std::vector<double> all_of(World& world) {
  std::vector<double> all{static_cast<double>(world.body_count()), static_cast<double>(world.joint_count()),
                          static_cast<double>(world.static_count()), world.desc().gravity.y, world.desc().skin};
  const PublishedState s = world.published();
  for (const auto& column : {s.x, s.y, s.angle, s.vx, s.vy, s.omega})
    all.insert(all.end(), column.begin(), column.end());
  return all;
}

struct Named {
  const char* name;
  std::function<bool(World&)> call;  // false: nothing was done
};

constexpr std::uint32_t kAsleep = 3, kJoined = 1, kBar = 13, kAwake = 20, kOff = 35, kOffWall = 36;

const std::vector<Named>& calls() {
  static std::string error;
  static std::uint32_t first = 0;
  static const auto add = [](BodyDesc Given::*which) {
    return [which](World& w) { return w.add_body(given().*which, error) != kNoBody; };
  };
  static const std::vector<Named> all{
      {"change a part", [](World& w) { return change_part(w, 3); }},
      {"change a static part", [](World& w) { return change_part(w, 0); }},
      {"add a disc", add(&Given::disc)},
      {"add a disc on a sleeper", add(&Given::above)},
      {"add a polygon", add(&Given::polygon)},
      {"add terrain on sleepers", add(&Given::terrain)},
      {"add a kinematic box", add(&Given::bar)},
      {"add discs", [](World& w) { return w.add_discs(given().discs, first, error) == 4; }},
      {"add fixed discs", [](World& w) { return w.add_discs(given().fixed, first, error) == 4; }},
      {"remove a sleeper", [](World& w) { return w.remove_body(nth(w, kAsleep)); }},
      {"remove sleepers",
       [](World& w) {
         const std::array ids{nth(w, kAsleep), nth(w, kAsleep + 1)};
         return w.remove_bodies(ids) == 2;
       }},
      {"remove what is joined", [](World& w) { return w.remove_body(nth(w, kJoined)); }},
      {"remove a moving body", [](World& w) { return w.remove_body(nth(w, kAwake)); }},
      {"remove the ground", [](World& w) { return w.remove_body(nth(w, 0)); }},
      {"place a sleeper",
       [](World& w) {
         return w.set_transform(nth(w, kAsleep), {1, 8}, 0.3);
       }},
      {"place a kinematic bar on sleepers",
       [](World& w) {
         return w.set_transform(nth(w, kBar), {0, 0.9}, 0);
       }},
      {"push a sleeper",
       [](World& w) {
         return w.set_velocity(nth(w, kAsleep), {1, 1}, 0.3);
       }},
      {"push what is joined",
       [](World& w) {
         return w.apply_impulse(nth(w, kJoined), {1, 1});
       }},
      {"push at a point",
       [](World& w) {
         return w.apply_impulse_at(nth(w, kAsleep), {1, 1}, {2, 2});
       }},
      {"turn a sleeper", [](World& w) { return w.apply_angular_impulse(nth(w, kAsleep), 0.1); }},
      {"apply a force to a sleeper",
       [](World& w) {
         return w.apply_force(nth(w, kAsleep), {1, 1});
       }},
      {"apply a force at a point",
       [](World& w) {
         return w.apply_force_at(nth(w, kAwake), {1, 1}, {2, 2});
       }},
      {"apply a torque", [](World& w) { return w.apply_torque(nth(w, kJoined), 0.1); }},
      {"explode",
       [](World& w) {
         return w.explode({{0, 1}, 3, 5, 0.1, ~0u}).has_value();
       }},
      {"fluids", [](World& w) { return pour(w, error); }},
      {"taps", [](World& w) { return open_taps(w, error); }},
      {"fluid in a sensor", [](World& w) { return w.fluid_in_sensor(nth(w, kBar)).has_value(); }},
      {"cut", [](World& w) { return !w.joints_across(given().low, given().high).empty(); }},
      {"fields", [](World& w) { return w.set_fields(given().fields, error); }},
      {"a sleeper becomes a wall", [](World& w) { return w.set_body(nth(w, kAsleep), given().terrain, error); }},
      {"the ground becomes a bar", [](World& w) { return w.set_body(nth(w, 0), given().bar, error); }},
      {"what is joined becomes a polygon",
       [](World& w) { return w.set_body(nth(w, kJoined), given().polygon, error); }},
      {"what is disabled becomes a wall", [](World& w) { return w.set_body(nth(w, kOff), given().terrain, error); }},
      {"disable a sleeper", [](World& w) { return w.set_enabled(nth(w, kAsleep), false); }},
      {"disable what is joined", [](World& w) { return w.set_enabled(nth(w, kJoined), false); }},
      {"disable the ground", [](World& w) { return w.set_enabled(nth(w, 0), false); }},
      {"enable", [](World& w) { return w.set_enabled(nth(w, kOff), true); }},
      {"enable a wall on sleepers", [](World& w) { return w.set_enabled(nth(w, kOffWall), true); }},
      {"change traits of a sleeper", [](World& w) { return change(w, kAsleep); }},
      {"change traits of what moves", [](World& w) { return change(w, kAwake); }},
      {"change traits of the ground", [](World& w) { return change(w, 0); }},
      {"change traits of what is disabled", [](World& w) { return change(w, kOff); }},
      {"user data", [](World& w) { return w.set_user_data(nth(w, kAwake), 7); }},
      {"wake", [](World& w) { return w.wake(nth(w, kAsleep)); }},
      {"gravity",
       [](World& w) {
         return w.set_gravity({0, -5});
       }},
      {"skin", [](World& w) { return w.set_skin(1.5); }},
      {"join",
       [](World& w) {
         JointDesc d;
         d.type = JointType::revolute;
         d.a = nth(w, kAsleep), d.b = nth(w, kAwake);
         return w.add_joint(d, error) != kNoJoint;
       }},
      {"join by a wheel that breaks",
       [](World& w) {
         JointDesc d;
         d.type = JointType::wheel;
         d.a = kWorldBody, d.b = nth(w, kAsleep);
         d.stiffness = 5, d.break_force = 1e6;
         return w.add_joint(d, error) != kNoJoint;
       }},
      {"change a joint",
       [](World& w) {
         JointDesc d = w.joint_desc({0, 0}).value_or(JointDesc{});
         d.lower = 0.1, d.stiffness = 20, d.user_data = 3, d.pressure = 5, d.area = 1;
         return w.set_joint({0, 0}, d, error);
       }},
      {"part",
       [](World& w) {
         return w.remove_joint({0, 0});
       }},
      {"ray",
       [](World& w) {
         return w.ray_cast({-20, 0.4}, {20, 0.4}).has_value();
       }},
      {"rays",
       [](World& w) {
         return !w.ray_cast_all({-20, 0.4}, {20, 0.4}).empty();
       }},
      {"ray batch", [](World& w) { return w.ray_cast_batch(given().rays, given().hits) == 300; }},
      {"shape cast",
       [](World& w) {
         return w.shape_cast(given().box, {-60, 3}, 0, {90, 0}, 1).has_value();
       }},
      {"nearby",
       [](World& w) {
         return w.nearby(given().box, {0, 0}, 0.1, 1, given().near) != 0;
       }},
      {"shapes of a body", [](World& w) { return !w.shapes_of(nth(w, 0)).empty(); }},
      {"bounds of a part", [](World& w) { return w.bounds_of_part(nth(w, kBar), 0).has_value(); }},
      {"bounds of a shape", [](World&) { return shape_bounds(given().polygon.shape).has_value(); }},
      {"point in a shape",
       [](World&) {
         return shape_holds(given().polygon.shape, {}, {0.5, 0.5});
       }},
      {"ray at a shape",
       [](World&) {
         return shape_ray_cast(given().polygon.shape, {}, {-5, 0.5}, {5, 0.5}).has_value();
       }},
      {"distance of two shapes",
       [](World&) {
         return shape_distance(given().polygon.shape, {}, given().terrain.shape, {{3, 9}, 1}).has_value();
       }},
      {"cast of two shapes",
       [](World&) { return shape_cast(given().polygon.shape, given().fall, given().terrain.shape).has_value(); }},
      {"convex hull",
       [](World&) {
         const Vec2 points[] = {{0, 0}, {1, 0}, {1, 1}, {0.5, 0.2}, {0, 1}, {0.5, 1}};
         return convex_hull(points).size() == 4;
       }},
      {"walk and push a sleeper",
       [](World& w) {
         MoverDesc desc;
         desc.push_force = 1e3;
         Mover mover(desc, {-8.72, 0.91});
         const bool done = mover.move(w, {3, 0}, 1.0 / 60);
         return done && !mover.touches().empty();
       }},
      {"overlap",
       [](World& w) {
         return !w.overlap(given().box, {0, 0}, 0.1).empty();
       }},
      {"region",
       [](World& w) {
         return !w.in_region({-10, -10, 10, 10}).empty();
       }},
      {"closest",
       [](World& w) {
         return w.closest({0, 5}, 10).has_value();
       }},
      {"contacts", [](World& w) { return !w.contacts().empty(); }},
      {"strips", [](World& w) { return !w.strips().empty(); }},
      {"sums", [](World& w) { return w.diagnostics().kinetic > 0; }},
      {"hash", [](World& w) { return w.state_hash() != 0; }},
      {"why", [](World& w) { return !w.why_awake(nth(w, kAwake)).empty(); }},
      {"plan", [](World& w) { return !w.plan().empty(); }},
      {"trace",
       [](World& w) {
         w.start_trace();
         w.stop_trace();
         return true;
       }},
      {"save",
       [](World& w) {
         std::vector<std::byte> out;
         w.save(out);
         return !out.empty();
       }},
      {"restore", [](World& w) { return w.restore(given().state, error); }},
  };
  return all;
}

// The call, and whether all allocations fail after the n-th one, too.
class NoRoomForCall : public ::testing::TestWithParam<std::tuple<std::size_t, bool>> {};

TEST_P(NoRoomForCall, ChangesNothing) {
  const auto [which, all] = GetParam();
  const Named& named = calls()[which];
  out_of_memory();
  const auto first = yard();
  std::vector<std::byte> state;
  first->save(state);
  const std::vector<double> before = all_of(*first);
  ASSERT_TRUE(named.call(*first));
  const std::vector<double> after = all_of(*first);
  std::uint64_t n = 1;
  for (;; ++n) {
    std::string error;
    const auto world = World::from_state(state, {.threads = 2}, error);
    ASSERT_NE(world, nullptr) << error;
    ASSERT_FALSE(out_of_memory());
    fail_allocation(allocations() + n, all);
    const bool done = named.call(*world);
    fail_allocation(0);
    if (!out_of_memory()) {
      ASSERT_TRUE(done);
      break;
    }
    ASSERT_FALSE(done) << named.name << ", allocation " << n;
    ASSERT_FALSE(out_of_memory());
    if (all && world->body_count() == 0) {  // there was none to go back to how it was, either
      ASSERT_STREQ(named.name, "restore");
      ASSERT_STREQ(world->step().no_room_for, "motion");
      for (const Named& any : calls()) any.call(*world);
      ASSERT_TRUE(out_of_memory());
      continue;
    }
    ASSERT_EQ(all_of(*world), before) << named.name << ", allocation " << n;
    ASSERT_TRUE(named.call(*world)) << named.name << ", allocation " << n;
    ASSERT_EQ(all_of(*world), after) << named.name << ", allocation " << n;
    ASSERT_EQ(world->step().no_room_for, nullptr);
    for (const double v : all_of(*world)) ASSERT_TRUE(std::isfinite(v)) << named.name << ", allocation " << n;
  }
  RecordProperty("allocations", static_cast<int>(n - 1));
}

INSTANTIATE_TEST_SUITE_P(Calls, NoRoomForCall,
                         ::testing::Combine(::testing::Range(std::size_t{0}, calls().size()), ::testing::Bool()),
                         [](const auto& of) {
                           std::string name = calls()[std::get<0>(of.param)].name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name + (std::get<1>(of.param) ? "_and_all_others" : "");
                         });

// What a step tells may be lost, if the step is not: then the next one tells of all that touch.
TEST(NoRoom, AStepIsDoneOrNot) {
  const auto first = yard();
  std::vector<std::byte> state;
  first->save(state);
  const std::vector<double> before = all_of(*first);
  first->step();
  const std::vector<double> after = all_of(*first);
  first->set_event_options({});
  first->set_event_options({.contacts = true, .hits = true, .hit_speed = 0.1, .sensors = true});
  first->step();
  const std::size_t told = first->events().begin.size();  // by who knows nothing of the steps before
  int refused = 0, lost = 0;
  for (std::uint64_t n = 1;; ++n) {
    std::string error;
    const auto world = World::from_state(state, {.threads = 2}, error);
    const std::uint64_t frame = world->frame();
    fail_allocation(allocations() + n, n % 2 == 0);
    const StepReport report = world->step();
    fail_allocation(0);
    if (!out_of_memory()) break;
    ASSERT_NE(report.no_room_for, nullptr);
    ASSERT_STRNE(report.no_room_for, "motion") << "allocation " << n;
    const bool done = world->frame() != frame;
    (done ? lost : refused) += 1;
    ASSERT_EQ(all_of(*world), done ? after : before) << "allocation " << n << ", " << report.no_room_for;
    ASSERT_EQ(world->step().no_room_for, nullptr);
    if (done && std::string(report.no_room_for) == "events") {
      ASSERT_EQ(world->events().begin.size(), told);
    }
    if (!done) {
      ASSERT_EQ(all_of(*world), after) << "allocation " << n;
    }
  }
  EXPECT_GE(refused, 10);
  EXPECT_GE(lost, 10);
}

TEST(NoRoom, AWorldIsMadeOrNot) {
  for (std::uint64_t n = 1;; ++n) {
    std::string error;
    fail_allocation(allocations() + n);
    const auto world = World::create({}, {.threads = 3}, error);
    fail_allocation(0);
    if (!out_of_memory()) {
      ASSERT_NE(world, nullptr);
      return;
    }
    ASSERT_EQ(world, nullptr) << "allocation " << n;
  }
}

// A push beside the centre is a push and a turn: both or none, in a world where nothing turned yet.
TEST(NoRoom, APushAtAPointIsWhole) {
  for (std::uint64_t n = 1;; ++n) {
    std::string error;
    const auto world = World::create({}, {}, error);
    const BodyId id = world->add_body(disc_at(0, 0), error);
    fail_allocation(allocations() + n, n % 2 == 0);
    const bool done = world->apply_impulse_at(id, {0, 1}, {0.3, 0});
    fail_allocation(0);
    const BodyState s = *world->body(id);
    EXPECT_EQ(done, s.vy != 0);
    EXPECT_EQ(done, s.omega != 0);
    if (!out_of_memory()) break;
    EXPECT_FALSE(done);
  }
}

// What prepare() finds no memory for, is done by the first step, with the same bits.
TEST(NoRoom, PreparedOrNot) {
  std::string error;
  const auto scene = make_builtin("pile", 300, 1, error);
  const auto first = build_world(*scene, {}, error);
  first->step();
  for (std::uint64_t n = 1;; ++n) {
    const auto world = build_world(*scene, {}, error);
    fail_allocation(allocations() + n);
    world->prepare();
    fail_allocation(0);
    const bool failed = out_of_memory();
    ASSERT_EQ(world->step().no_room_for, nullptr) << "allocation " << n;
    ASSERT_EQ(world->state_hash(), first->state_hash()) << "allocation " << n;
    if (!failed) break;
  }
}

// C has a code for it, and the world goes on.
TEST(NoRoom, InCIsACode) {
  psim_world_desc desc;
  psim_world_desc_init(&desc);
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.shape = psim_disc(0.5);
  psim_world* world = nullptr;
  ASSERT_EQ(psim_world_create(&desc, nullptr, &world, nullptr, 0), PSIM_OK);
  const auto until_done = [&](const char* name, const auto& call) {
    for (std::uint64_t n = 1;; ++n) {
      fail_allocation(allocations() + n, n % 2 == 0);
      const psim_result result = call();
      fail_allocation(0);
      if (result == PSIM_OK) return;
      ASSERT_EQ(result, PSIM_ERROR_OUT_OF_MEMORY) << name << ", allocation " << n;
      char line[200];
      psim_last_error(world, line, sizeof line);
      ASSERT_TRUE(std::string(line).find("no room") != std::string::npos ||
                  std::string(line).find("out of memory") != std::string::npos)
          << line;
      ASSERT_LT(n, 1000u);
    }
  };
  psim_body_id id[2];
  for (std::size_t k = 0; k < 2; ++k) {
    body.position = {2.0 * static_cast<double>(k), 0};
    until_done("add", [&] { return psim_world_add_body(world, &body, id + k); });
  }
  psim_joint_desc rod;
  psim_joint_desc_init(&rod);
  rod.a = id[0], rod.b = id[1];
  until_done("join", [&] { return psim_world_add_joint(world, &rod, nullptr); });
  psim_step_report report;
  psim_step_report_init(&report);
  until_done("step", [&] { return psim_world_step(world, &report); });
  std::size_t count = 0;
  psim_body_id found[2];
  until_done("region", [&] { return psim_world_in_region(world, {-1, -1, 3, 1}, nullptr, found, 2, &count); });
  EXPECT_EQ(count, 2u);
  const void* state = nullptr;
  std::size_t size = 0;
  until_done("save", [&] { return psim_world_save(world, &state, &size); });
  until_done("remove", [&] { return psim_world_remove_body(world, id[0]); });
  EXPECT_EQ(psim_world_body_count(world), 1u);
  psim_world_destroy(world);
}

// What is not done is not written down: the recording that is left replays.
TEST(NoRoom, ARecordingHoldsWhatWasDone) {
  const auto first = yard();
  std::vector<std::byte> state;
  first->save(state);
  std::uint64_t failed = 0;
  for (std::uint64_t n = 1; n < 60; ++n) {
    std::string error;
    const auto world = World::from_state(state, {}, error);
    Recorder recorder(*world, 1);
    fail_allocation(allocations() + n);
    recorder.add_body(disc_at(-3.5, 1.2), error);
    recorder.apply_impulse(world->id_of(kAsleep), {1, 2});
    recorder.step();
    const std::array gone{world->id_of(kAsleep + 1), world->id_of(kAwake), world->id_of(kAsleep + 2)};
    recorder.remove_bodies(gone);
    recorder.remove_body(world->id_of(kJoined));
    recorder.step();
    fail_allocation(0);
    failed += out_of_memory() ? 1 : 0;
    recorder.step();
    const auto replay = Replay::open(recorder.recording(), {}, error);
    ASSERT_NE(replay, nullptr) << error;
    while (replay->next()) {
    }
    EXPECT_EQ(replay->differs_at(), 0u) << "allocation " << n;
    EXPECT_TRUE(replay->complete());
  }
  EXPECT_GE(failed, 20u);
}

}  // namespace
}  // namespace psim::test
