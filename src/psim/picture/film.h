// The pictures of a run: when one is due, what it shows, where it goes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "picture/film_clock.h"
#include "picture/painter.h"
#include "picture/video.h"

namespace psim::cli {

class Film {
 public:
  /// Finds out whether the pictures can be written, before the run: throws UserError. `video` is the open
  /// file of --video, if it was given. All arguments are used as long as the film lives. The pictures do not depend on
  /// the threads.
  Film(const PictureOptions& options, const Scene& scene, AtomicFile* video, int threads);

  /// Draws what is due once `frame` is done; frame 0 is the start. What cannot be written ends the
  /// film and not the run; finish() says so.
  void after(std::uint64_t frame, World& world);

  /// Completes the film. Throws UserError if something could not be written.
  void finish();

 private:
  void draw(const Moment& moment);
  void write();
  void write_frame_file();
  void warn_of_old_frames() const;
  std::string frame_path(std::uint64_t picture) const;

  const PictureOptions& options_;
  const Scene& scene_;
  int threads_;
  Painter painter_;
  FilmView view_;
  std::optional<FilmClock> clock_;  // since the first frame: a restored world has a dt of its own
  PictureSize size_;
  Canvas canvas_;
  std::optional<VideoWriter> video_;
  std::optional<Brightest> bright_;  // follows the bodies softly
  const std::size_t joints_;         // of the scene, with those of links
  Moment now_, before_, between_;
  std::vector<std::uint8_t> rgb_;
  std::uint64_t written_ = 0;
  std::string failure_;
};

}  // namespace psim::cli
