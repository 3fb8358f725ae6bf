#include "picture/film_clock.h"

#include <algorithm>

namespace psim::cli {
namespace {

constexpr double kSameTime = 0.01;  // of a frame

}  // namespace

double FilmClock::frames_until_next() const {
  const auto next = static_cast<double>(pictures_);
  return every_ ? next * static_cast<double>(*every_) : next / (fps_ * dt_s_);
}

std::optional<double> FilmClock::due(std::uint64_t frame) {
  const double share = frames_until_next() - (static_cast<double>(frame) - 1);
  if (share > 1 + kSameTime) return std::nullopt;
  ++pictures_;
  return share > 1 - kSameTime ? 1 : std::max(share, 0.0);
}

bool FilmClock::is_between(std::uint64_t frame) const {
  const double share = frames_until_next() - static_cast<double>(frame);
  return share > 0 && share <= 1 - kSameTime;
}

}  // namespace psim::cli
