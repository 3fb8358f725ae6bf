// A Scene as text that parse_scene reads back to the same Scene. Numbers are the shortest that read
// back to the same bits; what stands at its default is left out. The scene's own seed has no key:
// it is mixed into the groups' seeds.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "file/json_text.h"
#include "file/parse_limits.h"
#include "file/parse_node.h"
#include "place/placement.h"
#include "place/shape_size.h"
#include "psim/scene.h"

namespace psim {

using scene::array_lines;
using scene::list_of;
using scene::Object;
using scene::text_of;

namespace {

constexpr std::string_view kTypeNames[] = {"dynamic", "static", "kinematic"};
constexpr std::string_view kBoundaryNames[] = {"walls", "periodic", "open"};
constexpr std::string_view kJointNames[] = {"distance", "spring", "rope",   "revolute", "prismatic", "weld",
                                            "wheel",    "motor",  "target", "gear",     "pulley",    "filter"};
constexpr std::string_view kPinNames[] = {"none", "top", "corners", "left", "ends"};
constexpr std::string_view kLayoutNames[] = {"lattice", "hex", "random", "explicit", "ring"};

template <class Enum>
std::string_view name_of(Enum value, const std::string_view* names) {
  return names[static_cast<std::size_t>(value)];
}

std::string material_text(const Material& m) {
  Object out;
  out.add("density", m.density).add("restitution", m.restitution).add("friction", m.friction);
  out.add_unless("tangent_speed", m.tangent_speed, 0).add_unless("rolling_resistance", m.rolling_resistance, 0);
  return out.one_line();
}

// The keys of a filter, less those that are as usual.
void add_filter(Object& out, const Filter& filter, const Filter* usual) {
  const auto add = [&](std::string_view key, auto Filter::*of) {
    if (usual == nullptr || filter.*of != usual->*of) out.raw(key, std::to_string(filter.*of));
  };
  add("category", &Filter::category);
  add("mask", &Filter::mask);
  add("group", &Filter::group);
}

struct ShapeText {
  std::string operator()(const DiscShape& disc) const {
    return Object().raw("disc", Object().add("radius", disc.radius).one_line()).one_line();
  }
  std::string operator()(const SegmentShape& s) const {
    return Object().raw("segment", Object().add("p1", s.p1).add("p2", s.p2).one_line()).one_line();
  }
  std::string operator()(const ChainShape& chain) const {
    Object keys;
    keys.raw("vertices", list_of(chain.vertices)).add_if("loop", chain.loop);
    std::string materials;
    for (const Material& m : chain.materials) materials += (materials.empty() ? "" : ", ") + material_text(m);
    if (!materials.empty()) keys.raw("materials", '[' + materials + ']');
    return Object().raw("chain", keys.one_line()).one_line();
  }
  std::string operator()(const BoxShape& box) const {
    Object keys;
    keys.add("size", Vec2{box.width, box.height}).add_unless("radius", box.radius, 0);
    return Object().raw("box", keys.one_line()).one_line();
  }
  std::string operator()(const PolygonShape& polygon) const {
    Object keys;
    keys.raw("vertices", list_of(polygon.vertices)).add_unless("radius", polygon.radius, 0);
    return Object().raw("polygon", keys.one_line()).one_line();
  }
  std::string operator()(const CapsuleShape& capsule) const {
    Object keys;
    keys.add("p1", capsule.p1).add("p2", capsule.p2).add("radius", capsule.radius);
    return Object().raw("capsule", keys.one_line()).one_line();
  }
  std::string operator()(const CompoundShape& compound) const {
    std::vector<std::string> parts;
    for (const ShapePart& part : compound.parts) {
      const std::string shape = std::visit(ShapeText{}, part.shape);
      Object keys;
      keys.add_unless("position", part.position, {}).add_unless("angle", part.angle, 0);
      if (part.density) keys.add("density", *part.density);
      if (part.restitution) keys.add("restitution", *part.restitution);
      if (part.friction) keys.add("friction", *part.friction);
      if (part.tangent_speed) keys.add("tangent_speed", *part.tangent_speed);
      if (part.rolling_resistance) keys.add("rolling_resistance", *part.rolling_resistance);
      if (part.one_way) keys.add("one_way", *part.one_way);
      if (part.filter) add_filter(keys, *part.filter, nullptr);
      if (part.sensor) keys.add("sensor", *part.sensor);
      const std::string own = keys.one_line();  // behind the shape, in one object with it
      parts.push_back(own == "{}" ? shape : shape.substr(0, shape.size() - 2) + ", " + own.substr(2));
    }
    std::string text = "[";
    for (const std::string& part : parts) text += (text.size() > 1 ? ", " : "") + part;
    return text + ']';
  }
};

// `shape` of a body or a group, or `shapes` of a compound.
void add_shape(Object& out, const Shape& shape) {
  out.raw(std::holds_alternative<CompoundShape>(shape) ? "shapes" : "shape", std::visit(ShapeText{}, shape));
}

void add_shared_keys(Object& out, const BodyDesc& body) {
  const BodyDesc absent;
  out.add_unless("angle", body.angle, absent.angle)
      .add_unless("angular_velocity", body.angular_velocity, absent.angular_velocity)
      .add_unless("density", body.material.density, absent.material.density)
      .add_unless("restitution", body.material.restitution, absent.material.restitution)
      .add_unless("friction", body.material.friction, absent.material.friction)
      .add_unless("tangent_speed", body.material.tangent_speed, 0)
      .add_unless("rolling_resistance", body.material.rolling_resistance, 0)
      .add_unless("one_way", body.one_way, {})
      .add_unless("mass", body.mass, 0)
      .add_unless("gravity_scale", body.gravity_scale, absent.gravity_scale)
      .add_if("fixed_rotation", body.fixed_rotation)
      .add_if("bullet", body.bullet);
  add_filter(out, body.filter, &absent.filter);
  out.add_if("sensor", body.sensor)
      .add_unless("linear_damping", body.linear_damping, 0)
      .add_unless("angular_damping", body.angular_damping, 0);
  std::string locks;
  for (const auto& [locked, name] :
       {std::pair(body.locks.x, "x"), std::pair(body.locks.y, "y"), std::pair(body.locks.angle, "angle")}) {
    if (locked) locks += (locks.empty() ? "" : ", ") + text_of(std::string_view(name));
  }
  if (!locks.empty()) out.raw("lock", '[' + locks + ']');
  if (!body.enabled) out.raw("enabled", "false");
}

std::string body_text(const BodyDesc& body, std::string_view name) {
  Object out;
  if (!name.empty()) out.add("name", name);
  out.add("type", name_of(body.type, kTypeNames));
  add_shape(out, body.shape);
  out.add("position", body.position).add_unless("velocity", body.velocity, {});
  add_shared_keys(out, body);
  return out.one_line();
}

std::vector<double> column_or(const std::vector<double>& column, double each, std::size_t size) {
  return column.empty() ? std::vector<double>(size, each) : column;
}

void add_listed_keys(Object& out, const GroupDesc& group) {
  out.raw("x", list_of(group.x)).raw("y", list_of(group.y));
  if (!is_disc(group.body.shape)) {
    add_shape(out, group.body.shape);
  } else if (group.radius.size() == group.x.size() && group.radius.size() != 1) {
    out.raw("radius", list_of(group.radius));
  } else {
    out.add("radius", group.radius.empty() ? group.radius_min : group.radius[0]);
  }
  if (group.vx.empty() && group.vy.empty()) {
    out.add_unless("velocity", group.velocity, {});
    return;
  }
  const auto add_speeds = [&](std::string_view key, const std::vector<double>& column, double each) {
    if (!column.empty() || each != 0) out.raw(key, list_of(column_or(column, each, group.x.size())));
  };
  add_speeds("vx", group.vx, group.velocity.x);
  add_speeds("vy", group.vy, group.velocity.y);
}

std::string links_text(const LinkDesc& links) {
  Object out;
  out.add("type", name_of(links.type, kJointNames));
  if (links.type == JointType::spring) {
    out.add("stiffness", links.stiffness).add_unless("damping", links.damping, 0);
  }
  out.add_if("diagonals", links.diagonals);
  if (links.pin != Pin::none) out.add("pin", name_of(links.pin, kPinNames));
  out.add_if("collide", links.collide).add_unless("break_force", links.break_force, 0);
  out.add_unless("pressure", links.pressure, 0).add_unless("drag", links.drag, 0).add_unless("lift", links.lift, 0);
  out.add_if("area", links.area).add_unless("bending", links.bending, 0);
  if (links.bending_damping) out.add("bending_damping", *links.bending_damping);
  return out.one_line();
}

void add_spring(Object& out, const JointDesc& joint) {
  if (joint.frequency) {
    out.add("frequency", *joint.frequency).add_unless("damping_ratio", joint.damping_ratio, 0);
    return;
  }
  const bool needed = joint.type == JointType::spring || joint.type == JointType::target;
  if (needed) out.add("stiffness", joint.stiffness);
  if (!needed) out.add_unless("stiffness", joint.stiffness, 0);
  out.add_unless("damping", joint.damping, 0);
}

// The bodies of a joint, or the joints of a gear.
void add_sides(Object& out, const SceneJoint& joint) {
  const JointType type = joint.joint.type;
  const auto side = [](std::uint64_t id) { return id == kWorldSide ? "\"world\"" : std::to_string(id); };
  if (type == JointType::gear) {
    out.raw("joint_a", std::to_string(joint.joint_a)).raw("joint_b", std::to_string(joint.joint_b));
    return;
  }
  if (type != JointType::target) out.raw("a", side(joint.a));
  out.raw("b", side(joint.b));
  out.add_unless("anchor_a", joint.joint.anchor_a, {}).add_unless("anchor_b", joint.joint.anchor_b, {});
}

std::string joint_text(const SceneJoint& scene_joint) {
  const JointDesc& joint = scene_joint.joint;
  const JointDesc absent;
  const JointType type = joint.type;
  Object out;
  out.add("type", name_of(type, kJointNames));
  add_sides(out, scene_joint);
  if (joint.length) out.add("length", *joint.length);
  if (joint.reference) out.add("reference", *joint.reference);
  add_spring(out, joint);
  if (type == JointType::target) out.add("target", joint.target);
  out.add_unless("axis", joint.axis, absent.axis).add_unless("target", joint.rest, 0);
  if (joint.lower) out.add("lower", *joint.lower);
  if (joint.upper) out.add("upper", *joint.upper);
  out.add_unless("motor_speed", joint.motor_speed, 0).add_unless("motor_limit", joint.motor_limit, 0);
  out.add_unless("linear_velocity", joint.linear_velocity, {})
      .add_unless("angular_velocity", joint.angular_velocity, 0);
  out.add_unless("force_limit", joint.force_limit, 0).add_unless("torque_limit", joint.torque_limit, 0);
  out.add_unless("linear_stiffness", joint.linear_stiffness, 0).add_unless("linear_damping", joint.linear_damping, 0);
  out.add_unless("correction", joint.correction, 0).add_unless("offset", joint.offset, {});
  if (type == JointType::pulley) out.add("ground_a", joint.ground_a).add("ground_b", joint.ground_b);
  out.add_unless("ratio", joint.ratio, 1);
  out.add_unless("break_force", joint.break_force, 0).add_unless("break_torque", joint.break_torque, 0);
  out.add_unless("pressure", joint.pressure, 0).add_unless("drag", joint.wind_drag, 0);
  out.add_unless("lift", joint.wind_lift, 0).add_unless("area", joint.area, 0);
  return out.add_if("collide", joint.collide).one_line();
}

void add_placed_keys(Object& out, const GroupDesc& group) {
  out.raw("count", std::to_string(group.count)).add("region", group.region);
  if (!is_disc(group.body.shape)) {
    add_shape(out, group.body.shape);
  } else if (group.radius_min == group.radius_max) {
    out.add("radius", group.radius_min);
  } else {
    out.add("radius", Vec2{group.radius_min, group.radius_max});
  }
  out.add_unless("jitter", group.jitter, 0)
      .add_unless("velocity", group.velocity, {})
      .add_unless("velocity_spread", group.velocity_spread, 0);
  if (group.seed != 1) out.raw("seed", std::to_string(group.seed));
  if (group.links) out.raw("links", links_text(*group.links));
}

std::string group_text(const GroupDesc& group) {
  Object out;
  out.add("layout", name_of(group.layout, kLayoutNames));
  if (group.body.type != BodyType::dynamic_body) {
    out.add("type", name_of(group.body.type, kTypeNames));
  }
  if (group.layout == Layout::explicit_list) {
    add_listed_keys(out, group);
  } else {
    add_placed_keys(out, group);
  }
  add_shared_keys(out, group.body);
  return out.lines(4);
}

struct FieldText {
  std::string operator()(const WellField& well) const {
    const WellField absent;
    return Object()
        .add("type", std::string_view("well"))
        .add("position", well.position)
        .add("strength", well.strength)
        .add_unless("softening", well.softening, absent.softening)
        .add_unless("exponent", well.exponent, absent.exponent)
        .add_unless("range", well.range, absent.range)
        .one_line();
  }
  std::string operator()(const DragField& drag) const {
    return Object()
        .add("type", std::string_view("drag"))
        .add("linear", drag.linear)
        .add("quadratic", drag.quadratic)
        .one_line();
  }
  std::string operator()(const BuoyancyField& water) const {
    const BuoyancyField absent;
    Object out;
    out.add("type", std::string_view("buoyancy")).add("region", water.region).add("density", water.density);
    out.add_unless("linear_damping", water.linear_damping, absent.linear_damping);
    out.add_unless("angular_damping", water.angular_damping, absent.angular_damping);
    out.add_unless("flow", water.flow, absent.flow);
    if (water.mask != absent.mask) out.raw("mask", std::to_string(water.mask));
    return out.one_line();
  }
  std::string operator()(const WindField& wind) const {
    const WindField absent;
    Object out;
    out.add("type", std::string_view("wind")).add("velocity", wind.velocity).add("density", wind.density);
    out.add_unless("drag", wind.drag, absent.drag).add_unless("lift", wind.lift, absent.lift);
    if (wind.region) out.add("region", *wind.region);
    if (wind.mask != absent.mask) out.raw("mask", std::to_string(wind.mask));
    return out.one_line();
  }
};

bool is_unbounded(const WorldDesc& world) {
  const Bounds &b = world.bounds, &open = kOpenBounds;
  return world.boundary == Boundary::open && b.xmin == open.xmin && b.xmax == open.xmax && b.ymin == open.ymin &&
         b.ymax == open.ymax;
}

std::string world_text(const WorldDesc& world) {
  Object out, mixing;
  const MixingRules usual;
  const auto add_rule = [&](std::string_view key, Mixing rule, Mixing absent) {
    if (rule != absent) mixing.add(key, scene::kMixingNames[static_cast<std::size_t>(rule)]);
  };
  add_rule("restitution", world.mixing.restitution, usual.restitution);
  add_rule("friction", world.mixing.friction, usual.friction);
  if (!is_unbounded(world)) {
    out.add("bounds", world.bounds).add("boundary", name_of(world.boundary, kBoundaryNames));
  }
  if (world.mixing != usual) out.raw("mixing", mixing.one_line());
  return out.add("gravity", world.gravity)
      .add_unless("linear_damping", world.linear_damping, 0)
      .add("material", std::string_view("wall"))
      .lines(2);
}

std::string step_text(const Scene& scene) {
  return Object()
      .add("dt", scene.world.dt)
      .raw("substeps", std::to_string(scene.world.substeps))
      .add("sleeping", scene.world.sleeping)
      .add("integrator", integrator_name(scene.world.integrator))
      .add_unless("restitution_threshold", scene.world.restitution_threshold, 0)
      .add_unless("skin", scene.world.skin, 1)
      .one_line();
}

}  // namespace

std::string scene_to_json(const Scene& scene) {
  std::vector<std::string> fields, bodies, groups, joints, fluids, emitters, drains;
  for (const Field& field : scene.world.fields) fields.push_back(std::visit(FieldText{}, field));
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const bool named = k < scene.body_names.size();
    bodies.push_back(body_text(scene.bodies[k], named ? scene.body_names[k] : std::string()));
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    groups.push_back(group_text(seeded_group(scene, k)));
  }

