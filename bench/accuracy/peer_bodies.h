// What engines without psim's fields have to be told step by step, and what psim's scenes hold that
// they cannot take.
#pragma once

#include <cmath>
#include <string>
#include <variant>

#include "model.h"

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

/// Discs, segments and boxes with sharp corners.
inline bool is_translated(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return box->radius == 0;
  return std::holds_alternative<DiscShape>(shape) || std::holds_alternative<SegmentShape>(shape);
}

/// Rods, springs and pins without limit and motor.
inline bool is_translated(const JointDesc& joint) {
  if (joint.type == JointType::distance || joint.type == JointType::spring) return true;
  return joint.type == JointType::revolute && !joint.lower && !joint.upper &&
         joint.motor_limit == 0;
}

/// Why the other engines' adapters cannot take the scene; empty if they can.
inline std::string refusal(const Model& model) {
  if (model.scene.world.boundary == Boundary::periodic) return "it knows no periodic world";
  for (const BodyDesc& body : model.bodies) {
    if (!is_translated(body.shape)) return "a shape in it is not translated";
  }
  for (const SceneJoint& joint : model.scene.joints) {
    if (!is_translated(joint.joint)) return "a joint in it is not translated";
  }
  return {};
}

}  // namespace psim::accuracy
