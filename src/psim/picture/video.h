// Pictures in, an MP4 file (H.264) out: ffmpeg, a program of its own, gets them through a pipe.
//
// ffmpeg writes into the nameless file of an AtomicFile, which takes its name only after ffmpeg has
// ended well: neither Ctrl-C nor a crash leaves a film that only looks complete. ffmpeg stands in a
// process group of its own, so that Ctrl-C in a terminal reaches psim alone, which then ends the film.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>

#include "options/picture_options.h"
#include "output/atomic_file.h"

namespace psim::cli {

/// The path of ffmpeg. Throws UserError, with `label` (option and file) in front, if PATH has none.
std::string find_ffmpeg(const std::string& label);

class VideoWriter {
 public:
  /// Starts ffmpeg. Both sides of the pictures must be even. Throws UserError.
  VideoWriter(AtomicFile& file, const std::string& ffmpeg, PictureSize size, double fps);
  /// Without finish(): ffmpeg is stopped, and the file is not named.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Hands over a picture, rows from the top, 3 bytes a pixel. Waits while ffmpeg is behind. Throws
  /// UserError with what ffmpeg said if it has ended.
  void add(std::span<const std::uint8_t> rgb);

  /// Waits for ffmpeg's end and names the file. Throws UserError.
  void finish();

 private:
  void start(const std::string& ffmpeg, PictureSize size, double fps);
  int wait();
  [[noreturn]] void refuse_failed(int status);

  AtomicFile& file_;
  pid_t process_ = -1;
  int pipe_ = -1;      // to ffmpeg's stdin
  int messages_ = -1;  // a file in memory that gets ffmpeg's stderr
  void (*old_sigpipe_)(int) = nullptr;
};

}  // namespace psim::cli
