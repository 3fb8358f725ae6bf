// A law holds in every scene of its kind, so that any scene drawn at random is a test of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "draw.h"
#include "psim/scene.h"

namespace psim::laws {

/// Where a scene breaks a law.
struct Fault {
  int frame = 0;
  std::string what;  ///< one line: what was measured, and what the law allows
};

/// What may be taken out of a scene that breaks the law so that it can still be expected to hold.
enum class Spare {
  nothing,  ///< all that is there carries or encloses something
  movers,   ///< dynamic bodies and joints
  all       ///< everything
};

struct Law {
  std::string name;  ///< "L7"
  std::string text;  ///< one line
  Spare spare = Spare::nothing;
  /// A random scene of the law's kind, without its substeps.
  Scene (*draw)(Draw&) = nullptr;
  /// Runs the scene as it is, and whatever it is compared with.
  std::optional<Fault> (*broken)(const Scene&) = nullptr;
};

/// L1 to L16.
const std::vector<Law>& all_laws();
/// L1 to L3, L5 to L9 and L17, of scenes with fluids.
const std::vector<Law>& fluid_laws();

// By file; all_laws joins them.
std::vector<Law> symmetry_laws();  // L1 to L6, L13 to L15
std::vector<Law> sum_laws();       // L7, L8
std::vector<Law> solid_laws();     // L9, L10
std::vector<Law> time_laws();      // L11, L12, L16

}  // namespace psim::laws
