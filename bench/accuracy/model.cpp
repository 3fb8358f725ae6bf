#include "model.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <variant>

namespace psim::accuracy {
namespace {

void append_group(const GroupDesc& group, std::vector<BodyDesc>& bodies) {
  std::string error;
  const auto placed = place_group(group, error);
  if (!placed) throw std::runtime_error(error);
  for (std::size_t k = 0; k < placed->x.size(); ++k) {
    BodyDesc body = group.body;
    body.shape = DiscShape{placed->radius[k]};
    body.position = {placed->x[k], placed->y[k]};
    body.velocity = {placed->vx[k], placed->vy[k]};
    bodies.push_back(std::move(body));
  }
}

}  // namespace

Model make_model(const Scene& scene) {
  std::string error;
  auto parsed = parse_scene(scene_to_json(scene), scene.name, error);
  if (!parsed) throw std::runtime_error(error);
  Model model{std::move(*parsed), {}};
  model.bodies = model.scene.bodies;
  for (const GroupDesc& group : model.scene.groups) append_group(group, model.bodies);
  return model;
}

double radius_of(const BodyDesc& body) {
  const auto* shape = std::get_if<DiscShape>(&body.shape);
  return shape ? shape->radius : 0;
}

double mass_of(const BodyDesc& body) {
  const double r = radius_of(body);
  return body.mass > 0 ? body.mass : body.material.density * std::numbers::pi * r * r;
}

double inertia_of(const BodyDesc& body) {
  const double r = radius_of(body);
  return 0.5 * mass_of(body) * r * r;
}

Scene open_scene(double half_size, Vec2 gravity) {
  Scene scene;
  scene.world.bounds = {-half_size, -half_size, half_size, half_size};
  scene.world.boundary = Boundary::open;
  scene.world.gravity = gravity;
  return scene;
}

Scene walled_scene(double width, double height, Material wall, Vec2 gravity) {
  Scene scene;
  scene.world.bounds = {0, 0, width, height};
  scene.world.boundary = Boundary::walls;
  scene.world.wall = wall;
  scene.world.gravity = gravity;
  return scene;
}

Scene periodic_scene(double width, double height) {
  Scene scene;
  scene.world.bounds = {0, 0, width, height};
  scene.world.boundary = Boundary::periodic;
  scene.world.gravity = {0, 0};
  return scene;
}

BodyDesc disc(Vec2 position, Vec2 velocity, Material surface, double radius) {
  BodyDesc body;
  body.shape = DiscShape{radius};
  body.position = position;
  body.velocity = velocity;
  body.material = surface;
  return body;
}

BodyDesc segment(Vec2 p1, Vec2 p2, Material surface) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = SegmentShape{p1, p2};
  body.material = surface;
  return body;
}

BodyDesc ground(Material surface, double half_length) {
  return segment({-half_length, 0}, {half_length, 0}, surface);
}

}  // namespace psim::accuracy
