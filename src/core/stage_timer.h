// Times a stage into the step's report.
#pragma once

#include <chrono>
#include <cstddef>

#include "psim/report.h"
#include "trace.h"

namespace psim {

/// Adds the time until its end to one stage, and tells the tracer.
class StageTimer {
 public:
  StageTimer(StepReport& report, Tracer& tracer, Stage stage)
      : report_(report),
        tracer_(tracer),
        stage_(static_cast<std::size_t>(stage)),
        begin_(std::chrono::steady_clock::now()) {
    tracer_.set_stage(kStageNames[stage_].data());
  }
  ~StageTimer() {
    const std::chrono::steady_clock::time_point end = std::chrono::steady_clock::now();
    report_.stage_ms[stage_] += std::chrono::duration<double, std::milli>(end - begin_).count();
    if (tracer_.on()) tracer_.add(0, kStageNames[stage_].data(), begin_, end);
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StepReport& report_;
  Tracer& tracer_;
  std::size_t stage_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace psim
