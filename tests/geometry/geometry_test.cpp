// Geometry without a world against brute force: distances by Minkowski differences, rays and casts by many looks.
#include "geometry/any_shape.h"

namespace psim::test {
namespace {

constexpr double kClose = 1e-8;  // m: doubles, of shapes of some metres

Vec2 along(Vec2 p, double way, Vec2 n) { return {p.x + way * n.x, p.y + way * n.y}; }
Pose moved(const ShapeMove& m, double share) {
  return {along(m.from.position, share, m.translation), m.from.angle + share * m.rotation};
}
bool is_one_part(const Shape& shape) {
  return !std::holds_alternative<CompoundShape>(shape) && !std::holds_alternative<ChainShape>(shape);
}

TEST(Geometry, BoundsHoldAllVertices) {
  Random r(1);
  for (int n = 0; n < 2000; ++n) {
    const Shape shape = any_shape(r, r.uniform(0.1, 3));
    const Pose at = any_pose(r, 100);
    Bounds box{1e300, 1e300, -1e300, -1e300};
    for (const auto& o : outlines(shape, at.position, at.angle)) {
      for (const auto& v : o.points) {
        box = {std::min(box.xmin, v.x - o.radius), std::min(box.ymin, v.y - o.radius),
               std::max(box.xmax, v.x + o.radius), std::max(box.ymax, v.y + o.radius)};
      }
    }
    const Bounds told = shape_bounds(shape, at).value();
    EXPECT_NEAR(told.xmin, box.xmin, kClose);
    EXPECT_NEAR(told.ymin, box.ymin, kClose);
    EXPECT_NEAR(told.xmax, box.xmax, kClose);
    EXPECT_NEAR(told.ymax, box.ymax, kClose);
  }
}

TEST(Geometry, HoldsThePointsThatBruteForceFinds) {
  Random r(2);
  int inside = 0;
  for (int n = 0; n < 20000; ++n) {
    const Shape shape = any_shape(r, r.uniform(0.5, 3));
    const Pose at = any_pose(r, 100);
    const Vec2 point{at.position.x + r.uniform(-4, 4), at.position.y + r.uniform(-4, 4)};
    const double far = true_distance(shape, at, point);
    if (far > 0 && far < kClose) continue;
    EXPECT_EQ(shape_holds(shape, at, point), far == 0) << n;
    inside += far == 0;
  }
  EXPECT_GT(inside, 1000);
}

TEST(Geometry, HoldsItsSurface) {
  const BoxShape box{2, 2, 0};
  EXPECT_TRUE(shape_holds(box, {}, {1, 0.3}));
  EXPECT_TRUE(shape_holds(box, {}, {1, 1}));
  EXPECT_FALSE(shape_holds(box, {}, {1 + 1e-9, 1}));
  EXPECT_TRUE(shape_holds(DiscShape{1}, {{3, 0}, 0}, {2, 0}));
  EXPECT_TRUE(shape_holds(SegmentShape{{0, 0}, {4, 0}}, {}, {1, 0}));
  EXPECT_FALSE(shape_holds(SegmentShape{{0, 0}, {4, 0}}, {}, {1, 1e-9}));
  EXPECT_FALSE(shape_holds(ChainShape{{{0, 0}, {4, 0}, {4, 4}}, true, {}}, {}, {3, 1})) << "a loop has no inside";
}

// Nothing of the shape lies on the way before the hit, which is on the surface; where no hit is told, nothing does at all.
TEST(Geometry, RaysEnterWhereBruteForceDoes) {
  Random r(3);
  int hits = 0, misses = 0, inside = 0;
  for (int n = 0; n < 6000; ++n) {
    const Shape shape = any_shape(r, r.uniform(0.3, 3));
    const Pose at = any_pose(r, 50);
    const Vec2 from = along(at.position, r.uniform(0, 6), {std::cos(n), std::sin(n)});
    const Vec2 to = along(at.position, r.uniform(0, 6), {std::cos(2.7 * n), std::sin(2.7 * n)});
    const auto hit = shape_ray_cast(shape, at, from, to);
    const Vec2 way{to.x - from.x, to.y - from.y};
    const double end = hit ? hit->fraction : 1;
    for (int k = 0; k < 400; ++k) {
      if (!hit || hit->fraction > 0) {
        EXPECT_GT(true_distance(shape, at, along(from, end * k / 400, way)), 0) << "ray " << n << " at " << k;
      }
    }
    if (!hit) {
      ++misses;
      continue;
    }
    EXPECT_LT(true_distance(shape, at, hit->point), kClose);
    EXPECT_NEAR(hit->point.x, from.x + end * way.x, kClose);
    EXPECT_NEAR(hit->point.y, from.y + end * way.y, kClose);
    if (hit->normal == Vec2{}) {
      ++inside;
      EXPECT_EQ(hit->fraction, 0);
      EXPECT_EQ(true_distance(shape, at, from), 0);
      continue;
    }
    ++hits;
    EXPECT_NEAR(std::hypot(hit->normal.x, hit->normal.y), 1, 1e-12);
    EXPECT_LT(hit->normal.x * way.x + hit->normal.y * way.y, 1e-9);
    if (is_one_part(shape)) {
      EXPECT_NEAR(true_distance(shape, at, along(hit->point, 1e-3, hit->normal)), 1e-3, kClose) << "ray " << n;
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 500);
  EXPECT_GT(inside, 100);
}

TEST(Geometry, DistancesAreThoseOfBruteForce) {
  Random r(4);
  int apart = 0, deep = 0;
  for (int n = 0; n < 20000; ++n) {
    const Shape a = any_shape(r, r.uniform(0.1, 3)), b = any_shape(r, r.uniform(0.1, 3));
    const double half = r.uniform(0, 8);
    const Pose at_a = any_pose(r, half), at_b = any_pose(r, half);
    const auto gap = shape_distance(a, at_a, b, at_b);
    ASSERT_TRUE(gap);
    ASSERT_NEAR(gap->distance, true_gap(a, at_a, b, at_b), kClose) << n;
    EXPECT_NEAR(std::hypot(gap->normal.x, gap->normal.y), 1, 1e-12);
    const Vec2 end = along(gap->point_a, gap->distance, gap->normal);
    EXPECT_NEAR(end.x, gap->point_b.x, 1e-7) << n;
    EXPECT_NEAR(end.y, gap->point_b.y, 1e-7) << n;
    EXPECT_LT(true_distance(a, at_a, gap->point_a), 1e-7) << n;
    EXPECT_LT(true_distance(b, at_b, gap->point_b), 1e-7) << n;
    const auto other = shape_distance(b, at_b, a, at_a);
    EXPECT_NEAR(other->distance, gap->distance, 1e-12);
    gap->distance > 0 ? ++apart : ++deep;
  }
  EXPECT_GT(apart, 5000);
  EXPECT_GT(deep, 5000);
}

// Along the normal, by the depth, two convex shapes come apart, and along no other way sooner.
TEST(Geometry, TheNormalIsTheShortestWayOut) {
  Random r(5);
  int deep = 0;
  for (int n = 0; n < 4000; ++n) {
    const Shape a = any_shape(r, r.uniform(0.1, 3)), b = any_shape(r, r.uniform(0.1, 3));
    const Pose at_a = any_pose(r, 2), at_b = any_pose(r, 2);
    const ShapeGap gap = shape_distance(a, at_a, b, at_b).value();
    if (gap.distance >= 0 || !is_one_part(a) || !is_one_part(b)) continue;
    ++deep;
    const auto gap_after = [&](double way, Vec2 to) {
      return true_gap(a, at_a, b, {along(at_b.position, way, to), at_b.angle});
    };
    EXPECT_NEAR(gap_after(-gap.distance, gap.normal), 0, kClose);
    for (int k = 0; k < 40; ++k) {
      const double angle = 2 * kPi * k / 40;
      EXPECT_LT(gap_after(-0.999 * gap.distance, {std::cos(angle), std::sin(angle)}), 0);
    }
  }
  EXPECT_GT(deep, 500);
}

TEST(Geometry, DistancesStayWhereAllIsMovedAndTurned) {
  Random r(6);
  for (int n = 0; n < 2000; ++n) {
    const Shape a = any_shape(r, r.uniform(0.1, 3)), b = any_shape(r, r.uniform(0.1, 3));
    const Pose at_a = any_pose(r, 5), at_b = any_pose(r, 5);
    const double angle = r.uniform(-3, 3), c = std::cos(angle), s = std::sin(angle);
    const Vec2 way{r.uniform(-1e4, 1e4), r.uniform(-1e4, 1e4)};
    const auto place = [&](const Pose& at) -> Pose {
      const Vec2 p = at.position;
      return {{way.x + c * p.x - s * p.y, way.y + s * p.x + c * p.y}, at.angle + angle};
    };
    const ShapeGap one = shape_distance(a, at_a, b, at_b).value();
    const ShapeGap other = shape_distance(a, place(at_a), b, place(at_b)).value();
    EXPECT_NEAR(one.distance, other.distance, 1e-8) << n;
  }
}

TEST(Geometry, TouchingShapesAreNoDistanceApart) {
  const BoxShape box{2, 2, 0};
  EXPECT_EQ(shape_distance(box, {}, box, {{2, 0.5}, 0})->distance, 0);
  const auto beside = shape_distance(box, {}, box, {{3, 1}, 0});
  EXPECT_EQ(beside->distance, 1);
  EXPECT_EQ(beside->normal, (Vec2{1, 0}));
  EXPECT_EQ(beside->point_a, (Vec2{1, 0.5})) << "the middle of the sides that face each other";
  EXPECT_EQ(beside->point_b, (Vec2{2, 0.5}));
  EXPECT_EQ(shape_distance(DiscShape{1}, {}, DiscShape{1}, {{2, 0}, 0})->distance, 0);
  const auto same = shape_distance(DiscShape{1}, {}, DiscShape{0.5}, {});
  EXPECT_EQ(same->distance, -1.5);
  EXPECT_EQ(std::hypot(same->normal.x, same->normal.y), 1);
  const SegmentShape line{{0, 0}, {4, 0}}, across{{1, -1}, {1, 3}};
  EXPECT_EQ(shape_distance(line, {}, across, {})->distance, -1) << "lines that cross are as deep as one must go";
  EXPECT_EQ(shape_distance(line, {}, SegmentShape{{5, 0}, {9, 0}}, {})->distance, 1);
}

// Both move and turn. Nothing touches before the hit, and there the gap is closed.
TEST(Geometry, CastsMeetWhereBruteForceDoes) {
  Random r(7);
  int hits = 0, misses = 0, inside = 0;
  for (int n = 0; n < 6000; ++n) {
    const Shape a = any_shape(r, r.uniform(0.1, 2)), b = any_shape(r, r.uniform(0.1, 2));
    const auto any_move = [&](bool goes, bool turns) {  // mostly past the middle
      ShapeMove move{any_pose(r, 8), {}, 0};
      const Vec2 from = move.from.position, to{r.uniform(-3, 3), r.uniform(-3, 3)};
      if (goes) move.translation = {2 * (to.x - from.x), 2 * (to.y - from.y)};
      if (turns) move.rotation = r.uniform(-5, 5);
      return move;
    };
    const ShapeMove move_a = any_move(r.chance(0.9), r.chance(0.5)), move_b = any_move(r.chance(0.5), r.chance(0.5));
    const auto hit = shape_cast(a, move_a, b, move_b);
    const double end = hit ? hit->fraction : 1;
    const auto gap = [&](double share) { return true_gap(a, moved(move_a, share), b, moved(move_b, share)); };
    for (int k = 0; k < 100 && end > 0; ++k) {
      ASSERT_GT(gap(end * k / 100), -1e-6) << "cast " << n << " at " << k << " of " << end;
    }
    if (!hit) {
      ++misses;
      continue;
    }
    if (hit->normal == Vec2{}) {
      ++inside;
      EXPECT_LT(gap(0), kClose);
      EXPECT_EQ(hit->fraction, 0);
      EXPECT_EQ(hit->point, move_a.from.position);
      continue;
    }
    ++hits;
    EXPECT_NEAR(gap(end), 0, 1e-6) << "cast " << n;
    EXPECT_LT(true_distance(a, moved(move_a, end), hit->point), 1e-6) << "cast " << n;
    EXPECT_LT(true_distance(b, moved(move_b, end), hit->point), 1e-6) << "cast " << n;
    EXPECT_NEAR(std::hypot(hit->normal.x, hit->normal.y), 1, 1e-12);
    if (!is_one_part(a) || !is_one_part(b)) continue;
    Pose away = moved(move_a, end);
    away.position = along(away.position, 1e-3, hit->normal);
    EXPECT_GT(true_gap(a, away, b, moved(move_b, end)), 1e-3 - 1e-6) << "cast " << n;
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 500);
  EXPECT_GT(inside, 50);
}

// It makes no difference which of the two moves.
TEST(Geometry, CastsAreRelative) {
  Random r(8);
  int hits = 0;
  for (int n = 0; n < 1000; ++n) {
    const Shape a = any_shape(r, r.uniform(0.1, 2)), b = any_shape(r, r.uniform(0.1, 2));
    const Pose at_a = any_pose(r, 8), at_b = any_pose(r, 8);
    const Vec2 way{2 * (at_b.position.x - at_a.position.x) + r.uniform(-3, 3),
                   2 * (at_b.position.y - at_a.position.y) + r.uniform(-3, 3)};
    const auto one = shape_cast(a, {at_a, way}, b, {at_b});
    const auto other = shape_cast(b, {at_b, {-way.x, -way.y}}, a, {at_a});
    const auto both = shape_cast(a, {at_a, {3 * way.x, 3 * way.y}}, b, {at_b, {2 * way.x, 2 * way.y}});
    ASSERT_EQ(one.has_value(), other.has_value()) << n;
    ASSERT_EQ(one.has_value(), both.has_value()) << n;
    if (!one) continue;
    ++hits;
    EXPECT_NEAR(one->fraction, other->fraction, 1e-9) << n;
    EXPECT_NEAR(one->fraction, both->fraction, 1e-9) << n;
  }
  EXPECT_GT(hits, 200);
}

TEST(Geometry, ACastThatTouchesAtTheStartMeetsIfItComesNearer) {
  const BoxShape box{2, 2, 0};
  const ShapeMove other{{{2, 0}, 0}, {}, 0};
  const auto into = shape_cast(box, {{}, {1, 0}}, box, other);
  ASSERT_TRUE(into);
  EXPECT_EQ(into->fraction, 0);
  EXPECT_EQ(into->normal, (Vec2{-1, 0}));
  EXPECT_FALSE(shape_cast(box, {{}, {-1, 0}}, box, other));
  const auto turning = shape_cast(box, {{}, {}, 1}, box, other);
  ASSERT_TRUE(turning);
  EXPECT_LT(turning->fraction, 1e-3);
}

// Two rods turn towards each other like scissors, each the image of the other in the point (1, 0.25): they stay parallel
// and meet when they pass it.
TEST(Geometry, BothMayTurn) {
  const SegmentShape rod{{0, 0}, {2, 0}};
  const auto hit = shape_cast(rod, {{{0, 0}, 0}, {}, kPi / 2}, rod, {{{2, 0.5}, kPi}, {}, kPi / 2});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->fraction * kPi / 2, std::atan2(0.25, 1.0), 1e-6);
}

TEST(Geometry, AnswersAreThoseOfAWorld) {
  Random r(9);
  int casts = 0;
  for (int n = 0; n < 300; ++n) {
    const Shape a = any_shape(r, r.uniform(0.3, 2)), b = any_shape(r, r.uniform(0.3, 2));
    const Pose at_a = any_pose(r, 6), at_b = any_pose(r, 6);
    auto world = make(unbounded(100, {0, 0}));
    BodyDesc body{.type = BodyType::static_body, .shape = b, .position = at_b.position, .angle = at_b.angle};
    add(*world, body);
    const ShapeMove move{at_a, {r.uniform(-9, 9), r.uniform(-9, 9)}, r.chance(0.5) ? r.uniform(-3, 3) : 0};
    const auto here = shape_cast(a, move, b, {at_b});
    const auto there = world->shape_cast(a, at_a.position, at_a.angle, move.translation, move.rotation);
    ASSERT_EQ(here.has_value(), there.has_value()) << n;
    EXPECT_NEAR(here ? here->fraction : 2, there ? there->fraction : 2, 1e-5) << n;
    casts += here.has_value();
    NearHit near;
    ASSERT_GT(world->nearby(a, at_a.position, at_a.angle, 100, {&near, 1}), 0u);
    const ShapeGap gap = shape_distance(a, at_a, b, at_b).value();
    EXPECT_NEAR(gap.distance, near.distance, 1e-5) << n;
    const Bounds box = shape_bounds(b, at_b).value(), of_world = world->bounds_of({0, 0}).value();
    EXPECT_NEAR(box.xmin, of_world.xmin, 1e-5);
    EXPECT_NEAR(box.ymax, of_world.ymax, 1e-5);
  }
  EXPECT_GT(casts, 50);
}

TEST(Geometry, RefusesWhatIsWrong) {
  const Shape good = DiscShape{1};
  const Pose nowhere{{kNan, 0}, 0}, far{{2e9, 0}, 0}, spun{{}, kInf};
  for (const Pose& wrong : {nowhere, far, spun}) {
    EXPECT_FALSE(shape_bounds(good, wrong));
    EXPECT_FALSE(shape_holds(good, wrong, {}));
    EXPECT_FALSE(shape_ray_cast(good, wrong, {}, {1, 1}));
    EXPECT_FALSE(shape_distance(good, wrong, good, {}));
    EXPECT_FALSE(shape_distance(good, {}, good, wrong));
    EXPECT_FALSE(shape_cast(good, {wrong, {1, 0}}, good, {}));
    EXPECT_FALSE(shape_cast(good, {{}, {1, 0}}, good, {wrong}));
  }
  const PolygonShape bow{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0};
  for (const Shape& wrong : {Shape(DiscShape{0}), Shape(DiscShape{kNan}), Shape(bow), Shape(SegmentShape{}),
                             Shape(CompoundShape{}), Shape(BoxShape{1, -1, 0}), Shape(ChainShape{})}) {
    EXPECT_FALSE(shape_bounds(wrong, {}));
    EXPECT_FALSE(shape_holds(wrong, {}, {}));
    EXPECT_FALSE(shape_ray_cast(wrong, {}, {-5, 0}, {5, 0}));
    EXPECT_FALSE(shape_distance(good, {}, wrong, {}));
    EXPECT_FALSE(shape_distance(wrong, {}, good, {}));
    EXPECT_FALSE(shape_cast(good, {{{-5, 0}, 0}, {9, 0}}, wrong));
  }
  EXPECT_FALSE(shape_holds(good, {}, {kNan, 0}));
  EXPECT_FALSE(shape_ray_cast(good, {}, {-5, 0}, {kInf, 0}));
  EXPECT_FALSE(shape_cast(good, {{{-5, 0}, 0}, {9, 0}, 1001}, good));
  EXPECT_FALSE(shape_cast(good, {{{-5, 0}, 0}, {kNan, 0}}, good));
  EXPECT_FALSE(out_of_memory());
}

// Far away, and where the shape is far from its own origin, the numbers are as good as doubles there.
TEST(Geometry, IsPreciseFarAway) {
  const PolygonShape off{{{1e6, 0}, {1e6 + 1, 0}, {1e6 + 1, 1}, {1e6, 1}}, 0};
  const BoxShape box{1, 1, 0};
  for (const double x : {0.0, 1e3, 1e6, 1e8}) {
    const auto gap = shape_distance(off, {{x - 1e6, 0}, 0}, box, {{x + 2.5, 0.5}, 0});
    ASSERT_TRUE(gap);
    EXPECT_NEAR(gap->distance, 1, 1e-9 + 1e-15 * x);
  }
}

}  // namespace
}  // namespace psim::test
