// Conservative advancement: it misses nothing, and it comes to the impact in a few advances, in a touch that grazes, too.
#include "solver/approach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "hull_oracle.h"

namespace psim::hull_oracle {
namespace {

struct Pair {
  Hull a, b;
  Course of_a, of_b;
  Approach approach() const { return {a, of_a, b, of_b}; }
  double size() const { return double{a.reach} + b.reach; }
  double distance(double share) const {
    const Vec2 d = of_b.place(share) - of_a.place(share);
    return oracle(a, rotor(of_a.facing(share)), b, rotor(of_b.facing(share)), {d.x, d.y});
  }
};

Pair random_pair(Scene s, std::mt19937_64& g) {
  Pair p{s.a, s.b, {}, {}};
  const double away = uniform(g, 0.3, 1.5) * s.size(), at = uniform(g, 0, 7);
  p.of_a = {{uniform(g, -1, 1), uniform(g, -1, 1)}, {uniform(g, -1, 1), uniform(g, -1, 1)}, uniform(g, 0, 7), 0};
  p.of_b = {p.of_a.at + Vec2{away * std::cos(at), away * std::sin(at)},
            {uniform(g, -2, 2), uniform(g, -2, 2)},
            uniform(g, 0, 7),
            0};
  if (g() % 2 != 0) p.of_a.turn = uniform(g, -2, 2);
  if (g() % 4 != 0) p.of_b.turn = uniform(g, -2, 2);
  return p;
}

TEST(Approach, NothingIsMetWithinAnAdvance) {
  int advances = 0;
  for_random_pairs(21, [&](const Scene& s, auto& g) {
    const Pair p = random_pair(s, g);
    const double from = uniform(g, 0, 0.8), fine = 1e-5 * p.size();
    const double limit = p.distance(from) - std::pow(10, uniform(g, -3, 0)) * p.size();
    const Approach::Stand now = p.approach().stand(from, limit);
    ASSERT_NEAR(now.distance, p.distance(from), fine);
    for (int k = 1; k <= 20; ++k) {
      const double share = from + now.advance * k / 20;
      if (share > 1) break;
      ASSERT_GE(p.distance(share), limit - fine) << k;
      ++advances;
    }
  });
  EXPECT_GT(advances, 1000);
}

// One end of a rod touches the floor while the other comes down: it is far from the floor, and comes nearer fast.
TEST(Approach, ARodThatTipsIsFollowedInFewAdvances) {
  std::mt19937_64 g(5);
  for (int trial = 0; trial < 200; ++trial) {
    const double turn = -uniform(g, 0.02, 0.5), tilt = uniform(g, 0.05, 1), sunk = uniform(g, 0, 0.02);
    Pair p{box(20, 1), capsule(0.28, 0.045), {}, {}};
    // The centre goes down as fast as the turn brings the lower end up, or a little faster.
    const double low = 0.14 * std::sin(tilt) + 0.045 - sunk, gain = uniform(g, 0, 0.001);
    p.of_b = {{0, 0.5 + low}, {0, turn * 0.14 * std::cos(tilt) - gain}, tilt, turn};
    const double start = p.distance(0), tolerance = 2e-5, limit = start - 2 * tolerance;
    const double found = p.approach().falls_to(limit, tolerance / 2, 0);
    double share = 0;
    int advances = 0;
    for (; advances < 128; ++advances) {
      const Approach::Stand now = p.approach().stand(share, limit);
      if (now.distance <= limit + tolerance / 2) break;
      share += now.advance;
      if (!(share < 1)) break;
    }
    ASSERT_LE(advances, 24) << trial << " tilt " << tilt << " turn " << turn;
    if (found > 1) {
      for (int k = 0; k <= 200; ++k) ASSERT_GT(p.distance(k / 200.0), limit - 1e-6);
    } else {
      ASSERT_NEAR(p.distance(found), limit, tolerance / 2 + 2e-6);
      for (int k = 0; k < 200; ++k) ASSERT_GE(p.distance(found * k / 200), limit - 1e-6);
    }
  }
}

}  // namespace
}  // namespace psim::hull_oracle
