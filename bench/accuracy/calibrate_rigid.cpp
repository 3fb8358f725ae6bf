#include "calibrate_rigid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "check/scene_kind.h"
#include "psim/psim.h"

namespace psim::accuracy {
namespace {

constexpr int kFrames = 600;
constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::unique_ptr<World> world_of(const Scene& scene) {
  std::string error;
  auto world = build_world(scene, {best_isa(), 1}, error);
  if (!world) throw std::runtime_error(error);
  world->set_sleeping(false);
  return world;
}

double energy(World& world) {
  const Diagnostics d = world.diagnostics();
  return d.kinetic + d.potential;
}

Scene built_in(const char* name, std::uint64_t bodies) {
  std::string error;
  auto scene = make_builtin(name, bodies, 1, error);
  if (!scene) throw std::runtime_error(error);
  return std::move(*scene);
}

// Boxes of 1 m in walls.
Scene boxes(std::uint64_t count, Vec2 room, const Material& material, std::uint64_t seed) {
  GroupDesc group;
  group.count = count;
  group.region = {0, 0, room.x, room.y};
  group.jitter = 0.5;
  group.seed = seed;
  group.body.shape = BoxShape{1, 1};
  group.body.material = material;
  Scene scene;
  scene.world.bounds = {0, 0, room.x, 2 * room.y};
  scene.world.wall = material;
  scene.groups.push_back(group);
  return scene;
}

}  // namespace

Scene pyramid_of_boxes(std::uint64_t) { return built_in("pyramid", 210); }

Scene heap_of_boxes(double width, std::uint64_t seed) {
  constexpr double kRoom = 2.2;  // m^2 a box
  return boxes(200, {width, 200 * kRoom / width + 2}, {1, 0, 0.5}, seed);
}

Scene gas_of_boxes(double speed, std::uint64_t seed) {
  Scene scene = boxes(100, {30, 30}, {1, 1, 0}, seed);
  scene.world.bounds.ymax = 30;
  scene.world.gravity = {0, 0};
  scene.groups[0].velocity_spread = speed;
  return scene;
}

Scene pinned(const char* name, std::uint64_t bodies) { return built_in(name, bodies); }

double shapes_error(const Scene& scene) {
  const auto world = world_of(scene);
  const SceneTraits traits = traits_of(scene);
  const double size = traits.size, start = energy(*world);
  double most = start;
  for (int frame = 0; frame < kFrames; ++frame) {
    world->step();
    most = std::max(most, energy(*world));
    if (!std::isfinite(most)) return kInfinity;
  }
  std::vector<double> depths;
  for (const Contact& contact : world->contacts()) depths.push_back(std::max(-contact.separation, 0.0));
  if (depths.empty()) return kInfinity;
  const auto at = depths.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(depths.size() - 1));
  std::nth_element(depths.begin(), at, depths.end());
  const Vec2 g = scene.world.gravity;
  const double mass = static_cast<double>(traits.moving) * kPi / 4 * size * size;  // of bodies of density 1
  return std::max(*at / size, (most - start) / (mass * std::hypot(g.x, g.y) * size));
}

double elastic_shapes_error(const Scene& scene) {
  const auto world = world_of(scene);
  const double start = energy(*world);
  double worst = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    world->step();
    const double off = std::abs(energy(*world) / start - 1);
    if (!std::isfinite(off)) return kInfinity;
    worst = std::max(worst, off);
  }
  return worst;
}

double joints_error(const Scene& scene) {
  const auto world = world_of(scene);
  double worst = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    world->step();
    for (std::uint32_t k = 0; k < world->joint_count(); ++k) {
      const auto joint = world->joint({k, 0});
      if (!joint || joint->type != JointType::revolute) continue;
      const double gap = std::hypot(joint->anchor_b.x - joint->anchor_a.x, joint->anchor_b.y - joint->anchor_a.y);
      if (!std::isfinite(gap)) return kInfinity;
      worst = std::max(worst, gap);
    }
  }
  return worst / traits_of(scene).size;
}

}  // namespace psim::accuracy
