#include "report/trace.h"

#include <fmt/format.h>

namespace psim::cli {
namespace {

constexpr int kProcess = 1;

// The format counts in microseconds; three decimals keep the nanosecond.
double microseconds(std::int64_t ns) { return static_cast<double>(ns) / 1000; }

}  // namespace

TraceWriter::TraceWriter(AtomicFile& file, World& world) : file_(file), frame_track_(world.threads()) {
  file_.write("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[");
  const auto name_track = [this](int track, std::string_view name) {
    event(fmt::format(R"({{"name":"thread_name","ph":"M","pid":{},"tid":{},)"
                      R"("args":{{"name":"{}"}}}})",
                      kProcess, track, name));
    event(fmt::format(R"({{"name":"thread_sort_index","ph":"M","pid":{},"tid":{},)"
                      R"("args":{{"sort_index":{}}}}})",
                      kProcess, track, track == frame_track_ ? -1 : track));
  };
  event(fmt::format(R"({{"name":"process_name","ph":"M","pid":{},"args":{{"name":"psim"}}}})", kProcess));
  name_track(frame_track_, "frames");
  name_track(0, "main");
  for (int worker = 1; worker < frame_track_; ++worker) {
    name_track(worker, fmt::format("worker {}", worker));
  }
  start_ = Clock::now();
  world.start_trace();
}

void TraceWriter::event(std::string_view json) {
  file_.write(first_ ? "\n" : ",\n");
  file_.write(json);
  first_ = false;
}

void TraceWriter::span(std::string_view name, int track, std::int64_t begin_ns, std::int64_t end_ns) {
  event(fmt::format(R"({{"name":"{}","ph":"X","pid":{},"tid":{},"ts":{:.3f},"dur":{:.3f}}})", name, kProcess, track,
                    microseconds(begin_ns), microseconds(end_ns - begin_ns)));
}

void TraceWriter::frame(std::uint64_t frame, Clock::time_point begin, Clock::time_point end, const StepReport& report,
                        const std::vector<TraceEvent>& spans) {
  const auto since_start = [this](Clock::time_point t) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(t - start_).count();
  };
  span(fmt::format("frame {}", frame), frame_track_, since_start(begin), since_start(end));
  for (const TraceEvent& e : spans) span(e.name, e.thread, e.begin_ns, e.end_ns);
  const auto curve = [&](std::string_view name, std::uint64_t value) {
    event(fmt::format(R"({{"name":"{0}","ph":"C","pid":{1},"ts":{2:.3f},"args":{{"{0}":{3}}}}})", name, kProcess,
                      microseconds(since_start(begin)), value));
  };
  curve("pairs", report.pairs);
  curve("contacts", report.contacts);
}

void TraceWriter::finish() { file_.write("\n]}\n"); }

}  // namespace psim::cli
