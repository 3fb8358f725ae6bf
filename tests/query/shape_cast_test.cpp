// Casts of shapes, with and without a turn on the way, against brute force and closed forms.
#include "body_outlines.h"
#include "support.h"

namespace psim::test {
namespace {

constexpr double kFuzz = 1e-5;  // m: the engine has its bodies in floats

Shape cast_shape(Random& r, double size) {
  const auto point = [&] { return Vec2{r.uniform(-size, size), r.uniform(-size, size)}; };
  switch (r.below(6)) {
    case 0:
      return DiscShape{size * r.uniform(0.2, 1)};
    case 1:
      return CapsuleShape{point(), point(), size * r.uniform(0.1, 0.6)};
    case 2:
      return BoxShape{size * r.uniform(0.2, 2), size * r.uniform(0.2, 2), r.chance(0.5) ? 0.2 * size : 0};
    case 3:
      return SegmentShape{point(), point()};
    case 4: {
      CompoundShape two;
      two.parts.push_back({.shape = BoxShape{size, 0.4 * size, 0}, .position = point(), .angle = r.uniform(-3, 3)});
      two.parts.push_back({.shape = DiscShape{0.3 * size}, .position = point()});
      return two;
    }
    default: {
      PolygonShape polygon;
      const std::size_t n = 3 + r.below(6);
      const Vec2 off = point();
      for (std::size_t k = 0; k < n; ++k) {
        const double a = 2 * kPi * static_cast<double>(k) / static_cast<double>(n);
        polygon.vertices.push_back({off.x + size * std::cos(a), off.y + size * std::sin(a)});
      }
      return polygon;
    }
  }
}

/// Bodies of all shapes, chains and compounds among them, in a world of 40 m.
struct Crowd {
  std::unique_ptr<World> world;
  std::vector<BodyDesc> desc;
  std::vector<BodyId> id;
  bool wraps = false;

  Crowd(std::uint64_t seed, bool periodic_world, int threads = 1) : wraps(periodic_world) {
    Random r(seed);
    WorldDesc d = periodic_world ? periodic(40, 40) : unbounded(60, {0, 0});
    d.bounds = periodic_world ? Bounds{0, 0, 40, 40} : d.bounds;
    world = make(d, best_isa(), threads);
    for (int k = 0; k < 90; ++k) {
      BodyDesc body;
      body.type = r.chance(0.4)   ? BodyType::static_body
                  : r.chance(0.3) ? BodyType::kinematic_body
                                  : BodyType::dynamic_body;
      body.shape = cast_shape(r, r.uniform(0.1, 1.2));
      if (body.type != BodyType::dynamic_body && r.chance(0.3)) {
        body.shape = ChainShape{{{-2, 0}, {-1, 0.4}, {0, 0.3}, {1, -0.2}, {2, 0.1}}, false};
      }
      body.position = {r.uniform(0, 40), r.uniform(0, 40)};
      body.angle = r.uniform(-4, 4);
      desc.push_back(body);
      id.push_back(add(*world, body));
    }
    run(*world, 1);
  }

  static constexpr double kFar = 9;  // m: two bodies whose places are farther apart are none of each other's business

