#include "run/trail.h"

#include <fmt/format.h>

#include "output/text.h"

namespace psim::cli {

namespace {

std::uint64_t frames_without_solver(const World& world) {
  for (const auto& [stage, frames] : world.skipped()) {
    if (stage == "solver") return frames;
  }
  return 0;
}

}  // namespace

Trail step_and_trail(World& world) {
  const std::uint64_t skipped = frames_without_solver(world);
  const StepReport step = world.step();
  return {world.state_hash(), step.pairs, step.contacts, step.colours, frames_without_solver(world) == skipped};
}

std::string_view first_stage(const Trail& a, const Trail& b, bool motion_differs) {
  if (a.pairs != b.pairs) return "broad_phase";
  if (a.contacts != b.contacts && a.hash == b.hash) return "narrow_phase";
  if (a.colours != b.colours) return "colouring";
  // Without the solver, velocities change in integrate: free flight in closed form.
  return motion_differs && (a.solved || b.solved) ? "solver" : "integrate";
}

std::string trails_text(const Trail& a, const Trail& b) {
  return fmt::format("hash {} against {}, pairs {} against {}, contacts {} against {}, colours {} against {}",
                     hash_text(a.hash), hash_text(b.hash), a.pairs, b.pairs, a.contacts, b.contacts, a.colours,
                     b.colours);
}

}  // namespace psim::cli