  for (const SceneJoint& joint : scene.joints) joints.push_back(joint_text(joint));
  for (std::size_t k = 0; k < scene.fluids.size(); ++k) {
    const bool fed = std::ranges::any_of(scene.emitters, [k](const EmitterDesc& e) { return e.fluid == k; });
    fluids.push_back(scene::fluid_text(scene.fluids[k], fed));
  }
  for (const EmitterDesc& emitter : scene.emitters) emitters.push_back(scene::emitter_text(emitter));
  for (const Bounds& region : scene.drains) drains.push_back(scene::drain_text(region));

  Object out;
  out.raw("psim", "1");
  if (!scene.name.empty()) out.add("name", std::string_view(scene.name));
  if (!scene.description.empty()) out.add("description", std::string_view(scene.description));
  out.raw("world", world_text(scene.world))
      .raw("step", step_text(scene))
      .raw("materials", Object().raw("wall", material_text(scene.world.wall)).lines(2));
  if (!fields.empty()) out.raw("fields", array_lines(fields, 2));
  if (!bodies.empty()) out.raw("bodies", array_lines(bodies, 2));
  if (!groups.empty()) out.raw("groups", array_lines(groups, 2));
  if (!joints.empty()) out.raw("joints", array_lines(joints, 2));
  if (!fluids.empty()) out.raw("fluids", array_lines(fluids, 2));
  if (!emitters.empty()) out.raw("emitters", array_lines(emitters, 2));
  if (!drains.empty()) out.raw("drains", array_lines(drains, 2));
  return out.lines(0) + '\n';
}

}  // namespace psim
