#include "engines/model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <variant>

#include "place/links.h"

namespace psim::accuracy {
namespace {

void append_group(const GroupDesc& group, std::vector<BodyDesc>& bodies) {
  std::string error;
  const auto placed = place_group(group, error);
  if (!placed) throw std::runtime_error(error);
  for (std::size_t k = 0; k < placed->x.size(); ++k) {
    BodyDesc body = group.body;
    if (std::holds_alternative<DiscShape>(body.shape)) body.shape = DiscShape{placed->radius[k]};
    if (group.links && is_pinned(group, k)) body.type = BodyType::static_body;
    body.position = {placed->x[k], placed->y[k]};
    body.velocity = {placed->vx[k], placed->vy[k]};
    bodies.push_back(std::move(body));
  }
}

/// The same bodies and joints without groups.
Scene without_groups(Scene scene) {
  scene.joints = all_joints(scene);
  for (const GroupDesc& group : scene.groups) append_group(group, scene.bodies);
  scene.body_names.resize(scene.bodies.size());
  scene.groups.clear();
  return scene;
}

struct Area {
  double area = 0, square = 0;  ///< m^2; integral of the distance from the centre squared, m^4
  Vec2 centre;
};

/// Of a polygon, by triangles from the frame's origin.
Area area_of(const PolygonShape& polygon) {
  Area sum;
  double square = 0;
  const auto& v = polygon.vertices;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const Vec2 p = v[k], q = v[(k + 1) % v.size()];
    const double twice = p.x * q.y - q.x * p.y;
    sum.area += twice / 2;
    sum.centre.x += twice * (p.x + q.x) / 6;
    sum.centre.y += twice * (p.y + q.y) / 6;
    square += twice * (p.x * p.x + p.x * q.x + q.x * q.x + p.y * p.y + p.y * q.y + q.y * q.y) / 12;
  }
  sum.centre = {sum.centre.x / sum.area, sum.centre.y / sum.area};
  const Vec2 c = sum.centre;
  sum.square = square - sum.area * (c.x * c.x + c.y * c.y);
  return sum;
}

}  // namespace

Model make_model(const Scene& scene) {
  const bool linked = std::ranges::any_of(scene.groups, [](const GroupDesc& g) { return g.links.has_value(); });
  std::string error;
  auto parsed = parse_scene(scene_to_json(linked ? without_groups(scene) : scene), scene.name, error);
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
  if (const auto* polygon = std::get_if<PolygonShape>(&body.shape)) return area_of(*polygon).area;
  const double r = radius_of(body);
  return std::numbers::pi * r * r;
}

double mass_of(const BodyDesc& body) { return body.mass > 0 ? body.mass : body.material.density * area_of(body); }

double inertia_of(const BodyDesc& body) {
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    return mass_of(body) * (box->width * box->width + box->height * box->height) / 12;
  }
  if (const auto* polygon = std::get_if<PolygonShape>(&body.shape)) {
    const Area a = area_of(*polygon);
    return mass_of(body) * a.square / a.area;
  }
  const double r = radius_of(body);
  return 0.5 * mass_of(body) * r * r;
}

Vec2 centre_of(const BodyDesc& body) {
  const auto* polygon = std::get_if<PolygonShape>(&body.shape);
  if (!polygon || body.type != BodyType::dynamic_body) return {};
  return area_of(*polygon).centre;
}

std::optional<Rectangle> rectangle_of(const PolygonShape& polygon) {
  if (polygon.vertices.size() != 4 || polygon.radius > 0) return {};
  const auto& v = polygon.vertices;
  const double left = std::min(v[0].x, v[2].x), right = std::max(v[0].x, v[2].x);
  const double low = std::min(v[0].y, v[2].y), high = std::max(v[0].y, v[2].y);
  const auto is_corner = [&](Vec2 p) { return (p.x == left || p.x == right) && (p.y == low || p.y == high); };
  if (!std::ranges::all_of(v, is_corner)) return {};
  return Rectangle{{(left + right) / 2, (low + high) / 2}, right - left, high - low};
}

bool has_boxes(const Model& model) {
  return std::ranges::any_of(model.bodies, [](const BodyDesc& b) {
    return std::holds_alternative<BoxShape>(b.shape) || std::holds_alternative<PolygonShape>(b.shape);
  });
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

double reference_of(const Model& model, const SceneJoint& joint) {
  return joint.joint.reference.value_or(model.bodies[joint.b].angle - model.bodies[joint.a].angle);
}

int joint_rows(const Model& model) {
  int rows = 0;
  for (const SceneJoint& j : model.scene.joints) {
    const bool two = j.joint.type == JointType::revolute || j.joint.type == JointType::prismatic;
    rows += j.joint.type == JointType::weld ? 3 : two ? 2 : 1;
  }
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

BodyDesc ground(Material surface, double half_length) { return segment({-half_length, 0}, {half_length, 0}, surface); }

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

SceneJoint& join(Scene& scene, JointType type, std::size_t a, std::size_t b, Vec2 anchor_a, Vec2 anchor_b) {
  SceneJoint& made = scene.joints.emplace_back();
  made.a = a;
  made.b = b;
  made.joint.type = type;
  made.joint.anchor_a = anchor_a;
  made.joint.anchor_b = anchor_b;
  return made;
}

}  // namespace psim::accuracy
