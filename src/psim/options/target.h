// --target-error and --target-ms: settings chosen from what was measured. In: a scene and what is
// wanted; out: the scene with its substeps and integrator set, and why. --target-error looks at no
// clock: the same scene gives the same settings on every machine.
#pragma once

#include <optional>
#include <string>

#include "check/scene_kind.h"
#include "options/options.h"
#include "psim/scene.h"

namespace psim::cli {

/// Settings, and what they are expected to do. Infinite: not known.
struct TargetSettings {
  Integrator integrator = Integrator::verlet;
  int substeps = 0;
  double error = 0;
  double ms_per_frame = 0;  ///< here with --target-ms, on the calibration's machine otherwise
};

struct Target {
  bool of_time = false;  ///< --target-ms, else --target-error
  double wanted = 0;     ///< ms a frame, or error
  SceneTraits traits;
  std::string measure;  ///< what the error is
  TargetSettings chosen;
  /// The nearest settings that do not do: the dearest cheaper one, or the one more substep.
  std::optional<TargetSettings> refused;
};

/// Chooses and applies, if one of the options was given. Throws UserError if nothing reaches it.
std::optional<Target> apply_target(const Options& options, Scene& scene);

/// Lines of the text report.
std::string target_text(const Target& target);

}  // namespace psim::cli
