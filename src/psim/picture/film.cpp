#include "picture/film.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/os.h"
#include "os/console.h"
#include "output/text.h"
#include "output/user_error.h"
#include "picture/png_write.h"

namespace psim::cli {
namespace {

constexpr PictureSize kFilmSize{1920, 1080};

void require_directory(const std::string& path) {
  if (const int error = os::folder_error(path); error != 0) {
    throw UserError(fmt::format("--frames-dir {}: needs a directory that can be written to: {}", one_line(path),
                                std::strerror(error)));
  }
}

}  // namespace

Film::Film(const PictureOptions& options, const Scene& scene, AtomicFile* video, int threads)
    : options_(options),
      scene_(scene),
      threads_(threads),
      painter_(scene, options),
      view_(scene, painter_.shapes()),
      size_(options.size.value_or(kFilmSize)),
      canvas_(size_.width, size_.height),
      joints_(joints_of(scene)) {
  if (!options.frames_dir.empty()) require_directory(options.frames_dir);
  if (video != nullptr) {
    video_.emplace(*video, find_ffmpeg(video->label()), size_, options.fps);
  }
}

void Film::after(std::uint64_t frame, World& world) {
  if (!failure_.empty()) return;
  if (!clock_) clock_.emplace(world.desc().dt, options_.fps, options_.every);
  bool is_taken = false;
  while (const std::optional<double> share = clock_->due(frame)) {
    if (!is_taken) take_moment(world, now_, options_.colouring, joints_);
    is_taken = true;
    if (*share < 1) place_between(before_, now_, *share, scene_.world, between_);
    draw(*share < 1 ? between_ : now_);
    if (!failure_.empty()) return;
  }
  if (!clock_->is_between(frame)) return;
  if (!is_taken) take_moment(world, now_, options_.colouring, joints_);
  std::swap(before_, now_);
}

void Film::draw(const Moment& moment) {
  constexpr double kFollow = 0.1;  // of the way a picture: colours do not flicker
  const Brightest now = brightest(scene_, moment, painter_.shapes());
  if (!bright_) bright_ = now;
  bright_->speed += kFollow * (now.speed - bright_->speed);
  bright_->spin += kFollow * (now.spin - bright_->spin);
  bright_->force += kFollow * (now.force - bright_->force);
  bright_->fluid_speed += kFollow * (now.fluid_speed - bright_->fluid_speed);
  bright_->pressure += kFollow * (now.pressure - bright_->pressure);
  const Bounds view = options_.view ? *options_.view : view_.follow(moment);
  painter_.paint(canvas_, PictureCamera(view, size_.width, size_.height), moment, *bright_);
  canvas_.to_srgb(rgb_, threads_);
  try {
    if (!options_.frames_dir.empty()) write_frame_file();
    if (video_) video_->add(rgb_);
    ++written_;
  } catch (const UserError& error) {
    failure_ = error.what();
    video_.reset();
  }
}

std::string Film::frame_path(std::uint64_t picture) const {
  return fmt::format("{}/frame_{:06}.png", options_.frames_dir, picture);
}

void Film::write_frame_file() {
  AtomicFile file("--frames-dir", frame_path(written_));
  write_png(file, size_.width, size_.height, rgb_, threads_);
  file.commit(Durable::no);  // the next one follows soon
}

// A film that was longer leaves frames that would be taken for this one's.
void Film::warn_of_old_frames() const {
  const std::string next = frame_path(written_);
  std::error_code ignored;
  if (options_.frames_dir.empty() || !exists(os::path_of(next), ignored)) return;
  fmt::print(stderr, "psim: --frames-dir {}: {} pictures were written; {} and what follows it is from before\n",
             one_line(options_.frames_dir), written_, fmt::format("frame_{:06}.png", written_));
}

void Film::finish() {
  if (!failure_.empty()) throw UserError(failure_);
  warn_of_old_frames();
  if (video_) video_->finish();
}

}  // namespace psim::cli
