#include <fcntl.h>
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
#include <system_error>

#include "os/program.h"

namespace psim::os {
namespace {

constexpr int kPipeBytes = 1 << 20;  // the most that Linux lets anyone have

void close_once(int& fd) {
  if (fd >= 0) ::close(fd);
  fd = -1;
}

bool is_program(const std::string& path) {
  struct stat file = {};
  return ::stat(path.c_str(), &file) == 0 && S_ISREG(file.st_mode) && ::access(path.c_str(), X_OK) == 0;
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

}  // namespace

struct PipedProgram::Process {
  pid_t id = -1;
  int pipe = -1;      // to its stdin
  int messages = -1;  // a file in memory that gets its stderr
  void (*old_sigpipe)(int) = SIG_DFL;
  int start(std::vector<char*>& argv, int file, int input);
};

bool can_start_programs() { return true; }

std::string find_program(std::string_view name) {
  const char* const path = std::getenv("PATH");
  std::string_view left = path != nullptr ? path : "";
  while (!left.empty()) {
    const std::size_t end = std::min(left.find(':'), left.size());
    std::string program = std::string(left.substr(0, end)) + "/" + std::string(name);
    if (end > 0 && is_program(program)) return program;
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return {};
}

// Returns the error of posix_spawn.
int PipedProgram::Process::start(std::vector<char*>& argv, int file, int input) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, file, kFileOfProgram);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (messages >= 0) {
    posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
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
  const int error = posix_spawn(&id, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

PipedProgram::PipedProgram(const std::vector<std::string>& words, int file) : process_(std::make_unique<Process>()) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "no pipe to it");
  process_->pipe = ends[1];
  ::fcntl(ends[1], F_SETPIPE_SZ, kPipeBytes);
  process_->messages = ::memfd_create("stderr of a program", MFD_CLOEXEC);
  std::vector<std::string> copies = words;
  std::vector<char*> argv;
  argv.reserve(copies.size() + 1);
  for (std::string& word : copies) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int error = process_->start(argv, file, ends[0]);
  close_once(ends[0]);
  if (error != 0) {
    close_once(process_->pipe);
    close_once(process_->messages);
    throw std::system_error(error, std::generic_category(), "does not start");
  }
  // A pipe whose reader has ended is an error to report, not a signal to die of.
  process_->old_sigpipe = std::signal(SIGPIPE, SIG_IGN);
}

PipedProgram::~PipedProgram() {
  if (process_->id > 0) {
    ::kill(process_->id, SIGKILL);
    wait();
  }
  close_once(process_->messages);
  std::signal(SIGPIPE, process_->old_sigpipe);
}

bool PipedProgram::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(process_->pipe, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

std::string PipedProgram::wait() {
  close_once(process_->pipe);
  int status = 0;
  while (::waitpid(process_->id, &status, 0) < 0 && errno == EINTR) {
  }
  process_->id = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (process_->messages >= 0) {
    if (const std::string text = read_all(process_->messages); !last_line(text).empty()) {
      return std::string(last_line(text));
    }
  }
  return WIFSIGNALED(status) ? "ended by signal " + std::to_string(WTERMSIG(status))
                             : "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace psim::os
