// Films where a program cannot start another one, as in WebAssembly: refused before anything is computed.
#include "output/user_error.h"
#include "picture/video.h"

namespace psim::cli {

std::string find_ffmpeg(const std::string& label) {
  throw UserError(label + ": psim cannot start ffmpeg on this platform; --frames-dir writes the pictures of a film");
}

VideoWriter::VideoWriter(AtomicFile& file, const std::string& ffmpeg, PictureSize size, double fps) : file_(file) {
  start(ffmpeg, size, fps);
}
VideoWriter::~VideoWriter() = default;
void VideoWriter::add(std::span<const std::uint8_t>) {}
void VideoWriter::finish() {}
void VideoWriter::start(const std::string& ffmpeg, PictureSize, double) { find_ffmpeg(ffmpeg); }

}  // namespace psim::cli
