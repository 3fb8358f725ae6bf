// Times the stages of a step for its report, and records which stage ran when on which thread if the host asked for a
// trace. If not, the trace costs one branch a stage.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "base/profile_zone.h"
#include "psim/report.h"

namespace psim {

/// Name of the spans in which the first thread waits for the last jobs of the others. They lie within a stage's span.
inline constexpr const char* kWaitName = "wait";

class Tracer {
 public:
  using Clock = std::chrono::steady_clock;

  void start() {
    if (origin_ == Clock::time_point{}) origin_ = Clock::now();
    on_.store(true, std::memory_order_relaxed);
  }
  /// Ends recording; the spans so far can still be taken.
  void stop() { on_.store(false, std::memory_order_relaxed); }
  bool on() const { return on_.load(std::memory_order_relaxed); }

  /// Reads the clock: the next stage begins now.
  Clock::time_point begin() { return stage_end_ = Clock::now(); }
  /// The time at which the last stage ended, or the step began.
  Clock::time_point stage_end() const { return stage_end_; }
  void set_stage(const char* name) { stage_ = name; }
  const char* stage() const { return stage_; }

  /// Adds a span; several threads may do so at once. A span that there is no memory for is lost.
  void add(std::size_t thread, const char* name, Clock::time_point begin, Clock::time_point end) noexcept {
    const auto ns = [this](Clock::time_point t) {
      return std::chrono::duration_cast<std::chrono::nanoseconds>(t - origin_).count();
    };
    const std::lock_guard lock(adding_);
    try {
      spans_.push_back({name, static_cast<int>(thread), ns(begin), ns(end)});
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  std::vector<TraceEvent> take() { return std::exchange(spans_, {}); }

 private:
  // Atomic, because a late worker may read it between two steps. Relaxed: a worker adds a span only after it took a job,
  // and the run that gave it the job was opened after start() wrote `origin_` and set_stage() the stage.
  std::atomic<bool> on_ = false;
  const char* stage_ = "";
  Clock::time_point origin_, stage_end_;
  std::mutex adding_;
  std::vector<TraceEvent> spans_;
};

/// Adds the time until its destruction to one stage of the report, and passes the span to the tracer and to a profiler of
/// the host. A stage begins where the one before it ended, so a step reads the clock once at its begin and once a stage.
class StageTimer {
 public:
  StageTimer(StepReport& report, Tracer& tracer, Stage stage)
      : report_(report),
        tracer_(tracer),
        stage_(static_cast<std::size_t>(stage)),
        begin_(tracer.stage_end()),
        zone_(kStageNames[stage_].data()) {
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
  [[no_unique_address]] ProfileZone zone_;
};

}  // namespace psim
