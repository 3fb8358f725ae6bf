// Handles: stable under removal, reused with another generation, in step with every list.
#include <map>

#include "bodies/population.h"
#include "support.h"

namespace psim::test {
namespace {

TEST(Ids, CountFromZeroInTheOrderOfTheCalls) {
  auto world = make(unbounded(100, {0, 0}));
  EXPECT_EQ(add(*world, ground()).index, 0u);
  EXPECT_EQ(add(*world, disc({0, 5})).index, 1u);
  EXPECT_EQ(add(*world, lattice(10, {10, 10, 40, 40}, 0.5, 0, {})), 2u);
  EXPECT_EQ(add(*world, disc({0, 8})).index, 12u);
  EXPECT_EQ(world->body_count(), 13u);
  EXPECT_EQ(world->dynamic_count(), 12u);
  EXPECT_EQ(world->static_count(), 1u);
}

TEST(Ids, AStaleHandleIsKnown) {
  auto world = make(unbounded());
  const BodyId id = add(*world, disc({0, 0}));
  ASSERT_TRUE(world->remove_body(id));
  EXPECT_FALSE(world->is_valid(id));
  EXPECT_FALSE(world->remove_body(id));
  EXPECT_FALSE(world->body(id).has_value());
  EXPECT_FALSE(world->set_velocity(id, {1, 0}, 0));
  EXPECT_FALSE(world->set_transform(id, {1, 0}, 0));
  EXPECT_FALSE(world->apply_impulse(id, {1, 0}));
  const BodyId next = add(*world, disc({0, 0}));
  EXPECT_FALSE(world->is_valid(id));
  if (next.index == id.index) {
    EXPECT_NE(next.generation, id.generation);
  }
  EXPECT_FALSE(world->is_valid(kNoBody));
  EXPECT_FALSE(world->is_valid({1000000, 0}));
  EXPECT_EQ(world->id_of(next.index), next);
}

TEST(Ids, StaticBodiesCannotBeMoved) {
  auto world = make(unbounded());
  const BodyId id = add(*world, static_disc({3, 4}, 1));
  EXPECT_FALSE(world->set_velocity(id, {1, 0}, 0));
  EXPECT_FALSE(world->set_transform(id, {0, 0}, 0));
  EXPECT_EQ(state(*world, id).x, 3);
}

TEST(Ids, SurviveEveryStep) {
  // Bodies are sorted physically as they move: a handle must go on naming the same one.
  auto world = gas_in_walls(500, 0.2, material(1), 20, best_isa(), 2);
  const BodyId marked = world->id_of(123);
  ASSERT_TRUE(world->set_velocity(marked, {0, 0}, 77));
  for (int k = 0; k < 120; ++k) {
    world->step();
    ASSERT_EQ(state(*world, marked).omega, 77) << "frame " << k;  // nothing here has friction
  }
}

TEST(Ids, PublishedRowsAreTheBodiesInOrder) {
  auto world = gas_in_walls(300, 0.2, material(1));
  for (std::uint32_t k = 5; k < 300; k += 7) world->remove_body(world->id_of(k));
  run(*world, 30);
  const PublishedState s = world->published();
  ASSERT_EQ(s.id.size(), world->body_count());
  for (const std::size_t n : {s.x.size(), s.y.size(), s.angle.size(), s.vx.size(), s.vy.size(), s.omega.size(),
                              s.radius.size(), s.type.size()}) {
    ASSERT_EQ(n, s.id.size());
  }
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    ASSERT_TRUE(k == 0 || s.id[k - 1] < s.id[k]);
    const BodyState b = state(*world, world->id_of(s.id[k]));
    ASSERT_EQ(b.x, s.x[k]);
    ASSERT_EQ(b.y, s.y[k]);
    ASSERT_EQ(b.vx, s.vx[k]);
    ASSERT_EQ(b.radius, s.radius[k]);
  }
}

TEST(Ids, ChurnAgreesWithAMap) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    auto world = make(walled({0, 0, 200, 200}, {0, 0}, material(0.5)), best_isa(), 2);
    std::map<std::uint32_t, std::pair<BodyId, double>> model;  // index -> handle, radius as a mark
    std::vector<BodyId> dead;
    const auto learn = [&](BodyId id, double radius) {
      ASSERT_EQ(model.count(id.index), 0u) << "an index in use was given again";
      for (const BodyId& old : dead) ASSERT_FALSE(old == id) << "a dead handle came back";
      model[id.index] = {id, radius};
    };
    double mark = 0.1;
    for (int round = 0; round < 300; ++round) {
      mark += 1e-4;
      const Vec2 place{random.uniform(1, 199), random.uniform(1, 199)};
      switch (random.below(5)) {
        case 0:
          learn(add(*world, disc(place, {random.uniform(-5, 5), 0}, mark)), mark);
          break;
        case 1:
          learn(add(*world, static_disc(place, mark)), mark);
          break;
        case 2: {
          Discs batch;
          for (std::size_t k = 1 + random.below(20); k > 0; --k) {
            batch.push(random, {1, 1, 199, 199}, mark);
          }
          const std::size_t before = world->body_count();
          std::vector<bool> had(100000);
          for (const auto& [index, body] : model) had[index] = true;
          add(*world, batch);
          ASSERT_EQ(world->body_count(), before + batch.size());
          const PublishedState s = world->published();
          for (const std::uint32_t index : s.id) {
            if (!had[index]) learn(world->id_of(index), mark);
          }
          break;
        }
        case 3:
          for (std::size_t k = random.below(12); k > 0 && !model.empty(); --k) {
            auto victim = model.begin();
            std::advance(victim, static_cast<std::ptrdiff_t>(random.below(model.size())));
            ASSERT_TRUE(world->remove_body(victim->second.first));
            dead.push_back(victim->second.first);
            model.erase(victim);
          }
          break;
        default:
          world->step();
      }
      if (HasFatalFailure()) return;
      ASSERT_EQ(world->body_count(), model.size());
      for (const BodyId& id : dead) ASSERT_FALSE(world->is_valid(id));
      const PublishedState s = world->published();
      ASSERT_EQ(s.id.size(), model.size());
      std::size_t row = 0;
      for (const auto& [index, body] : model) {
        ASSERT_TRUE(world->is_valid(body.first));
        ASSERT_EQ(world->id_of(index), body.first);
        ASSERT_EQ(s.id[row], index);
        ASSERT_NEAR(s.radius[row], body.second, 1e-6);
        ASSERT_NEAR(state(*world, body.first).radius, body.second, 1e-6);
        ++row;
      }
    }
    EXPECT_GT(dead.size(), 50u);
  }
}

