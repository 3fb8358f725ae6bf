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

/// Why an engine of discs, segments and walls cannot take the scene; empty if it can.
inline std::string refusal(const Model& model) {
  if (model.scene.world.boundary == Boundary::periodic) return "it knows no periodic world";
  for (const BodyDesc& body : model.bodies) {
    if (std::holds_alternative<ChainShape>(body.shape)) return "chains are not translated";
  }
  return {};
}

}  // namespace psim::accuracy
