// Contacts of two hulls against an oracle in double precision.
#include "collide/collide.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "hull_oracle.h"

namespace psim::hull_oracle {
namespace {

TEST(Collide, NearestIsTheDistanceOrTheLeastDepth) {
  int apart = 0, deep = 0;
  for_random_pairs(300, [&](const Scene& s, auto&) {
    const double truth = s.truth();
    const Nearest n = s.near();
    ASSERT_NEAR(n.distance, truth, 4e-6 * s.size());
    ASSERT_NEAR(std::hypot(n.nx, n.ny), 1, 1e-6);
    // A's nearest point lies on A: a point-sized hull there is at distance 0.
    Hull point;
    point.count = 1;
    finish_hull(point);
    if (truth > -s.a.radius - s.b.radius) {
      ++apart;
      ASSERT_NEAR(oracle(s.a, s.qa, point, {}, {n.ax, n.ay}), 0, 4e-6 * s.size());
    } else {
      ++deep;
    }
  });
  EXPECT_GT(apart, 4000);
  EXPECT_GT(deep, 4000);
}

TEST(Collide, ThinHullsAndNearlyStraightCornersAreNoWorse) {
  std::mt19937_64 g(13);
  for (int k = 0; k < 15000; ++k) {
    Scene s = random_scene(g, 2 + static_cast<int>(g() % 7), 2 + static_cast<int>(g() % 7));
    for (Hull* h : {&s.a, &s.b}) {
      const float flat = g() % 3 == 0 ? 1.0f : static_cast<float>(std::exp(uniform(g, -8, 0)));
      const float size = static_cast<float>(std::exp(uniform(g, -3, 3)));
      for (int i = 0; i < h->count; ++i) {
        h->x[i] *= size;
        h->y[i] *= size * flat;
      }
      finish_hull(*h);
    }
    const Nearest far = s.near();  // then close together
    const double gap = uniform(g, -0.01, 0.02) * std::min(s.a.reach, s.b.reach);
    s.dx += static_cast<float>(far.nx * (gap - far.distance));
    s.dy += static_cast<float>(far.ny * (gap - far.distance));
    ASSERT_NEAR(s.near().distance, s.truth(), 8e-6 * s.size()) << "case " << k;
  }
}

TEST(Collide, LeastGapIsTheDistanceAndTheNormalAUnitVector) {
  for_random_pairs(300, [&](const Scene& s, auto&) {
    const Manifold m = s.manifold();
    ASSERT_GE(m.count, 1);
    ASSERT_NEAR(std::hypot(m.nx, m.ny), 1, 1e-6);
    const double truth = s.truth(), gap = least_gap(m);
    const bool cores_apart = truth > -s.a.radius - s.b.radius;
    // In overlap a face of A is taken if it is all but the best.
    ASSERT_NEAR(gap, truth, cores_apart ? 6e-6 * s.size() : 1.1e-3 * std::min(s.a.reach, s.b.reach));
  });
}

TEST(Collide, PushingByTheDepthParts) {
  for_random_pairs(300, [&](const Scene& s, auto&) {
    const auto left = [&](double gap, float nx, float ny) {
      Scene pushed = s;
      pushed.dx = static_cast<float>(s.dx - gap * nx);
      pushed.dy = static_cast<float>(s.dy - gap * ny);
      return pushed.truth();
    };
    const Nearest n = s.near();
    if (n.distance >= 0) return;
    ASSERT_NEAR(left(n.distance, n.nx, n.ny), 0, 6e-6 * s.size());
    const Manifold m = s.manifold();
    ASSERT_NEAR(left(least_gap(m), m.nx, m.ny), 0, 1.1e-3 * std::min(s.a.reach, s.b.reach));
  });
}

TEST(Collide, PointsAreMidwayBetweenTheSurfaces) {
  for_random_pairs(120, [&](const Scene& s, auto&) {
    const Manifold m = s.manifold();
    const double eps = 6e-6 * s.size();
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      ASSERT_NEAR(p.ax - p.bx, s.dx, eps);
      ASSERT_NEAR(p.ay - p.by, s.dy, eps);
      if (s.truth() < -s.a.radius - s.b.radius + 0.01) continue;
      // Half a gap back along the normal is A (or its rounding's tangent), half a gap on is B.
      Hull point;
      point.count = 1;
      finish_hull(point);
      if (p.gap > least_gap(m) + eps) continue;
      const double half = 0.5 * p.gap;
      ASSERT_NEAR(oracle(s.a, s.qa, point, {}, {p.ax - half * m.nx, p.ay - half * m.ny}), 0, eps);
      ASSERT_NEAR(oracle(s.b, s.qb, point, {}, {p.bx + half * m.nx, p.by + half * m.ny}), 0, eps);
    }
  });
}

TEST(Collide, MarginLeavesOutWhatIsFarther) {
  for_random_pairs(120, [&](const Scene& s, auto& g) {
    const double truth = s.truth(), eps = 6e-6 * s.size();
    const float margin = static_cast<float>(uniform(g, 0, 0.5));
    const Manifold m = s.manifold(margin);
    if (truth > margin + eps) {
      ASSERT_EQ(m.count, 0);
    }
    if (truth < margin - eps) {
      ASSERT_GE(m.count, 1);
    }
    for (int k = 0; k < m.count; ++k) ASSERT_LE(m.point[k].gap, margin);
    if (m.count == 2) {
      const double apart = std::hypot(m.point[0].bx - m.point[1].bx, m.point[0].by - m.point[1].by);
      ASSERT_GT(apart, 0.999e-3 * std::min(s.a.reach, s.b.reach));
      ASSERT_NE(m.point[0].feature, m.point[1].feature);
    }
  });
}

TEST(Collide, SwappedHullsGiveTheSameDistanceAndTheOppositeNormal) {
  for_random_pairs(120, [&](const Scene& s, auto&) {
    const Nearest ab = s.near();
    const Nearest ba = nearest(s.b, s.qb, s.a, s.qa, -s.dx, -s.dy);
    ASSERT_NEAR(ab.distance, ba.distance, 6e-6 * s.size());
    const double core = ab.distance + s.a.radius + s.b.radius;
    if (core < 1e-3 * s.size()) return;
    const double angle = 2 * std::sqrt(6e-6 * s.size() / core);
    ASSERT_NEAR(ab.nx, -ba.nx, angle);
    ASSERT_NEAR(ab.ny, -ba.ny, angle);
  });
}

TEST(Collide, RotationOfAllRotatesTheAnswer) {
  for_random_pairs(120, [&](Scene s, auto& g) {
    const Nearest before = s.near();
    const double by = uniform(g, -3, 3);
    const double c = std::cos(by), sn = std::sin(by);
    s.qa = rotor(s.angle_a + by);
    s.qb = rotor(s.angle_b + by);
    const double x = s.dx, y = s.dy;
    s.dx = static_cast<float>(c * x - sn * y);
    s.dy = static_cast<float>(sn * x + c * y);
    const Nearest after = s.near();
    ASSERT_NEAR(before.distance, after.distance, 6e-6 * s.size());
    const double core = before.distance + s.a.radius + s.b.radius;
    if (core < 1e-3 * s.size()) return;
    const double angle = 2 * std::sqrt(6e-6 * s.size() / core);
    ASSERT_NEAR(after.nx, c * before.nx - sn * before.ny, angle);
    ASSERT_NEAR(after.ny, sn * before.nx + c * before.ny, angle);
  });
}

Hull mirrored(const Hull& h) {
  Hull m;
  m.count = h.count;
  m.radius = h.radius;
  for (int k = 0; k < h.count; ++k) {
    m.x[k] = -h.x[h.count - 1 - k];
    m.y[k] = h.y[h.count - 1 - k];
  }
  finish_hull(m);
  return m;
}

TEST(Collide, AMirroredPairGivesMirroredBits) {
  int twos = 0;
  for_random_pairs(120, [&](const Scene& s, auto&) {
    const Manifold m = s.manifold(0.1f);
    const Manifold r = collide(mirrored(s.a), {s.qa.c, -s.qa.s}, mirrored(s.b), {s.qb.c, -s.qb.s}, -s.dx, s.dy, 0.1f);
    ASSERT_EQ(m.count, r.count);
    ASSERT_EQ(m.nx, -r.nx);
    ASSERT_EQ(m.ny, r.ny);
    twos += m.count == 2;
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint &p = m.point[k], &q = r.point[m.count - 1 - k];
      ASSERT_EQ(p.gap, q.gap);
      ASSERT_EQ(p.ax, -q.ax);
      ASSERT_EQ(p.ay, q.ay);
      ASSERT_EQ(p.bx, -q.bx);
      ASSERT_EQ(p.by, q.by);
    }
  });
  EXPECT_GT(twos, 400);
}