TEST(Ids, RemovalInAPileKeepsTheOthersInPlace) {
  auto world = pile(400, material(0, 0.5));
  run(*world, 300);
  std::vector<BodyId> kept;
  std::vector<double> radius;
  Random random(3);
  for (std::uint32_t k = 0; k < 400; ++k) {
    if (random.chance(0.3)) {
      world->remove_body(world->id_of(k));
    } else {
      kept.push_back(world->id_of(k));
    }
  }
  std::vector<BodyState> before;
  for (const BodyId& id : kept) before.push_back(state(*world, id));
  world->step();
  for (std::size_t k = 0; k < kept.size(); ++k) {
    ASSERT_NEAR(state(*world, kept[k]).x, before[k].x, 0.1);
    ASSERT_NEAR(state(*world, kept[k]).y, before[k].y, 0.1);
  }
}

// Four milliards of bodies later: an index that had all its generations is given to nobody.
TEST(Ids, NoneComesASecondTime) {
  const WorldDesc desc = unbounded(100);
  const Lattice lattice{desc.bounds, false};
  MemoryMeter memory;
  Population population{desc, lattice, memory};
  std::string error;
  const BodyId first = population.add(disc({0, 0}), error);
  ASSERT_EQ(first, (BodyId{0, 0}));
  population.bodies.info[0].generation = kLastGeneration - 1;
  const BodyId last{0, kLastGeneration - 1};
  ASSERT_TRUE(population.is_valid(last));
  EXPECT_FALSE(population.is_valid(first));
  population.remove(0);
  EXPECT_EQ(population.bodies.living(), 0u);
  for (const BodyId id : {first, last, BodyId{0, kLastGeneration}}) EXPECT_FALSE(population.is_valid(id));
  const BodyId next = population.add(disc({0, 0}), error);
  EXPECT_EQ(next, (BodyId{1, 0}));
  EXPECT_EQ(population.bodies.living(), 1u);
  for (const BodyId id : {first, last, BodyId{0, kLastGeneration}}) EXPECT_FALSE(population.is_valid(id));
  population.remove(1);
  EXPECT_EQ(population.add(disc({0, 0}), error), (BodyId{1, 1}));
}

TEST(Ids, HashChangesWithTheStateOnly) {
  auto world = pile(50);
  run(*world, 10);
  const auto before = world->state_hash();
  EXPECT_EQ(world->state_hash(), before);
  world->published();
  world->diagnostics();
  EXPECT_EQ(world->state_hash(), before);
  const BodyState s = state(*world, world->id_of(5));
  world->set_velocity(s.id, {s.vx + 0.125, s.vy}, s.omega);
  EXPECT_NE(world->state_hash(), before);
}

TEST(Ids, HashTakesSignedZerosAlike) {
  auto plus = make(unbounded(100, {0, 0}));
  auto minus = make(unbounded(100, {0, 0}));
  add(*plus, disc({0.0, 0.0}, {0.0, 0.0}));
  add(*minus, disc({-0.0, -0.0}, {-0.0, -0.0}));
  EXPECT_EQ(plus->state_hash(), minus->state_hash());
}

}  // namespace
}  // namespace psim::test
