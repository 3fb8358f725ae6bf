// The parts of a world that the manifolds of a saved state must fit.
#pragma once

#include <cstdint>

namespace psim {

/// The state of the world around them, against which reading checks the manifolds of a saved state.
struct ManifoldsAround {
  std::uint32_t numbered = 0;  ///< slots that pairs may name
  bool wanted = false;         ///< the plan has manifolds
  bool fresh = false;          ///< lists are not stale
  bool carried = false;        ///< their impulses are of use
  bool spread = false;         ///< work of a step is under way over frames: some are of this step, some of the last
  bool lists = false;          ///< lists last
  bool in_place = false;       ///< every slot has the body that pairs name it for

  bool present() const { return wanted && fresh; }  ///< the manifolds are those of the next step
  bool exact() const { return fresh && !spread; }
};

}  // namespace psim
