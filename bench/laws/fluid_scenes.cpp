#include "fluid_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include "course.h"
#include "scenes.h"
#include "shapes.h"

namespace psim::laws {
namespace {

constexpr double kPi = std::numbers::pi;

void add(Scene& scene, BodyDesc body, const char* name = "") {
  scene.bodies.push_back(std::move(body));
  scene.body_names.emplace_back(name);
}

// Four boxes, as thick as asked, around the pen.
void add_plates(Scene& scene, double thick, const Material& material) {
  const double at = kPen + thick / 2, length = 2 * (kPen + thick);
  for (const double side : {-at, at}) {
    add(scene, fixed_of(BoxShape{length, thick, 0}, {0, side}, material));
    add(scene, fixed_of(BoxShape{thick, length, 0}, {side, 0}, material));
  }
}

void add_lines(Scene& scene, const Material& material) {
  const std::array<Vec2, 4> corners = {Vec2{-kPen, -kPen}, {kPen, -kPen}, {kPen, kPen}, {-kPen, kPen}};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    add(scene, fixed_of(SegmentShape{corners[k], corners[(k + 1) % corners.size()]}, {}, material));
  }
}

void add_vessel(Draw& draw, Scene& scene, const FluidScope& scope) {
  const Material material = draw_material(draw);
  ChainShape loop{{{-kPen, kPen}, {-kPen, -kPen}, {kPen, -kPen}, {kPen, kPen}}, true};
  if (draw.chance(0.5)) loop.vertices = {loop.vertices.rbegin(), loop.vertices.rend()};
  switch (draw.below(scope.walls ? 7 : 5)) {
    case 0:
      return add(scene, fixed_of(loop, {}, material));
    case 1:
      loop.loop = !scope.open;
      return add(scene, fixed_of(loop, {}, material));
    case 2:
      return add_plates(scene, 1, material);
    case 3:
      return add_plates(scene, draw.logarithmic(0.02, 0.5), material);
    case 4:
      return add_lines(scene, material);
    default:
      scene.world.bounds = {-kPen, -kPen, kPen, kPen};
      scene.world.boundary = Boundary::walls;
      scene.world.wall = material;
  }
}

// A hill or a step on the floor.
BodyDesc draw_hill(Draw& draw, const Material& material) {
  const double at = draw.uniform(-4, 4), half = draw.uniform(0.5, 2), high = draw.uniform(0.3, 2);
  const double flat = draw.chance(0.3) ? half : draw.uniform(0.1, 0.9) * half;
  if (draw.chance(0.3)) {
    ChainShape line{{{-half, 0}, {-flat, high}, {flat, high}, {half, 0}}, false};
    return fixed_of(line, {at, -kPen}, material);
  }
  return fixed_of(PolygonShape{{{-half, 0}, {half, 0}, {flat, high}, {-flat, high}}, 0}, {at, -kPen}, material);
}

// A line from one side of the pen to the other one.
BodyDesc draw_slope(Draw& draw, const Material& material) {
  const double left = draw.uniform(-kPen, -2), right = draw.uniform(-kPen, -2);
  if (draw.chance(0.5)) return fixed_of(SegmentShape{{-kPen, left}, {kPen, right}}, {}, material);
  ChainShape line{{{-kPen, left}, {draw.uniform(-3, 3), draw.uniform(-5.5, -3)}, {kPen, right}}, false};
  return fixed_of(line, {}, material);
}

// Something in the middle, which may turn or go to and fro if the law lets it.
BodyDesc draw_obstacle(Draw& draw, const FluidScope& scope, const Material& material) {
  const double r = draw.uniform(0.3, 2);
  const Shape shape = draw.chance(0.3) ? draw_compound(draw, r) : draw_shape(draw, r);
  BodyDesc body = fixed_of(shape, {draw.uniform(-3, 3), draw.uniform(-3, 1)}, material);
  body.angle = draw.uniform(-kPi, kPi);
  if (draw.chance(0.3)) body.type = BodyType::kinematic_body;
  if (!scope.driven || !draw.chance(0.5)) return body;
  body.type = BodyType::kinematic_body;
  body.angular_velocity = draw.uniform(-3, 3);
  return body;
}

void add_obstacles(Draw& draw, Scene& scene, const FluidScope& scope) {
  const Material material = draw_material(draw);
  for (int k = draw.below(3); k > 0; --k) {
    switch (draw.below(5)) {
      case 0:
      case 1:
        add(scene, draw_hill(draw, material));
        break;
      case 2:
        add(scene, draw_slope(draw, material));
        break;
      default:
        add(scene, draw_obstacle(draw, scope, material));
    }
  }
  if (!draw.chance(0.15)) return;
  for (BodyDesc& b : scene.bodies) {
    if (b.type == BodyType::static_body) b.type = BodyType::kinematic_body;
  }
}

FluidPolygon draw_area(Draw& draw, Vec2 at, double r) {
  FluidPolygon polygon;
  const int corners = draw.from(3, 7);
  const double begin = draw.uniform(0, 2 * kPi);
  for (int k = 0; k < corners; ++k) {
    const double angle = begin + 2 * kPi * k / corners, far = r * draw.uniform(0.5, 1);
    polygon.vertices.push_back({at.x + far * std::cos(angle), at.y + far * std::sin(angle)});
  }
  return polygon;
}

// A disc or a polygon within r of a place.
SceneFluid draw_lump(Draw& draw, Vec2 at, double r) {
  SceneFluid fluid;
  if (draw.chance(0.5)) {
    fluid.place = FluidDisc{at, r};
  } else {
    fluid.place = draw_area(draw, at, r);
  }
  return fluid;
}

double area_of(const SceneFluid& fluid) {
  if (const auto* b = std::get_if<Bounds>(&fluid.place)) return (b->xmax - b->xmin) * (b->ymax - b->ymin);
  if (const auto* d = std::get_if<FluidDisc>(&fluid.place)) return kPi * d->radius * d->radius;
  if (const auto* p = std::get_if<FluidPolygon>(&fluid.place)) return laws::area_of(PolygonShape{p->vertices, 0});
  return static_cast<double>(std::get<FluidList>(fluid.place).x.size()) * fluid.fluid.spacing * fluid.fluid.spacing;
}

// How many particles there are, and what they are made of. Spacings are such that a lattice shifted by whole metres has
// the same bits.
void draw_liquids(Draw& draw, Scene& scene, const FluidScope& scope) {
  double area = 0;
  for (const SceneFluid& f : scene.fluids) area += area_of(f);
  const double spacing = std::sqrt(area / draw.logarithmic(250, 2500));
  for (std::size_t k = 0; k < scene.fluids.size(); ++k) {
    FluidDesc& f = scene.fluids[k].fluid;
    f.spacing = std::ceil(0x1p12 * spacing) * 0x1p-12;
    f.density = draw.chance(0.5) ? 1000 : draw.logarithmic(300, 3000);
    if (k > 0) f.density = scene.fluids[0].fluid.density * draw.logarithmic(0.2, 5);
    if (draw.chance(0.3)) f.viscosity = draw.logarithmic(1e-3, 1);
    if (scope.tension && draw.chance(0.25)) f.surface_tension = draw.logarithmic(1, 300);
    if (draw.chance(0.5)) continue;
    const double way = draw.uniform(0, 2 * kPi), fast = draw.logarithmic(scope.fluid_speed / 1000, scope.fluid_speed);
    scene.fluids[k].velocity = {fast * std::cos(way), fast * std::sin(way)};
  }
}

// A pool, a dam or a lump that falls, from the floor or from `right` leftwards; sometimes a second one above it.
void add_fluids(Draw& draw, Scene& scene, const FluidScope& scope, double right) {
  const double wide = right + kPen;
  SceneFluid first;
  double top = 0;
  if (draw.chance(0.7)) {
    const double reach = draw.chance(0.5) ? wide : draw.uniform(0.2, 0.8) * wide;
    top = draw.uniform(-5, 1);
    first.place = Bounds{right - reach, -kPen, right, top};
  } else {
    const double r = draw.uniform(0.8, 0.2 * wide), y = draw.uniform(-kPen + r, 0);
    first = draw_lump(draw, {right - r - draw.uniform(0, wide - 2 * r), y}, r);
    top = y + r;
  }
  scene.fluids.push_back(first);
  if (draw.chance(0.35)) {
    SceneFluid second;
    if (const auto* b = std::get_if<Bounds>(&first.place); b != nullptr && draw.chance(0.5)) {
      second.place = Bounds{b->xmin, top, b->xmax, top + draw.uniform(0.5, 2)};
    } else {
      const double r = draw.uniform(0.5, 0.15 * wide);
      second = draw_lump(draw, {right - r - draw.uniform(0, wide - 2 * r), top + r + draw.uniform(0.3, 1)}, r);
    }
    scene.fluids.push_back(second);
  }
  draw_liquids(draw, scene, scope);
}

// Whether a body of this reach has room there beside the bodies from `first` on: circles around them do not touch it, and
// it lies above all slopes.
bool fits(const Scene& scene, std::size_t first, Vec2 at, double reach) {
  for (std::size_t k = first; k < scene.bodies.size(); ++k) {
    const BodyDesc& b = scene.bodies[k];
    const bool line = std::holds_alternative<SegmentShape>(b.shape) || std::holds_alternative<ChainShape>(b.shape);
    if (line && at.y - reach < -2) return false;
    if (!line && std::hypot(at.x - b.position.x, at.y - b.position.y) < reach_of(b.shape) + reach + 0.01) return false;
  }
  return true;
}

// Bodies of all shapes that move, beside those from `first` on.
void add_floats(Draw& draw, Scene& scene, const FluidScope& scope, Bounds within, std::size_t first) {
  const double density = scene.fluids[0].fluid.density;
  for (int k = draw.below(6); k > 0; --k) {
    const double r = draw.logarithmic(0.15, 0.9);
    Material material = draw_material(draw);
    material.density = density * draw.logarithmic(0.1, 4);
    const Shape shape = draw.chance(0.2) ? draw_compound(draw, r) : draw_shape(draw, r);
    for (int attempt = 0; attempt < 20; ++attempt) {
      const double room = r + 0.05;
      const Vec2 at{draw.uniform(within.xmin + room, within.xmax - room),
                    draw.uniform(within.ymin + room, within.ymax - room)};
      if (!fits(scene, first, at, r)) continue;
      add(scene, mover_of(draw, shape, at, draw.chance(0.5) ? 0 : scope.body_speed, 3, material));
      break;
    }
  }
}

// A wall from the floor to the lid, whose left side is at x.
BodyDesc draw_partition(Draw& draw, double x) {
  const Material material = draw_material(draw);
  switch (draw.below(3)) {
    case 0:
      return fixed_of(SegmentShape{{0, -kPen}, {0, kPen}}, {x, 0}, material);
    case 1:
      return fixed_of(ChainShape{{{0, kPen}, {0, draw.uniform(-3, 3)}, {0, -kPen}}, false}, {x, 0}, material);
    default: {
      const double thick = draw.logarithmic(0.02, 0.5);
      return fixed_of(BoxShape{thick, 2 * kPen, 0}, {x + thick / 2, 0}, material);
    }
  }
}

// A lump of fluid and bodies above ground that ends at both sides.
Scene fluid_on_terrain(Draw& draw, const FluidScope& scope) {
  Scene scene = space(true);
  const double r = draw.uniform(0.8, 2), at = draw.uniform(-2, 2);
  scene.fluids.push_back(draw_lump(draw, {at, 3.5 + r}, r));
  draw_liquids(draw, scene, scope);
  add_floats(draw, scene, scope, {-4, 3, 4, 10}, 0);
  add_terrain(draw, scene, draw_material(draw));
  return scene;
}

}  // namespace