TEST(Collide, ABoxOverABoxHasTwoPointsAndAFlatNormal) {
  const Hull b = box(1, 1);
  for (const float gap : {-0.01f, 0.0f, 0.005f}) {
    for (const float shift : {0.0f, 1e-7f, 0.3f, -0.9f}) {
      const Manifold m = collide(b, {}, b, {}, shift, 1 + gap, 0.01f);
      ASSERT_EQ(m.count, 2);
      EXPECT_EQ(m.nx, 0);
      EXPECT_EQ(m.ny, 1);
      for (const ManifoldPoint& p : m.point) EXPECT_NEAR(p.gap, gap, 2e-7);
      EXPECT_NEAR(std::fabs(m.point[0].ax - m.point[1].ax), 1 - std::fabs(shift), 2e-7);
      EXPECT_NEAR(m.point[0].ay, 0.5 + gap / 2, 2e-7);
      EXPECT_NEAR(m.point[0].by, -0.5 - gap / 2, 2e-7);
    }
  }
}

TEST(Collide, ABoxOnAWideGroundKeepsItsOwnCorners) {
  const Hull ground = box(1000, 2), b = box(1, 1);
  const Manifold m = collide(ground, {}, b, {}, 317.1f, 1.5f, 0.01f);
  ASSERT_EQ(m.count, 2);
  EXPECT_EQ(std::fabs(m.point[0].bx), 0.5f);
  EXPECT_EQ(m.point[0].bx, -m.point[1].bx);
  EXPECT_EQ(m.point[0].gap, 0);
}

