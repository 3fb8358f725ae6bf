// Who touches whom, where and how hard, as an array to read after a step.
#pragma once

#include <cstdint>

#include "psim/types.h"

namespace psim {

/// No strip: World::strips, Contact::strip.
inline constexpr std::uint32_t kNoStrip = 0xFFFFFFFFu;
/// No colour: Contact::colour.
inline constexpr std::uint32_t kNoColour = 0xFFFFFFFFu;

/// One point in which two bodies touched at the end of the last step. Two shapes that touch along an
/// edge have two, one after the other.
struct Contact {
  BodyId a;               ///< a.index < b.index
  BodyId b;               ///< kNoBody for a wall of the world
  Vec2 point;             ///< metres: midway between the two surfaces; in periodic worlds near a
  Vec2 normal;            ///< of length 1, from a to b
  double separation = 0;  ///< metres: between the surfaces along the normal, negative in overlap
  /// N s, >= 0: that the last substep put on b along the normal, and its opposite on a, times the substeps of a step.
  /// Over dt it is the force.
  double impulse = 0;
  /// N s: likewise along (-normal.y, normal.x); of friction, at most its coefficient x `impulse`.
  double friction = 0;
  /// The strip of the lists that it was found in (World::strips): strips are the units of parallel work. kNoStrip for
  /// contacts that no step solved: those among sleepers.
  std::uint32_t strip = kNoStrip;
  /// Its colour in that strip: contacts of one colour are solved together, since no two of them share a
  /// dynamic body (the two points of a manifold are one contact there). Small numbers are solved first. kNoColour: it
  /// is solved by itself, where a body has too many contacts; or not known, after World::restore until the next step
  /// and while a governor spreads a step over frames.
  std::uint32_t colour = kNoColour;
  /// Which parts touch, as in World::part_traits; which segment of a chain with surfaces of its own; else 0.
  std::uint32_t part_a = 0;
  std::uint32_t part_b = 0;  ///< likewise; of a wall 0
};

}  // namespace psim
