#include "run.h"

#include <time.h>

#include <algorithm>
#include <cmath>

#include "comparison.h"
#include "errors.h"

namespace psim::peers {
namespace {

constexpr int kLooks = 12;  // in a run

double now_ms(const Setting& setting) {
  timespec now{};
  ::clock_gettime(setting.threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void raise(std::optional<double>& most, double value) { most = std::max(most.value_or(0), value); }

void look_at(const Comparison& of, Run& run, Errors& errors) {
  if (of.overlaps) {
    const std::vector<double> depths = overlaps(run);
    raise(errors.deepest, depths.empty() ? 0 : depths.back());
    errors.overlap_p99 = accuracy::quantile(depths, 0.99);
  }
  if (!run.model().scene.joints.empty()) raise(errors.joint_gap, joint_gap(run));
}

void look_at_end(const Comparison& of, Run& run, double energy, Errors& errors) {
  if (run.model().scene.world.boundary == Boundary::walls) {
    errors.passed_walls = passed_walls(run);
  }
  if (of.energy) errors.energy_drift = (accuracy::energy(run) - energy) / energy;
  if (of.rests) errors.rest_speed = accuracy::rms_speed(run);
  if (!of.stands) return;
  const Displacement moved = displacement(run);
  errors.sway = moved.sideways;
  errors.sink = moved.down;
}

}  // namespace

Result run(const Comparison& of, const Model& model, int frames, const Engine& engine, const Setting& setting,
           bool look) {
  Result result;
  Setting asked = setting;
  asked.frame = model.scene.world.dt;
  asked.sleeping = of.sleeping;
  try {
    Run run(model, engine.make(model, asked));
    const double energy = of.energy ? accuracy::energy(run) : 0;
    for (int k = 0; k < of.settle; ++k) run.advance();
    const int pause = std::max(1, frames / kLooks);
    for (int k = 1; k <= frames; ++k) {
      const double begin = now_ms(asked);
      run.advance();
      result.frame_ms.push_back(now_ms(asked) - begin);
      if (look && (k % pause == 0 || k == frames)) look_at(of, run, result.errors);
    }
    if (look) look_at_end(of, run, energy, result.errors);
  } catch (const accuracy::Failed& why) {
    result.failed = why.what();
    result.errors = {};
  }
  return result;
}

}  // namespace psim::peers
