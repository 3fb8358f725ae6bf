// Times a stage into the step's report. A stage begins where the one before it ended, so a step reads the clock
// once at its begin and once a stage.
#pragma once

#include <chrono>
#include <cstddef>

#include "base/trace.h"
#include "psim/report.h"

namespace psim {

/// Adds the time until its destruction to one stage, and passes the span to the tracer.
class StageTimer {
 public:
  StageTimer(StepReport& report, Tracer& tracer, Stage stage)
      : report_(report), tracer_(tracer), stage_(static_cast<std::size_t>(stage)), begin_(tracer.stage_end()) {
    tracer_.set_stage(kStageNames[stage_].data());
  }
  ~StageTimer() {
    const Tracer::Clock::time_point end = tracer_.begin();
    report_.stage_ms[stage_] += std::chrono::duration<double, std::milli>(end - begin_).count();
    if (tracer_.on()) tracer_.add(0, kStageNames[stage_].data(), begin_, end);
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StepReport& report_;
  Tracer& tracer_;
  std::size_t stage_;
  Tracer::Clock::time_point begin_;
};

}  // namespace psim
