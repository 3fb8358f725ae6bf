#include "place/links.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/rotor.h"
#include "place/placement.h"
#include "place/shape_size.h"

namespace psim {
namespace {

std::uint64_t size_of(const GroupDesc& group) {
  return group.layout == Layout::explicit_list ? group.x.size() : group.count;
}

LatticePlan plan_of(const GroupDesc& group) {
  return plan_lattice(group.count, group.region, group.layout == Layout::hex);
}

bool is_pinned(const GroupDesc& group, const LatticePlan& plan, std::uint64_t k) {
  const std::uint64_t row = k / plan.columns, column = k % plan.columns;
  const bool left = column == 0;
  const bool right = column + 1 == plan.columns || k + 1 == group.count;
  const bool top = row + 1 == plan.rows;
  switch (group.links->pin) {
    case Pin::none:
      return false;
    case Pin::top:
      return top;
    case Pin::corners:
      return top && (left || right);
    case Pin::left:
      return left;
    case Pin::ends:
      return left || right;
  }
  return false;
}

// Each body with the next one, and the last with the first. Two bodies have one link.
void append_ring(std::uint64_t count, std::uint64_t first, SceneJoint link, std::vector<SceneJoint>& joints) {
  const std::uint64_t links = count > 2 ? count : count - 1;
  for (std::uint64_t k = 0; k < links; ++k) {
    link.a = first + k;
    link.b = first + (k + 1) % count;
    joints.push_back(link);
  }
}

// Makes a link a beam. Without damping the bodies of a ring under pressure would tremble.
void bend(const LinkDesc& links, JointDesc& link) {
  constexpr double kRelaxation = 1e-3;  // s
  link.type = JointType::weld;
  link.stiffness = links.bending;
  link.damping = links.bending_damping.value_or(links.bending * kRelaxation);
}

// The area between a link of a ring and the middle: equal angles of an ellipse have equal areas.
double area_of_link(const GroupDesc& group) {
  const Bounds& r = group.region;
  const double angle = 2 * std::numbers::pi / static_cast<double>(group.count);
  return (r.xmax - r.xmin) * (r.ymax - r.ymin) / 8 * sine_cosine(angle).sine;
}

}  // namespace

SceneBodies::SceneBodies(const Scene& scene) : scene_(scene) {
  std::uint64_t next = scene.bodies.size();
  for (const GroupDesc& group : scene.groups) {
    first_.push_back(next);
    next += size_of(group);
  }
}

// An empty group has the first id of the one behind it.
std::size_t SceneBodies::group_of(std::uint64_t id) const {
  const auto behind = std::upper_bound(first_.begin(), first_.end(), id);
  return static_cast<std::size_t>(behind - first_.begin()) - 1;
}

const BodyDesc& SceneBodies::desc_of(std::uint64_t id) const {
  static const BodyDesc world{.type = BodyType::static_body};
  if (id == kWorldSide) return world;
  if (id < scene_.bodies.size()) return scene_.bodies[id];
  return scene_.groups[group_of(id)].body;
}

BodyType SceneBodies::type_of(std::uint64_t id) const {
  if (id == kWorldSide) return BodyType::static_body;
  if (id < scene_.bodies.size()) return scene_.bodies[id].type;
  const std::size_t k = group_of(id);
  const GroupDesc& group = scene_.groups[k];
  return psim::is_pinned(group, id - first_[k]) ? BodyType::static_body : group.body.type;
}

std::optional<double> SceneBodies::anchor_distance(const SceneJoint& joint) const {
  const auto placed = [&](std::uint64_t id) { return id < scene_.bodies.size() || id == kWorldSide; };
  if (!placed(joint.a) || !placed(joint.b)) return std::nullopt;
  const BodyDesc &body_a = desc_of(joint.a), &body_b = desc_of(joint.b);
  const Vec2 a = to_world(joint.joint.anchor_a, body_a.position, body_a.angle);
  const Vec2 b = to_world(joint.joint.anchor_b, body_b.position, body_b.angle);
  return length_of(b - a);
}

bool is_pinned(const GroupDesc& group, std::uint64_t k) {
  if (!group.links || group.links->pin == Pin::none || group.count == 0 || group.layout == Layout::ring) return false;
  return is_pinned(group, plan_of(group), k);
}

bool may_bend(const GroupDesc& group) {
  if (group.layout == Layout::ring || group.count == 0) return true;
  const LatticePlan plan = plan_of(group);
  return plan.rows == 1 || plan.columns == 1;
}

void append_links(const GroupDesc& group, std::uint64_t first, std::vector<SceneJoint>& joints) {
  if (!group.links || group.count == 0) return;
  const LinkDesc& links = *group.links;
  SceneJoint link;
  link.joint.type = links.type;
  link.joint.stiffness = links.stiffness;
  link.joint.damping = links.damping;
  link.joint.collide = links.collide;
  link.joint.break_force = links.break_force;
  link.joint.pressure = links.pressure;
  link.joint.wind_drag = links.drag;
  link.joint.wind_lift = links.lift;
  if (group.layout == Layout::ring && links.area) link.joint.area = area_of_link(group);
  if (links.bending > 0) bend(links, link.joint);
  if (group.layout == Layout::ring) return append_ring(group.count, first, link, joints);
  const LatticePlan plan = plan_of(group);
  const bool hex = group.layout == Layout::hex;
  const auto join = [&](std::uint64_t k, std::uint64_t other) {
    if (other >= group.count) return;
    if (is_pinned(group, plan, k) && is_pinned(group, plan, other)) return;
    link.a = first + k;
    link.b = first + other;
    joints.push_back(link);
  };
  for (std::uint64_t k = 0; k < group.count; ++k) {
    const std::uint64_t row = k / plan.columns, column = k % plan.columns;
    const std::uint64_t above = k + plan.columns;
    const bool first_column = column == 0, last_column = column + 1 == plan.columns;
    if (!last_column) join(k, k + 1);
    join(k, above);
    // Odd rows of a hex lattice are shifted to the right.
    const bool up_left = hex ? row % 2 == 0 : links.diagonals;
    const bool up_right = hex ? row % 2 == 1 : links.diagonals;
    if (up_left && !first_column) join(k, above - 1);
    if (up_right && !last_column) join(k, above + 1);
  }
}

std::vector<SceneJoint> all_joints(const Scene& scene) {
  std::vector<SceneJoint> joints = scene.joints;
  const SceneBodies bodies(scene);
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    append_links(scene.groups[k], bodies.first_of_group(k), joints);
  }
  return joints;
}

std::vector<DrawnJoint> drawn_joints(const Scene& scene) {
  std::vector<DrawnJoint> drawn;
  const std::vector<SceneJoint> all = all_joints(scene);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const SceneJoint& joint = all[k];
    const JointDesc& d = joint.joint;
    DrawnJoint line{joint, static_cast<std::uint32_t>(k)};
    if (d.type == JointType::gear || d.type == JointType::filter) continue;
    if (d.type == JointType::target) line.joint.anchor_a = d.target;
    if (d.type == JointType::pulley) {
      line.a = kWorldSide;
      line.b = joint.a;
      line.joint.type = JointType::rope;
      line.joint.anchor_a = d.ground_a;
      line.joint.anchor_b = d.anchor_a;
      drawn.push_back(line);
      line.b = joint.b;
      line.joint.anchor_a = d.ground_b;
      line.joint.anchor_b = d.anchor_b;
    }
    drawn.push_back(line);
  }
  return drawn;
}

}  // namespace psim
