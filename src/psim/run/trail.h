// What one frame left behind, enough to name the stage in which two runs of it part.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "psim/world.h"

namespace psim::cli {

struct Trail {
  std::uint64_t hash = 0;
  std::uint64_t pairs = 0, contacts = 0;
  std::uint32_t colours = 0;
  bool solved = false;  // the solver had something to do
  friend bool operator==(const Trail&, const Trail&) = default;
};

/// Steps the world once.
Trail step_and_trail(World& world);

/// The earliest stage whose result is known to differ. What a stage hands on is only seen through
/// the counts of the step and the state at its end, so this is where to begin to look.
/// `motion_differs`: velocities differ, and not places alone.
std::string_view first_stage(const Trail& a, const Trail& b, bool motion_differs);

/// "hash … against …, pairs … against …, contacts …, colours …"
std::string trails_text(const Trail& a, const Trail& b);

}  // namespace psim::cli
