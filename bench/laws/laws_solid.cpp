// L9 and L10: what is solid keeps bodies out.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "course.h"
#include "law.h"
#include "scenes.h"
#include "shapes.h"

namespace psim::laws {
namespace {

// Makes the walls of a pen kinematic: the host holds them, and does not move them.
void hold_walls(Scene& scene) {
  for (BodyDesc& b : scene.bodies) {
    if (b.type == BodyType::static_body) b.type = BodyType::kinematic_body;
  }
}

// Turns some bodies into thin sticks that spin.
void add_sticks(Draw& draw, Scene& scene) {
  for (BodyDesc& b : scene.bodies) {
    if (b.type != BodyType::dynamic_body || !draw.chance(0.3)) continue;
    b.shape = BoxShape{draw.uniform(0.3, 1), draw.logarithmic(0.01, 0.1), 0};
    b.angular_velocity = draw.uniform(-300, 300);
  }
}

// Bodies that pass each other in a pen, so that the walls alone are asked; sometimes a heavy one presses on them.
Scene fast_pen(Draw& draw) {
  Scene scene = space(draw.chance(0.3));
  scene.world.bounds = {-2e5, -2e5, 2e5, 2e5};
  Material wall = draw_material(draw);
  wall.restitution = draw.one_of(std::array{0.0, 0.5, 0.95, 1.0});
  add_pen(draw, scene, wall);
  const double speed = draw.logarithmic(10, 1e4);
  const bool through = draw.chance(0.6);
  fill_pen(draw, scene, draw.from(1, 20), speed, false, nullptr);
  if (draw.chance(0.2)) add_sticks(draw, scene);
  if (draw.chance(0.2)) hold_walls(scene);
  for (BodyDesc& b : scene.bodies) {
    if (b.type == BodyType::dynamic_body && through) b.filter.group = -1;
  }
  if (!through && draw.chance(0.5)) {
    BodyDesc press = body_of(BoxShape{11, 0.8, 0}, {0, 5.4}, draw_dull(draw));
    press.velocity = {0, -draw.logarithmic(5, 200)};
    press.mass = draw.logarithmic(10, 1e4);
    for (BodyDesc& b : scene.bodies) {  // those below it stay below
      if (b.type == BodyType::dynamic_body) {
        b.position.y = -5.8 + (b.position.y + 5.8) * 0.8;
        b.velocity = {0, 0};
      }
    }
    scene.bodies.push_back(press);
    scene.body_names.emplace_back();
  }
  return scene;
}

std::optional<Fault> nobody_passes(const Scene& scene) {
  std::optional<Fault> fault;
  const auto look = [&](World& world, int frame) {
    for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) {
      const BodyDesc& desc = scene.bodies[id];
      if (desc.type != BodyType::dynamic_body) continue;
      const auto b = world.body(world.id_of(id));
      const auto inside = [](Vec2 at) { return std::fabs(at.x) <= 6.1 && std::fabs(at.y) <= 6.1; };
      if (b && std::ranges::all_of(places_of(desc.shape, *b), inside)) continue;
      fault = Fault{frame, b ? fmt::format("body {} left its pen: it is at {:.4g}, {:.4g} m", id, b->x, b->y)
                             : fmt::format("body {} left the world", id)};
      return false;
    }
    return true;
  };
  course_of(scene, 180, look);
  return fault;
}

Scene heap(Draw& draw) {
  Scene scene = space(true);
  const Material ground = draw_dull(draw);
  if (draw.chance(0.5)) {
    add_pen(draw, scene, ground);
  } else {
    add_terrain(draw, scene, ground);
  }
  const int count = draw.from(1, 30);
  const double high = draw.chance(0.5) ? 0 : 3;
  const std::size_t fixed = scene.bodies.size();
  fill_pen(draw, scene, count, 2, false, nullptr);
  for (std::size_t id = fixed; id < scene.bodies.size(); ++id) {
    scene.bodies[id].material = draw_dull(draw);
    if (scene.world.boundary == Boundary::open && fixed > 4) scene.bodies[id].position.y += 9 + high;
    if (fixed < 4 && scene.world.boundary == Boundary::open) scene.bodies[id].position.y += 9 + high;
  }
  return scene;
}

// Deeper than 1 % of the smaller body's size for longer than 0.2 s.
std::optional<Fault> nobody_overlaps(const Scene& scene) {
  constexpr int kLong = 12;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> deep;
  std::optional<Fault> fault;
  const auto size = [&](BodyId id) {
    const double inner = id == kNoBody ? 0 : inner_of(scene.bodies[id.index].shape);
    return inner > 0 ? 2 * inner : 1e300;
  };
  const auto look = [&](World& world, int frame) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> still;
    for (const Contact& c : world.contacts()) {
      const double share = -c.separation / std::min(size(c.a), size(c.b));
      if (!(share > 0.01)) continue;
      const std::pair pair{c.a.index, c.b.index};
      const int frames = deep[pair] + 1;
      still[pair] = frames;
      if (frames <= kLong) continue;
      fault = Fault{frame, fmt::format("bodies {} and {} overlap by {:.3g} of their size for {} frames", c.a.index,
                                       c.b == kNoBody ? -1 : static_cast<int>(c.b.index), share, frames)};
      return false;
    }
    deep = std::move(still);
    return true;
  };
  course_of(scene, 240, look);
  return fault;
}

}  // namespace

std::vector<Law> solid_laws() {
  return {{"L9", "nobody passes what is solid", Spare::movers, fast_pen, nobody_passes},
          {"L10", "nobody overlaps by over 1 % of its size for over 0.2 s", Spare::movers, heap, nobody_overlaps}};
}

}  // namespace psim::laws
