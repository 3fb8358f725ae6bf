// Pairs whose hulls are far apart are not looked at, and parts of bodies that cannot meet are not listed. Both must be
// right however long bodies last next to each other, drift and turn: nothing goes into anything unseen.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "psim/geometry.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// Bars, tees and polygons.
BodyDesc random_body(Random& random) {
  BodyDesc body;
  const double length = random.uniform(1, 2.5), width = random.uniform(0.15, 0.4);
  switch (random.below(4)) {
    case 0:
      body.shape = BoxShape{length, width};
      break;
    case 1:
      body.shape = PolygonShape{{{0, 0}, {length, 0}, {length / 2, length / 2}}};
      break;
    case 2:
      body.shape = CompoundShape{{{BoxShape{length, width}, {0, length / 2}, 0}, {BoxShape{width, length}, {0, 0}, 0}}};
      break;
    default:
      body.shape = CompoundShape{{{DiscShape{width}, {length / 2, 0}, 0},
                                  {PolygonShape{{{0, 0}, {length / 2, width}, {0, width}}}, {0, 0}, 0},
                                  {CapsuleShape{{-length / 2, -width}, {0, 0}, width / 2}, {0, 0}, 0}}};
  }
  body.material.friction = 0.3;
  return body;
}

struct Crowd {
  std::unique_ptr<World> world;
  std::vector<BodyId> ids;
  std::vector<BodyDesc> bodies;

  // Bodies that drift and turn so fast; where `still`, they turn in their places.
  Crowd(Random& random, double speed, double restitution, bool still) {
    WorldDesc desc = unbounded(6, {0, 0});
    desc.boundary = Boundary::walls;
    world = make(desc);
    for (int k = 0; k < 16; ++k) {
      BodyDesc body = random_body(random);
      body.material.restitution = restitution;
      body.position = {2.6 * (k % 4) - 3.9, 2.6 * (k / 4) - 3.9};
      body.angle = random.uniform(0, 2 * kPi);
      if (!still) body.velocity = {random.uniform(-speed, speed), random.uniform(-speed, speed)};
      body.angular_velocity = random.uniform(-speed, speed);
      ids.push_back(add(*world, body));
      bodies.push_back(body);
    }
  }

  // m: how deep any two bodies lie in each other.
  double deepest() const {
    double depth = 0;
    for (std::size_t a = 0; a < ids.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const auto gap = shape_distance(bodies[a].shape, pose(a), bodies[b].shape, pose(b));
        if (gap) depth = std::max(depth, -gap->distance);
      }
    }
    return depth;
  }
  Pose pose(std::size_t k) const {
    const BodyState s = state(*world, ids[k]);
    return {{s.x, s.y}, s.angle};
  }
};

TEST(Apart, NothingGoesIntoAnythingHoweverLongItTurnsBesideIt) {
  Random random(20261128);
  double deepest = 0;
  for (int n = 0; n < 120; ++n) {
    const bool still = n % 3 == 0;
    const double speed = n % 3 == 1 ? 0.4 : 3;  // lists last, or serve a step each
    Crowd crowd(random, speed, n % 4 < 2 ? 1 : 0.5, still);
    const double before = crowd.deepest();
    for (int frame = 0; frame < 300; ++frame) {
      run(*crowd.world, 1);
      if (frame % 8 == 0 && before < 1e-3) deepest = std::max(deepest, crowd.deepest());
    }
  }
  EXPECT_LT(deepest, 0.05);  // as much as the fastest go within a frame
}

// Tables fall on each other every way round. Half a turn brings a leg to the other side: what was apart then may lie
// there now.
TEST(Apart, TablesThatTumbleComeToRestBesideEachOther) {
  double sum = 0;
  constexpr int kPiles = 24;
  for (int n = 0; n < kPiles; ++n) {
    auto world = make(unbounded(50));
    BodyDesc floor = box({0, -1}, 50, 1, material(0, 0.5));
    floor.type = BodyType::static_body;
    add(*world, floor);
    for (int k = 0; k < 40; ++k) {
      BodyDesc table;
      table.shape = CompoundShape{{{BoxShape{1.5, 0.15}, {0, 0.5}, 0},
                                   {BoxShape{0.15, 0.5}, {-1.2, 0}, 0},
                                   {BoxShape{0.15, 0.5}, {1.2, 0}, 0}}};
      table.position = {3.4 * (k % 5) - 7 + 0.3 * std::sin(1.7 * n + 2.3 * k), 2 + 3.4 * (k / 5)};
      table.material = material(0, 0.5);
      add(*world, turned(table, 0.7 * k + 0.37 * n * (1 + k % 3)));
    }
    run(*world, 300);
    double deepest = 0;
    for (int frame = 0; frame < 100; ++frame) {
      run(*world, 1);
      for (const Contact& c : world->contacts()) deepest = std::max(deepest, -c.separation);
    }
    sum += deepest;
  }
  EXPECT_LT(sum / kPiles, 0.03);
}

}  // namespace
}  // namespace psim::test
