// Basins made of many boxes, into which bodies fall. Figures of E. Catto's benchmarks of Box2D 3.
#include <algorithm>
#include <numbers>
#include <utility>

#include "base/rotor.h"
#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

// The ground that both scenes have: boxes that overlap a little, one a metre, as a single static body.
// The floor is 1 m thick about y = 0 and reaches from -half to half; sides stand on its ends.
CompoundShape basin(int half, int height) {
  CompoundShape shape;
  for (int x = -half; x <= half; ++x) shape.parts.push_back(part_of(BoxShape{1.1, 1, 0}, {static_cast<double>(x), 0}));
  for (const int x : {-half, half}) {
    for (int y = 1; y <= height; ++y) {
      shape.parts.push_back(part_of(BoxShape{1, 1.1, 0}, {static_cast<double>(x), static_cast<double>(y)}));
    }
  }
  return shape;
}

std::uint64_t add_basin(Scene& scene, CompoundShape shape) {
  BodyDesc ground = rigid(std::move(shape), {0, 0});
  ground.type = BodyType::static_body;
  const std::uint64_t id = add(scene, ground);
  scene.body_names.back() = "ground";
  return id;
}

// n bodies in rows of `columns`, from the corner (x, y) up; odd rows are shifted by `stagger`, even ones back.
void put_rows(GroupDesc& group, std::uint64_t n, std::uint64_t columns, Vec2 at, Vec2 pitch, double stagger) {
  for (std::uint64_t k = 0; k < n; ++k) {
    const std::uint64_t row = k / columns;
    put(group, at.x + pitch.x * static_cast<double>(k % columns) + (row % 2 == 0 ? -stagger : stagger),
        at.y + pitch.y * static_cast<double>(row));
  }
}

// A pentagon of unequal sides: corners on a circle, each turned from the last by the golden angle.
PolygonShape scrap(double radius) {
  constexpr double kGoldenAngle = std::numbers::pi * (3 - 2.23606797749979);
  PolygonShape shape;
  for (const int k : {0, 2, 4, 1, 3}) {  // counter-clockwise
    const SineCosine at = sine_cosine(-kGoldenAngle * k);
    shape.vertices.push_back({radius * at.cosine, radius * at.sine});
  }
  return shape;
}

// A blade of 4 x 8 m and 1000 t on a slide along the floor, tied to its middle by a spring. It swings
// 60 m to either side in 31 s, and scrap of a tonne in all hardly slows it down.
void add_blade(Scene& scene, std::uint64_t ground) {
  constexpr double kReach = 60, kRate = 0.2;  // m, rad/s
  const Vec2 middle{0, 4};
  BodyDesc blade = rigid(BoxShape{4, 8, 0}, middle);
  blade.mass = 1e6;
  blade.gravity_scale = 0;
  blade.velocity = {kReach * kRate, 0};
  const std::uint64_t id = add(scene, blade);
  scene.body_names.back() = "blade";
  SceneJoint slide;
  slide.a = ground;
  slide.b = id;
  slide.joint.type = JointType::prismatic;
  slide.joint.anchor_a = middle;
  scene.joints.push_back(slide);
  SceneJoint spring = slide;
  spring.joint.type = JointType::spring;
  spring.joint.length = 0;
  spring.joint.stiffness = kRate * kRate * blade.mass;
  scene.joints.push_back(spring);
}

}  // namespace

// Box2D's benchmark: 20 columns of 150 bodies, each of two triangles that overlap, 2.25 m apart.
Scene compounds(std::uint64_t n, std::uint64_t) {
  constexpr std::uint64_t kColumns = 20;
  const double rows = static_cast<double>((n + kColumns - 1) / kColumns);
  Scene scene = open_scene({-810, -90, 810, std::max(120.0, 2.25 * rows + 20)});
  CompoundShape ground = basin(40, 100);
  // What falls over the sides lands on a line far below.
  ground.parts.push_back(part_of(SegmentShape{{-800, -80}, {800, -80}}));
  add_basin(scene, std::move(ground));

  CompoundShape triangles;
  triangles.parts.push_back(part_of(PolygonShape{{{-1, 0}, {0.5, 1}, {0, 2}}, 0}));
  triangles.parts.push_back(part_of(PolygonShape{{{1, 0}, {0, 2}, {-0.5, 1}}, 0}));
  GroupDesc bodies = list_of(std::move(triangles), {1, 0, 0.5});
  put_rows(bodies, n, kColumns, {-19, 5.575}, {2, 2.25}, -0.25);
  scene.groups.push_back(std::move(bodies));
  return scene;
}

// Box2D's benchmark: 200 columns of 40 pentagons of 0.5 m, and a blade that pushes them to and fro.
Scene junkyard(std::uint64_t n, std::uint64_t) {
  constexpr std::uint64_t kColumns = 200;
  const double rows = static_cast<double>((n + kColumns - 1) / kColumns);
  Scene scene = open_scene({-100, -20, 100, std::max(80.0, rows + 30)});
  const std::uint64_t ground = add_basin(scene, basin(80, 50));
  add_blade(scene, ground);
  GroupDesc pieces = list_of(scrap(0.25));
  put_rows(pieces, n, kColumns, {-75, 15}, {0.75, 1}, 0.1);
  scene.groups.push_back(std::move(pieces));
  return scene;
}

}  // namespace psim::builtin