Scene fluid_scene(Draw& draw, const FluidScope& scope) {
  if (scope.open && draw.chance(0.2)) return fluid_on_terrain(draw, scope);
  Scene scene = space(true);
  add_vessel(draw, scene, scope);
  const std::size_t vessel = scene.bodies.size();
  add_obstacles(draw, scene, scope);
  add_fluids(draw, scene, scope, kPen);
  add_floats(draw, scene, scope, {-kPen, -kPen, kPen, kPen}, vessel);
  return scene;
}

Scene fluid_adrift(Draw& draw) {
  Scene scene = space(false);
  const double r = draw.uniform(0.5, 2);
  const double fast = draw.logarithmic(0.3, 10);
  scene.fluids.push_back(draw_lump(draw, {-r - 1, 0}, r));
  if (draw.chance(0.3)) scene.fluids.push_back(draw_lump(draw, {-r - 1, 1.5 * r}, r / 3));
  if (draw.chance(0.3)) scene.fluids[0].place = Bounds{-2 * r - 1, -r / 2, -1, r / 2};
  draw_liquids(draw, scene, {.fluid_speed = 0.5});
  for (SceneFluid& f : scene.fluids) f.velocity.x = fast;
  add_floats(draw, scene, {.body_speed = 1}, {-0.9, -2, 4, 2}, 0);
  return scene;
}

