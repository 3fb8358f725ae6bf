// No pair is lost, whatever the radii and wherever the grid's cells fall: against brute force.
#include <set>

#include "support.h"

namespace psim::test {
namespace {

/// A disc whose place among the others is free by at least `gap`; false if none was found.
bool place(Discs& discs, Random& random, Bounds region, double radius, double gap, reference::Periods periods = {}) {
  for (int attempt = 0; attempt < 2000; ++attempt) {
    discs.push(random, region, radius);
    const std::size_t last = discs.size() - 1;
    bool free = true;
    for (std::size_t k = 0; free && k < last; ++k) {
      free = reference::gap_between(discs.x, discs.y, discs.radius, k, last, periods) > gap;
    }
    if (free) return true;
    discs.x.pop_back();
    discs.y.pop_back();
    discs.radius.pop_back();
    discs.vx.pop_back();
    discs.vy.pop_back();
  }
  return false;
}

/// Radii spread evenly over the octaves between the two.
double log_uniform(Random& random, double low, double high) { return low * std::pow(high / low, random.uniform(0, 1)); }

/// One step of discs at rest: exactly those that overlap another may and must be pushed.
void expect_exactly_overlaps_are_felt(const WorldDesc& desc, const Discs& discs) {
  reference::Periods periods;
  if (desc.boundary == Boundary::periodic) periods = {desc.bounds.xmax, desc.bounds.ymax};
  std::vector<bool> deep(discs.size()), near(discs.size());
  // Who is pushed may come 0.1 m far in the step and push the next.
  for (const auto& p : reference::pairs_closer_than(discs.x, discs.y, discs.radius, 0.2, periods)) {
    const double smaller = std::min(discs.radius[p.a], discs.radius[p.b]);
    near[p.a] = near[p.b] = true;
    if (p.gap < -0.05 * smaller) deep[p.a] = deep[p.b] = true;
  }
  for (const Isa isa : available_isas()) {
    auto world = make(desc, isa, 2);
    add(*world, discs);
    const PublishedState before = world->published();
    const std::vector<double> x(before.x.begin(), before.x.end());
    const std::vector<double> y(before.y.begin(), before.y.end());
    world->step();
    const PublishedState s = world->published();
    for (std::size_t k = 0; k < discs.size(); ++k) {
      const bool moved = s.x[k] != x[k] || s.y[k] != y[k] || s.vx[k] != 0 || s.vy[k] != 0;
      if (deep[k]) {
        ASSERT_TRUE(moved) << isa_name(isa) << " disc " << k << " at (" << discs.x[k] << ", " << discs.y[k] << ") r "
                           << discs.radius[k] << " overlaps unnoticed";
      }
      if (!near[k]) {
        ASSERT_FALSE(moved) << isa_name(isa) << " disc " << k << " is pushed by nobody";
      }
    }
  }
}

TEST(MixedRadii, EveryOverlapOfEqualDiscsIsFelt) {
  Random random(1);
  Discs discs;
  for (int k = 0; k < 800; ++k) discs.push(random, {0, 0, 80, 80}, 0.5);
  expect_exactly_overlaps_are_felt(unbounded(200, {0, 0}), discs);
}

TEST(MixedRadii, EveryOverlapFromOneToFiftyIsFelt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    Discs discs;
    for (int k = 0; k < 600; ++k) {
      discs.push(random, {0, 0, 300, 300}, log_uniform(random, 0.1, 5));
    }
    SCOPED_TRACE(seed);
    expect_exactly_overlaps_are_felt(unbounded(500, {0, 0}), discs);
  }
}

TEST(MixedRadii, EveryOverlapWithManyMiddlingOnesIsFelt) {
  // More large ones than are compared each with each; the small ones lie on them.
  for (const bool wraps : {false, true}) {
    Random random(11);
    Discs discs;
    for (int k = 0; k < 1000; ++k) {
      ASSERT_TRUE(place(discs, random, {1, 1, 299, 199}, log_uniform(random, 0.5, 1.5), 0.3));
    }
    for (int k = 0; k < 6000; ++k) discs.push(random, {0, 0, 300, 200}, 0.03);
    SCOPED_TRACE(wraps ? "periodic" : "open");
    expect_exactly_overlaps_are_felt(wraps ? periodic(300, 200) : unbounded(500, {0, 0}), discs);
  }
}

TEST(MixedRadii, CandidatesOfManyMiddlingOnesHoldEveryDeepOverlap) {
  for (const bool wraps : {false, true}) {
    Random random(12);
    Discs discs;
    for (int k = 0; k < 1500; ++k) discs.push(random, {0, 0, 300, 200}, log_uniform(random, 1, 3));
    for (int k = 0; k < 4000; ++k) discs.push(random, {0, 0, 300, 200}, 0.03);
    auto world = make(wraps ? periodic(300, 200) : unbounded(500, {0, 0}));
    add(*world, discs);
    const reference::Periods periods = wraps ? reference::Periods{300, 200} : reference::Periods{};
    const auto touching = reference::pairs_closer_than(discs.x, discs.y, discs.radius, 0, periods);
    world->step();
    std::set<std::pair<std::uint32_t, std::uint32_t>> listed;
    for (const Contact& c : world->contacts()) listed.insert({c.a.index, c.b.index});
    std::size_t deep = 0;
    for (const auto& p : touching) {
      if (p.gap > -0.5) continue;  // some of the others are apart after the step
      ++deep;
      ASSERT_TRUE(listed.contains({p.a, p.b})) << p.a << " " << p.b << " " << p.gap;
    }
    EXPECT_GT(deep, 1000u);
  }
}

TEST(MixedRadii, EveryOverlapAcrossTheSeamIsFelt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    Discs discs;
    for (int k = 0; k < 500; ++k) {
      discs.push(random, {0, 0, 100, 60}, log_uniform(random, 0.2, 2));
    }
    SCOPED_TRACE(seed);
    expect_exactly_overlaps_are_felt(periodic(100, 60), discs);
  }
}

