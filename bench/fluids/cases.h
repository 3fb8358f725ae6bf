// The flows that both methods are measured on. Each has a truth: a closed form or an experiment.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "flow.h"
#include "method.h"

namespace psim::fluids {

/// What one run says.
struct Measured {
  std::string name;   ///< of the quantity
  std::string unit;   ///< of the error
  std::string truth;  ///< where the right value is from
  double error = 0;   ///< with its sign
};

struct Case {
  std::string name;
  std::string shows;
  double frame = 1.0 / 60;    ///< seconds: what Motion::advance is called with
  std::vector<int> layers;    ///< particles in a metre, or in the width of a vortex box; coarse to fine
  bool finest_by_all = true;  ///< else the finest is run by psim and by the default of the other method alone
  int quick_layers = 0;       ///< with --quick
  std::function<Flow(int layers)> flow;
  std::function<std::vector<Measured>(Motion&, const Flow&, bool quick)> measure;
};

Case taylor_green();
Case hydrostatic(int depth);
Case standing_wave();
Case dam_break();
Case elliptical_drop();
Case large_dam();

std::vector<Case> all_cases();

}  // namespace psim::fluids
