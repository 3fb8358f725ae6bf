// Writes what World recorded as a Chrome trace (JSON), for ui.perfetto.dev or chrome://tracing: a
// track a thread with the stages, a track with the frames, a curve each of pairs and contacts.
#pragma once

#include <chrono>
#include <cstdint>

#include "output/atomic_file.h"
#include "psim/report.h"
#include "psim/world.h"

namespace psim::cli {

class TraceWriter {
 public:
  using Clock = std::chrono::steady_clock;

  /// Starts the world's recording; both must outlive the writer.
  TraceWriter(AtomicFile& file, World& world);

  /// After every step, outside of the timed span: takes the frame's events and writes them.
  void frame(std::uint64_t frame, Clock::time_point begin, Clock::time_point end, const StepReport& report,
             const std::vector<TraceEvent>& spans);

  /// Closes the JSON. The file still has to be committed.
  void finish();

 private:
  void event(std::string_view json);
  void span(std::string_view name, int track, std::int64_t begin_ns, std::int64_t end_ns);

  AtomicFile& file_;
  int frame_track_;
  bool first_ = true;
  Clock::time_point start_;
};

}  // namespace psim::cli