TEST(MixedRadii, LonePairsAnywhereComeApart) {
  // Pairs at random places, sizes and directions, each alone with its overlap of a fifth.
  Random random(4);
  Discs centres;
  Discs discs;
  for (int k = 0; k < 300; ++k) {
    const double big = log_uniform(random, 0.1, 5), small = log_uniform(random, 0.1, big);
    if (!place(centres, random, {-900, -900, 900, 900}, 2 * (big + small), 0.5)) continue;
    const double direction = random.uniform(0, 2 * kPi);
    const double apart = big + small - 0.2 * small;
    const double x = centres.x.back(), y = centres.y.back();
    discs.push(x, y, big);
    discs.push(x + apart * std::cos(direction), y + apart * std::sin(direction), small);
  }
  ASSERT_GT(discs.size(), 400u);
  auto world = make(unbounded(1000, {0, 0}), best_isa(), 2);
  add(*world, discs);
  EXPECT_GE(world->step().contacts, discs.size() / 2);
  run(*world, 120);
  const PublishedState s = world->published();
  for (std::size_t k = 0; k < discs.size(); k += 2) {
    const double gap = reference::gap_between(s.x, s.y, s.radius, k, k + 1);
    EXPECT_GT(gap, -0.02 * 2 * s.radius[k + 1]) << "pair " << k / 2;
  }
}

TEST(MixedRadii, CandidatesHoldEveryTouchingPair) {
  Random random(8);
  WorldDesc desc = walled({0, 0, 60, 60}, {0, -kG}, material(0.3));
  Discs discs;
  for (int k = 0; k < 400; ++k) place(discs, random, {5, 5, 55, 55}, log_uniform(random, 0.1, 3), 0);
  ASSERT_GT(discs.size(), 200u);
  auto world = make(desc);
  add(*world, discs);
  for (int frame = 0; frame < 120; ++frame) {
    const PublishedState s = world->published();
    const auto touching = reference::pairs_closer_than(s.x, s.y, s.radius, 0).size();
    const StepReport report = world->step();
    ASSERT_GE(report.pairs, touching) << "frame " << frame;
    ASSERT_GE(report.pairs, report.contacts) << "frame " << frame;
  }
}

TEST(MixedRadii, NobodyPassesThroughAnother) {
  Random random(6);
  const Bounds bounds{0, 0, 100, 100};
  Discs discs;
  discs.m = material(0.8);
  for (int k = 0; k < 12; ++k) place(discs, random, {6, 6, 94, 94}, 5, 0.1);
  for (int k = 0; k < 500; ++k) place(discs, random, {6, 6, 94, 94}, log_uniform(random, 0.1, 2), 0.01);
  for (std::size_t k = 0; k < discs.size(); ++k) {
    discs.vx[k] = random.uniform(-10, 10);
    discs.vy[k] = random.uniform(-10, 10);
  }
  for (const int threads : {1, 3}) {
    auto world = make(walled(bounds, {0, 0}, material(0.8)), best_isa(), threads);
    add(*world, discs);
    double worst = 0;
    for (int frame = 0; frame < 240; ++frame) {
      world->step();
      const PublishedState s = world->published();
      for (const auto& p : reference::pairs_closer_than(s.x, s.y, s.radius, 0)) {
        worst = std::max(worst, -p.gap / (2 * std::min(s.radius[p.a], s.radius[p.b])));
      }
    }
    // Of the smaller one's diameter; light ones are knocked about by bodies 15,000 times as heavy.
    EXPECT_LT(worst, 0.5) << threads << " threads";
    EXPECT_TRUE(all_inside(*world));
  }
}

TEST(MixedRadii, ManySmallOnesRoundABigOne) {
  // 600 about one: more contacts on one body than any register or colour count is wide.
  auto world = make(unbounded(200, {0, 0}), best_isa(), 2);
  const double big = 20, small = 0.1;
  add(*world, disc({0, 0}, {}, big));
  Discs ring;
  for (int k = 0; k < 600; ++k) {
    const double angle = 2 * kPi * k / 600;
    ring.push((big + 2) * std::cos(angle), (big + 2) * std::sin(angle), small, -5 * std::cos(angle),
              -5 * std::sin(angle));
  }
  add(*world, ring);
  run_seconds(*world, 2);
  const PublishedState s = world->published();
  for (std::size_t k = 1; k < s.id.size(); ++k) {
    ASSERT_GT(std::hypot(s.x[k] - s.x[0], s.y[k] - s.y[0]), big + small - 0.02) << k;
  }
  EXPECT_NEAR(s.x[0], 0, 1e-3);
  EXPECT_NEAR(s.y[0], 0, 1e-3);
}

}  // namespace
}  // namespace psim::test
