// What moves the bodies within a step, and what it remembers from one step to the next.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "solver/continuous.h"
#include "solver/forces.h"
#include "solver/media.h"
#include "solver/solver.h"

namespace psim {

struct Dynamics {
  /// The substep, s, that contact stiffness is for if the next substep takes h seconds. Contacts stiffen and soften by
  /// and by where the length of steps changes: what rests on a soft contact's overlap would be thrown off by a stiff
  /// one, and what rests on a stiff contact would sink into a soft one.
  double next_stiff_substep(double h) const {
    constexpr double kStiffening = 0.98, kSoftening = 1.1;  // a step
    return stiff_substep > 0 ? std::clamp(h, kStiffening * stiff_substep, kSoftening * stiff_substep) : h;
  }

  Solver solver;
  std::unique_ptr<Forces> forces;  ///< none where gravity is uniform
  bool forces_stale = true;        ///< the arrays of the forces do not fit the bodies' order
  Media media;                     ///< of this step
  std::vector<Push> pushes;        ///< of this step: see ForcesOfStep
  Continuous continuous;
  bool moving = false;       ///< this step has begun to move bodies: it cannot be given up any more
  int substeps = 4;          ///< of this step
  double last_substep = 0;   ///< s: of the last step
  double stiff_substep = 0;  ///< s, that contact stiffness is for
};

}  // namespace psim
