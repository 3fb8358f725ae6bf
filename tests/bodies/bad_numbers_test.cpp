// What must not break a world: NaN and infinity set from outside, everything at one point,
// denormals, extreme sizes and masses, refused descriptions.
#include "support.h"

namespace psim::test {
namespace {

TEST(Quarantine, ABodyWithNanIsFrozenAndReportedOnce) {
  for (const Isa isa : available_isas()) {
    for (const double bad : {kNan, kInf, -kInf}) {
      for (const bool in_velocity : {false, true}) {
        SCOPED_TRACE(testing::Message() << isa_name(isa) << " " << bad << " " << in_velocity);
        auto world = pile(100, material(0, 0.3), isa, 2);
        run(*world, 60);
        const BodyId victim = world->id_of(37);
        ASSERT_TRUE(in_velocity ? world->set_velocity(victim, {bad, 0}, 0) : world->set_transform(victim, {0, bad}, 0));
        EXPECT_EQ(world->step().quarantined, 1u);
        for (int k = 0; k < 60; ++k) {
          EXPECT_EQ(world->step().quarantined, 0u);
          const PublishedState s = world->published();
          for (std::size_t row = 0; row < s.id.size(); ++row) {
            if (s.id[row] == victim.index) continue;
            ASSERT_TRUE(std::isfinite(s.x[row] + s.y[row] + s.vx[row] + s.vy[row] + s.omega[row] + s.angle[row]))
                << "body " << s.id[row] << " frame " << k;
          }
        }
        EXPECT_EQ(world->body_count(), 100u);
      }
    }
  }
}

TEST(Quarantine, NanInTheSpinCountsToo) {
  auto world = pile(50, material(0, 0.3));
  run(*world, 10);
  const BodyId victim = world->id_of(7);
  world->set_velocity(victim, {0, 0}, kNan);
  EXPECT_EQ(world->step().quarantined, 1u);
  run(*world, 60);
  const PublishedState s = world->published();
  for (std::size_t row = 0; row < s.id.size(); ++row) {
    if (s.id[row] == victim.index) continue;
    EXPECT_TRUE(std::isfinite(s.omega[row] + s.x[row])) << row;
  }
}

TEST(Quarantine, OthersGoOnAsIfItWereAbsent) {
  // A body that nobody touches: the rest must have the same bits as without it.
  const auto build = [] {
    auto world = make(walled({0, 0, 100, 40}, {0, -kG}, material(0.2, 0.3)));
    add(*world, lattice(200, {0, 0, 40, 40}, 0.5, 5, material(0.2, 0.3)));
    return world;
  };
  auto with = build();
  auto without = build();
  const BodyId a = add(*with, disc({90, 30}));
  const BodyId b = add(*without, disc({90, 30}));
  run(*with, 30);
  run(*without, 30);
  ASSERT_TRUE(with->set_velocity(a, {kNan, kNan}, 0));
  ASSERT_TRUE(without->remove_body(b));
  EXPECT_EQ(with->step().quarantined, 1u);
  without->step();
  run(*with, 60);
  run(*without, 60);
  const PublishedState s = with->published();
  const PublishedState t = without->published();
  ASSERT_EQ(t.id.size(), 200u);
  for (std::size_t k = 0; k < 200; ++k) {
    ASSERT_EQ(s.x[k], t.x[k]) << k;
    ASSERT_EQ(s.y[k], t.y[k]) << k;
    ASSERT_EQ(s.vx[k], t.vx[k]) << k;
    ASSERT_EQ(s.omega[k], t.omega[k]) << k;
  }
}

TEST(Quarantine, ManyAtOnce) {
  auto world = pile(300, {}, best_isa(), 3);
  run(*world, 30);
  for (std::uint32_t k = 0; k < 300; k += 10) world->set_velocity(world->id_of(k), {kNan, kInf}, 0);
  EXPECT_EQ(world->step().quarantined, 30u);
  run(*world, 60);
  const PublishedState s = world->published();
  for (std::size_t row = 0; row < s.id.size(); ++row) {
    if (s.id[row] % 10 == 0) continue;
    ASSERT_TRUE(std::isfinite(s.x[row] + s.y[row])) << row;
  }
}

TEST(Quarantine, ABodySetRightAgainCanBeRemoved) {
  auto world = pile(50);
  world->set_velocity(world->id_of(3), {kNan, 0}, 0);
  run(*world, 10);
  EXPECT_TRUE(world->remove_body(world->id_of(3)));
  run(*world, 10);
  EXPECT_TRUE(all_finite(*world));
  EXPECT_EQ(world->body_count(), 49u);
}

TEST(Quarantine, AbsurdPlacesAndSpeedsHurtNobodyElse) {
  for (const double absurd : {1e9, 1e30, 1e300}) {
    for (const bool in_velocity : {false, true}) {
      auto world = pile(100);
      run(*world, 30);
      const BodyId victim = world->id_of(50);
      in_velocity ? world->set_velocity(victim, {absurd, -absurd}, 0) : world->set_transform(victim, {absurd, 0}, 0);
      run(*world, 120);
      const PublishedState s = world->published();
      for (std::size_t row = 0; row < s.id.size(); ++row) {
        if (s.id[row] == victim.index) continue;
        ASSERT_TRUE(std::isfinite(s.x[row] + s.y[row] + s.vx[row])) << absurd;
      }
    }
  }
}

std::unique_ptr<World> all_at_one_point(std::size_t n, int threads, Isa isa = best_isa()) {
  auto world = make(unbounded(1000, {0, 0}), isa, threads);
  Discs discs;
  for (std::size_t k = 0; k < n; ++k) discs.push(3.25, -1.5, 0.5);
  add(*world, discs);
  return world;
}

TEST(OnePoint, AFewDiscsComeApartWithoutMomentum) {
  for (const Isa isa : available_isas()) {
    for (const std::size_t n : {2u, 3u, 10u}) {
      SCOPED_TRACE(testing::Message() << isa_name(isa) << " " << n);
      auto world = all_at_one_point(n, 1, isa);
      auto again = all_at_one_point(n, 3, best_isa());
      for (int k = 0; k < 300; ++k) {
        world->step();
        again->step();
        ASSERT_EQ(world->state_hash(), again->state_hash()) << "frame " << k;
        ASSERT_TRUE(all_finite(*world)) << "frame " << k;
      }
      const Diagnostics d = world->diagnostics();
      EXPECT_NEAR(std::hypot(d.momentum_x, d.momentum_y), 0, 3e-5);
      if (n == 2) {
        EXPECT_LT(deepest(*world), 0.02);
      }
      double x = 0, y = 0;
      const PublishedState s = world->published();
      for (std::size_t k = 0; k < n; ++k) {
        x += s.x[k] / static_cast<double>(n);
        y += s.y[k] / static_cast<double>(n);
      }
      EXPECT_NEAR(x, 3.25, 1e-4);
      EXPECT_NEAR(y, -1.5, 1e-4);
    }
  }
}

TEST(SlowOnePoint, AThousandDiscsStayFinite) {
  auto world = all_at_one_point(1000, 2);
  auto again = all_at_one_point(1000, 1, Isa::scalar);
  for (int k = 0; k < 30; ++k) {
    world->step();
    again->step();
    ASSERT_EQ(world->state_hash(), again->state_hash()) << "frame " << k;
    ASSERT_TRUE(all_finite(*world)) << "frame " << k;
  }
  EXPECT_LT(relative_momentum(*world), 1e-4);
  EXPECT_EQ(world->body_count(), 1000u);
}

TEST(Denormals, GiveTheSameBitsEverywhere) {
  std::vector<std::vector<std::uint64_t>> seen;
  for (const Isa isa : available_isas()) {
    auto world = make(unbounded(100, {0, -1e-42}), isa);
    Random random(2);
    Discs discs;
    discs.m = material(0.5, 0.5);
    for (int j = 0; j < 10; ++j) {
      for (int i = 0; i < 10; ++i) {
        const double v = random.uniform(-1e-41, 1e-41), u = random.uniform(-1e-40, 1e-40);
        discs.push(i * 1.0, j * 1.0, 0.5, u, v);
      }
    }
    add(*world, discs);
    seen.push_back(hashes(*world, 60));
    EXPECT_TRUE(all_finite(*world));
  }
  for (const auto& h : seen) EXPECT_EQ(h, seen.front());
}

TEST(Extremes, BodiesAreRefusedOrStayFinite) {
  for (const double radius : {1e-300, 1e-30, 1e-6, 1e3, 1e30, 1e300}) {
    for (const double mass : {0.0, 1e-300, 1e-39, 1e-6, 1e6, 1e39, 1e300}) {
      auto world = make(unbounded(100));
      add(*world, ground());
      const BodyId normal = add(*world, disc({20, 0.5}));
      BodyDesc body = disc({0, 5}, {}, radius);
      body.mass = mass;
      std::string error;
      const BodyId id = world->add_body(body, error);
      if (id == kNoBody) {
        EXPECT_FALSE(error.empty()) << "radius " << radius << " mass " << mass;
      }
      run(*world, 120);
      const BodyState s = state(*world, normal);
      EXPECT_TRUE(std::isfinite(s.x + s.y + s.vx + s.vy)) << "radius " << radius << " mass " << mass;
      EXPECT_TRUE(all_finite(*world)) << "radius " << radius << " mass " << mass;
    }
  }
}

TEST(Refused, BodiesWithBadNumbers) {
  auto world = make(unbounded(100));
  std::vector<BodyDesc> bad(16, disc({0, 0}));
  bad[0].shape = DiscShape{0};
  bad[1].shape = DiscShape{-1};
  bad[2].shape = DiscShape{kNan};
  bad[3].position = {kNan, 0};
  bad[4].position = {0, kInf};
  bad[5].position = {101, 0};
  bad[6].velocity = {kInf, 0};
  bad[7].angular_velocity = kNan;
  bad[8].angle = kNan;
  bad[9].mass = -1;
  bad[10].mass = kNan;
  bad[11].material.density = 0;
  bad[12].material.restitution = 1.5;
  bad[13].material.friction = -0.1;
  bad[14].gravity_scale = kInf;
  bad[15].material.restitution = kNan;
  for (std::size_t k = 0; k < bad.size(); ++k) {
    std::string error;
    EXPECT_EQ(world->add_body(bad[k], error), kNoBody) << k;
    EXPECT_FALSE(error.empty()) << k;
    EXPECT_EQ(error.find('\n'), std::string::npos) << k;
  }
  EXPECT_EQ(world->body_count(), 0u);
}

TEST(Refused, StaticShapesThatAreNone) {
  auto world = make(unbounded(100));
  std::vector<BodyDesc> bad = {segment({1, 1}, {1, 1}),       segment({kNan, 0}, {1, 1}), chain({{0, 0}}), chain({}),
                               chain({{0, 0}, {1, 0}}, true), chain({{0, 0}, {kInf, 0}})};
  BodyDesc moving = chain({{0, 0}, {1, 0}});
  moving.type = BodyType::dynamic_body;
  bad.push_back(moving);
  for (std::size_t k = 0; k < bad.size(); ++k) {
    std::string error;
    EXPECT_EQ(world->add_body(bad[k], error), kNoBody) << k;
    EXPECT_FALSE(error.empty()) << k;
  }
  EXPECT_EQ(world->body_count(), 0u);
}

TEST(Refused, ABatchWithOneBadDiscAddsNone) {
  auto world = make(unbounded(100));
  const auto refused = [&](const DiscBatch& batch) {
    std::uint32_t first = 0;
    std::string error;
    EXPECT_EQ(world->add_discs(batch, first, error), 0u);
    EXPECT_FALSE(error.empty());
    EXPECT_EQ(world->body_count(), 0u);
  };
  std::vector<double> x(10, 1), y(10, 2), radius(10, 0.5), one{0.5}, short_y(9, 2);
  DiscBatch batch;
  batch.x = x;
  batch.y = short_y;
  batch.radius = one;
  refused(batch);
  batch.y = y;
  radius[7] = kNan;
  batch.radius = radius;
  refused(batch);
  batch.radius = one;
  x[3] = kInf;
  refused(batch);
  x[3] = 1;
  std::uint32_t first = 99;
  std::string error;
  EXPECT_EQ(world->add_discs(batch, first, error), 10u) << error;
  EXPECT_EQ(first, 0u);
}

TEST(Refused, WorldsWithBadNumbers) {
  std::vector<WorldDesc> bad(21, unbounded(100));
  bad[0].bounds = {1, -1, -1, 1};
  bad[1].bounds = {0, 0, 0, 1};
  bad[2].bounds.xmax = kNan;
  bad[3].bounds.ymax = kInf;
  bad[4].gravity.y = kNan;
  bad[5].gravity.x = kInf;
  bad[6].dt = 0;
  bad[7].dt = -1;
  bad[8].dt = kNan;
  bad[9].substeps = 0;
  bad[10].substeps = 65;
  bad[11].linear_damping = kNan;
  bad[12].restitution_threshold = -1;
  bad[13].wall.restitution = 2;
  bad[14].wall.friction = kNan;
  bad[15].fields.push_back(WellField{{kNan, 0}, 1, 0, 2, 0});
  bad[16].fields.push_back(WellField{{0, 0}, kInf, 0, 2, 0});
  bad[17].fields.push_back(DragField{kNan, 0});
  bad[18].linear_damping = -1;
  bad[19].skin = 0.2;
  bad[20].skin = kNan;
  for (std::size_t k = 0; k < bad.size(); ++k) {
    std::string error;
    EXPECT_EQ(World::create(bad[k], {}, error), nullptr) << k;
    EXPECT_FALSE(error.empty()) << k;
    EXPECT_EQ(error.find('\n'), std::string::npos) << k;
  }
}

TEST(Refused, RunOptionsThatCannotBe) {
  for (const int threads : {0, -1, 257}) {
    std::string error;
    EXPECT_EQ(World::create(unbounded(), {best_isa(), threads}, error), nullptr) << threads;
    EXPECT_FALSE(error.empty());
  }
  for (const Isa isa : kAllIsas) {
    if (isa_available(isa)) continue;
    std::string error;
    EXPECT_EQ(World::create(unbounded(), {isa, 1}, error), nullptr);
    EXPECT_NE(error.find(isa_name(isa)), std::string::npos) << error;
  }
}

}  // namespace
}  // namespace psim::test
