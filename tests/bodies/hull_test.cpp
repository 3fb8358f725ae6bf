// Shapes made into hulls: what is put right, what is refused, and mass properties against closed
// forms; and the engine's own sine and cosine against the library's.
#include "bodies/hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "base/rotor.h"

namespace psim {
namespace {

constexpr double kPi = std::numbers::pi;

HullSet made(const Shape& shape, bool about_centre = true) {
  HullSet out;
  std::string error;
  EXPECT_TRUE(make_hulls(shape, about_centre, out, error)) << error;
  EXPECT_TRUE(error.empty());
  return out;
}

std::string refusal(const Shape& shape) {
  HullSet out;
  std::string error;
  EXPECT_FALSE(make_hulls(shape, true, out, error));
  EXPECT_TRUE(out.parts.empty());
  EXPECT_FALSE(error.empty());
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  return error;
}

void expect_mass(const HullSet& set, double area, Vec2 centre, double inertia) {
  const double size = std::sqrt(inertia);
  EXPECT_NEAR(set.mass.area, area, 1e-12 * area);
  EXPECT_NEAR(set.mass.centre.x, centre.x, 1e-12 * size);
  EXPECT_NEAR(set.mass.centre.y, centre.y, 1e-12 * size);
  EXPECT_NEAR(set.mass.inertia, inertia, 1e-12 * inertia);
}

bool contains(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

TEST(Hull, MassOfDiscSegmentAndBox) {
  expect_mass(made(DiscShape{0.7}), kPi * 0.49, {}, 0.245);
  expect_mass(made(SegmentShape{{1, 1}, {4, 5}}), 5, {2.5, 3}, 25.0 / 12);
  expect_mass(made(BoxShape{2, 3, 0}), 6, {}, 13.0 / 12);
}

CompoundShape two(ShapePart a, ShapePart b) { return {{std::move(a), std::move(b)}}; }

TEST(Hull, MassOfACompoundIsTheSumOfItsParts) {
  // Two halves of a box, one of them standing on its side.
  expect_mass(made(two({BoxShape{1, 3}, {-0.5, 0}, 0, {}, {}, {}}, {BoxShape{3, 1}, {0.5, 0}, kPi / 2, {}, {}, {}})), 6,
              {}, 13.0 / 12);
  // A heavy disc at the end of a light rod; areas count as often as a part is denser than the body.
  HullSet set;
  std::string error;
  const Shape hammer = two({BoxShape{2, 0.2}, {}, 0, {}, {}, {}}, {DiscShape{0.5}, {1, 0}, 1, 6, {}, {}});
  ASSERT_TRUE(make_hulls(hammer, true, set, error, 2)) << error;
  const double rod = 0.4, head = 3 * kPi * 0.25, area = rod + head, x = head / area;
  const double polar = rod * (4.04 / 12 + x * x) + head * (0.125 + (1 - x) * (1 - x));
  expect_mass(set, area, {x, 0}, polar / area);
  ASSERT_EQ(set.parts.size(), 2u);
  EXPECT_NEAR(set.parts[1].x[0], 1 - x, 1e-7);
  EXPECT_FLOAT_EQ(set.parts[0].inner, 0.1f) << "half of the rod's width, though its centre is not that of the body";
  EXPECT_FLOAT_EQ(set.parts[1].inner, 0.5f);
  EXPECT_FLOAT_EQ(set.parts[0].middle_x, static_cast<float>(-x));
}

TEST(Hull, ACompoundOfOnePartIsThatPart) {
  const Shape box = BoxShape{2, 1, 0.1};
  const HullSet alone = made(box), part = made(CompoundShape{{{BoxShape{2, 1, 0.1}, {}, 0, {}, {}, {}}}});
  EXPECT_EQ(alone.parts, part.parts);
  EXPECT_EQ(alone.mass.inertia, part.mass.inertia);
}

TEST(Hull, MassOfACapsuleIsThatOfARectangleAndTwoHalfDiscs) {
  const double l = 3, r = 0.5;
  const double rectangle = 2 * l * r, cap = kPi * r * r / 2, offset = 4 * r / (3 * kPi);
  const double area = rectangle + 2 * cap;
  // About the capsule's centre; a half disc's own about its centroid is r^2/2 - offset^2.
  const double polar = rectangle * (l * l + 4 * r * r) / 12 +
                       2 * cap * (r * r / 2 - offset * offset + (l / 2 + offset) * (l / 2 + offset));
  expect_mass(made(CapsuleShape{{-1.5, 0}, {1.5, 0}, r}), area, {}, polar / area);
  const double c = std::cos(0.3), s = std::sin(0.3);
  expect_mass(made(CapsuleShape{{7, 9}, {7 + l * c, 9 + l * s}, r}), area, {7 + 1.5 * c, 9 + 1.5 * s}, polar / area);
}

TEST(Hull, MassOfARoundedBoxIsACrossAndFourQuarterDiscs) {
  const double w = 2, h = 1, r = 0.25;
  const double quarter = kPi * r * r / 4, offset = 4 * r / (3 * kPi);
  const double area = w * h + 2 * r * (w + h) + 4 * quarter;
  const double x = w / 2 + offset, y = h / 2 + offset;
  const double polar = w * h * (w * w + h * h) / 12 + 2 * (w * r * ((w * w + r * r) / 12 + (h + r) * (h + r) / 4)) +
                       2 * (h * r * ((h * h + r * r) / 12 + (w + r) * (w + r) / 4)) +
                       4 * quarter * (r * r / 2 - 2 * offset * offset + x * x + y * y);
  expect_mass(made(BoxShape{w, h, r}), area, {}, polar / area);
  // The same as a polygon elsewhere.
  expect_mass(made(PolygonShape{{{10, 5}, {12, 5}, {12, 6}, {10, 6}}, r}), area, {11, 5.5}, polar / area);
}

TEST(Hull, MassOfATriangle) {
  // Inertia of a triangle about its centroid over its mass: (a^2 + b^2 + c^2) / 36.
  const PolygonShape s{{{0, 0}, {4, 0}, {0, 3}}, 0};
  expect_mass(made(s), 6, {4.0 / 3, 1}, (16.0 + 9 + 25) / 36);
}

TEST(Hull, CentreOfARoundedTriangleByItsParts) {
  // Corners by integrals over angles, with the library's functions.
  const Vec2 v[3] = {{0, 0}, {4, 0}, {0, 3}};
  const double r = 0.6;
  double area = 6, mx = 6 * 4.0 / 3, my = 6, polar = 6 * ((50.0) / 36 + 16.0 / 9 + 1);
  for (int k = 0; k < 3; ++k) {
    const Vec2 p = v[k], q = v[(k + 1) % 3], o = v[(k + 2) % 3];
    const double angle = std::atan2(q.y - p.y, q.x - p.x) - kPi / 2;
    const double before = std::atan2(p.y - o.y, p.x - o.x) - kPi / 2;
    double theta = angle - before;
    while (theta < 0) theta += 2 * kPi;
    const double middle = angle - theta / 2;
    const double sector = theta * r * r / 2;
    const double out = 4 * r * std::sin(theta / 2) / (3 * theta);
    const double cx = p.x + out * std::cos(middle), cy = p.y + out * std::sin(middle);
    area += sector;
    mx += sector * cx;
    my += sector * cy;
    polar += sector * (r * r / 2 - out * out + cx * cx + cy * cy);
    const double length = std::hypot(q.x - p.x, q.y - p.y), strip = length * r;
    const double ex = (p.x + q.x) / 2 + r / 2 * std::cos(angle);
    const double ey = (p.y + q.y) / 2 + r / 2 * std::sin(angle);
    area += strip;
    mx += strip * ex;
    my += strip * ey;
    polar += strip * ((length * length + r * r) / 12 + ex * ex + ey * ey);
  }
  const Vec2 centre{mx / area, my / area};
  expect_mass(made(PolygonShape{{v[0], v[1], v[2]}, r}), area, centre,
              polar / area - centre.x * centre.x - centre.y * centre.y);
}

TEST(Hull, MassOfAThinRoundingTendsToThatOfTheSharpShape) {
  const HullSet sharp = made(PolygonShape{{{0, 0}, {4, 0}, {5, 2}, {1, 3}}, 0});
  const HullSet round = made(PolygonShape{{{0, 0}, {4, 0}, {5, 2}, {1, 3}}, 1e-9});
  EXPECT_NEAR(sharp.mass.area, round.mass.area, 1e-7);
  EXPECT_NEAR(sharp.mass.inertia, round.mass.inertia, 1e-7);
}

TEST(Hull, MassOfAChainIsThatOfItsSegments) {
  const HullSet set = made(ChainShape{{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, true}, false);
  ASSERT_EQ(set.parts.size(), 4u);
  EXPECT_DOUBLE_EQ(set.mass.area, 8);
  EXPECT_DOUBLE_EQ(set.mass.centre.x, 1);
  EXPECT_NEAR(set.mass.inertia, 4 * (4.0 / 12 + 1) / 4, 1e-15);
  EXPECT_EQ(made(ChainShape{{{0, 0}, {2, 0}, {2, 0}, {5, 2}}, false}, false).parts.size(), 2u);
}

TEST(Hull, BoxHasItsNormalsReachAndInnerDistance) {
  const Hull h = made(BoxShape{2, 1, 0.25}).parts.at(0);
  ASSERT_EQ(h.count, 4);
  const float nx[4] = {0, 1, 0, -1}, ny[4] = {-1, 0, 1, 0};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(h.nx[k], nx[k]);
    EXPECT_EQ(h.ny[k], ny[k]);
  }
  EXPECT_NEAR(h.reach, 0.25 + std::sqrt(1.25), 1e-6);
  EXPECT_GE(double{h.reach}, 0.25 + std::sqrt(1.25));
  EXPECT_EQ(h.inner, 0.75f);
  const Hull d = made(DiscShape{0.3}).parts.at(0);
  EXPECT_EQ(d.count, 1);
  EXPECT_EQ(d.reach, 0.3f);
  EXPECT_EQ(d.inner, 0.3f);
  const Hull c = made(CapsuleShape{{0, 1}, {0, 5}, 0.5}).parts.at(0);
  EXPECT_EQ(c.count, 2);
  EXPECT_EQ(c.reach, 2.5f);
  EXPECT_EQ(c.inner, 0.5f);
}

TEST(Hull, AboutThePlaceOrAboutTheCentre) {
  const PolygonShape s{{{10, 0}, {14, 0}, {10, 3}}, 0};
  const Hull place = made(s, false).parts.at(0), centre = made(s, true).parts.at(0);
  EXPECT_EQ(place.x[1], 14.0f);
  EXPECT_FLOAT_EQ(centre.x[1], static_cast<float>(14 - 10 - 4.0 / 3));
  EXPECT_FLOAT_EQ(centre.y[2], 2.0f);
}

TEST(Hull, ClockwiseRepeatedAndCollinearVerticesArePutRight) {
  const Hull plain = made(PolygonShape{{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, 0}).parts.at(0);
  const PolygonShape faulty[] = {
      {{{0, 0}, {0, 2}, {2, 2}, {2, 0}}, 0},
      {{{0, 0}, {0, 0}, {2, 0}, {2, 2}, {2, 2}, {0, 2}, {0, 0}}, 0},
      {{{0, 0}, {1, 0}, {2, 0}, {2, 1e-9}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}, 0},
      {{{0, 0}, {1, 1e-7}, {2, 0}, {2, 2}, {0, 2}}, 0},  // a dent of nothing
  };
  for (const PolygonShape& s : faulty) {
    const HullSet set = made(s);
    const Hull& h = set.parts.at(0);
    ASSERT_EQ(h.count, 4);
    EXPECT_NEAR(set.mass.area, 4, 1e-5);
    double turned = 0;
    for (int k = 0; k < 4; ++k) {
      const int n = (k + 1) % 4;
      turned += double{h.x[k]} * h.y[n] - double{h.x[n]} * h.y[k];
    }
    EXPECT_NEAR(turned, 8, 1e-5);
    EXPECT_NEAR(h.reach, plain.reach, 1e-5);
  }
}

TEST(Hull, RefusalsNameTheVertex) {
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {4, 0}, {2, 1}, {2, 4}}, 0}), "vertex 2"));
  // The same dent, clockwise.
  EXPECT_TRUE(contains(refusal(PolygonShape{{{2, 4}, {2, 1}, {4, 0}, {0, 0}}, 0}), "vertex 1"));
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {1, 0}, {NAN, 1}}, 0}), "vertex 2"));
  EXPECT_TRUE(contains(refusal(SegmentShape{{0, 0}, {1e10, 0}}), "vertex 1"));
}

