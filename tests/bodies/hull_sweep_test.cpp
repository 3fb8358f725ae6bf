// Hulls that move and rays against hulls: fine steps of an oracle in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collide/collide.h"
#include "hull_oracle.h"

namespace psim::hull_oracle {
namespace {

/// First share at which the distance is at most `slack`, by fine steps; 1 if none.
double stepped_impact(const Scene& s, double turn, double mx, double my, double slack) {
  constexpr int kSteps = 2000;
  for (int k = 0; k <= kSteps; ++k) {
    const double t = static_cast<double>(k) / kSteps;
    const Rotor q = rotor(s.angle_b + t * turn);
    if (oracle(s.a, s.qa, s.b, q, {s.dx + t * mx, s.dy + t * my}) <= slack) return t;
  }
  return 1;
}

TEST(HullSweep, NeverLateAndNotEarly) {
  int hits = 0;
  for_random_pairs(12, [&](Scene s, auto& g) {
    const double slack = uniform(g, 0.01, 0.1), turn = g() % 2 ? 0 : uniform(g, -3, 3);
    const double away = 1.3 * s.size(), at = uniform(g, 0, 7);
    s.dx = static_cast<float>(away * std::cos(at));
    s.dy = static_cast<float>(away * std::sin(at));
    const float mx = static_cast<float>(-2 * s.dx + uniform(g, -1, 1) * away);
    const float my = static_cast<float>(-2 * s.dy + uniform(g, -1, 1) * away);
    const float share = time_of_impact(s.a, s.qa, s.b, s.angle_b, turn, s.dx, s.dy, mx, my, static_cast<float>(slack));
    const double stepped = stepped_impact(s, turn, mx, my, slack);
    ASSERT_LE(share, stepped + 1e-5);
    if (share >= 1) return;
    ++hits;
    const double left =
        oracle(s.a, s.qa, s.b, rotor(s.angle_b + share * turn), {s.dx + double{share} * mx, s.dy + double{share} * my});
    ASSERT_GE(left, slack - 1e-5 * s.size());
    ASSERT_LE(left, 1.2 * slack + 1e-5 * s.size());
  });
  EXPECT_GT(hits, 100);
}

TEST(HullSweep, AnArrowIntoAThinWall) {
  Hull wall;
  wall.count = 2;
  wall.y[0] = -5;
  wall.y[1] = 5;
  finish_hull(wall);
  const Hull arrow = box(0.4, 0.02);
  const float share = time_of_impact(wall, {}, arrow, 0, 0, -10, 0, 1000, 0, 0.01f);
  EXPECT_NEAR(share, (10 - 0.2 - 0.01) / 1000, 2e-6);
  EXPECT_EQ(time_of_impact(wall, {}, arrow, 0, 0, -10, 5.1f, 1000, 0, 0.01f), 1);
}

TEST(HullSweep, CloseFromTheStart) {
  const Hull ground = box(10, 1), b = box(1, 1);
  const auto from = [&](float gap, float mx, float my) {
    return time_of_impact(ground, {}, b, 0, 0, 0, 1 + gap, mx, my, 0.01f);
  };
  EXPECT_EQ(from(0.005f, 3, 0), 1);  // slides
  EXPECT_EQ(from(0.0105f, 3, 0), 1);
  EXPECT_EQ(from(0.005f, 0, 1), 1);      // parts
  EXPECT_EQ(from(0.005f, 0, -0.1f), 1);  // presses
  // What would pass on through is stopped half of its inner radius deep; sunk as deep from the start,
  // before its centre goes through; inside already, not at all: contacts push it out.
  EXPECT_NEAR(from(0.005f, 0, -3), 0.255 / 3, 1e-3);
  EXPECT_NEAR(from(-0.005f, 0, -3), 0.245 / 3, 1e-3);
  EXPECT_NEAR(from(-0.3f, 0, -3), 0.5 * 0.2 / 3, 1e-3);
  EXPECT_EQ(from(-0.7f, 0, -3), 1);
}

TEST(HullRay, AgreesWithFineSteps) {
  std::mt19937_64 g(11);
  Hull point;
  point.count = 1;
  finish_hull(point);
  int hits = 0;
  for (int count = 1; count <= 8; ++count) {
    for (int k = 0; k < 200; ++k) {
      const Hull h = random_hull(g, count, count < 3 || g() % 2);
      const Rotor q = rotor(uniform(g, -4, 4));
      const double at = uniform(g, 0, 7), away = uniform(g, 0, 2) * h.reach;
      const P o{away * std::cos(at), away * std::sin(at)};
      const P r{-2 * o.x + uniform(g, -1, 1), -2 * o.y + uniform(g, -1, 1)};
      const auto distance = [&](double t) { return oracle(h, q, point, {}, {o.x + t * r.x, o.y + t * r.y}); };
      // Sphere tracing: the ray may advance by its distance from the hull.
      double t = 0;
      const double start = distance(0);
      if (start > 0) {
        for (int i = 0; i < 3000 && t <= 1; ++i) {
          const double left = distance(t);
          if (left < 1e-9) break;
          t += left / norm(r);
        }
      }
      const RayCast cast = cast_ray(h, q, o.x, o.y, r.x, r.y);
      SCOPED_TRACE(testing::Message() << count << " vertices, case " << k);
      if (start < -1e-6) {
        ASSERT_EQ(cast.fraction, 0);
        ASSERT_EQ(cast.nx, 0);
        ASSERT_EQ(cast.ny, 0);
      } else if (t > 1) {
        ASSERT_EQ(cast.fraction, 2);
      } else if (start > 1e-6) {
        ++hits;
        ASSERT_NEAR(cast.fraction, t, 1e-4);
        ASSERT_NEAR(std::hypot(cast.nx, cast.ny), 1, 1e-5);
        ASSERT_LT(cast.nx * r.x + cast.ny * r.y, 1e-4);
        // A little out along the normal is as far from the hull.
        const P on{o.x + cast.fraction * r.x + 0.01 * cast.nx, o.y + cast.fraction * r.y + 0.01 * cast.ny};
        ASSERT_NEAR(oracle(h, q, point, {}, on), 0.01, 1e-4);
      }
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(HullRay, KnownHits) {
  const Hull b = box(2, 2);
  RayCast r = cast_ray(b, {}, -3, 0.5, 4, 0);
  EXPECT_EQ(r.fraction, 0.5f);
  EXPECT_EQ(r.nx, -1);
  EXPECT_EQ(cast_ray(b, {}, -3, 0.5, 1.9, 0).fraction, 2);  // too short
  EXPECT_EQ(cast_ray(b, {}, -3, 0.5, -4, 0).fraction, 2);   // away
  EXPECT_EQ(cast_ray(b, {}, -3, 0.5, 0, 0).fraction, 2);    // nowhere
  EXPECT_EQ(cast_ray(b, {}, 0.2, 0.5, 0, 0).fraction, 0);   // inside
  EXPECT_EQ(cast_ray(b, {}, -1, 0, 1, 0).fraction, 0);      // from the surface inwards:
  EXPECT_EQ(cast_ray(b, {}, -1, 0, 1, 0).nx, -1);           // with its normal
  EXPECT_EQ(cast_ray(b, {}, -1, 0, -1, 0).fraction, 2);     // outwards
  // Through a corner, either edge's normal, but a hit.
  EXPECT_FLOAT_EQ(cast_ray(b, {}, -2, -2, 2, 2).fraction, 0.5f);
  // A thin segment is hit from both sides.
  Hull s;
  s.count = 2;
  s.x[0] = -1;
  s.x[1] = 1;
  finish_hull(s);
  EXPECT_EQ(cast_ray(s, {}, 0, 1, 0, -2).fraction, 0.5f);
  EXPECT_EQ(cast_ray(s, {}, 0, 1, 0, -2).ny, 1);
  EXPECT_EQ(cast_ray(s, {}, 0, -1, 0, 2).ny, -1);
  EXPECT_EQ(cast_ray(s, {}, 1.1, -1, 0, 2).fraction, 2);
}

TEST(HullRay, NoneSlipsThroughACorner) {
  std::mt19937_64 g(5);
  for (int count = 3; count <= 8; ++count) {
    for (int k = 0; k < 4000; ++k) {
      const Hull h = random_hull(g, count, false);
      const Rotor q = rotor(uniform(g, -3, 3));
      const auto corner = static_cast<std::size_t>(k % count);
      // From outside through the corner to a place within.
      P to;
      double all = 0;
      for (const P v : corners(h, q, {})) {
        const double share = uniform(g, 0.1, 1);
        to = {to.x + share * v.x, to.y + share * v.y};
        all += share;
      }
      to = {to.x / all, to.y / all};
      const P at = corners(h, q, {})[corner];
      const double back = uniform(g, 1, 5);
      const P from{at.x + back * (at.x - to.x), at.y + back * (at.y - to.y)};
      ASSERT_LE(cast_ray(h, q, from.x, from.y, to.x - from.x, to.y - from.y).fraction, 1);
    }
  }
}

}  // namespace
}  // namespace psim::hull_oracle
