// The files that a run writes, opened together before the run begins and named at its end.
#pragma once

#include <optional>

#include "options/options.h"
#include "output/atomic_file.h"

namespace psim::cli {

struct OutputFiles {
  /// Opens every file that the options ask for; throws UserError if one cannot be written, or if
  /// two of them, or one and the scene file, are the same. Nothing is left behind then.
  explicit OutputFiles(const Options& options);

  std::optional<AtomicFile> state, fluid_state, metrics, trajectory, image, video, trace, governor_log, save, record;
};

}  // namespace psim::cli
