// Worlds of the stress measurements, in few words.
#pragma once

#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace psim::accuracy::stress {

inline constexpr double kG = 9.81;

/// Open, and so large that nothing leaves.
inline WorldDesc open_world(double half = 1024, Vec2 gravity = {0, -kG}) {
  WorldDesc desc;
  desc.bounds = {-half, -half, half, half};
  desc.boundary = Boundary::open;
  desc.gravity = gravity;
  return desc;
}

inline std::unique_ptr<World> make(const WorldDesc& desc) {
  std::string error;
  auto world = World::create(desc, RunOptions{best_isa(), 1}, error);
  if (!world) throw std::runtime_error("World::create: " + error);
  return world;
}

inline BodyId add(World& world, const BodyDesc& body) {
  std::string error;
  const BodyId id = world.add_body(body, error);
  if (id == kNoBody) throw std::runtime_error("World::add_body: " + error);
  return id;
}

inline BodyDesc disc(Vec2 position, Vec2 velocity = {}, double radius = 0.5, Material m = {}) {
  BodyDesc body;
  body.shape = DiscShape{radius};
  body.position = position;
  body.velocity = velocity;
  body.material = m;
  return body;
}

inline BodyDesc segment(Vec2 p1, Vec2 p2, Material m = {}) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = SegmentShape{p1, p2};
  body.material = m;
  return body;
}

/// Level ground through y = 0, 1 km to each side.
inline BodyDesc ground(Material m = {}) { return segment({-1000, 0}, {1000, 0}, m); }

inline BodyState state(const World& world, BodyId id) {
  const auto body = world.body(id);
  if (!body) throw std::runtime_error("a body is gone");
  return *body;
}

inline void run(World& world, int frames) {
  for (int k = 0; k < frames; ++k) world.step();
}

inline double energy(const World& world) {
  const Diagnostics d = world.diagnostics();
  return d.kinetic + d.potential;
}

inline bool all_finite(World& world) {
  const PublishedState s = world.published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (!std::isfinite(s.x[k] + s.y[k] + s.angle[k] + s.vx[k] + s.vy[k] + s.omega[k])) return false;
  }
  return true;
}

inline double fastest(World& world) {
  const PublishedState s = world.published();
  double speed = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    speed = std::max(speed, std::hypot(s.vx[k], s.vy[k]));
  }
  return speed;
}

inline double rms_speed(World& world) {
  const PublishedState s = world.published();
  double sum = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) sum += s.vx[k] * s.vx[k] + s.vy[k] * s.vy[k];
  return s.id.empty() ? 0 : std::sqrt(sum / static_cast<double>(s.id.size()));
}

/// Columns of discs to add in bulk.
struct Discs {
  std::vector<double> x, y, vx, vy;
  void push(double px, double py, double ux = 0, double uy = 0) {
    x.push_back(px);
    y.push_back(py);
    vx.push_back(ux);
    vy.push_back(uy);
  }
};

inline void add(World& world, const Discs& discs, double radius, Material m = {}) {
  DiscBatch batch;
  batch.x = discs.x;
  batch.y = discs.y;
  batch.vx = discs.vx;
  batch.vy = discs.vy;
  batch.radius = {&radius, 1};
  batch.material = m;
  std::uint32_t first = 0;
  std::string error;
  if (world.add_discs(batch, first, error) != discs.x.size()) {
    throw std::runtime_error("World::add_discs: " + error);
  }
}

}  // namespace psim::accuracy::stress
