// A body tells its parts. They make a body again that is the same: its mass, its place, and all that queries find.
#include "geometry/any_shape.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// What a body is made of anew.
BodyDesc told_again(const World& world, BodyId id) {
  const BodyState s = state(world, id);
  BodyDesc body;
  body.type = s.type;
  body.shape = CompoundShape{world.shapes_of(id)};
  body.position = {s.x, s.y};
  body.angle = s.angle;
  return body;
}

double reach_of(const World& world, const Shape& shape, const Pose& at) {
  NearHit near;
  QueryFilter all;
  all.sensors = true;
  return world.nearby(shape, at.position, at.angle, 1e3, {&near, 1}, all) != 0 ? near.distance : 1e300;
}

void expect_alike(World& one, BodyId id, World& other, BodyId again, std::uint64_t seed) {
  const double far = 1e-6;
  const Bounds a = one.bounds_of(id).value(), b = other.bounds_of(again).value();
  EXPECT_NEAR(a.xmin, b.xmin, far);
  EXPECT_NEAR(a.ymin, b.ymin, far);
  EXPECT_NEAR(a.xmax, b.xmax, far);
  EXPECT_NEAR(a.ymax, b.ymax, far);
  const BodyTraits s = one.traits(id).value(), t = other.traits(again).value();
  EXPECT_NEAR(s.mass, t.mass, 1e-6 * s.mass);
  EXPECT_NEAR(s.inertia, t.inertia, 2e-6 * s.inertia);
  EXPECT_EQ(s.friction, t.friction);
  EXPECT_EQ(s.restitution, t.restitution);
  EXPECT_EQ(s.tangent_speed, t.tangent_speed);
  EXPECT_EQ(s.rolling_resistance, t.rolling_resistance);
  EXPECT_EQ(s.filter, t.filter);
  EXPECT_EQ(s.sensor, t.sensor);
  EXPECT_NEAR(s.one_way.x, t.one_way.x, 1e-6);
  EXPECT_NEAR(s.one_way.y, t.one_way.y, 1e-6);
  EXPECT_NEAR(one.centre_of_mass(id)->x, other.centre_of_mass(again)->x, far);
  EXPECT_NEAR(one.centre_of_mass(id)->y, other.centre_of_mass(again)->y, far);
  Random r(seed);
  for (int k = 0; k < 30; ++k) {
    const Shape probe = DiscShape{0.1};
    const Pose at{{r.uniform(a.xmin - 2, a.xmax + 2), r.uniform(a.ymin - 2, a.ymax + 2)}, 0};
    EXPECT_NEAR(reach_of(one, probe, at), reach_of(other, probe, at), 2e-6);
  }
}

// The only body of a world, and of another one that is made of what it tells.
void expect_round_trip(const BodyDesc& body, std::uint64_t seed) {
  const WorldDesc open = unbounded(100, {0, 0});
  auto one = make(open), other = make(open);
  const BodyId id = add(*one, body);
  const BodyId again = add(*other, told_again(*one, id));
  expect_alike(*one, id, *other, again, seed);
  const auto first = one->shapes_of(id), second = other->shapes_of(again);
  ASSERT_EQ(first.size(), second.size()) << seed;
  Bounds all{1e300, 1e300, -1e300, -1e300};
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].shape.index(), second[k].shape.index());
    EXPECT_EQ(first[k].angle, 0);
    const Bounds box = one->bounds_of_part(id, k).value();
    all = {std::min(all.xmin, box.xmin), std::min(all.ymin, box.ymin), std::max(all.xmax, box.xmax),
           std::max(all.ymax, box.ymax)};
  }
  EXPECT_FALSE(one->bounds_of_part(id, first.size()));
  const Bounds whole = one->bounds_of(id).value();
  EXPECT_NEAR(all.xmin, whole.xmin, 1e-6);
  EXPECT_NEAR(all.ymax, whole.ymax, 1e-6);
}

