// Scene -> World: `bodies` in order, then `groups`, so that ids are as the scene says. O(n).
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "placement.h"
#include "psim/scene.h"

namespace psim {
namespace {

bool add_body(World& world, const Scene& scene, std::size_t k, std::string& error) {
  std::string what;
  if (world.add_body(scene.bodies[k], what) != kNoBody) return true;
  error = "bodies[" + std::to_string(k) + "]";
  if (k < scene.body_names.size() && !scene.body_names[k].empty()) {
    error += " \"" + scene.body_names[k] + "\"";
  }
  error += ": " + what;
  return false;
}

bool add_group(World& world, const Scene& scene, std::size_t k, std::string& error) {
  const GroupDesc group = seeded_group(scene, k);
  std::string what;
  const std::optional<PlacedGroup> placed = place_group(group, what);
  if (placed && placed->x.empty()) return true;
  if (placed) {
    const std::size_t n = placed->x.size();
    std::vector<double> angle, angular_velocity;
    if (group.body.angle != 0) angle.assign(n, group.body.angle);
    if (group.body.angular_velocity != 0) angular_velocity.assign(n, group.body.angular_velocity);
    DiscBatch batch;
    batch.x = placed->x;
    batch.y = placed->y;
    batch.radius = placed->radius;
    batch.angle = angle;
    batch.vx = placed->vx;
    batch.vy = placed->vy;
    batch.angular_velocity = angular_velocity;
    batch.type = group.body.type;
    batch.material = group.body.material;
    batch.mass = group.body.mass;
    batch.gravity_scale = group.body.gravity_scale;
    batch.fixed_rotation = group.body.fixed_rotation;
    batch.bullet = group.body.bullet;
    std::uint32_t first = 0;
    if (world.add_discs(batch, first, what) == n) return true;
  }
  error = "groups[" + std::to_string(k) + "]: " + what;
  return false;
}

}  // namespace

std::unique_ptr<World> build_world(const Scene& scene, const RunOptions& options,
                                   std::string& error) {
  std::unique_ptr<World> world = World::create(scene.world, options, error);
  if (!world) return nullptr;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    if (!add_body(*world, scene, k, error)) return nullptr;
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    if (!add_group(*world, scene, k, error)) return nullptr;
  }
  return world;
}

}  // namespace psim
