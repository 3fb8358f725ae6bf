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

// What holds the fluids of a scene.
struct Vessel {
  double floor = -kPen;  // m: nothing of it is higher than this between its sides
  bool thin = false;     // it is made of lines or thin plates
};

// A loop whose floor goes up and down.
Vessel add_rough_vessel(Draw& draw, Scene& scene, bool lid, const Material& material) {
  ChainShape loop{{{kPen, kPen}, {-kPen, kPen}}, true};
  if (!lid) loop = {{{-kPen, kPen}}, false};
  const int parts = draw.from(2, 12);
  double floor = -kPen;
  for (int k = 0; k <= parts; ++k) {
    loop.vertices.push_back({kPen * (2.0 * k / parts - 1), draw.uniform(-kPen, -kPen + 1.5)});
    floor = std::max(floor, loop.vertices.back().y);
  }
  if (!lid) loop.vertices.push_back({kPen, kPen});
  if (draw.chance(0.5)) loop.vertices = {loop.vertices.rbegin(), loop.vertices.rend()};
  add(scene, fixed_of(loop, {}, material));
  return {floor, true};
}

Vessel add_vessel(Draw& draw, Scene& scene, const FluidScope& scope) {
  const Material material = draw_material(draw);
  const bool lid = !scope.open || draw.chance(0.5);
  switch (draw.below(scope.walls ? 8 : 6)) {
    case 0: {
      ChainShape loop{{{-kPen, kPen}, {-kPen, -kPen}, {kPen, -kPen}, {kPen, kPen}}, lid};
      if (draw.chance(0.5)) loop.vertices = {loop.vertices.rbegin(), loop.vertices.rend()};
      add(scene, fixed_of(loop, {}, material));
      return {-kPen, true};
    }
    case 1:
      return add_rough_vessel(draw, scene, lid, material);
    case 2:
      add_plates(scene, draw.logarithmic(0.02, 0.5), material);
      return {-kPen, true};
    case 3:
      add_lines(scene, material);
      return {-kPen, true};
    case 4:
    case 5:
      add_plates(scene, 2, material);
      return {};
    default:
      scene.world.bounds = {-kPen, -kPen, kPen, kPen};
      scene.world.boundary = Boundary::walls;
      scene.world.wall = material;
      return {};
  }
}

// A hill, a step or a slope on the floor. A line has no inside, so that water would stand below it: these are solid.
BodyDesc draw_hill(Draw& draw, const Material& material) {
  if (draw.chance(0.3)) {
    const double left = draw.uniform(0.3, 3), right = draw.uniform(0.3, 3);
    return fixed_of(PolygonShape{{{-kPen, 0}, {kPen, 0}, {kPen, right}, {-kPen, left}}, 0}, {0, -kPen}, material);
  }
  const double at = draw.uniform(-4, 4), half = draw.uniform(0.5, 2), high = draw.uniform(0.3, 2);
  const double flat = draw.chance(0.3) ? half : draw.uniform(0.1, 0.9) * half;
  return fixed_of(PolygonShape{{{-half, 0}, {half, 0}, {flat, high}, {-flat, high}}, 0}, {at, -kPen}, material);
}

// A line in the middle, open to both sides.
BodyDesc draw_shelf(Draw& draw, const Material& material) {
  const double half = draw.uniform(0.5, 2.5), rise = draw.uniform(-1, 1);
  const Vec2 at{draw.uniform(-1.5, 1.5), draw.uniform(-2.5, 1)};
  if (draw.chance(0.5)) return fixed_of(SegmentShape{{-half, -rise}, {half, rise}}, at, material);
  return fixed_of(ChainShape{{{-half, -rise}, {0, draw.uniform(-1, 1)}, {half, rise}}, false}, at, material);
}

// Something in the middle, which may turn if the law lets it.
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
        add(scene, draw_shelf(draw, material));
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
  const double spacing = std::sqrt(area / draw.logarithmic(300, 2500));
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

// Moves the edges of areas away from lines: beside one, particles would be moved by its width at the start.
void keep_apart(Scene& scene, double right, double floor) {
  for (SceneFluid& f : scene.fluids) {
    auto* b = std::get_if<Bounds>(&f.place);
    const double gap = 0.75 * scene.fluids[0].fluid.spacing;
    if (b == nullptr) continue;
    *b = {std::max(b->xmin, -kPen + gap), std::max(b->ymin, floor + gap), std::min(b->xmax, right - gap), b->ymax};
  }
}

// A pool, a dam or a lump that falls, from the floor or from `right` leftwards; sometimes a second one above it.
void add_fluids(Draw& draw, Scene& scene, const FluidScope& scope, const Vessel& vessel, double right) {
  const double wide = right + kPen;
  SceneFluid first;
  double top = 0;
  if (draw.chance(0.7)) {
    const double reach = draw.chance(0.5) ? wide : draw.uniform(0.2, 0.8) * wide;
    top = draw.uniform(vessel.floor + 1, 1);
    first.place = Bounds{right - reach, vessel.floor, right, top};
  } else {
    const double r = draw.uniform(0.8, 0.2 * wide), y = draw.uniform(vessel.floor + r, 0);
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
  if (vessel.thin && !scope.beside) keep_apart(scene, right, vessel.floor);
}

// Whether a body of this reach has room there beside the bodies from `first` on: circles around them do not touch it,
// and it lies above a slope.
bool fits(const Scene& scene, std::size_t first, Vec2 at, double reach) {
  for (std::size_t k = first; k < scene.bodies.size(); ++k) {
    const BodyDesc& b = scene.bodies[k];
    const double far = reach_of(b.shape);
    const bool slope = far > kPen;  // at most 3 m high
    if (slope ? at.y - reach < -kPen + 3 : std::hypot(at.x - b.position.x, at.y - b.position.y) < far + reach + 0.01) {
      return false;
    }
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
  const Vessel vessel = add_vessel(draw, scene, scope);
  const std::size_t first = scene.bodies.size();
  add_obstacles(draw, scene, scope);
  add_fluids(draw, scene, scope, vessel, kPen);
  add_floats(draw, scene, scope, {-kPen, vessel.floor, kPen, kPen}, first);
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
  const FluidScope scope{.open = false, .beside = true, .fluid_speed = 1000, .body_speed = 100};
  Scene scene = space(draw.chance(0.7));
  const Vessel vessel = add_vessel(draw, scene, scope);
  const bool parted = draw.chance(0.4);
  const double right = parted ? draw.uniform(-1, 4) : kPen;
  if (parted) add(scene, draw_partition(draw, right), kPartition);
  const std::size_t first = scene.bodies.size();
  if (!parted) add_obstacles(draw, scene, scope);
  add_fluids(draw, scene, scope, vessel, right);
  add_floats(draw, scene, scope, {-kPen, vessel.floor, right, kPen}, first);
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
