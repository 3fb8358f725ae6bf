// Contacts of two hulls against an oracle in double precision: the Minkowski difference of the two
// cores as a convex polygon, and the origin's signed distance from its outline.
#include "collide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace psim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr float kAll = std::numeric_limits<float>::infinity();

struct P {
  double x = 0, y = 0;
};
P operator-(P a, P b) { return {a.x - b.x, a.y - b.y}; }
double cross(P a, P b) { return a.x * b.y - a.y * b.x; }
double norm(P a) { return std::hypot(a.x, a.y); }

Rotor rotor(double angle) {
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
}

P turned(Rotor q, P v) { return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y}; }

std::vector<P> corners(const Hull& h, Rotor q, P at) {
  std::vector<P> out;
  for (int k = 0; k < h.count; ++k) {
    const P v = turned(q, {h.x[k], h.y[k]});
    out.push_back({v.x + at.x, v.y + at.y});
  }
  return out;
}

double distance_to_line(P from, P a, P b) {
  const P e = b - a;
  const double span2 = e.x * e.x + e.y * e.y;
  const P u = from - a;
  const double t = span2 > 0 ? std::clamp((u.x * e.x + u.y * e.y) / span2, 0.0, 1.0) : 0;
  return norm({u.x - t * e.x, u.y - t * e.y});
}

