// Pictures in, an MP4 file (H.264) out: ffmpeg, a program of its own, gets them through a pipe.
//
// ffmpeg writes into the nameless file of an AtomicFile, which takes its name only after ffmpeg has
// ended well: neither Ctrl-C nor a crash leaves a film that only looks complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "options/picture_options.h"
#include "os/program.h"
#include "output/atomic_file.h"

namespace psim::cli {

/// The path of ffmpeg. Throws UserError, with `label` (option and file) in front, if PATH has none.
std::string find_ffmpeg(const std::string& label);

class VideoWriter {
 public:
  /// Starts ffmpeg. Both sides of the pictures must be even. Throws UserError.
  VideoWriter(AtomicFile& file, const std::string& ffmpeg, PictureSize size, double fps);
  // Without finish(): ffmpeg is stopped, and the file is not named.

  /// Hands over a picture, rows from the top, 3 bytes a pixel. Waits while ffmpeg is behind. Throws
  /// UserError with what ffmpeg said if it has ended.
  void add(std::span<const std::uint8_t> rgb);

  /// Waits for ffmpeg's end and names the file. Throws UserError.
  void finish();

 private:
  [[noreturn]] void refuse_failed(std::string_view why);

  AtomicFile& file_;
  os::PipedProgram ffmpeg_;
};

}  // namespace psim::cli
