#include "picture/video.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

constexpr int kFileOfChild = 100;    // the file, as ffmpeg has it; no number that psim uses
constexpr int kPipeBytes = 1 << 20;  // the most that Linux lets anyone have

void close_once(int& fd) {
  if (fd >= 0) ::close(fd);
  fd = -1;
}

bool is_program(const std::string& path) {
  struct stat file = {};
  return ::stat(path.c_str(), &file) == 0 && S_ISREG(file.st_mode) && ::access(path.c_str(), X_OK) == 0;
}

// The last line that has something in it.
std::string last_line(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) {
    text.remove_suffix(1);
  }
  const std::size_t before = text.find_last_of("\r\n");
  return one_line(before == std::string_view::npos ? text : text.substr(before + 1));
}

std::string read_all(int fd) {
  std::string text;
  std::array<char, 4096> part;
  ::lseek(fd, 0, SEEK_SET);
  for (ssize_t n; (n = ::read(fd, part.data(), part.size())) > 0;) {
    text.append(part.data(), static_cast<std::size_t>(n));
  }
  return text;
}

// Colours of a high-definition film; the pictures' tone curve is sRGB's, which players take for it.
std::vector<std::string> arguments(const std::string& ffmpeg, const std::string& target, PictureSize size, double fps) {
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
  const char* const path = std::getenv("PATH");
  std::string_view left = path != nullptr ? path : "";
  while (!left.empty()) {
    const std::size_t end = std::min(left.find(':'), left.size());
    std::string program = std::string(left.substr(0, end)) + "/ffmpeg";
    if (end > 0 && is_program(program)) return program;
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  throw UserError(
      fmt::format("{}: needs the program ffmpeg, which PATH does not have; apt install ffmpeg, or "
                  "--frames-dir DIR for the pictures alone",
                  label));
}

VideoWriter::VideoWriter(AtomicFile& file, const std::string& ffmpeg, PictureSize size, double fps) : file_(file) {
  start(ffmpeg, size, fps);
  // A pipe whose reader has ended is an error to report, not a signal to die of.
  old_sigpipe_ = std::signal(SIGPIPE, SIG_IGN);
}

VideoWriter::~VideoWriter() {
  close_once(pipe_);
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    wait();
  }
  close_once(messages_);
  std::signal(SIGPIPE, old_sigpipe_);
}

void VideoWriter::start(const std::string& ffmpeg, PictureSize size, double fps) {
  const auto refuse = [this](std::string_view what, int error) {
    throw UserError(fmt::format("{}: ffmpeg: {}: {}", file_.label(), what, std::strerror(error)));
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) refuse("no pipe to it", errno);
  pipe_ = ends[1];
  int of_child = ends[0];
  ::fcntl(pipe_, F_SETPIPE_SZ, kPipeBytes);
  messages_ = ::memfd_create("ffmpeg's stderr", MFD_CLOEXEC);

  std::vector<std::string> words = arguments(ffmpeg, file_.path_for_program(kFileOfChild), size, fps);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, file_.descriptor(), kFileOfChild);
  posix_spawn_file_actions_adddup2(&actions, of_child, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (messages_ >= 0) {
    posix_spawn_file_actions_adddup2(&actions, messages_, STDERR_FILENO);
  } else {
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t to_default;
  sigemptyset(&to_default);
  for (const int signal : {SIGPIPE, SIGINT, SIGTERM}) sigaddset(&to_default, signal);
  posix_spawnattr_setsigdefault(&attributes, &to_default);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  const int error = posix_spawn(&process_, ffmpeg.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close_once(of_child);
  if (error != 0) {
    process_ = -1;
    close_once(pipe_);
    close_once(messages_);
    refuse("does not start", error);
  }
}

int VideoWriter::wait() {
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

void VideoWriter::refuse_failed(int status) {
  std::string why = messages_ >= 0 ? last_line(read_all(messages_)) : "";
  if (why.empty()) {
    why = WIFSIGNALED(status)        ? fmt::format("ended by signal {}", WTERMSIG(status))
          : WEXITSTATUS(status) == 0 ? std::string("ended without a film")
                                     : fmt::format("exit status {}", WEXITSTATUS(status));
  }
  throw UserError(fmt::format("{}: ffmpeg failed: {}", file_.label(), why));
}

void VideoWriter::add(std::span<const std::uint8_t> rgb) {
  while (!rgb.empty()) {
    const ssize_t n = ::write(pipe_, rgb.data(), rgb.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      close_once(pipe_);
      refuse_failed(wait());
    }
    rgb = rgb.subspan(static_cast<std::size_t>(n));
  }
}

void VideoWriter::finish() {
  close_once(pipe_);
  const int status = wait();
  struct stat film = {};
  const bool is_empty = ::fstat(file_.descriptor(), &film) == 0 && S_ISREG(film.st_mode) && film.st_size == 0;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || is_empty) refuse_failed(status);
  file_.commit();
}

}  // namespace psim::cli