/// Convex outline of points, counter-clockwise (Andrew's monotone chain).
std::vector<P> outline(std::vector<P> p) {
  std::sort(p.begin(), p.end(), [](P a, P b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<P> out;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = out.size();
    for (const P v : p) {
      while (out.size() >= base + 2 &&
             cross(out.back() - out[out.size() - 2], v - out[out.size() - 2]) <= 0) {
        out.pop_back();
      }
      out.push_back(v);
    }
    out.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return out;
}

/// Distance of two hulls, radii included; minus the least depth where the cores overlap.
double oracle(const Hull& a, Rotor qa, const Hull& b, Rotor qb, P d) {
  std::vector<P> difference;
  for (const P u : corners(b, qb, d)) {
    for (const P v : corners(a, qa, {})) difference.push_back(u - v);
  }
  double core = 0;
  if (difference.size() == 1) {
    core = norm(difference[0]);
  } else {
    const std::vector<P> hull = outline(difference);
    double least = 1e300;
    bool inside = hull.size() > 2;
    for (std::size_t k = 0; k < hull.size(); ++k) {
      const P u = hull[k], v = hull[(k + 1) % hull.size()];
      least = std::min(least, distance_to_line({}, u, v));
      inside = inside && cross(v - u, P{} - u) > 0;
    }
    core = inside ? -least : least;
  }
  return core - a.radius - b.radius;
}

double uniform(std::mt19937_64& g, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(g);
}

/// A hull of `count` vertices on an ellipse, its centre within it, sized about 1.
Hull random_hull(std::mt19937_64& g, int count, bool round) {
  Hull h;
  h.count = count;
  if (round || count == 1) h.radius = static_cast<float>(uniform(g, 0.05, 0.7));
  const double flat = uniform(g, 0.2, 1), size = uniform(g, 0.4, 2), start = uniform(g, 0, 7);
  for (int k = 0; k < count; ++k) {
    const double at = start + 2 * kPi * (k + uniform(g, -0.35, 0.35)) / count;
    if (count == 1) break;
    h.x[k] = static_cast<float>(size * std::cos(at));
    h.y[k] = static_cast<float>(size * flat * std::sin(at));
  }
  finish_hull(h);
  return h;
}

Hull box(double w, double h, double radius = 0) {
  HullSet out;
  std::string error;
  EXPECT_TRUE(make_hulls(BoxShape{w, h, radius}, true, out, error)) << error;
  return out.parts.at(0);
}

Hull capsule(double length, double radius) {
  HullSet out;
  std::string error;
  EXPECT_TRUE(
      make_hulls(CapsuleShape{{-length / 2, 0}, {length / 2, 0}, radius}, true, out, error));
  return out.parts.at(0);
}

Hull disc(double radius) {
  Hull h;
  h.count = 1;
  h.radius = static_cast<float>(radius);
  finish_hull(h);
  return h;
}

struct Scene {
  Hull a, b;
  double angle_a = 0, angle_b = 0;
  Rotor qa, qb;
  float dx = 0, dy = 0;
  double size() const { return double{a.reach} + b.reach; }
  double truth() const { return oracle(a, qa, b, qb, {dx, dy}); }
  Manifold manifold(float margin = kAll) const { return collide(a, qa, b, qb, dx, dy, margin); }
  Nearest near() const { return nearest(a, qa, b, qb, dx, dy); }
};

/// Places from well apart to the same centre.
Scene random_scene(std::mt19937_64& g, int na, int nb) {
  Scene s;
  s.a = random_hull(g, na, g() % 2);
  s.b = random_hull(g, nb, g() % 2);
  s.angle_a = uniform(g, -4, 4);
  s.angle_b = g() % 4 == 0 ? s.angle_a : uniform(g, -4, 4);
  s.qa = rotor(s.angle_a);
  s.qb = rotor(s.angle_b);
  const double r = uniform(g, 0, 1.2) * s.size(), at = uniform(g, 0, 7);
  s.dx = static_cast<float>(r * std::cos(at));
  s.dy = static_cast<float>(r * std::sin(at));
  return s;
}

double least_gap(const Manifold& m) {
  double least = m.point[0].gap;
  for (int k = 1; k < m.count; ++k) least = std::min<double>(least, m.point[k].gap);
  return least;
}

/// Calls `check` with pairs of all counts of vertices.
template <class Check>
void for_random_pairs(int each, Check check) {
  std::mt19937_64 g(7);
  for (int na = 1; na <= 8; ++na) {
    for (int nb = 1; nb <= 8; ++nb) {
      for (int k = 0; k < each; ++k) {
        SCOPED_TRACE(testing::Message() << na << " against " << nb << ", case " << k);
        check(random_scene(g, na, nb), g);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

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
    ASSERT_NEAR(gap, truth,
                cores_apart ? 6e-6 * s.size() : 1.1e-3 * std::min(s.a.reach, s.b.reach));
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
    const Manifold r = collide(mirrored(s.a), {s.qa.c, -s.qa.s}, mirrored(s.b), {s.qb.c, -s.qb.s},
                               -s.dx, s.dy, 0.1f);
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
    const Manifold m =
        collide(ground, {}, b, rotor(angle), 0.01f * static_cast<float>(k), 1.5f, 0.05f);
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
    const Manifold m =
        collide(round, rotor(tilt), round, rotor(tilt + angle),
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
    const Manifold m =
        collide(ground, {}, b, rotor(angle), 0, static_cast<float>(1 + height), 0.05f);
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

// ---- motions -------------------------------------------------------------------------------------

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
    const float share = time_of_impact(s.a, s.qa, s.b, s.angle_b, turn, s.dx, s.dy, mx, my,
                                       static_cast<float>(slack));
    const double stepped = stepped_impact(s, turn, mx, my, slack);
    ASSERT_LE(share, stepped + 1e-5);
    if (share >= 1) return;
    ++hits;
    const double left = oracle(s.a, s.qa, s.b, rotor(s.angle_b + share * turn),
                               {s.dx + double{share} * mx, s.dy + double{share} * my});
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

// ---- rays ----------------------------------------------------------------------------------------

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
      const auto distance = [&](double t) {
        return oracle(h, q, point, {}, {o.x + t * r.x, o.y + t * r.y});
      };
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
        const P on{o.x + cast.fraction * r.x + 0.01 * cast.nx,
                   o.y + cast.fraction * r.y + 0.01 * cast.ny};
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
}  // namespace psim
