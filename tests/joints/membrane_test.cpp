// Links that are membranes: pressure, wind and the area inside a ring, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "joint_support.h"
#include "psim/scene.h"

namespace psim::test {
namespace {

const double kHalfTurn = std::acos(-1);

// A ring of discs, 1 m in radius unless it is said otherwise, without gravity.
psim::Scene ring_of(std::uint64_t count, double mass, const LinkDesc& links, Vec2 half = {1, 1}) {
  psim::Scene scene;
  scene.world.gravity = {0, 0};
  scene.world.sleeping = false;
  GroupDesc ring;
  ring.layout = Layout::ring;
  ring.count = count;
  ring.region = {-half.x, -half.y, half.x, half.y};
  ring.radius_min = ring.radius_max = 0.4 * std::min(half.x, half.y) * std::sin(kHalfTurn / static_cast<double>(count));
  ring.body.mass = mass;
  ring.links = links;
  scene.groups.push_back(ring);
  return scene;
}

std::unique_ptr<World> world_of(const psim::Scene& scene, const RunOptions& options = {}) {
  std::string error;
  std::unique_ptr<World> world = build_world(scene, options, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

void run_frames(World& world, int frames) {
  for (int frame = 0; frame < frames; ++frame) world.step();
}

std::vector<BodyState> first_bodies(const World& world, std::uint32_t count) {
  std::vector<BodyState> all;
  for (std::uint32_t k = 0; k < count; ++k) all.push_back(world.body(world.id_of(k)).value());
  return all;
}

struct Extent {
  double least = HUGE_VAL, mean = 0, most = 0;
};
// How far bodies are from their middle.
Extent radius_of(const std::vector<BodyState>& bodies) {
  Vec2 middle;
  const double share = 1 / static_cast<double>(bodies.size());
  for (const BodyState& b : bodies) middle = {middle.x + share * b.x, middle.y + share * b.y};
  Extent out;
  for (const BodyState& b : bodies) {
    const double r = std::hypot(b.x - middle.x, b.y - middle.y);
    out.least = std::min(out.least, r), out.most = std::max(out.most, r), out.mean += share * r;
  }
  return out;
}

double area_in(const std::vector<BodyState>& ring) {
  double area = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const BodyState &a = ring[k], &b = ring[(k + 1) % ring.size()];
    area += 0.5 * (a.x * b.y - a.y * b.x);
  }
  return area;
}

double fastest_of(const std::vector<BodyState>& bodies) {
  double most = 0;
  for (const BodyState& b : bodies) most = std::max(most, std::hypot(b.vx, b.vy));
  return most;
}

// ---- pressure

// The tension T of a ring of radius R under the pressure p is p R. It stretches links of the rest length L and the
// stiffness k, so that EA = k L, by T/EA: R = R0 / (1 - p R0/EA).
TEST(Membranes, ARingOfSpringsGrowsUntilItsTensionHoldsThePressure) {
  constexpr std::uint32_t kCount = 100;
  const double stiffness = 5000, rest = 2 * std::sin(kHalfTurn / kCount);
  for (const int substeps : {4, 8}) {
    for (const double share : {0.1, 0.3}) {
      LinkDesc links{.type = JointType::spring, .stiffness = stiffness, .damping = 1};
      links.pressure = share * stiffness * rest;
      psim::Scene scene = ring_of(kCount, 0.05, links);
      scene.world.substeps = substeps;
      scene.world.linear_damping = 3;
      const auto world = world_of(scene);
      run_frames(*world, 600);
      const std::vector<BodyState> ring = first_bodies(*world, kCount);
      EXPECT_NEAR(radius_of(ring).mean * (1 - share), 1, 0.005) << share << ' ' << substeps;
      EXPECT_NEAR(radius_of(ring).least / radius_of(ring).most, 1, 0.005) << share << ' ' << substeps;
      EXPECT_LT(fastest_of(ring), 1e-3) << share << ' ' << substeps;
    }
  }
}

// Two links, at the angle pi/n to the tangent, hold the halves of p L of their two edges: T = p R cos(pi/n).
TEST(Membranes, RodsOfARingBearPressureTimesRadius) {
  for (const std::uint32_t count : {12u, 40u, 200u}) {
    LinkDesc links;
    links.pressure = 50;
    psim::Scene scene = ring_of(count, 0.05, links);
    scene.world.linear_damping = 1;
    const auto world = world_of(scene);
    run_frames(*world, 300);
    EXPECT_NEAR(radius_of(first_bodies(*world, count)).mean, 1, 1e-3) << count;
    for (std::uint32_t k = 0; k < count; k += 5) {
      const JointState joint = world->joint({k, 0}).value();
      EXPECT_NEAR(std::hypot(joint.force.x, joint.force.y), 50 * std::cos(kHalfTurn / count), 0.5) << count << ' ' << k;
    }
  }
}

// Links without damping swing about for 20 s. Kinetic energy, that of the springs and - p A add up to the same.
TEST(Membranes, PressureKeepsTheEnergyOfARingThatSwings) {
  constexpr std::uint32_t kCount = 40;
  LinkDesc links{.type = JointType::spring, .stiffness = 2000};
  links.pressure = 30;
  const auto world = world_of(ring_of(kCount, 0.1, links, {1.4, 0.8}));
  std::vector<double> rest;
  const std::vector<BodyState> start = first_bodies(*world, kCount);
  const auto length = [](const std::vector<BodyState>& ring, std::size_t k) {
    const BodyState &a = ring[k], &b = ring[(k + 1) % kCount];
    return std::hypot(b.x - a.x, b.y - a.y);
  };
  for (std::size_t k = 0; k < kCount; ++k) rest.push_back(length(start, k));
  const auto energy = [&](const std::vector<BodyState>& ring) {
    double sum = -30 * area_in(ring);
    for (std::size_t k = 0; k < kCount; ++k) {
      sum += 0.05 * (ring[k].vx * ring[k].vx + ring[k].vy * ring[k].vy);
      sum += 1000 * std::pow(length(ring, k) - rest[k], 2);
    }
    return sum;
  };
  const double before = energy(start);
  double moved = 0;
  for (int frame = 0; frame < 1200; ++frame) {
    world->step();
    const std::vector<BodyState> ring = first_bodies(*world, kCount);
    for (const BodyState& b : ring) moved = std::max(moved, 0.05 * kCount * (b.vx * b.vx + b.vy * b.vy));
    ASSERT_LT(energy(ring) - before, 0.02 * moved + 1e-3) << frame;
  }
  EXPECT_GT(moved, 5);
}

// The pushes on a line that closes add up to nothing, and so do their torques.
TEST(Membranes, AFreeRingKeepsItsMomentum) {
  constexpr std::uint32_t kCount = 60;
  LinkDesc links{.type = JointType::spring, .stiffness = 2000};
  links.pressure = 40;
  links.area = true;
  psim::Scene scene = ring_of(kCount, 0.05, links, {1.5, 0.7});
  scene.groups[0].velocity = {3, -2};
  const auto world = world_of(scene);
  for (int frame = 0; frame < 300; ++frame) {
    world->step();
    const std::vector<BodyState> ring = first_bodies(*world, kCount);
    Vec2 speed, middle;
    for (const BodyState& b : ring) speed.x += b.vx / kCount, speed.y += b.vy / kCount;
    for (const BodyState& b : ring) middle.x += b.x / kCount, middle.y += b.y / kCount;
    double spin = 0, size = 0;
    for (const BodyState& b : ring) {
      spin += (b.x - middle.x) * (b.vy - speed.y) - (b.y - middle.y) * (b.vx - speed.x);
      size += std::hypot(b.x - middle.x, b.y - middle.y) * std::hypot(b.vx - speed.x, b.vy - speed.y);
    }
    ASSERT_NEAR(speed.x, 3, 2e-5) << frame;
    ASSERT_NEAR(speed.y, -2, 2e-5) << frame;
    ASSERT_LE(std::fabs(spin), 1e-4 * std::max(size, 10.0)) << frame;
  }
}

// To the right of a to b is to the left of b to a.
TEST(Membranes, ALinkDescribedFromItsOtherEndWithTheOppositePressureDoesTheSame) {
  constexpr std::uint32_t kCount = 24;
  std::vector<double> mean;
  for (const bool turned_round : {false, true}) {
    JointScene s = free_scene(4, {0, 0});
    std::vector<BodyId> ids;
    for (std::uint32_t k = 0; k < kCount; ++k) {
      const double angle = 2 * kHalfTurn * k / kCount;
      ids.push_back(ghost(s, {std::cos(angle), std::sin(angle)}, 0.1, 0.05));
    }
    for (std::uint32_t k = 0; k < kCount; ++k) {
      const BodyId a = ids[k], b = ids[(k + 1) % kCount];
      JointDesc d = turned_round ? between(JointType::spring, b, a) : between(JointType::spring, a, b);
      d.stiffness = 1000, d.damping = 5;
      d.pressure = turned_round ? -60 : 60;
      s.join(d);
    }
    s.run(300);
    mean.push_back(radius_of(first_bodies(*s.world, kCount)).mean);
  }
  EXPECT_GT(mean[0], 1.1);
  EXPECT_NEAR(mean[0], mean[1], 1e-3);
}

// A link between corners of two boards: the push is p L across it, and has no torque about the middle of the link.
TEST(Membranes, PressureActsAtTheAnchors) {
  JointScene s = free_scene(4, {0, 0});
  const BodyId a = board(s, {-1, 0}, 1, 0.5, 2), b = board(s, {1, 0.5}, 0.5, 0.5, 1);
  JointDesc d = between(JointType::distance, a, b, {0.5, 0.25}, {-0.25, -0.25});
  d.pressure = 3;
  s.join(d);
  const Vec2 from{-0.5, 0.25}, to{0.75, 0.25};
  s.world->step();
  const BodyState of_a = s.at(a), of_b = s.at(b);
  const double impulse = 3 * (to.x - from.x) / 60;
  EXPECT_NEAR(2 * of_a.vy + of_b.vy, -impulse, 1e-4 * impulse);
  EXPECT_NEAR(2 * of_a.vx + of_b.vx, 0, 1e-3 * impulse);
  const Vec2 middle{(from.x + to.x) / 2, (from.y + to.y) / 2};
  const auto spin = [&](const BodyState& of, double mass, double inertia, Vec2 start) {
    return mass * ((start.x - middle.x) * of.vy - (start.y - middle.y) * of.vx) + inertia * of.omega;
  };
  const double sum = spin(of_a, 2, 2 * (1 + 0.25) / 12, {-1, 0}) + spin(of_b, 1, (0.25 + 0.25) / 12, {1, 0.5});
  EXPECT_LT(of_a.omega, -1e-3);
  EXPECT_NEAR(sum, 0, 1e-3 * impulse);
}

// A pressure of p moves an end by its length in a step where p dt^2 = m. Rods hold any.
TEST(Membranes, NoPressureThrowsRodsApart) {
  constexpr std::uint32_t kCount = 40;
  const double mass = 0.05, a_length_a_step = mass * 60 * 60;
  for (const double times : {0.1, 1.0, 10.0, 1e3, 1e9}) {
    LinkDesc links;
    links.pressure = std::min(times * a_length_a_step, 1e12);
    const auto world = world_of(ring_of(kCount, mass, links));
    for (int frame = 0; frame < 300; ++frame) {
      ASSERT_EQ(world->step().quarantined, 0u) << times;
      const Extent radius = radius_of(first_bodies(*world, kCount));
      ASSERT_LT(radius.most, 1.05) << times << " frame " << frame;
      ASSERT_GT(radius.least, 0.95) << times << " frame " << frame;
    }
  }
}

psim::Scene on_the_floor(std::uint64_t count, const LinkDesc& links) {
  psim::Scene scene = ring_of(count, 0.02, links);
  scene.world.gravity = {0, -kG};
  scene.world.bounds = {-5, -1.5, 5, 8};
  scene.world.boundary = Boundary::walls;
  scene.world.sleeping = true;
  return scene;
}

TEST(Membranes, ABalloonComesToRestAndSleeps) {
  LinkDesc links{.type = JointType::spring, .stiffness = 3000, .damping = 10};
  links.pressure = 30;
  psim::Scene scene = on_the_floor(40, links);
  scene.world.linear_damping = 2;
  const auto world = world_of(scene);
  run_frames(*world, 1500);
  const std::vector<BodyState> lies = first_bodies(*world, 40);
  EXPECT_LT(fastest_of(lies), 0.02);
  EXPECT_EQ(world->step().awake, 0u);
}

TEST(Membranes, GiveTheSameBitsOnAllThreadsAndAfterASave) {
  LinkDesc links{.type = JointType::spring, .stiffness = 3000, .damping = 1};
  links.pressure = 40;
  links.drag = links.lift = 1;
  links.area = true;
  psim::Scene scene = on_the_floor(120, links);
  scene.world.fields.push_back(WindField{.velocity = {6, 2}, .density = 1});
  const auto one = world_of(scene, {.threads = 1}), four = world_of(scene, {.threads = 4});
  const std::uint64_t start = one->state_hash();
  std::unique_ptr<World> resumed;
  for (int frame = 0; frame < 120; ++frame) {
    one->step(), four->step();
    ASSERT_EQ(one->state_hash(), four->state_hash()) << "frame " << frame;
    if (resumed) {
      resumed->step();
      ASSERT_EQ(one->state_hash(), resumed->state_hash()) << "frame " << frame;
    }
    if (frame != 40) continue;
    std::vector<std::byte> saved;
    std::string error;
    four->save(saved);
    resumed = world_of(scene, {.threads = 2});
    ASSERT_TRUE(resumed->restore(saved, error)) << error;
  }
  EXPECT_NE(one->state_hash(), start);
}

// ---- wind

// A row that does not move yields to nothing in its first step: heavy discs that no wind meets, with links that it does.
TEST(Membranes, WindPushesARowOfLinksByItsFormula) {
  constexpr int kLinks = 10;
  constexpr double kMass = 1e4, kDensity = 1.2, kPart = 0.5;
  const Vec2 velocity{12, -5};
  const double speed = std::hypot(velocity.x, velocity.y);
  for (const double drag : {0.0, 0.7}) {
    for (const double lift : {0.0, 1.3}) {
      if (drag == 0 && lift == 0) continue;
      for (int k = 0; k < 12; ++k) {
        const double angle = 0.1 + kHalfTurn * k / 6;
        WorldDesc desc;
        desc.gravity = {0, 0};
        desc.fields.push_back(WindField{.velocity = velocity, .density = kDensity, .mask = 2});
        JointScene s(desc);
        std::vector<BodyId> ids;
        for (int n = 0; n <= kLinks; ++n) {
          ids.push_back(ghost(s, {n * kPart * std::cos(angle), n * kPart * std::sin(angle)}, kMass));
          if (n == 0) continue;
          JointDesc d = between(JointType::distance, ids[ids.size() - 2], ids.back());
          d.wind_drag = drag, d.wind_lift = lift;
          s.join(d);
        }
        s.world->step();
        Vec2 force;
        for (const BodyId id : ids) force = {force.x + 60 * kMass * s.at(id).vx, force.y + 60 * kMass * s.at(id).vy};
        const Vec2 along{velocity.x / speed, velocity.y / speed};
        Vec2 lee{-std::sin(angle), std::cos(angle)};
        double facing = lee.x * along.x + lee.y * along.y;
        if (facing < 0) lee = {-lee.x, -lee.y}, facing = -facing;
        const double pushes = 0.5 * kDensity * kLinks * kPart * facing * speed * speed;
        const Vec2 expected{pushes * (drag * along.x + lift * (lee.x - facing * along.x)),
                            pushes * (drag * along.y + lift * (lee.y - facing * along.y))};
        EXPECT_NEAR(force.x, expected.x, 1e-3 * pushes + 1e-3) << angle;
        EXPECT_NEAR(force.y, expected.y, 1e-3 * pushes + 1e-3) << angle;
      }
    }
  }
}

TEST(Membranes, WindBlowsInItsRegionAlone) {
  for (const bool inside : {false, true}) {
    WorldDesc desc;
    desc.gravity = {0, 0};
    desc.fields.push_back(WindField{.velocity = {5, 0}, .region = Bounds{inside ? -1.0 : 1.0, -5, 9, 5}, .mask = 2});
    JointScene s(desc);
    JointDesc d = between(JointType::distance, ghost(s, {0, 0}, 1), ghost(s, {0, 1}, 1));
    d.wind_drag = 1;
    s.join(d);
    s.run(3);
    EXPECT_EQ(s.at(d.a).vx > 0, inside);
  }
}

// However light a ribbon and however strong the wind, the ribbon as a whole gets as fast as the air and no faster.
TEST(Membranes, WindTakesALightRibbonAlong) {
  for (const double wind : {1.0, 30.0, 300.0}) {
    WorldDesc desc;
    desc.gravity = {0, 0};
    desc.sleeping = false;
    desc.bounds = {-1e5, -1e5, 1e5, 1e5};
    desc.fields.push_back(WindField{.velocity = {wind, 0}, .density = 1000, .mask = 2});
    JointScene s(desc);
    std::vector<BodyId> ids;
    for (int n = 0; n < 30; ++n) {
      ids.push_back(ghost(s, {0, 0.2 * n}, 1e-3));
      if (n == 0) continue;
      JointDesc d = between(JointType::distance, ids[ids.size() - 2], ids.back());
      d.wind_drag = 2;
      s.join(d);
    }
    for (int frame = 0; frame < 200; ++frame) {
      s.world->step();
      double mean = 0;
      for (const BodyId id : ids) mean += s.at(id).vx / 30;
      ASSERT_LT(mean, 1.001 * wind) << frame;
    }
    EXPECT_GT(s.at(ids[15]).vx, 0.9 * wind);
  }
}

// ---- area

// A ball of jelly falls 3 m. Links that stretch let it flatten; of rods no ring but the circle has this area.
TEST(Membranes, AJellyBallThatFallsKeepsItsArea) {
  for (const int substeps : {4, 8}) {
    LinkDesc links{.type = JointType::spring, .stiffness = 800, .damping = 1};
    links.area = true;
    psim::Scene scene = on_the_floor(48, links);
    scene.world.substeps = substeps;
    scene.world.bounds.ymin = -4;
    const auto world = world_of(scene);
    const double before = area_in(first_bodies(*world, 48));
    double least = HUGE_VAL, most = 0, lowest = HUGE_VAL, flattest = HUGE_VAL;
    for (int frame = 0; frame < 600; ++frame) {
      world->step();
      const std::vector<BodyState> ball = first_bodies(*world, 48);
      const double area = area_in(ball) / before;
      least = std::min(least, area), most = std::max(most, area);
      for (const BodyState& b : ball) lowest = std::min(lowest, b.y);
      const Extent radius = radius_of(ball);
      flattest = std::min(flattest, radius.least / radius.most);
    }
    EXPECT_GT(least, 0.995) << substeps;
    EXPECT_LT(most, 1.005) << substeps;
    EXPECT_LT(lowest, -3.9);
    EXPECT_LT(flattest, 0.8);
  }
}

// Without it the same ring falls flat: the test above would see it.
TEST(Membranes, ARingWithoutAreaFallsFlat) {
  LinkDesc links{.type = JointType::spring, .stiffness = 800, .damping = 1};
  const auto world = world_of(on_the_floor(48, links));
  const double before = area_in(first_bodies(*world, 48));
  run_frames(*world, 300);
  EXPECT_LT(area_in(first_bodies(*world, 48)), 0.6 * before);
}

TEST(Membranes, ALooseRingGoesBackToItsArea) {
  for (const double share : {0.5, 1.5}) {
    LinkDesc links{.type = JointType::spring, .stiffness = 1, .damping = 0.1};
    links.area = true;
    psim::Scene scene = ring_of(30, 0.1, links);
    scene.world.linear_damping = 2;
    const auto world = world_of(scene);
    const double before = area_in(first_bodies(*world, 30));
    for (std::uint32_t k = 0; k < 30; ++k) {
      const BodyState at = world->body(world->id_of(k)).value();
      world->set_transform(world->id_of(k), {at.x, at.y * share}, 0);
    }
    run_frames(*world, 300);
    EXPECT_NEAR(area_in(first_bodies(*world, 30)) / before, 1, 1e-3) << share;
  }
}

TEST(Membranes, ARingThatIsTornLosesItsArea) {
  LinkDesc links{.type = JointType::spring, .stiffness = 5, .damping = 0.5};
  links.area = true;
  const auto world = world_of(on_the_floor(40, links));
  const double before = area_in(first_bodies(*world, 40));
  run_frames(*world, 300);
  EXPECT_GT(area_in(first_bodies(*world, 40)), 0.97 * before);
  world->remove_joint({3, 0});
  run_frames(*world, 300);
  EXPECT_LT(area_in(first_bodies(*world, 40)), 0.7 * before);
}

}  // namespace
}  // namespace psim::test
