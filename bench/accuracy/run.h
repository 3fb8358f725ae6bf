// One run of a scene in one engine, watched: time, bodies, visits. What goes wrong on the way ends
// it with `Failed`, which becomes a point at the top edge of the diagram.
#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "engines/engine.h"

namespace psim::accuracy {

/// The engine did not get through: a body lost or no longer finite, nothing left to measure.
struct Failed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Run {
 public:
  /// `thorough`: statistics are worth their time, this is a setting that is quoted.
  Run(const Model& model, std::unique_ptr<Simulation> simulation, bool thorough = false)
      : model_(&model), simulation_(std::move(simulation)), thorough_(thorough) {}

  const Model& model() const { return *model_; }
  Simulation& simulation() { return *simulation_; }
  bool thorough() const { return thorough_; }

  void frame();
  /// A frame whose rows nobody counts: what is timed.
  void advance();
  void frames(int count);
  /// Whole frames that make up the time.
  void seconds(double duration);

  int frame_count() const { return frames_; }
  double time() const { return static_cast<double>(frames_) / kFrameRate; }
  double row_visits() const { return visits_; }

  const std::vector<BodyState>& bodies();
  const BodyState& body(std::size_t k) { return bodies()[k]; }

 private:
  const Model* model_;
  std::unique_ptr<Simulation> simulation_;
  bool thorough_;
  int frames_ = 0;
  double visits_ = 0;
  std::vector<BodyState> bodies_;
  int read_at_ = -1;
};

// ---- sums over bodies, alike for every engine -------------------------------------------------

double kinetic_energy(Run& run);
/// Kinetic and in uniform gravity.
double energy(Run& run);
Vec2 momentum(Run& run);
double angular_momentum(Run& run);  ///< about the origin, spins included
double rms_speed(Run& run);         ///< of dynamic bodies
/// Depth of every overlap of discs with discs, segments and walls, sorted, m.
std::vector<double> penetrations(Run& run);
double deepest(Run& run);
/// The q-quantile of a sorted list, 0 if it is empty.
double quantile(const std::vector<double>& sorted, double q);

}  // namespace psim::accuracy