TEST(Hull, CrossingFlatAndCrowdedPolygonsAreRefused) {
  PolygonShape star;  // turns left at every vertex, twice around
  for (int k = 0; k < 5; ++k) {
    star.vertices.push_back({std::cos(0.8 * kPi * k), std::sin(0.8 * kPi * k)});
  }
  EXPECT_TRUE(contains(refusal(star), "convex"));
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0}), "convex"));
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {1, 0}, {2, 0}}, 0}), "area"));
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {1, 0}, {0.5, 1e-7}}, 0}), "area"));
  EXPECT_TRUE(contains(refusal(PolygonShape{{{0, 0}, {1, 0}}, 0}), "3 to 8"));
  PolygonShape nine;
  for (int k = 0; k < 9; ++k) nine.vertices.push_back({std::cos(0.7 * k), std::sin(0.7 * k)});
  EXPECT_TRUE(contains(refusal(nine), "3 to 8"));
  // A spike is no collinear vertex.
  refusal(PolygonShape{{{0, 0}, {2, 0}, {3, 0}, {2, 0}, {2, 2}, {0, 2}}, 0});
}

TEST(Hull, SizesOutOfRangeAreRefused) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, 2e9, inf, std::nan("")}) {
    refusal(DiscShape{bad});
    refusal(BoxShape{bad, 1, 0});
    refusal(BoxShape{1, bad, 0});
    refusal(CapsuleShape{{0, 0}, {1, 0}, bad});
    if (bad != 0) {
      refusal(BoxShape{1, 1, bad});
      refusal(PolygonShape{{{0, 0}, {1, 0}, {0, 1}}, bad});
    }
  }
  refusal(SegmentShape{{1, 1}, {1, 1}});
  refusal(ChainShape{{{0, 0}}, false});
  refusal(ChainShape{{{0, 0}, {1, 0}}, true});
  refusal(ChainShape{{{0, 0}, {inf, 0}}, false});
  // Floats about a far place cannot hold it.
  HullSet out;
  std::string error;
  const PolygonShape far{{{1e8, 0}, {1e8 + 1, 0}, {1e8, 1}}, 0};
  EXPECT_FALSE(make_hulls(far, false, out, error));
  EXPECT_TRUE(make_hulls(far, true, out, error)) << error;
}