  /// The gap between a placed shape and body k, over all copies; negative: how deep they overlap.
  double gap(const Shape& shape, Vec2 at, double angle, std::size_t k) const {
    const BodyState s = state(*world, id[k]);
    double least = 1e300;
    for (int x = wraps ? -1 : 0; x <= (wraps ? 1 : 0); ++x) {
      for (int y = wraps ? -1 : 0; y <= (wraps ? 1 : 0); ++y) {
        const Vec2 place{s.x + 40 * x, s.y + 40 * y};
        if (std::hypot(place.x - at.x, place.y - at.y) > kFar) continue;
        for (const auto& mine : outlines(shape, at, angle)) {
          for (const auto& o : outlines(desc[k].shape, place, s.angle)) {
            const double apart = distance(o, mine);
            least = std::min(least, apart > 0 ? apart : -depth(o, mine));
          }
        }
      }
    }
    return least;
  }
  double gap(const Shape& shape, Vec2 at, double angle) const {
    double least = 1e300;
    for (std::size_t k = 0; k < id.size(); ++k) least = std::min(least, gap(shape, at, angle, k));
    return least;
  }
};

// Nothing is met before the hit, and what is met is touched there, at the point and with the normal that are told.
TEST(ShapeCast, MeetsWhatBruteForceMeets) {
  std::size_t hits = 0, misses = 0, inside = 0, turning = 0;
  for (const bool wraps : {false, true}) {
    const Crowd crowd(wraps ? 2 : 1, wraps);
    Random r(7);
    for (int n = 0; n < 300; ++n) {
      const Shape shape = cast_shape(r, r.uniform(0.05, 0.7));
      const Vec2 from{r.uniform(0, 40), r.uniform(0, 40)}, way{r.uniform(-9, 9), r.uniform(-9, 9)};
      const double angle = r.uniform(-4, 4), turn = r.chance(0.5) ? r.uniform(-3, 3) : 0;
      const auto hit = crowd.world->shape_cast(shape, from, angle, way, turn);
      const auto at = [&](double share) { return Vec2{from.x + share * way.x, from.y + share * way.y}; };
      const double end = hit ? hit->fraction : 1;
      for (int k = 0; k < 60; ++k) {
        const double share = end * k / 60;
        ASSERT_GT(crowd.gap(shape, at(share), angle + share * turn), hit && hit->fraction == 0 ? -1e300 : -kFuzz)
            << "cast " << n << " at " << share << " of " << end;
      }
      if (!hit) {
        ++misses;
        continue;
      }
      const auto k =
          static_cast<std::size_t>(std::find(crowd.id.begin(), crowd.id.end(), hit->body) - crowd.id.begin());
      ASSERT_LT(k, crowd.id.size());
      if (hit->fraction == 0 && hit->normal == Vec2{}) {
        ++inside;
        EXPECT_LT(crowd.gap(shape, from, angle, k), kFuzz);
        continue;
      }
      ++hits;
      turning += turn != 0;
      EXPECT_NEAR(crowd.gap(shape, at(end), angle + end * turn, k), 0, kFuzz) << "cast " << n;
      EXPECT_NEAR(std::hypot(hit->normal.x, hit->normal.y), 1, 1e-9);
      // The point lies on both, and the gap grows along the normal.
      EXPECT_NEAR(crowd.gap(DiscShape{1e-6}, hit->point, 0, k), 0, 2 * kFuzz) << "cast " << n;
      double off = wraps ? 0 : 1e300;  // m: from the shape
      for (const auto& mine : outlines(shape, at(end), angle + end * turn)) {
        off = std::min(off, distance(mine, exact(hit->point)));
      }
      EXPECT_LT(off, 2 * kFuzz) << "cast " << n;
      const Vec2 away{at(end).x + 1e-3 * hit->normal.x, at(end).y + 1e-3 * hit->normal.y};
      EXPECT_GT(crowd.gap(shape, away, angle + end * turn, k), std::holds_alternative<CompoundShape>(shape) ? -1 : 0);
    }
  }
  EXPECT_GT(hits, 150u);
  EXPECT_GT(turning, 50u);
  EXPECT_GT(misses, 10u);
  EXPECT_GT(inside, 10u);
}

TEST(ShapeCast, IsExactForADiscAndABox) {
  auto world = make(unbounded(100, {0, 0}));
  const BodyId id = add(*world, static_disc({5, 0}, 1));
  const auto hit = world->shape_cast(DiscShape{0.5}, {0, 0.9}, 0, {10, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, id);
  const double x = 5 - std::sqrt(1.5 * 1.5 - 0.9 * 0.9);
  EXPECT_NEAR(hit->fraction, x / 10, 1e-9);
  EXPECT_NEAR(hit->normal.x, (x - 5) / 1.5, 1e-9);
  EXPECT_NEAR(hit->point.y, 0.9 / 1.5, 1e-9);
  // A face that meets a face is met in the middle of what touches.
  BodyDesc box;
  box.type = BodyType::static_body;
  box.shape = BoxShape{2, 2, 0};
  box.position = {0, 10};
  add(*world, box);
  const auto flush = world->shape_cast(BoxShape{1, 2, 0}, {-9, 10.5}, 0, {20, 0});
  ASSERT_TRUE(flush);
  EXPECT_NEAR(flush->fraction, 7.5 / 20, 1e-9);
  EXPECT_EQ(flush->normal.x, -1);
  EXPECT_NEAR(flush->point.x, -1, 1e-9);
  EXPECT_NEAR(flush->point.y, 10.25, 1e-9);
}

// A rod of half length 2 turns about its middle until it touches a disc: sin(angle) = (height + radius) / distance.
TEST(ShapeCast, TurnsAsTheClosedFormSays) {
  for (const double radius : {0.25, 0.5}) {
    auto world = make(unbounded(100, {0, 0}));
    const Vec2 at{1.5, 1};
    add(*world, static_disc(at, radius));
    const auto hit = world->shape_cast(BoxShape{4, 0.2, 0}, {0, 0}, 0, {0, 0}, kPi);
    ASSERT_TRUE(hit);
    const double far = std::hypot(at.x, at.y), touch = std::atan2(at.y, at.x) - std::asin((radius + 0.1) / far);
    EXPECT_NEAR(hit->fraction * kPi, touch, 3e-7);
    EXPECT_FALSE(world->shape_cast(BoxShape{4, 0.2, 0}, {0, 0}, 0, {0, 0}, touch - 1e-6));
    EXPECT_TRUE(world->shape_cast(BoxShape{4, 0.2, 0}, {0, 0}, 0, {0, 0}, touch + 1e-6));
    EXPECT_NEAR(hit->normal.x, std::sin(touch), 1e-6);  // from the disc to the upper face of the rod
    EXPECT_NEAR(hit->normal.y, -std::cos(touch), 1e-6);
    EXPECT_NEAR(hit->point.x, at.x + radius * std::sin(touch), 1e-6);
    // The other way round, the other end comes.
    const auto back = world->shape_cast(BoxShape{4, 0.2, 0}, {0, 0}, 0, {0, 0}, -kPi);
    ASSERT_TRUE(back);
    const double other = kPi - std::atan2(at.y, at.x) - std::asin((radius + 0.1) / far);
    EXPECT_NEAR(back->fraction * kPi, other, 3e-7);
  }
}

// A gear that turns free beside a wall at a distance of less than its corner's bend never touches, however often.
TEST(ShapeCast, TurnsFreelyBesideAWall) {
  auto world = make(unbounded(100, {0, 0}));
  add(*world, segment({-10, -std::sqrt(0.5) - 1e-4}, {10, -std::sqrt(0.5) - 1e-4}));
  EXPECT_FALSE(world->shape_cast(BoxShape{1, 1, 0}, {0, 0}, 0, {0, 0}, 20));
  EXPECT_FALSE(world->shape_cast(BoxShape{1, 1, 0}, {-5, 0}, 0, {10, 0}, -20));
  EXPECT_TRUE(world->shape_cast(BoxShape{1, 1, 0}, {0, 0}, 0, {0, -2e-4}, 20));
}

TEST(ShapeCast, StartsInWhatItOverlaps) {
  auto world = make(unbounded(100, {0, 0}));
  const BodyId id = add(*world, static_disc({0, 0}, 1));
  const BodyId next = add(*world, static_disc({4, 0}, 1));
  for (const double turn : {0.0, 1.0}) {
    const auto hit = world->shape_cast(BoxShape{1, 1, 0}, {0.5, 0}, 0, {9, 0}, turn);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->body, id);
    EXPECT_EQ(hit->fraction, 0);
    EXPECT_EQ(hit->normal, Vec2{});
    EXPECT_EQ(hit->point, (Vec2{0.5, 0}));
    QueryFilter enters;
    enters.enter_only = true;
    EXPECT_EQ(world->shape_cast(BoxShape{1, 1, 0}, {0.5, 0}, 0, {9, 0}, turn, enters)->body, next);
  }
}

TEST(ShapeCast, MeetsNoWallOfTheWorld) {
  auto world = make(walled({-5, -5, 5, 5}));
  EXPECT_FALSE(world->shape_cast(DiscShape{1}, {0, 0}, 0, {100, 0}));
}

TEST(ShapeCast, GoesOnceThroughAPeriodicWorld) {
  auto world = make(periodic(20, 20));
  const BodyId id = add(*world, static_disc({1, 10}, 0.5));
  const auto hit = world->shape_cast(DiscShape{0.5}, {15, 10}, 0, {100, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, id);
  EXPECT_NEAR(hit->point.x, 20.5, 1e-6);
  EXPECT_NEAR(hit->fraction, 0.05, 1e-7);
}

TEST(ShapeCast, RefusesBadNumbers) {
  auto world = make(unbounded());
  add(*world, static_disc({3, 0}, 1));
  const DiscShape shape{0.5};
  EXPECT_TRUE(world->shape_cast(shape, {0, 0}, 0, {9, 0}, 0));
  std::vector<NearHit> near(4);
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(world->shape_cast(shape, {bad, 0}, 0, {9, 0}, 0));
    EXPECT_FALSE(world->shape_cast(shape, {0, 0}, bad, {9, 0}, 0));
    EXPECT_FALSE(world->shape_cast(shape, {0, 0}, 0, {9, bad}, 0));
    EXPECT_FALSE(world->shape_cast(shape, {0, 0}, 0, {9, 0}, bad));
    EXPECT_FALSE(world->shape_cast(DiscShape{bad}, {0, 0}, 0, {9, 0}, 0));
    EXPECT_EQ(world->nearby(shape, {bad, 0}, 0, 9, near), 0u);
    EXPECT_EQ(world->nearby(shape, {0, 0}, bad, 9, near), 0u);
    EXPECT_EQ(world->nearby(shape, {0, 0}, 0, bad, near), 0u);
  }
  EXPECT_FALSE(world->shape_cast(DiscShape{-1}, {0, 0}, 0, {9, 0}, 0));
  EXPECT_FALSE(world->shape_cast(CapsuleShape{{0, 0}, {1, 0}, -1}, {0, 0}, 0, {9, 0}, 0));
  EXPECT_FALSE(world->shape_cast(PolygonShape{{{0, 0}, {1, 0}}, 0}, {0, 0}, 0, {9, 0}, 0));
  EXPECT_FALSE(world->shape_cast(shape, {0, 0}, 0, {9, 0}, 1e4));
  EXPECT_EQ(world->nearby(shape, {0, 0}, 0, -1, near), 0u);
  EXPECT_TRUE(world->shape_cast(shape, {-1e8, 0}, 0, {2e8, 1}, 0));
  EXPECT_TRUE(world->shape_cast(BoxShape{1, 1, 0}, {-1e8, 0}, 0, {2e8, 0.1}, 1));
}

// Each piece within reach is told once, the nearest first, with a gap and a normal that brute force confirms.
TEST(Nearby, TellsGapsAndNormals) {
  std::size_t apart = 0, deep = 0;
  const Crowd crowd(3, false);
  Random r(5);
  std::vector<NearHit> near(64);
  for (int n = 0; n < 500; ++n) {
    Shape shape = cast_shape(r, r.uniform(0.05, 1));
    if (std::holds_alternative<CompoundShape>(shape)) shape = DiscShape{0.4};
    const Vec2 at{r.uniform(0, 40), r.uniform(0, 40)};
    const double angle = r.uniform(-4, 4), reach = r.uniform(0, 2);
    const std::size_t count = crowd.world->nearby(shape, at, angle, reach, near);
    ASSERT_LE(count, near.size());
    std::vector<bool> seen(crowd.id.size(), false);
    for (std::size_t k = 0; k < count; ++k) {
      if (k > 0) {
        EXPECT_LE(near[k - 1].distance, near[k].distance);
      }
      const auto which =
          static_cast<std::size_t>(std::find(crowd.id.begin(), crowd.id.end(), near[k].body) - crowd.id.begin());
      const double gap = crowd.gap(shape, at, angle, which);
      if (!seen[which]) {  // of several pieces the nearest comes first
        EXPECT_NEAR(near[k].distance, gap, kFuzz) << n;
      }
      seen[which] = true;
      (gap > 0 ? apart : deep) += 1;
      const Vec2 out{at.x - near[k].distance * near[k].normal.x, at.y - near[k].distance * near[k].normal.y};
      if (const auto* chain = std::get_if<ChainShape>(&crowd.desc[which].shape); chain != nullptr) continue;
      if (std::holds_alternative<CompoundShape>(crowd.desc[which].shape)) continue;
      EXPECT_NEAR(crowd.gap(shape, out, angle, which), 0, 2 * kFuzz) << n;
    }
    for (std::size_t k = 0; k < crowd.id.size(); ++k) {
      if (!seen[k]) {
        EXPECT_GT(crowd.gap(shape, at, angle, k), reach - kFuzz);
      }
    }
    // With less room the nearest are kept.
    std::vector<NearHit> few(2);
    EXPECT_EQ(crowd.world->nearby(shape, at, angle, reach, few), count);
    for (std::size_t k = 0; k < std::min<std::size_t>(2, count); ++k) EXPECT_EQ(few[k].distance, near[k].distance);
  }
  EXPECT_GT(apart, 50u);
  EXPECT_GT(deep, 50u);
}

// ---- rays by the batch, and filters -------------------------------------------------------------

TEST(RayBatch, GivesTheAnswersOfSingleCallsOnAnyNumberOfThreads) {
  std::vector<RayHit> first;
  for (const int threads : {1, 2, 3}) {
    Crowd crowd(4, true, threads);
    Random r(1);
    std::vector<RayInput> rays(10'000);
    for (RayInput& ray : rays) ray = {{r.uniform(0, 40), r.uniform(0, 40)}, {r.uniform(0, 40), r.uniform(0, 40)}};
    rays[17].to.x = kNan;
    std::vector<RayHit> hits(rays.size(), RayHit{{5, 5}, {1, 1}, {1, 1}, 3});
    const std::size_t met = crowd.world->ray_cast_batch(rays, hits);
    EXPECT_GT(met, 5'000u);
    EXPECT_LT(met, 9'990u);
    EXPECT_EQ(hits[17].body, kNoBody);
    std::size_t counted = 0;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      const RayHit one = crowd.world->ray_cast(rays[k].from, rays[k].to).value_or(RayHit{});
      ASSERT_TRUE(one.body == hits[k].body && one.point == hits[k].point && one.normal == hits[k].normal &&
                  one.fraction == hits[k].fraction)
          << "ray " << k << ", " << threads << " threads";
      counted += one.body != kNoBody;
    }
    EXPECT_EQ(met, counted);
    if (first.empty()) first = hits;
    for (std::size_t k = 0; k < rays.size(); ++k) ASSERT_EQ(first[k].fraction, hits[k].fraction);
    hits.resize(5);
    hits[0].fraction = 7;
    EXPECT_EQ(crowd.world->ray_cast_batch(rays, hits), 0u);
    EXPECT_EQ(hits[0].fraction, 7);
    EXPECT_EQ(crowd.world->ray_cast_batch({}, {}), 0u);
  }
}

TEST(RayBatch, RunsOnTheHostsJobs) {
  Crowd crowd(4, true);
  std::size_t jobs = 0;
  crowd.world->set_job_system({[&](std::size_t count, const std::function<void(std::size_t)>& job) {
    jobs += count;
    for (std::size_t k = count; k > 0; --k) job(k - 1);
  }});
  const Vec2 to = crowd.desc[5].position;
  std::vector<RayInput> rays(1000, RayInput{{0, 20}, to});
  std::vector<RayHit> hits(rays.size());
  EXPECT_EQ(crowd.world->ray_cast_batch(rays, hits), crowd.world->ray_cast({0, 20}, to) ? 1000u : 0u);
  EXPECT_NE(hits[999].body, kNoBody);
  EXPECT_GT(jobs, 1u);
}

// All questions of a filter: both masks agree, and the ignored body is none.
TEST(QueryFilters, BothMasksAgree) {
  for (const std::uint32_t category : {1u, 2u, 6u}) {
    for (const std::uint32_t mask : {0u, 1u, 4u, 0xFFFFFFFFu}) {
      for (const std::uint32_t asked : {1u, 4u, 0xFFFFFFFFu}) {
        for (const std::uint32_t asker : {1u, 4u, 0xFFFFFFFFu}) {
          for (const bool compound : {false, true}) {
            auto world = make(unbounded(100, {0, 0}));
            BodyDesc body = disc({3, 0}, {}, 1);
            body.filter = {category, mask, 0};
            if (compound) {
              // The parts have the filter, the body another one.
              CompoundShape shape;
              shape.parts.push_back({.shape = DiscShape{1}, .filter = body.filter});
              shape.parts.push_back({.shape = DiscShape{0.1}, .position = {0, 50}, .filter = Filter{8, 8, 0}});
              body.shape = shape;
              body.filter = {};
            }
            const BodyId id = add(*world, body);
            QueryFilter f;
            f.mask = asked;
            f.category = asker;
            const bool found = (category & asked) != 0 && (asker == 0xFFFFFFFFu || (mask & asker) != 0);
            std::vector<NearHit> near(2);
            const auto all = [&](bool expected) {
              EXPECT_EQ(world->ray_cast({0, 0}, {9, 0}, f).has_value(), expected);
              EXPECT_EQ(!world->ray_cast_all({0, 0}, {9, 0}, f).empty(), expected);
              EXPECT_EQ(world->shape_cast(DiscShape{0.5}, {0, 0}, 0, {9, 0}, 0, f).has_value(), expected);
              EXPECT_EQ(world->nearby(DiscShape{0.5}, {1, 0}, 0, 2, near, f) != 0, expected);
              EXPECT_EQ(!world->overlap(DiscShape{1}, {2, 0}, 0, f).empty(), expected);
              EXPECT_EQ(!world->in_region({0, 0, 3, 1}, f).empty(), expected);
              EXPECT_EQ(world->closest({0, 0}, 9, f).has_value(), expected);
            };
            all(found);
            f.ignore = {id.index, id.generation + 1};  // of who had the index before or will have it
            all(found);
            f.ignore = id;
            all(false);
          }
        }
      }
    }
  }
}

// Shapes that are solid from one side are met there alone, if the filter says so, however the body is turned.
TEST(QueryFilters, OneWayShapesAreMetOnTheirSolidSide) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    for (const double angle : {0.0, 2.0}) {
      auto world = make(unbounded(100, {0, 0}));
      BodyDesc body;
      body.type = type;
      body.shape = BoxShape{4, 0.2, 0};
      body.one_way = {0, 3};
      body.angle = angle;
      add(*world, body);
      const Vec2 way{-std::sin(angle), std::cos(angle)};
      for (const double side : {1.0, -1.0}) {
        const Vec2 from{2 * side * way.x, 2 * side * way.y}, to{-from.x, -from.y};
        QueryFilter f;
        EXPECT_TRUE(world->ray_cast(from, to, f));
        EXPECT_TRUE(world->shape_cast(DiscShape{0.3}, from, 0, {2 * to.x, 2 * to.y}, 0, f));
        f.one_way = true;
        EXPECT_EQ(world->ray_cast(from, to, f).has_value(), side > 0);
        EXPECT_EQ(world->ray_cast_all(from, to, f).size(), side > 0 ? 1u : 0u);
        EXPECT_EQ(world->shape_cast(DiscShape{0.3}, from, 0, {2 * to.x, 2 * to.y}, 0, f).has_value(), side > 0);
        EXPECT_EQ(world->shape_cast(BoxShape{1, 1, 0}, from, 0, {2 * to.x, 2 * to.y}, 1, f).has_value(), side > 0);
        std::vector<NearHit> near(2);
        EXPECT_EQ(world->nearby(DiscShape{0.3}, from, 0, 9, near, f), side > 0 ? 1u : 0u);
        EXPECT_EQ(near[0].one_way, side > 0);
      }
    }
  }
}

TEST(ShapeCast, IsTheSameForEveryIsa) {
  std::vector<double> first;
  for (const Isa isa : available_isas()) {
    auto world = gas_in_walls(2000, 0.3, material(0.8), 10, isa, 2);
    run(*world, 10);
    Random r(5);
    std::vector<double> answers;
    const Bounds b = world->desc().bounds;
    for (int n = 0; n < 300; ++n) {
      const Vec2 from{r.uniform(b.xmin, b.xmax), r.uniform(b.ymin, b.ymax)};
      const auto hit =
          world->shape_cast(BoxShape{1, 0.3, 0}, from, 0.3, {r.uniform(-9, 9), r.uniform(-9, 9)}, n % 2 == 0 ? 0 : 2.0);
      if (hit) answers.insert(answers.end(), {hit->fraction, hit->normal.x, hit->point.y});
    }
    EXPECT_GT(answers.size(), 300u);
    if (first.empty()) first = answers;
    EXPECT_EQ(first, answers);
  }
}

}  // namespace
}  // namespace psim::test
