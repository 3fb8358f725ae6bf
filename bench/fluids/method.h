// A flow that a method moves, and the processor time that the method took for its steps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "flow.h"
#include "sph.h"

namespace psim::fluids {

class Motion {
 public:
  virtual ~Motion() = default;

  /// Moves on by one frame. The time of its steps is added to `seconds`.
  void advance(double frame);
  virtual void look(std::vector<Particle>& out) const = 0;

  /// Processor time of one sum over the neighbours of every particle; 0 for a method that has none.
  double time_of_sum();
  /// Kinetic energy, J/m.
  double energy() const;

  double seconds = 0;    ///< processor time of the calling thread in steps
  double simulated = 0;  ///< seconds
  double dt = 0;         ///< of the last step, seconds

 protected:
  virtual void run(double frame) = 0;
  virtual bool sum() { return false; }
};

struct Method {
  std::string engine;   ///< psim or sph
  std::string setting;  ///< names a curve
  int steps = 1;        ///< of psim in a frame
  SphSettings sph;
};

/// psim needs to know how long a frame is; the other method makes as many steps of it as it needs.
std::unique_ptr<Motion> begin(const Method& method, const Flow& flow, double frame);

}  // namespace psim::fluids
