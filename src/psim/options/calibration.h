// What settings were measured to reach and to cost, by kind of scene: docs/data/calibration.csv,
// written by `accuracy --calibrate` and compiled in. In: its text; out: errors and times for scenes
// of any rate and size between the measured ones.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "check/scene_kind.h"
#include "psim/integrator.h"

namespace psim::cli {

/// The table that psim was built with.
extern const char* const kCalibrationCsv;

struct CalibrationRow {
  SceneKind kind = SceneKind::pile;
  std::string measure;  ///< what `error` is
  Integrator integrator = Integrator::verlet;
  double rate_h = 0;  ///< the scene's rate x substep
  int substeps = 0;
  double error = 0;
  double bodies = 0, pairs = 0, ns_per_frame = 0;  ///< of the scene that was timed
};

/// ns a frame = body x bodies + item x items x substeps; items are pairs, with fields and joints bodies.
struct FrameCost {
  double body = 0, item = 0;
  double pairs_per_body = 0;  ///< on average in the scenes that were timed
};

inline bool costs_by_body(SceneKind kind) { return kind == SceneKind::fields || kind == SceneKind::joints; }

class Calibration {
 public:
  /// Throws std::runtime_error if a row is not what accuracy --calibrate writes.
  explicit Calibration(std::string_view csv);

  /// The largest error measured at this rate x substep or a shorter one, between rows by a straight
  /// line in logarithms; infinite beyond the longest.
  double error(SceneKind kind, Integrator integrator, double rate_h) const;
  std::string_view measure(SceneKind kind) const;
  /// Those that were measured for this kind.
  std::vector<Integrator> integrators(SceneKind kind) const;
  FrameCost cost(SceneKind kind, Integrator integrator) const;

 private:
  std::vector<CalibrationRow> rows_of(SceneKind kind, Integrator integrator) const;

  std::vector<CalibrationRow> rows_;  // by rate_h
};

}  // namespace psim::cli
