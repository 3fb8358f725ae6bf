// Geometry and the parts of bodies in C: the answers of C++, and what is said of wrong arguments.
#include <vector>

#include "c_api_support.h"
#include "psim/geometry.h"

namespace psim::test {
namespace {

psim_pose pose(double x, double y, double angle) { return {{x, y}, angle}; }

TEST(CGeometry, HasTheAnswersOfCpp) {
  const psim_vec2 corners[] = {{0, 0}, {2, 0}, {1, 2}};
  const psim_shape triangle = psim_polygon(corners, 3), box = psim_box(2, 1);
  const PolygonShape cpp_triangle{{{0, 0}, {2, 0}, {1, 2}}, 0};
  const BoxShape cpp_box{2, 1, 0};

  psim_bounds bounds{};
  ASSERT_EQ(psim_shape_bounds(&triangle, pose(3, 4, 0.5), &bounds), PSIM_OK);
  const Bounds want = shape_bounds(cpp_triangle, {{3, 4}, 0.5}).value();
  EXPECT_EQ(bounds.xmin, want.xmin);
  EXPECT_EQ(bounds.ymax, want.ymax);

  EXPECT_EQ(psim_shape_holds(&triangle, pose(0, 0, 0), {1, 1}), PSIM_OK);
  EXPECT_EQ(psim_shape_holds(&triangle, pose(0, 0, 0), {0, 1}), PSIM_NOTHING);

  psim_shape_hit hit{};
  ASSERT_EQ(psim_shape_ray_cast(&triangle, pose(0, 0, 0), {-5, 1}, {5, 1}, &hit), PSIM_OK);
  EXPECT_NEAR(hit.point.x, 0.5, 1e-12);
  EXPECT_LT(hit.normal.x, 0);
  EXPECT_EQ(psim_shape_ray_cast(&triangle, pose(0, 0, 0), {-5, 3}, {5, 3}, &hit), PSIM_NOTHING);

  psim_shape_gap gap{};
  ASSERT_EQ(psim_shape_distance(&triangle, pose(0, 0, 0), &box, pose(7, 1, 0.3), &gap), PSIM_OK);
  const ShapeGap near = shape_distance(cpp_triangle, {}, cpp_box, {{7, 1}, 0.3}).value();
  EXPECT_EQ(gap.distance, near.distance);
  EXPECT_EQ(gap.point_a.x, near.point_a.x);
  EXPECT_EQ(gap.point_b.y, near.point_b.y);
  EXPECT_EQ(gap.normal.x, near.normal.x);

  const psim_shape_move move{pose(0, 0, 0), {9, 0}, 2}, still{pose(7, 1, 0.3), {0, 0}, -1};
  ASSERT_EQ(psim_shape_cast(&triangle, move, &box, still, &hit), PSIM_OK);
  const ShapeHit met = shape_cast(cpp_triangle, {{}, {9, 0}, 2}, cpp_box, {{{7, 1}, 0.3}, {}, -1}).value();
  EXPECT_EQ(hit.fraction, met.fraction);
  EXPECT_EQ(hit.point.x, met.point.x);
  EXPECT_EQ(hit.normal.y, met.normal.y);

  const psim_vec2 points[] = {{0, 0}, {1, 0}, {1, 1}, {0.5, 0.2}, {0, 1}};
  psim_vec2 hull[3];
  size_t count = 0;
  ASSERT_EQ(psim_convex_hull(points, 5, 0, hull, 3, &count), PSIM_OK);
  EXPECT_EQ(count, 4u);
  EXPECT_EQ(hull[2].y, 1);
  EXPECT_EQ(psim_convex_hull(points, 2, 0, hull, 3, &count), PSIM_NOTHING);
  EXPECT_EQ(count, 0u);
}

TEST(CGeometry, RefusesWhatIsWrong) {
  const psim_shape disc = psim_disc(1), none = psim_shape_of_type(9), small = psim_disc(0);
  psim_bounds bounds{};
  psim_shape_hit hit{};
  psim_shape_gap gap{};
  size_t count = 0;
  const psim_shape_move move{pose(0, 0, 0), {1, 0}, 0};
  EXPECT_EQ(psim_shape_bounds(nullptr, pose(0, 0, 0), &bounds), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_bounds(&disc, pose(0, 0, 0), nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_bounds(&none, pose(0, 0, 0), &bounds), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_bounds(&small, pose(0, 0, 0), &bounds), PSIM_NOTHING);
  EXPECT_EQ(psim_shape_bounds(&disc, pose(kNaN, 0, 0), &bounds), PSIM_NOTHING);
  EXPECT_EQ(psim_shape_holds(nullptr, pose(0, 0, 0), {0, 0}), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_ray_cast(&disc, pose(0, 0, 0), {0, 0}, {1, 0}, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_distance(&disc, pose(0, 0, 0), nullptr, pose(0, 0, 0), &gap), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_shape_distance(&disc, pose(0, 0, 0), &small, pose(0, 0, 0), &gap), PSIM_NOTHING);
  EXPECT_EQ(psim_shape_cast(&disc, move, nullptr, move, &hit), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_convex_hull(nullptr, 3, 0, nullptr, 0, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_convex_hull(nullptr, 0, 0, nullptr, 0, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_convex_hull(nullptr, 0, 0, nullptr, 0, &count), PSIM_NOTHING);
}

TEST(CShapes, MakeTheBodyAgain) {
  CWorld world;
  const psim_vec2 corners[] = {{0, 0}, {2, 0}, {1, 2}}, line[] = {{0, 0}, {4, 1}, {4, 3}};
  psim_shape_part parts[2] = {};
  parts[0].shape = psim_polygon(corners, 3);
  parts[0].has_friction = 1, parts[0].friction = 0.5;
  parts[1].shape = psim_disc(0.5);
  parts[1].position = {3, 0};
  parts[1].has_sensor = parts[1].sensor = 1;
  psim_body_desc desc;
  psim_body_desc_init(&desc);
  desc.parts = parts, desc.part_count = 2;
  psim_body_id id{};
  ASSERT_EQ(psim_world_add_body(world.world, &desc, &id), PSIM_OK) << world.last();
  const psim_body_id chain = world.add(psim_chain(line, 3, 0), {10, 0}, PSIM_BODY_STATIC);

  const psim_shape_part* told = nullptr;
  size_t count = 0;
  ASSERT_EQ(psim_world_shapes_of(world.world, id, &told, &count), PSIM_OK);
  ASSERT_EQ(count, 2u);
  EXPECT_EQ(told[0].shape.type, PSIM_SHAPE_POLYGON);
  ASSERT_EQ(told[0].shape.vertex_count, 3u);
  EXPECT_NEAR(told[0].shape.vertices[2].y, 2, 1e-6);
  EXPECT_EQ(told[0].has_friction, 1);
  EXPECT_EQ(told[0].friction, 0.5);
  EXPECT_EQ(told[0].has_one_way, 1);
  EXPECT_EQ(told[1].shape.type, PSIM_SHAPE_DISC);
  EXPECT_NEAR(told[1].position.x, 3, 1e-6);
  EXPECT_EQ(told[1].sensor, 1);
  psim_bounds box{}, whole{};
  ASSERT_EQ(psim_world_bounds_of_part(world.world, id, 1, &box), PSIM_OK);
  EXPECT_NEAR(box.xmax, 3.5, 1e-6);
  EXPECT_EQ(psim_world_bounds_of_part(world.world, id, 2, &box), PSIM_NOTHING);

  desc.parts = told, desc.part_count = count;
  psim_body_id again{};
  ASSERT_EQ(psim_world_add_body(world.world, &desc, &again), PSIM_OK) << world.last();
  ASSERT_EQ(psim_world_bounds_of(world.world, id, &box), PSIM_OK);
  ASSERT_EQ(psim_world_bounds_of(world.world, again, &whole), PSIM_OK);
  EXPECT_NEAR(box.xmin, whole.xmin, 1e-6);
  EXPECT_NEAR(box.ymax, whole.ymax, 1e-6);

  ASSERT_EQ(psim_world_shapes_of(world.world, chain, &told, &count), PSIM_OK);
  ASSERT_EQ(count, 1u);
  EXPECT_EQ(told[0].shape.type, PSIM_SHAPE_CHAIN);
  EXPECT_EQ(told[0].shape.vertex_count, 3u);
  EXPECT_EQ(told[0].has_density, 0);

  EXPECT_EQ(psim_world_shapes_of(world.world, {99, 0}, &told, &count), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_shapes_of(world.world, id, nullptr, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_bounds_of_part(world.world, {99, 0}, 0, &box), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_bounds_of_part(world.world, id, 0, nullptr), PSIM_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace psim::test