Scene fast_fluid_pen(Draw& draw) {
  const FluidScope scope{.open = false, .fluid_speed = 1000, .body_speed = 100};
  Scene scene = space(draw.chance(0.7));
  add_vessel(draw, scene, scope);
  const bool parted = draw.chance(0.4);
  const double right = parted ? draw.uniform(-1, 4) : kPen;
  if (parted) add(scene, draw_partition(draw, right), kPartition);
  const std::size_t first = scene.bodies.size();
  if (!parted) add_obstacles(draw, scene, scope);
  add_fluids(draw, scene, scope, right);
  add_floats(draw, scene, scope, {-kPen, -kPen, right, kPen}, first);
  return scene;
}

Scene with_particles(const Scene& scene) {
  Scene out = scene;
  std::vector<FluidParticleState> particles;
  world_of(scene)->fluid_particles(particles);
  for (SceneFluid& f : out.fluids) f.place = FluidList{};
  for (const FluidParticleState& p : particles) {
    auto& list = std::get<FluidList>(out.fluids[p.fluid].place);
    list.x.push_back(p.position.x), list.y.push_back(p.position.y);
  }
  return out;
}

double fluid_area(const Scene& scene) {
  double area = 0;
  for (const SceneFluid& f : scene.fluids) area += area_of(f);
  return area;
}

}  // namespace psim::laws
