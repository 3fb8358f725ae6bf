// Answers to single questions, who may ask and when.
#include <thread>

#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

TEST(QueryAnswers, AreExactForADisc) {
  auto world = make(unbounded());
  const BodyId id = add(*world, disc({3, 0}, {}, 0.5));
  const auto hit = world->ray_cast({0, 0}, {10, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, id);
  EXPECT_NEAR(hit->fraction, 0.25, 1e-15);
  EXPECT_NEAR(hit->point.x, 2.5, 1e-15);
  EXPECT_EQ(hit->normal.x, -1);
  EXPECT_EQ(hit->normal.y, 0);
  EXPECT_FALSE(world->ray_cast({0, 0}, {2.4, 0}));
  EXPECT_FALSE(world->ray_cast({0, 0.6}, {10, 0.6}));
  const auto near = world->closest({0, 0}, 100);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->distance, 2.5, 1e-15);
  EXPECT_NEAR(near->point.x, 2.5, 1e-15);
  EXPECT_FALSE(world->closest({0, 0}, 2.4));
  EXPECT_EQ(world->overlap(DiscShape{2.6}, {0, 0}, 0), std::vector<BodyId>{id});
  EXPECT_TRUE(world->overlap(DiscShape{2.4}, {0, 0}, 0).empty());
}

TEST(QueryAnswers, OfEqualDistanceAreOrderedById) {
  for (const bool reversed : {false, true}) {
    auto world = make(unbounded());
    std::vector<BodyId> ids;
    for (int k = 0; k < 6; ++k) {
      const double side = reversed ? 5 - k : k;
      ids.push_back(add(*world, disc({3, 0}, {}, 0.5)));
      add(*world, disc({-3, 20 + side}, {}, 0.5));
    }
    EXPECT_EQ(world->closest({0, 0}, 10)->body, ids[0]);
    EXPECT_EQ(world->ray_cast({0, 0}, {10, 0})->body, ids[0]);
    const auto all = world->ray_cast_all({0, 0}, {10, 0});
    ASSERT_EQ(all.size(), 6u);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(all[k].body, ids[k]);
  }
}

