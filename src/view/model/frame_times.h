// What the parts of a picture cost the CPU, milliseconds.
#pragma once

#include <chrono>

#include "report/samples.h"

namespace psim::view {

struct FrameTimes {
  cli::Samples prepare;  ///< read the snapshot, look-ups, lines
  cli::Samples upload;   ///< columns to OpenGL's buffers
  cli::Samples panels;
  cli::Samples all;        ///< the three together: what a picture costs beside OpenGL's own work
  cli::Samples gl;         ///< draw calls: with software OpenGL the drawing itself
  double last_ms = 0;      ///< all, of the last picture
  double interval_ms = 0;  ///< between pictures, smoothed
};

class Stopwatch {
 public:
  /// Since the last call.
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace psim::view
