// When a picture of a film is due.
#pragma once

#include <cstdint>
#include <optional>

namespace psim::cli {

/// Which moments of a run are drawn. Picture k is that of the time k / fps, between two frames by
/// interpolation, or with `every` that of frame k * every. A time within 1 % of a frame's is that frame's.
class FilmClock {
 public:
  FilmClock(double dt_s, double fps, std::optional<std::uint64_t> every) : dt_s_(dt_s), fps_(fps), every_(every) {}

  /// The next picture that is due once `frame` is done: its share of the way from the frame before, 0 to 1.
  /// To be asked until there is none.
  std::optional<double> due(std::uint64_t frame);

  /// Whether the next picture lies between this frame and the one after it.
  bool is_between(std::uint64_t frame) const;

  std::uint64_t pictures() const { return pictures_; }

 private:
  double frames_until_next() const;  // from the start

  double dt_s_, fps_;
  std::optional<std::uint64_t> every_;
  std::uint64_t pictures_ = 0;
};

}  // namespace psim::cli
