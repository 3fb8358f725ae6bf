#include "course.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shapes.h"

namespace psim::laws {

std::unique_ptr<World> world_of(const Scene& scene) {
  std::string error;
  auto world = build_world(scene, {best_isa(), 1}, error);
  if (!world) throw std::runtime_error("a drawn scene is refused: " + error);
  return world;
}

Course course_of(const Scene& scene, int frames, const std::function<bool(World&, int)>& each) {
  const auto world = world_of(scene);
  Course course;
  for (int frame = 0; frame <= frames; ++frame) {
    if (frame > 0) world->step();
    std::vector<BodyState> now = course.empty() ? std::vector<BodyState>(scene.bodies.size()) : course.back();
    for (std::uint32_t id = 0; id < now.size(); ++id) {
      if (const auto state = world->body(world->id_of(id))) now[id] = *state;
    }
    course.push_back(std::move(now));
    if (frame > 0 && each && !each(*world, frame)) break;
  }
  return course;
}

double size_of(const Scene& scene, int frames) {
  const double time = frames * scene.world.dt;
  const double fall = std::hypot(scene.world.gravity.x, scene.world.gravity.y) * time * time / 2;
  double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300, way = 0;
  for (const BodyDesc& b : scene.bodies) {
    const double reach = reach_of(b.shape);
    low_x = std::min(low_x, b.position.x - reach), high_x = std::max(high_x, b.position.x + reach);
    low_y = std::min(low_y, b.position.y - reach), high_y = std::max(high_y, b.position.y + reach);
    if (b.type == BodyType::dynamic_body) way = std::max(way, std::hypot(b.velocity.x, b.velocity.y) * time + fall);
  }
  return std::hypot(high_x - low_x, high_y - low_y) + way;
}

}  // namespace psim::laws
