// Runs a case in an engine over its settings: the errors from one watched run, the time from others
// that nobody watches.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "cases/case.h"

namespace psim::accuracy {

/// A point of a work-precision diagram.
struct Row {
  const Quantity* quantity = nullptr;
  const Engine* engine = nullptr;
  Setting setting;
  double seconds_per_sim_second = 0;                       ///< wall time, median of the runs
  double row_visits = 0;                                   ///< a simulated second
  double error = std::numeric_limits<double>::infinity();  ///< infinite: the run failed

  bool failed() const { return error == std::numeric_limits<double>::infinity(); }
};

/// False for psim's other integrators where the scene has no fields, the same bits as verlet, for
/// instruction sets and threads where the case does without them, and for bare boxes without boxes.
bool matters(const Setting& setting, const Case& of, const Model& model);

/// All rows of one setting, one a quantity. A failed run gives rows, too.
std::vector<Row> run_setting(const Case& of, const Model& model, const Engine& engine, const Setting& setting,
                             Effort effort);

/// Lines about psim's rows of a case: errors above their limits, and errors that differ between
/// instruction sets or threads, which must give the same bits.
std::vector<std::string> complaints(const std::vector<Row>& rows);

}  // namespace psim::accuracy
