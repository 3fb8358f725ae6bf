// What engines without psim's fields have to be told step by step, and what psim's scenes hold that
// they cannot take.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "engines/model.h"

namespace psim::accuracy {

/// Acceleration of the scene's wells and quadratic drag at a place and speed.
inline Vec2 field_acceleration(const WorldDesc& world, Vec2 x, Vec2 v) {
  Vec2 sum;
  for (const Field& field : world.fields) {
    if (const auto* well = std::get_if<WellField>(&field)) {
      const double dx = well->position.x - x.x, dy = well->position.y - x.y;
      const double d2 = dx * dx + dy * dy;
      if (well->range > 0 && d2 > well->range * well->range) continue;
      const double softened = d2 + well->softening * well->softening;
      const double a = well->strength / std::pow(softened, 0.5 * (well->exponent + 1));
      sum.x += a * dx;
      sum.y += a * dy;
    } else if (const auto* drag = std::get_if<DragField>(&field)) {
      const double a = drag->quadratic * std::hypot(v.x, v.y);
      sum.x -= a * v.x;
      sum.y -= a * v.y;
    }
  }
  return sum;
}

/// dv/dt = -c v of the whole scene.
inline double linear_damping(const WorldDesc& world) {
  double sum = world.linear_damping;
  for (const Field& field : world.fields) {
    if (const auto* drag = std::get_if<DragField>(&field)) sum += drag->linear;
  }
  return sum;
}

/// Who collides with whom.
inline bool collide(const Filter& a, const Filter& b) {
  if (a.group != 0 && a.group == b.group) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

/// What an adapter says to its engine exactly, besides discs, boxes with sharp corners, pins without
/// limit and motor, walls, masses and materials, which all of them have.
struct Translation {
  bool fields = false;
  bool segments = false;
  bool rectangles = false;  ///< off the body's place
  bool polygons = false;
  bool chains = false;  ///< open ones, solid from both sides, without bumps at their joints
  bool gravity_scale = false;
  bool bullets = false;
  bool restitution_threshold = false;
  bool always_groups = false;  ///< filter groups whose members collide whatever their masks
  std::uint32_t categories = 0xFFFFFFFFu;
  bool rods = false;
  bool springs = false;
  bool ropes = false;
  bool welds = false;   ///< rigid, or soft in their angle
  bool slides = false;  ///< without limit and motor
  bool motors = false;  ///< of pins
};

inline std::string missing_in(const Translation& has, const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return box->radius == 0 ? "" : "rounded box";
  if (std::holds_alternative<DiscShape>(shape)) return "";
  if (std::holds_alternative<SegmentShape>(shape)) return has.segments ? "" : "segment";
  if (std::holds_alternative<CapsuleShape>(shape)) return "capsule";
  if (const auto* chain = std::get_if<ChainShape>(&shape)) {
    return has.chains && !chain->loop && chain->vertices.size() > 2 ? "" : "chain";
  }
  const auto* polygon = std::get_if<PolygonShape>(&shape);
  if (!polygon) return "shape";
  if (polygon->radius > 0) return "rounded polygon";
  return has.polygons || (has.rectangles && rectangle_of(*polygon)) ? "" : "polygon";
}

inline std::string missing_in(const Translation& has, const BodyDesc& body) {
  if (std::holds_alternative<SegmentShape>(body.shape) && body.type == BodyType::dynamic_body) {
    return "thin rod";
  }
  if (body.sensor) return "sensor";
  if (body.bullet && !has.bullets) return "bullet";
  if (body.gravity_scale != 1 && !has.gravity_scale) return "gravity scale";
  // What a mask says of categories that nobody has does not matter.
  if ((body.filter.category & ~has.categories) != 0) return "filter category";
  if (body.filter.group > 0 && !has.always_groups) return "filter group";
  return missing_in(has, body.shape);
}

inline std::string missing_in(const Translation& has, const JointDesc& joint) {
  const bool sprung = joint.frequency || joint.stiffness != 0 || joint.damping != 0;
  const bool rigid = joint.type != JointType::spring && joint.type != JointType::weld;
  if (rigid && sprung) return "spring of a joint";
  switch (joint.type) {
    case JointType::distance:
      if (joint.lower || joint.upper || joint.motor_limit != 0) return "limit or motor of a rod";
      return has.rods ? "" : "rod";
    case JointType::spring:
      return has.springs ? "" : "spring";
    case JointType::rope:
      return has.ropes ? "" : "rope";
    case JointType::revolute:
      if (joint.lower || joint.upper) return "limit of a pin";
      return joint.motor_limit == 0 || has.motors ? "" : "motor of a pin";
    case JointType::prismatic:
      if (joint.lower || joint.upper || joint.motor_limit != 0) return "limit or motor of a slide";
      return has.slides ? "" : "slide";
    case JointType::weld:
      return has.welds ? "" : "weld";
    default:
      return "wheel, motor, target, gear, pulley or filter";
  }
}

/// An open chain with an end more on each side, straight on, for engines that want to know what neighbours its ends.
inline std::vector<Vec2> with_neighbours(const ChainShape& chain) {
  const auto& v = chain.vertices;
  const auto beyond = [](Vec2 end, Vec2 inner) { return Vec2{2 * end.x - inner.x, 2 * end.y - inner.y}; };
  std::vector<Vec2> longer = {beyond(v[0], v[1])};
  longer.insert(longer.end(), v.begin(), v.end());
  longer.push_back(beyond(v[v.size() - 1], v[v.size() - 2]));
  return longer;
}

/// The first thing in the scene that an adapter cannot say; empty if there is none.
inline std::string refusal(const Model& model, const Translation& has) {
  const WorldDesc& world = model.scene.world;
  if (world.boundary == Boundary::periodic) return "periodic world";
  if (!world.fields.empty() && !has.fields) return "field";
  if (world.restitution_threshold != 0 && !has.restitution_threshold) {
    return "restitution threshold";
  }
  for (const BodyDesc& body : model.bodies) {
    if (std::string what = missing_in(has, body); !what.empty()) return what;
  }
  for (const SceneJoint& joint : model.scene.joints) {
    if (std::string what = missing_in(has, joint.joint); !what.empty()) return what;
  }
  return {};
}

}  // namespace psim::accuracy