TEST(QueryAnswers, TellAPolygonOnceThoughItHasManyPieces) {
  auto world = make(unbounded());
  BodyDesc box;
  box.type = BodyType::static_body;
  box.shape = BoxShape{2, 2, 0};
  const BodyId id = add(*world, box);
  EXPECT_EQ(world->ray_cast_all({-5, 0.1}, {5, 0.2}).size(), 1u);
  EXPECT_EQ(world->in_region({-2, -2, 2, 2}), std::vector<BodyId>{id});
  EXPECT_EQ(world->ray_cast({0, 0}, {5, 0})->fraction, 0);  // it is solid
  const BodyId ring = add(*world, chain({{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, true));
  EXPECT_EQ(world->ray_cast_all({-9, 3}, {9, 3}).size(), 1u);
  EXPECT_EQ(world->ray_cast({0, 3}, {9, 3})->body, ring);  // it is hollow
  EXPECT_EQ(world->ray_cast({0, 3}, {9, 3})->normal.x, -1);
}

TEST(QueryAnswers, DoNotTellWallsOfTheWorld) {
  auto world = make(walled({-5, -5, 5, 5}));
  EXPECT_FALSE(world->ray_cast({0, 0}, {100, 0}));
  EXPECT_FALSE(world->closest({4.9, 0}, 100));
  EXPECT_TRUE(world->in_region({-100, -100, 100, 100}).empty());
}

TEST(QueryAnswers, ToBadQuestionsAreEmpty) {
  auto world = make(unbounded());
  add(*world, disc({0, 0}, {}, 5));
  add(*world, ground());
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(world->ray_cast({bad, 0}, {1, 0}));
    EXPECT_FALSE(world->ray_cast({0, 0}, {1, bad}));
    EXPECT_TRUE(world->ray_cast_all({0, bad}, {1, 0}).empty());
    EXPECT_TRUE(world->overlap(DiscShape{1}, {bad, 0}, 0).empty());
    EXPECT_TRUE(world->overlap(DiscShape{1}, {0, 0}, bad).empty());
    EXPECT_TRUE(world->overlap(DiscShape{bad}, {0, 0}, 0).empty());
    EXPECT_TRUE(world->in_region({-1, -1, bad, 1}).empty());
    EXPECT_FALSE(world->closest({0, bad}, 1));
    EXPECT_FALSE(world->closest({0, 0}, bad));
  }
  EXPECT_TRUE(world->in_region({1, 1, -1, -1}).empty());
  EXPECT_FALSE(world->closest({0, 0}, -1));
  EXPECT_TRUE(world->overlap(PolygonShape{{{0, 0}, {1, 0}}, 0}, {0, 0}, 0).empty());
  EXPECT_TRUE(world->ray_cast({-1e200, 0}, {1e200, 0}) == std::nullopt);
  // Large but finite ones are answered.
  EXPECT_TRUE(world->ray_cast({-1e9, 0}, {1e9, 1}));
  EXPECT_EQ(world->in_region({-1e50, -1e50, 1e50, 1e50}).size(), 2u);
  EXPECT_TRUE(world->closest({1e6, 1e6}, 1e9));
}

TEST(QueryAnswers, FollowEveryChange) {
  auto world = make(unbounded(100, {0, 0}));
  EXPECT_FALSE(world->ray_cast({-50, 0}, {50, 0}));
  const BodyId a = add(*world, disc({0, 0}, {60, 0}));
  EXPECT_EQ(world->ray_cast({-50, 0}, {50, 0})->body, a);
  world->step();
  EXPECT_NEAR(world->ray_cast({-50, 0}, {50, 0})->point.x, 0.5, 1e-6);
  world->set_transform(a, {20, 0}, 0);
  EXPECT_NEAR(world->ray_cast({-50, 0}, {50, 0})->point.x, 19.5, 1e-6);
  const BodyId wall = add(*world, segment({10, -1}, {10, 1}));
  EXPECT_EQ(world->ray_cast({-50, 0}, {50, 0})->body, wall);
  world->remove_body(wall);
  EXPECT_EQ(world->ray_cast({-50, 0}, {50, 0})->body, a);
  world->set_velocity(a, {kNan, 0}, 0);
  world->step();  // it is frozen now
  EXPECT_EQ(world->ray_cast({-50, 0}, {50, 0})->body, a);
  world->remove_body(a);
  EXPECT_FALSE(world->ray_cast({-50, 0}, {50, 0}));
}

TEST(QueryAnswers, LeaveTheWorldAsItIs) {
  const auto build = [] { return pile(400, material(0.3, 0.5)); };
  auto asked = build(), left = build();
  for (int k = 0; k < 60; ++k) {
    asked->ray_cast({0, 5}, {20, 5});
    asked->closest({3, 3}, 5);
    asked->step();
    left->step();
    ASSERT_EQ(asked->state_hash(), left->state_hash());
  }
}

TEST(QueryAnswers, AreTheSameForEveryIsaAndThreadCount) {
  std::vector<double> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : thread_counts()) {
      auto world = gas_in_walls(3000, 0.3, material(0.8), 10, isa, threads);
      run(*world, 20);
      Random r(5);
      std::vector<double> answers;
      for (int n = 0; n < 200; ++n) {
        const Bounds b = world->desc().bounds;
        const auto point = [&] { return Vec2{r.uniform(b.xmin, b.xmax), r.uniform(b.ymin, b.ymax)}; };
        for (const RayHit& h : world->ray_cast_all(point(), point())) {
          answers.insert(answers.end(), {h.fraction, h.normal.x, h.point.y});
          answers.push_back(h.body.index);
        }
        const auto near = world->closest(point(), 3);
        if (near) answers.insert(answers.end(), {near->distance, near->point.x});
        for (const BodyId id : world->overlap(BoxShape{4, 2, 0}, point(), r.uniform(0, 6))) {
          answers.push_back(id.index);
        }
      }
      if (first.empty()) first = answers;
      EXPECT_GT(answers.size(), 1000u);
      EXPECT_EQ(answers, first);
    }
  }
}