TEST(Collide, FeaturesStayWhileABoxRocksAndSlides) {
  const Hull ground = box(100, 2), b = box(1, 1);
  std::uint16_t first[2] = {};
  for (int k = 0; k < 200; ++k) {
    const double angle = 1e-3 * std::sin(0.3 * k);
    const Manifold m = collide(ground, {}, b, rotor(angle), 0.01f * static_cast<float>(k), 1.5f, 0.05f);
    ASSERT_EQ(m.count, 2);
    for (int i = 0; i < 2; ++i) {
      if (k == 0) first[i] = m.point[i].feature;
      EXPECT_EQ(m.point[i].feature, first[i]);
    }
  }
  // Equal boxes: which one's corner ends the overlap flickers, the feature does not.
  for (int k = 0; k < 200; ++k) {
    const double angle = 1e-4 * std::sin(0.3 * k);
    const float shift = 1e-5f * static_cast<float>(std::sin(1.7 * k));
    const Manifold m = collide(b, rotor(-angle / 3), b, rotor(angle), shift, 1.0001f, 0.05f);
    ASSERT_EQ(m.count, 2);
    for (int i = 0; i < 2; ++i) {
      if (k == 0) first[i] = m.point[i].feature;
      EXPECT_EQ(m.point[i].feature, first[i]);
    }
  }
  // Rounded boxes rock more, and the better reference changes.
  const Hull round = box(1, 1, 0.2);
  int references = 0;
  for (int k = 0; k < 200; ++k) {
    const double angle = 0.05 * std::sin(0.3 * k), tilt = 0.7;
    const double height = 1.4 + 0.5 * std::fabs(std::sin(angle));
    const double shift = 0.3;  // so that the lower corner is beyond A's edge half of the time
    const Manifold m = collide(round, rotor(tilt), round, rotor(tilt + angle),
                               static_cast<float>(shift * std::cos(tilt) - height * std::sin(tilt)),
                               static_cast<float>(shift * std::sin(tilt) + height * std::cos(tilt)), 0.2f);
    ASSERT_EQ(m.count, 2);
    references += std::fabs(m.nx + std::sin(tilt)) < 1e-5;
    for (int i = 0; i < 2; ++i) {
      if (k == 0) first[i] = m.point[i].feature;
      EXPECT_EQ(m.point[i].feature, first[i]);
    }
  }
  EXPECT_GT(references, 10);
  EXPECT_LT(references, 190);
  // Rocking on one corner.
  for (int k = 0; k < 200; ++k) {
    const double angle = kPi / 4 + 0.3 * std::sin(0.3 * k);
    const double height = std::sqrt(0.5) * std::cos(angle - kPi / 4);
    const Manifold m = collide(ground, {}, b, rotor(angle), 0, static_cast<float>(1 + height), 0.05f);
    ASSERT_EQ(m.count, 1);
    if (k == 0) first[0] = m.point[0].feature;
    EXPECT_EQ(m.point[0].feature, first[0]);
  }
}

