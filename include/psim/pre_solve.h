// What the host says of new contacts before the step that solves them first.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "psim/types.h"

namespace psim {

/// A contact that is new: two parts, of which one asks (BodyDesc::pre_solve), have come near each other and may touch in
/// this step. The members from `enabled` on may be changed.
struct NewContact {
  BodyId a = {};  ///< a.index < b.index
  BodyId b = {};  ///< kNoBody for a wall of the world
  /// The number of the part in a compound, or of the segment in a chain with materials of its own; else 0. In a
  /// kinematic body each segment counts.
  std::uint32_t part_a = 0;
  std::uint32_t part_b = 0;  ///< likewise; of a wall 0
  Vec2 point = {};           ///< metres: midway between the two surfaces
  Vec2 normal = {};          ///< of length 1, from a to b
  double separation = 0;     ///< metres: between the surfaces along the normal, negative in overlap
  double speed = 0;          ///< m/s: of approach along the normal there; negative: they part

  bool enabled = true;            ///< false: the parts go through each other
  double friction = 0;            ///< of the two together, 0..1000
  double restitution = 0;         ///< likewise, 0..1
  double tangent_speed = 0;       ///< m/s: the sum of both, as in Material
  double rolling_resistance = 0;  ///< of the two together, 0..1
};

/// Gets all new contacts of a step, ordered by a, b, part_a, part_b, on the thread that steps, and changes what it wants to
/// (World::set_pre_solve).
using PreSolve = std::function<void(std::span<NewContact>)>;

}  // namespace psim