TEST(QueryAnswers, MayBeAskedForByManyThreadsAtOnce) {
  auto world = gas_in_walls(2000, 0.3, material(0.8));
  add(*world, static_disc({1, 1}, 0.3));
  for (int frame = 0; frame < 5; ++frame) {
    world->step();
    std::vector<std::vector<RayHit>> answers(4);
    std::vector<std::thread> threads;
    for (std::vector<RayHit>& mine : answers) {
      threads.emplace_back([&] { mine = world->ray_cast_all({0, 0}, {70, 60}); });
    }
    for (std::thread& t : threads) t.join();
    for (const auto& other : answers) {
      ASSERT_EQ(other.size(), answers[0].size());
      for (std::size_t k = 0; k < other.size(); ++k) EXPECT_EQ(other[k].body, answers[0][k].body);
    }
    EXPECT_GT(answers[0].size(), 3u);
  }
}

// Sorting leaves ids without their slots, questions without their index: whoever asks first makes them. Under the
// thread sanitizer this finds races.
TEST(QueryAnswers, ManyThreadsMayReadEverythingAtOnce) {
  auto world = make(walled({0, 0, 60, 60}, {0, -kG}, material(0.5)));
  add(*world, lattice(400, {0.5, 0.5, 59.5, 59.5}, 0.5, 5, material(0.5)));
  JointDesc rope;
  rope.type = JointType::rope;
  rope.a = world->id_of(3);
  rope.b = world->id_of(4);
  std::string error;
  const JointId joint = world->add_joint(rope, error);
  world->set_event_options({.contacts = true});
  for (int step = 0; step < 5; ++step) {
    const StepReport report = world->step();
    EXPECT_TRUE(report.rebuilt || step > 0);
    struct Answer {
      std::vector<double> numbers;
      bool operator==(const Answer&) const = default;
    };
    std::vector<Answer> answers(4);
    std::vector<std::thread> threads;
    for (std::size_t n = 0; n < answers.size(); ++n) {
      threads.emplace_back([&, n] {
        const World& w = *world;
        std::vector<double>& out = answers[n].numbers;
        for (std::uint32_t id = 0; id < 400; ++id)
          out.push_back(w.body(w.id_of(id))->x + (w.is_awake(w.id_of(id)) ? 100 : 0));
        out.push_back(w.joint(joint)->value);
        out.push_back(static_cast<double>(w.state_hash() >> 12));
        out.push_back(static_cast<double>(w.ray_cast_all({0, 0}, {60, 60}).size()));
        out.push_back(
            static_cast<double>(w.events().begin.size() + w.body_count() + w.joint_count() + w.plan().size()));
        out.push_back(w.memory_bytes() > 0 ? 1 : 0);
      });
    }
    for (std::thread& t : threads) t.join();
    for (const Answer& other : answers) EXPECT_EQ(other, answers[0]);
  }
}

TEST(QueryAnswers, SeeAcrossTheSeam) {
  auto world = make(periodic(10, 10));
  const BodyId id = add(*world, disc({0.2, 5}, {}, 0.5));
  EXPECT_EQ(world->closest({9.5, 5}, 1)->body, id);
  EXPECT_NEAR(world->closest({9.5, 5}, 1)->distance, 0.2, 1e-6);
  EXPECT_NEAR(world->closest({9.5, 5}, 1)->point.x, 9.7, 1e-6);  // on the image that is meant
  EXPECT_NEAR(world->ray_cast({8, 5}, {12, 5})->point.x, 9.7, 1e-6);
  EXPECT_EQ(world->in_region({9, 4, 9.9, 6}).size(), 1u);
  EXPECT_EQ(world->in_region({-300, -300, 300, 300}).size(), 1u);
  EXPECT_EQ(world->overlap(DiscShape{0.3}, {-0.5, 5}, 0).size(), 1u);
  EXPECT_TRUE(world->overlap(DiscShape{0.1}, {-0.5, 5}, 0).empty());
}

}  // namespace
}  // namespace psim::test