TEST(Hull, ACapsuleWithoutLengthIsADisc) {
  const HullSet set = made(CapsuleShape{{1, 2}, {1, 2}, 0.5});
  EXPECT_EQ(set.parts.at(0).count, 1);
  EXPECT_EQ(set.parts.at(0).x[0], 0.0f);
  EXPECT_EQ(set.mass.centre.x, 1);
  EXPECT_DOUBLE_EQ(set.mass.inertia, 0.125);
}

TEST(Hull, AcceptedPolygonsAreStrictlyConvexInFloats) {
  for (int n = 3; n <= 8; ++n) {
    for (const double size : {1e-6, 1.0, 1e6}) {
      for (const double flat : {1.0, 1e-2, 1e-4}) {
        PolygonShape s;
        for (int k = 0; k < n; ++k) {
          const double at = 2 * kPi * k / n + 0.1;
          s.vertices.push_back({size * std::cos(at), size * flat * std::sin(at)});
        }
        const Hull h = made(s).parts.at(0);
        ASSERT_EQ(h.count, n);
        for (int k = 0; k < n; ++k) {
          const int next = (k + 1) % n;
          EXPECT_NEAR(std::hypot(h.nx[k], h.ny[k]), 1, 2e-7);
          EXPECT_GT(double{h.nx[k]} * h.ny[next] - double{h.ny[k]} * h.nx[next], 0);
        }
      }
    }
  }
}

TEST(Rotor, TurnsBackByTheOppositeAngle) {
  for (int k = -200000; k <= 200000; ++k) {
    const double angle = 4.9 * k + 1e-3 * k * (k % 7);
    const SineCosine r = sine_cosine(angle), back = sine_cosine(-angle);
    ASSERT_EQ(back.sine, -r.sine);
    ASSERT_EQ(back.cosine, r.cosine);
    ASSERT_NEAR(r.sine * r.sine + r.cosine * r.cosine, 1, 5e-16);
  }
  EXPECT_EQ(sine_cosine(0).sine, 0);
  EXPECT_EQ(sine_cosine(0).cosine, 1);
}

TEST(Rotor, IsARotationForAnyFiniteAngle) {
  for (const double angle : {1e7, -3e9, 1e15, 1e300, -std::numeric_limits<double>::max(), 5e-324}) {
    const SineCosine r = sine_cosine(angle);
    EXPECT_NEAR(r.sine * r.sine + r.cosine * r.cosine, 1, 1e-14) << angle;
  }
}

}  // namespace
}  // namespace psim