TEST(BodyShapes, MakeTheBodyAgain) {
  Random r(1);
  for (std::uint64_t n = 0; n < 400; ++n) {
    BodyDesc body;
    body.type = static_cast<BodyType>(n % 3);
    body.shape = any_shape(r, r.uniform(0.2, 2));
    if (std::holds_alternative<ChainShape>(body.shape) && body.type == BodyType::dynamic_body)
      body.type = BodyType::kinematic_body;
    body.position = {r.uniform(-20, 20), r.uniform(-20, 20)};
    body.angle = r.uniform(-4, 4);
    body.material = {r.uniform(0.1, 5), r.uniform(0, 1), r.uniform(0, 2), 0, 0};
    if (r.chance(0.3)) body.material.tangent_speed = r.uniform(-2, 2);
    if (r.chance(0.3)) body.material.rolling_resistance = r.uniform(0, 1);
    if (r.chance(0.3)) body.one_way = {r.uniform(-1, 1), 1};
    if (r.chance(0.3)) body.filter = {4, 6, -2};
    body.sensor = r.chance(0.2);
    if (auto* compound = std::get_if<CompoundShape>(&body.shape)) {
      compound->parts[1].friction = 0.25;
      compound->parts[1].filter = Filter{2, 3, 1};
      compound->parts[2].sensor = true;
      compound->parts[0].one_way = Vec2{1, 0};
      compound->parts[0].tangent_speed = 3;
    }
    SCOPED_TRACE(n);
    expect_round_trip(body, n);
  }
}

TEST(BodyShapes, AreTheShapesThatWereGiven) {
  auto world = make(unbounded(100, {0, 0}));
  const auto only_part = [&](const BodyDesc& body) {
    const std::vector<ShapePart> parts = world->shapes_of(add(*world, body));
    EXPECT_EQ(parts.size(), 1u);
    return parts.at(0);
  };
  for (const BodyType type : {BodyType::dynamic_body, BodyType::static_body, BodyType::kinematic_body}) {
    BodyDesc body{.type = type, .position = {3, 4}, .angle = 0.5, .material = {2, 0.5, 0.25}, .filter = {2, 5, 1}};
    body.shape = DiscShape{0.5};
    const ShapePart round = only_part(body);
    EXPECT_EQ(std::get<DiscShape>(round.shape).radius, 0.5);
    EXPECT_EQ(round.position, Vec2{});
    EXPECT_EQ(round.restitution, 0.5);
    EXPECT_EQ(round.friction, 0.25);
    EXPECT_EQ(round.filter, body.filter);
    EXPECT_EQ(round.sensor, false);
    EXPECT_EQ(round.one_way, Vec2{});
    EXPECT_EQ(round.density.has_value(), type == BodyType::dynamic_body);
    EXPECT_NEAR(round.density.value_or(2), 2, 1e-6);

    body.shape = BoxShape{2, 1, 0.25};
    const ShapePart box = only_part(body);
    const auto& corners = std::get<PolygonShape>(box.shape);
    ASSERT_EQ(corners.vertices.size(), 4u);
    EXPECT_EQ(corners.radius, 0.25);
    EXPECT_NEAR(box.position.x, -1, 1e-6);
    EXPECT_NEAR(box.position.y, -0.5, 1e-6);
    EXPECT_NEAR(corners.vertices[2].x, 2, 1e-6);
    EXPECT_NEAR(corners.vertices[2].y, 1, 1e-6);

    body.shape = CapsuleShape{{1, 0}, {2, 1}, 0.5};
    const ShapePart capsule = only_part(body);
    EXPECT_EQ(std::get<CapsuleShape>(capsule.shape).radius, 0.5);
    EXPECT_NEAR(capsule.position.x, 1, 1e-6);
    EXPECT_NEAR(std::get<CapsuleShape>(capsule.shape).p2.y, 1, 1e-6);

    body.shape = SegmentShape{{1, 0}, {2, 1}};
    EXPECT_NEAR(std::get<SegmentShape>(only_part(body).shape).p2.x, 1, 1e-6);
    if (type == BodyType::dynamic_body) continue;
    for (const bool loop : {false, true}) {
      body.shape = ChainShape{{{0, 0}, {4, 1}, {4, 3}, {1, 2}}, loop, {}};
      const ShapePart line = only_part(body);
      const auto& chain = std::get<ChainShape>(line.shape);
      EXPECT_EQ(chain.loop, loop);
      ASSERT_EQ(chain.vertices.size(), 4u);
      EXPECT_NEAR(line.position.x, 0, 1e-6);
      EXPECT_NEAR(chain.vertices[3].x, 1, 1e-6);
      EXPECT_NEAR(chain.vertices[3].y, 2, 1e-6);
    }
  }
  EXPECT_TRUE(world->shapes_of({99, 0}).empty());
  EXPECT_FALSE(world->bounds_of_part({99, 0}, 0));
  EXPECT_FALSE(out_of_memory());
}