TEST(Collide, CapsulesSideBySideAndLyingHaveTwoPoints) {
  const Hull c = capsule(2, 0.5);
  Manifold m = collide(c, {}, c, {}, 0.5f, 1.01f, 0.05f);
  ASSERT_EQ(m.count, 2);
  EXPECT_EQ(m.ny, 1);
  EXPECT_NEAR(m.point[0].gap, 0.01, 1e-6);
  m = collide(box(10, 1), {}, c, {}, 0.5f, 1.0f, 0.05f);
  ASSERT_EQ(m.count, 2);
  EXPECT_EQ(m.ny, 1);
  // End to end, crossed, and on top of one another.
  m = collide(c, {}, c, {}, 3.02f, 0, 0.05f);
  ASSERT_EQ(m.count, 1);
  EXPECT_EQ(m.nx, 1);
  EXPECT_NEAR(m.point[0].gap, 0.02, 1e-6);
  m = collide(c, {}, c, {0, 1}, 0, 0, 0.05f);
  EXPECT_EQ(m.count, 1);
  EXPECT_NEAR(m.point[0].gap, -2, 1e-5);
  m = collide(c, {}, c, {}, 0, 0, 0.05f);
  ASSERT_EQ(m.count, 2);
  EXPECT_NEAR(m.point[0].gap, -1, 1e-6);
}

TEST(Collide, EqualCentresAndDegenerateHullsGiveFiniteAnswers) {
  std::mt19937_64 g(3);
  std::vector<Hull> hulls;
  for (int n = 1; n <= 8; ++n) hulls.push_back(random_hull(g, n, n % 2 == 0));
  hulls.push_back(box(1, 1));
  hulls.push_back(box(1e-6, 1e-6));
  hulls.push_back(box(1e6, 1e-3));
  hulls.push_back(disc(1e-6));
  Hull folded;  // two vertices in one place
  folded.count = 2;
  finish_hull(folded);
  hulls.push_back(folded);
  const float places[] = {0.0f, -0.0f, 1e-30f, 1e-7f, 0.5f, 1e9f};
  for (const Hull& a : hulls) {
    for (const Hull& b : hulls) {
      for (const float x : places) {
        for (const float y : places) {
          const Manifold m = collide(a, {}, b, {}, x, y, kAll);
          ASSERT_GE(m.count, 1);
          ASSERT_NEAR(std::hypot(m.nx, m.ny), 1, 1e-6);
          for (int k = 0; k < m.count; ++k) {
            ASSERT_TRUE(std::isfinite(m.point[k].gap));
            ASSERT_TRUE(std::isfinite(m.point[k].ax + m.point[k].ay));
            ASSERT_TRUE(std::isfinite(m.point[k].bx + m.point[k].by));
          }
          const Manifold again = collide(a, {}, b, {}, x, y, kAll);
          ASSERT_EQ(m.nx, again.nx);
        }
      }
    }
  }
}

}  // namespace
}  // namespace psim::hull_oracle
