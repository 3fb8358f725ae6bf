// Bodies under much heavier ones: which they are, that they carry them, and that others pay nothing.
#include "lists/heavy_loads.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support.h"

namespace psim::test {
namespace {

using Marks = std::vector<int>;

// A chain of bodies 0 - 1 - 2 - ... with these masses, in one strip.
struct Chain {
  explicit Chain(const std::vector<float>& masses) : bodies(memory), table(memory), loads(memory) {
    const std::size_t n = masses.size();
    bodies.reserve_slots(n);
    bodies.info.reserve(n);
    table.owner.reserve(n);
    table.other.reserve(n);
    for (const float mass : masses) {
      BodyProperties surface;
      surface.mass = mass;
      surface.inv_mass = mass > 0 ? 1 / mass : 0;
      const std::uint32_t id = bodies.take_id();
      bodies.info[id].properties = bodies.property_table.acquire(surface);
      bodies.id[bodies.count++] = id;
    }
    table.body_count = bodies.count;
    for (std::uint32_t k = 0; k + 1 < n; ++k) {
      table.owner[k] = k;
      table.other[k] = k + 1;
    }
    table.strips.resize(2);  // one of the grid, and the large bodies'
    table.strips[0].body_end = table.strips[1].body_begin = table.strips[1].body_end = bodies.count;
    table.strips[0].pair_end = static_cast<std::uint32_t>(n - 1);
    table.strips[1].pair_begin = table.strips[1].pair_end = table.strips[0].pair_end;
    find(loads, ~std::size_t{0});
  }

  // So many pieces at a time; how many there were.
  std::size_t find(HeavyLoads& found, std::size_t at_a_time) {
    found.begin(bodies, table, pool);
    std::size_t done = 0;
    while (done != found.pieces()) {
      const std::size_t end = done + std::min(at_a_time, found.pieces() - done);
      found.go_on(table, pool, done, end);
      done = end;
    }
    return done;
  }

  Marks marked() const {
    Marks out;
    for (std::uint32_t k = 0; k < bodies.count; ++k) out.push_back(loads.at(k) ? 1 : 0);
    return out;
  }

  MemoryMeter memory;
  WorkerPool pool{1};
  BodyStore bodies;
  PairTable table;
  HeavyLoads loads;
};

TEST(HeavyLoads, PiecesOneByOneFindTheSame) {
  const std::vector<std::vector<float>> chains = {{1, 1, 1, 1000, 1, 1, 50, 1}, {1, 2, 3}, {10, 1, 10, 1, 1}};
  for (const std::vector<float>& masses : chains) {
    Chain whole(masses), cut(masses);
    const std::size_t pieces = cut.find(cut.loads, 1);
    EXPECT_EQ(cut.marked(), whole.marked());
    EXPECT_EQ(pieces % cut.table.strips.size(), 0u);
    const std::size_t passes = whole.loads.any() ? 8 : 1;
    EXPECT_GE(pieces, passes * cut.table.strips.size()) << "a pass over the strips is one piece";
  }
}

TEST(HeavyLoads, NobodyAmongEqualsOrBelowEightfold) {
  EXPECT_FALSE(Chain({1, 1, 1}).loads.any());
  EXPECT_FALSE(Chain({1, 7.9f, 1}).loads.any());
}

TEST(HeavyLoads, TheLightPartnerAndFiveContactsFromIt) {
  const Chain chain({1, 1, 1, 1, 1, 1, 1, 1, 8});
  EXPECT_TRUE(chain.loads.any());
  EXPECT_EQ(chain.marked(), (Marks{0, 0, 1, 1, 1, 1, 1, 1, 0}));
}

TEST(HeavyLoads, TheLoadItselfPassesNothingOn) { EXPECT_EQ(Chain({1, 100, 1, 1}).marked(), (Marks{1, 0, 1, 1})); }

TEST(HeavyLoads, KinematicBodiesAreNoLoadAndPassNothingOn) {
  EXPECT_FALSE(Chain({1, 0, 1}).loads.any());
  EXPECT_EQ(Chain({1, 0, 1, 10}).marked(), (Marks{0, 0, 1, 0}));
}

TEST(HeavyLoads, TheHeaviestComeFirstWhereThereAreTooMany) {
  std::vector<float> masses;
  for (int k = 0; k < 2000; ++k) masses.insert(masses.end(), {1, 10, 10, 10});
  masses.insert(masses.end(), {10, 10, 10, 1000});
  const Chain chain(masses);
  EXPECT_TRUE(chain.loads.any());
  EXPECT_FALSE(chain.loads.at(0));
  EXPECT_TRUE(chain.loads.at(static_cast<std::uint32_t>(masses.size()) - 2));
}

// ---- in a world -------------------------------------------------------------------------------

struct Tower {
  double floor = 0, between = 0;  // overlaps, m
  double speed = 0;               // m/s
};

// A disc of `ratio` kg on one of 1 kg, radius 0.5 m, on the ground, for 10 s.
Tower tower(double ratio, Material m, Isa isa = Isa::scalar, int threads = 1) {
  const auto world = make(unbounded(), isa, threads);
  add(*world, ground(m));
  std::vector<BodyId> ids;
  for (int k = 0; k < 2; ++k) {
    BodyDesc body = disc({0, 0.5 + k}, {}, 0.5, m);
    body.mass = k == 0 ? 1 : ratio;
    body.fixed_rotation = true;
    ids.push_back(add(*world, body));
  }
  for (int k = 0; k < 600; ++k) world->step();
  const BodyState low = *world->body(ids[0]), high = *world->body(ids[1]);
  return {0.5 - low.y, 1 - (high.y - low.y), std::fmax(std::fabs(low.vy), std::fabs(high.vy))};
}

TEST(HeavyLoads, AThousandfoldSinksByLessThanAFortiethOfARadius) {
  for (const Material m : {material(0), material(0, 0.5), material(0.5), material(0.5, 0.5)}) {
    const Tower t = tower(1000, m);
    EXPECT_LT(t.floor, 0.0125) << m.restitution << ' ' << m.friction;
    EXPECT_LT(t.between, 0.0125) << m.restitution << ' ' << m.friction;
    EXPECT_LT(t.speed, 1e-4) << m.restitution << ' ' << m.friction;
  }
}

TEST(HeavyLoads, OverlapGrowsWithTheRatioNoFasterThanInProportion) {
  double last = tower(10, material(0)).between;
  for (const double ratio : {100.0, 1000.0}) {
    const double now = tower(ratio, material(0)).between;
    EXPECT_LT(now, 11 * last) << ratio;
    last = now;
  }
}

TEST(HeavyLoads, SameBitsFromEveryIsaAndThreadCount) {
  const Tower reference = tower(300, material(0.3, 0.5));
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      const Tower t = tower(300, material(0.3, 0.5), isa, threads);
      EXPECT_EQ(t.floor, reference.floor);
      EXPECT_EQ(t.between, reference.between);
      EXPECT_EQ(t.speed, reference.speed);
    }
  }
}

}  // namespace
}  // namespace psim::test
