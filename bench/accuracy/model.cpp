#include "model.h"

#include <algorithm>
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

double area_of(const BodyDesc& body) {
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) return box->width * box->height;
  const double r = radius_of(body);
  return std::numbers::pi * r * r;
}

double mass_of(const BodyDesc& body) {
  return body.mass > 0 ? body.mass : body.material.density * area_of(body);
}

double inertia_of(const BodyDesc& body) {
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    return mass_of(body) * (box->width * box->width + box->height * box->height) / 12;
  }
  const double r = radius_of(body);
  return 0.5 * mass_of(body) * r * r;
}

bool has_boxes(const Model& model) {
  return std::ranges::any_of(
      model.bodies, [](const BodyDesc& b) { return std::holds_alternative<BoxShape>(b.shape); });
}

double length_of(const Model& model, const SceneJoint& joint) {
  if (joint.joint.length) return *joint.joint.length;
  const auto anchor = [](const BodyDesc& body, Vec2 at) {
    const double c = std::cos(body.angle), s = std::sin(body.angle);
    return Vec2{body.position.x + c * at.x - s * at.y, body.position.y + s * at.x + c * at.y};
  };
  const Vec2 a = anchor(model.bodies[joint.a], joint.joint.anchor_a);
  const Vec2 b = anchor(model.bodies[joint.b], joint.joint.anchor_b);
  return std::hypot(b.x - a.x, b.y - a.y);
}

int joint_rows(const Model& model) {
  int rows = 0;
  for (const SceneJoint& j : model.scene.joints)
    rows += j.joint.type == JointType::revolute ? 2 : 1;
  return rows;
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

BodyDesc box(Vec2 position, Vec2 size, Material surface, double mass) {
  BodyDesc body;
  body.shape = BoxShape{size.x, size.y};
  body.position = position;
  body.material = surface;
  body.mass = mass;
  return body;
}

BodyDesc floor_box(Material surface, double half_length) {
  BodyDesc body = box({0, -0.5}, {2 * half_length, 1}, surface);
  body.type = BodyType::static_body;
  return body;
}

BodyDesc peg(Vec2 position) {
  BodyDesc body = disc(position, {0, 0}, material(0), 0.01);
  body.type = BodyType::static_body;
  return body;
}

SceneJoint& join(Scene& scene, JointType type, std::size_t a, std::size_t b, Vec2 anchor_a,
                 Vec2 anchor_b) {
  SceneJoint& made = scene.joints.emplace_back();
  made.a = a;
  made.b = b;
  made.joint.type = type;
  made.joint.anchor_a = anchor_a;
  made.joint.anchor_b = anchor_b;
  return made;
}

}  // namespace psim::accuracy