TEST(BodyShapes, SegmentsWithMaterialsAreParts) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body}) {
    BodyDesc body{.type = type, .position = {3, 4}, .angle = 1};
    ChainShape chain{{{0, 0}, {4, 1}, {4, 3}}, false, {}};
    chain.materials = {{1, 0, 0.5, 0, 0}, {1, 0.5, 0.25, 2, 0}};
    body.shape = chain;
    auto world = make(unbounded(100, {0, 0}));
    const std::vector<ShapePart> parts = world->shapes_of(add(*world, body));
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_TRUE(std::holds_alternative<SegmentShape>(parts[1].shape));
    EXPECT_EQ(parts[0].friction, 0.5);
    EXPECT_EQ(parts[1].friction, 0.25);
    EXPECT_EQ(parts[1].tangent_speed, 2);
    EXPECT_NEAR(parts[1].position.x, 4, 1e-6);
    expect_round_trip(body, 5);
  }
}

// Bodies that moved, fell asleep, are disabled, or changed their traits.
TEST(BodyShapes, AreToldAtAnyTime) {
  Random r(3);
  auto world = make(walled({-20, 0, 20, 40}, {0, -kG}, {1, 0, 0.5}));
  for (int k = 0; k < 60; ++k) {
    BodyDesc body = body_of_any_shape(r, {-18 + 2.4 * (k % 15), 1 + 2.4 * (k / 15)});
    if (k % 7 == 0) body.type = BodyType::static_body;
    if (k % 11 == 0) body.enabled = false;
    add(*world, body);
  }
  std::vector<std::vector<ShapePart>> first;
  for (std::uint32_t k = 0; k < 60; ++k) first.push_back(world->shapes_of(world->id_of(k)));
  run(*world, 400);
  bool asleep = false;
  for (std::uint32_t k = 0; k < 60; ++k) {
    const BodyId id = world->id_of(k);
    asleep = asleep || (!world->is_awake(id) && world->is_enabled(id));
    const std::vector<ShapePart> now = world->shapes_of(id);
    ASSERT_EQ(now.size(), first[k].size());
    for (std::size_t n = 0; n < now.size(); ++n) {
      EXPECT_EQ(now[n].position, first[k][n].position);
      EXPECT_EQ(now[n].density, first[k][n].density);
    }
  }
  EXPECT_TRUE(asleep);
  const BodyId id = world->id_of(1);
  BodyTraits t = world->traits(id).value();
  t.friction = 0.125, t.mass *= 2, t.filter.category = 8;
  ASSERT_TRUE(world->set_traits(id, t));
  const ShapePart part = world->shapes_of(id).at(0);
  EXPECT_EQ(part.friction, 0.125);
  EXPECT_EQ(part.filter->category, 8u);
  EXPECT_NEAR(*part.density, 2 * *first[1][0].density, 1e-5 * *part.density);
}

// Across the seam of a periodic world, too.
TEST(BodyShapes, ReachOverASeam) {
  auto world = make(periodic(40, 40));
  BodyDesc body{.type = BodyType::static_body, .position = {39, 1}, .angle = 0.3};
  body.shape = ChainShape{{{-2, -2}, {3, 0}, {1, 3}}, true, {}};
  const BodyId id = add(*world, body);
  const ShapePart part = world->shapes_of(id).at(0);
  EXPECT_NEAR(part.position.x, -2, 1e-6);
  EXPECT_NEAR(part.position.y, -2, 1e-6);
  const Bounds want = shape_bounds(body.shape, {body.position, body.angle}).value();
  for (const Bounds& box : {world->bounds_of_part(id, 0).value(), world->bounds_of(id).value()}) {
    EXPECT_NEAR(box.xmin, want.xmin, 1e-6);
    EXPECT_NEAR(box.ymin, want.ymin, 1e-6);
    EXPECT_NEAR(box.xmax, want.xmax, 1e-6);
    EXPECT_NEAR(box.ymax, want.ymax, 1e-6);
  }
}

}  // namespace
}  // namespace psim::test
