#include "run/progress.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "os/console.h"

namespace psim::cli {
namespace {

constexpr auto kRedrawEvery = std::chrono::milliseconds(200);
constexpr const char* kWipeLine = "\r\033[K";

std::string time_left(double seconds) {
  const auto s = static_cast<std::uint64_t>(std::ceil(seconds));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

}  // namespace

Progress::Progress(std::string what, std::uint64_t frames)
    : what_(std::move(what)), frames_(frames), is_terminal_(os::stderr_is_terminal()) {}

void Progress::draw(std::uint64_t frames_done, Clock::time_point now) {
  next_ = now + kRedrawEvery;
  drawn_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double per_frame = seconds / static_cast<double>(frames_done);
  const double left = per_frame * static_cast<double>(frames_ - frames_done);
  fmt::print(stderr, "{}{}  frame {} of {}  {:.2f} ms a frame  {} left", kWipeLine, what_, frames_done, frames_,
             per_frame * 1000, time_left(left));
  std::fflush(stderr);
}

void Progress::clear() {
  if (!drawn_) return;
  std::fputs(kWipeLine, stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace psim::cli
