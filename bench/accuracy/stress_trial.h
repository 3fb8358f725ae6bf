// A stress scene at work and short words for what becomes of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "run.h"
#include "stress.h"

namespace psim::accuracy::stress {

inline constexpr double kRadius = 0.5, kDiameter = 1;  // m, unless a scene says otherwise

class Trial {
 public:
  Trial(const Scene& scene, const Start& start) : model_(make_model(scene)), run_(model_, start(model_)) {}
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;

  Run& run() { return run_; }
  void frame() { run_.frame(); }
  void frames(int count) { run_.frames(count); }
  const std::vector<BodyState>& bodies() { return run_.bodies(); }
  const BodyState& body(std::size_t k) { return run_.body(k); }

  double fastest() {
    double speed = 0;
    for (const BodyState& b : bodies()) speed = std::max(speed, std::hypot(b.vx, b.vy));
    return speed;
  }
  /// The fastest in any of so many frames.
  double fastest_within(int count) {
    double speed = 0;
    for (int k = 0; k < count; ++k) {
      frame();
      speed = std::max(speed, fastest());
    }
    return speed;
  }

 private:
  Model model_;
  Run run_;
};

}  // namespace psim::accuracy::stress
