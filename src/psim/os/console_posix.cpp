#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <limits>

#include "os/console.h"
#include "os/interrupt.h"

namespace psim::os {
namespace {

std::atomic<bool> interrupt_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may write it");

void on_signal(int) { interrupt_flag.store(true, std::memory_order_relaxed); }

// A line like "MemAvailable:   12345 kB" of /proc/meminfo or /proc/self/status.
std::uint64_t kib_line(const char* file, std::string_view key, std::uint64_t if_missing) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t digit = line.find_first_of("0123456789");
    if (digit != std::string::npos) return 1024 * std::stoull(line.substr(digit));
  }
  return if_missing;
}

}  // namespace

Console::Console() = default;
Console::~Console() { (void)code_page_; }

std::vector<std::string> command_line(int argc, const char* const* argv) { return {argv, argv + argc}; }

bool stderr_is_terminal() { return ::isatty(STDERR_FILENO) == 1; }

std::uint64_t available_bytes() {
  std::uint64_t available = kib_line("/proc/meminfo", "MemAvailable:", std::numeric_limits<std::uint64_t>::max());
  std::uint64_t group = 0;
  if (std::ifstream limit("/sys/fs/cgroup/memory.max"); limit >> group) {
    available = std::min(available, group);
  }
  struct rlimit own = {};
  if (::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY) {
    const std::uint64_t used = kib_line("/proc/self/status", "VmSize:", 0);
    available = std::min<std::uint64_t>(available, own.rlim_cur - std::min<std::uint64_t>(used, own.rlim_cur));
  }
  return available;
}

std::uint64_t page_faults() {
  struct rusage usage = {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_minflt) + static_cast<std::uint64_t>(usage.ru_majflt);
}

int folder_error(const std::string& folder) {
  struct stat file = {};
  if (::stat(folder.c_str(), &file) != 0) return errno;
  if (!S_ISDIR(file.st_mode)) return ENOTDIR;
  return ::access(folder.c_str(), W_OK | X_OK) != 0 ? errno : 0;
}

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  // One shot: the handler is gone when the second signal comes, and that one ends the process.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return interrupt_flag.load(std::memory_order_relaxed); }

}  // namespace psim::os
