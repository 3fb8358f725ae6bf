#include "picture/video.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "base/os.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

using os::PipedProgram;

// Colours of a high-definition film; the pictures' tone curve is sRGB's, which players take for it.
std::vector<std::string> command(const std::string& ffmpeg, const std::string& target, PictureSize size, double fps) {
  return {ffmpeg,
          "-hide_banner",
          "-nostdin",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", size.width, size.height),
          "-framerate",
          fmt::format("{}", fps),
          "-i",
          "pipe:0",
          "-vf",
          "scale=out_color_matrix=bt709:out_range=tv",
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "bt709",
          "-color_range",
          "tv",
          "-c:v",
          "libx264",
          "-preset",
          "veryfast",
          "-crf",
          "18",
          "-movflags",
          "+faststart",
          "-f",
          "mp4",
          "file:" + target};
}

}  // namespace

std::string find_ffmpeg(const std::string& label) {
  if (!os::can_start_programs()) {
    throw UserError(label + ": psim cannot start ffmpeg on this platform; --frames-dir writes the pictures of a film");
  }
  if (std::string path = os::find_program("ffmpeg"); !path.empty()) return path;
  throw UserError(fmt::format(
      "{}: needs the program ffmpeg, which PATH does not have; install it (on Debian: apt install ffmpeg), or "
      "--frames-dir DIR for the pictures alone",
      label));
}

VideoWriter::VideoWriter(AtomicFile& file, const std::string& ffmpeg, PictureSize size, double fps) try
    : file_(file),
      ffmpeg_(command(ffmpeg, file.path_for_program(PipedProgram::kFileOfProgram), size, fps), file.descriptor()) {
} catch (const std::system_error& error) {
  throw UserError(fmt::format("{}: ffmpeg: {}", file.label(), error.what()));
}

void VideoWriter::refuse_failed(std::string_view why) {
  throw UserError(
      fmt::format("{}: ffmpeg failed: {}", file_.label(), why.empty() ? "ended without a film" : one_line(why)));
}

void VideoWriter::add(std::span<const std::uint8_t> rgb) {
  if (!ffmpeg_.write(rgb)) refuse_failed(ffmpeg_.wait());
}

void VideoWriter::finish() {
  const std::string why = ffmpeg_.wait();
  std::error_code is_no_file;
  const auto film = os::path_of(file_.path_for_program(file_.descriptor()));
  if (!why.empty() || file_size(film, is_no_file) == 0) refuse_failed(why);
  file_.commit();
}

}  // namespace psim::cli
