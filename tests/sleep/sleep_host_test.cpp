// Bodies that the host puts among sleepers, or takes from under them, wake those that they touch.
#include <string>

#include "sleep_support.h"

namespace psim::test {
namespace {

/// Puts a body that does not move against the side of the sleeping box at (0, 0.5), deep by 5 cm.
struct Arrival {
  const char* name;
  BodyId (*put)(World&, BodyDesc);
};

const Arrival kArrivals[] = {
    {"added", [](World& w, BodyDesc b) { return add(w, b); }},
    {"placed",
     [](World& w, BodyDesc b) {
       const Vec2 at = b.position;
       b.position = {30, 30};
       b.gravity_scale = 0;
       const BodyId id = add(w, b);
       w.set_sleeping(true);
       run(w, 3);
       EXPECT_TRUE(w.set_velocity(id, {0, 0}, 0));
       EXPECT_TRUE(w.set_transform(id, at, b.angle));
       return id;
     }},
    {"in a batch",
     [](World& w, BodyDesc b) {
       const double radius = std::get<DiscShape>(b.shape).radius;
       DiscBatch batch;
       batch.x = {&b.position.x, 1};
       batch.y = {&b.position.y, 1};
       batch.radius = {&radius, 1};
       batch.material = b.material;
       batch.type = b.type;
       std::uint32_t first = 0;
       std::string error;
       EXPECT_EQ(w.add_discs(batch, first, error), 1u) << error;
       return w.id_of(first);
     }},
};

TEST(SleepHost, WhateverComesToRestInASleeperWakesIt) {
  const BodyDesc shapes[] = {disc({0.95, 0.5}, {}, 0.5, kGrip), box({0.95, 0.5}, 1, 0.4, kGrip),
                             capsule({1.2, 0.5}, 1.1, 0.2, kGrip), turned(box({0.95, 0.5}, 0.4, 1, kGrip), kPi / 2)};
  for (const Arrival& arrival : kArrivals) {
    for (const BodyType type : {BodyType::kinematic_body, BodyType::dynamic_body, BodyType::static_body}) {
      for (std::size_t k = 0; k < std::size(shapes); ++k) {
        const std::string which = arrival.name;
        if ((which == "placed" && type == BodyType::static_body) || (which == "in a batch" && k != 0)) continue;
        Placed p = sleeping_stack(3);
        BodyDesc body = shapes[k];
        body.type = type;
        arrival.put(*p.world, body);
        p.world->step();
        const std::string what =
            which + ", type " + std::to_string(static_cast<int>(type)) + ", shape " + std::to_string(k);
        EXPECT_TRUE(p.world->is_awake(p.ids[0])) << what;
        EXPECT_TRUE(p.world->is_awake(p.ids[2]) || type == BodyType::dynamic_body) << what;
        run(*p.world, 60);
        if (type != BodyType::dynamic_body) {
          EXPECT_LT(p.now(0).x, -0.045) << what;
        }
      }
    }
  }
}

TEST(SleepHost, ASupportThatIsPlacedElsewhereOrTurnsLetsAllFall) {
  for (const bool turns : {false, true}) {
    auto world = make(unbounded());
    const BodyId table = add(*world, kinematic(box({0, -0.5}, 6, 1, kGrip)));
    std::vector<BodyId> ids;
    for (int k = 0; k < 4; ++k) ids.push_back(add(*world, box({2, k + 0.5}, 1, 1, kGrip, 1)));
    ids.push_back(add(*world, disc({-2, 0.5}, {}, 0.5, kGrip)));
    wait_for_rest(*world, 1);
    if (turns) {
      world->set_velocity(table, {0, 0}, -0.5);
    } else {
      world->set_transform(table, {0, -20}, 0);
    }
    world->step();
    for (const BodyId id : ids) EXPECT_TRUE(world->is_awake(id)) << turns << " " << id.index;
  }
}

TEST(SleepHost, AKinematicSensorWakesNobody) {
  Placed p = sleeping_stack(1);
  BodyDesc sensor = kinematic(box({0.5, 0.5}, 1, 1, kGrip));
  sensor.sensor = true;
  const BodyId id = add(*p.world, sensor);
  p.world->step();
  EXPECT_TRUE(p.world->set_transform(id, {0.2, 0.5}, 0.3));
  p.world->step();
  EXPECT_FALSE(p.world->is_awake(p.ids[0]));
}

}  // namespace
}  // namespace psim::test
