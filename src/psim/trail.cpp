#include "trail.h"

#include <fmt/format.h>

#include "text.h"

namespace psim::cli {

Trail step_and_trail(World& world) {
  const StepReport step = world.step();
  return {world.state_hash(), step.pairs, step.contacts, step.colours};
}

std::string_view first_stage(const Trail& a, const Trail& b, bool motion_differs) {
  if (a.pairs != b.pairs) return "broad_phase";
  if (a.contacts != b.contacts && a.hash == b.hash) return "narrow_phase";
  if (a.colours != b.colours) return "colouring";
  return motion_differs ? "solver" : "integrate";
}

std::string trails_text(const Trail& a, const Trail& b) {
  return fmt::format(
      "hash {} against {}, pairs {} against {}, contacts {} against {}, colours {} against {}",
      hash_text(a.hash), hash_text(b.hash), a.pairs, b.pairs, a.contacts, b.contacts, a.colours,
      b.colours);
}

}  // namespace psim::cli
