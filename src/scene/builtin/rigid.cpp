// What the built-in scenes of rigid bodies share.
#include <utility>

#include "builtin/builtin.h"
#include "place/shape_size.h"

namespace psim::builtin {

Scene open_scene(const Bounds& bounds) {
  Scene scene;
  scene.world.bounds = bounds;
  scene.world.boundary = Boundary::open;
  scene.world.gravity = {0, -10};
  return scene;
}

BodyDesc rigid(Shape shape, Vec2 position, const Material& material) {
  BodyDesc body;
  body.shape = std::move(shape);
  body.position = position;
  body.material = material;
  return body;
}

std::uint64_t add(Scene& scene, const BodyDesc& body) {
  scene.bodies.push_back(body);
  scene.body_names.emplace_back();
  return scene.bodies.size() - 1;
}

std::uint64_t add_ground(Scene& scene, Vec2 centre, double half_width, double half_height, const Material& material) {
  BodyDesc ground = rigid(BoxShape{2 * half_width, 2 * half_height, 0}, centre, material);
  ground.type = BodyType::static_body;
  const std::uint64_t id = add(scene, ground);
  scene.body_names.back() = id == 0 ? "ground" : "";
  return id;
}

ShapePart part_of(PartShape shape, Vec2 position) {
  ShapePart part;
  part.shape = std::move(shape);
  part.position = position;
  return part;
}

GroupDesc list_of(Shape shape, const Material& material) {
  GroupDesc group;
  group.layout = Layout::explicit_list;
  group.radius_min = group.radius_max = bounding_radius(shape);
  group.radius = {group.radius_min};
  if (!is_disc(shape)) group.body.shape = std::move(shape);
  group.body.material = material;
  return group;
}

void put(GroupDesc& group, double x, double y) {
  group.x.push_back(x);
  group.y.push_back(y);
  group.count = group.x.size();
}

JointDesc& pin(Scene& scene, std::uint64_t a, std::uint64_t b, Vec2 anchor_a, Vec2 anchor_b) {
  SceneJoint joint;
  joint.a = a;
  joint.b = b;
  joint.joint.type = JointType::revolute;
  joint.joint.anchor_a = anchor_a;
  joint.joint.anchor_b = anchor_b;
  scene.joints.push_back(joint);
  return scene.joints.back().joint;
}

}  // namespace psim::builtin
