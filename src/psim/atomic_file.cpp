#include "atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "text.h"
#include "user_error.h"

namespace psim::cli {
namespace {

constexpr mode_t kAnyoneByUmask = 0666;

std::string directory_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

// A link is followed, so that the file behind it is replaced and not the link. A file that does
// not exist yet keeps its name.
std::string resolved(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr),
                                                         &std::free);
  return real ? std::string(real.get()) : path;
}

bool is_same_file(const struct stat& file, int fd) {
  struct stat other = {};
  return ::fstat(fd, &other) == 0 && other.st_dev == file.st_dev && other.st_ino == file.st_ino;
}

}  // namespace

AtomicFile::AtomicFile(std::string_view option, const std::string& path)
    : label_(fmt::format("{} {}", option, one_line(path))), target_(resolved(path)) {
  open();
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::refuse(int error) const {
  throw UserError(fmt::format("{}: cannot be written: {}", label_, std::strerror(error)));
}

void AtomicFile::open() {
  struct stat old = {};
  const bool exists = ::stat(target_.c_str(), &old) == 0;
  if (exists) {
    if (S_ISDIR(old.st_mode)) refuse(EISDIR);
    if (::access(target_.c_str(), W_OK) != 0) refuse(errno);
    for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) {
      if (fd_ < 0 && is_same_file(old, standard)) fd_ = ::dup(standard);
    }
    if (fd_ < 0 && !S_ISREG(old.st_mode)) {
      fd_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
      if (fd_ < 0) refuse(errno);
    }
    straight_ = fd_ >= 0;
    if (straight_) return;
  }
  const std::string directory = directory_of(target_);
  if (target_.ends_with('/')) refuse(EISDIR);
  const bool can_be_named_later = ::access("/proc/self/fd", X_OK) == 0;
  errno = EOPNOTSUPP;
  if (can_be_named_later) {
    fd_ = ::open(directory.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, kAnyoneByUmask);
  }
  if (fd_ < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
    temporary_ = fmt::format("{}/.psim-{}.XXXXXX", directory, ::getpid());
    fd_ = ::mkostemp(temporary_.data(), O_CLOEXEC);
    if (fd_ < 0) temporary_.clear();
    if (fd_ >= 0 && !exists) {
      const mode_t mask = ::umask(0);
      ::umask(mask);
      ::fchmod(fd_, kAnyoneByUmask & ~mask);
    }
  }
  if (fd_ < 0) refuse(errno);
  if (exists) ::fchmod(fd_, old.st_mode & 07777);
  // The final name itself may be refused (too long, say); find out now.
  if (!exists && ::access(target_.c_str(), F_OK) != 0 && errno != ENOENT) refuse(errno);
}

std::string AtomicFile::path_for_program(int there) const {
  if (!temporary_.empty()) return temporary_;
  return fmt::format("/proc/self/fd/{}", there);
}

void AtomicFile::flush() {
  std::string_view left = buffer_;
  while (!left.empty() && write_error_ == 0) {
    const ssize_t n = ::write(fd_, left.data(), left.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      write_error_ = errno;
    } else {
      left.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  buffer_.clear();
}

// A nameless file cannot take a name that is in use, so it gets a temporary one first.
void AtomicFile::name_the_file() {
  if (temporary_.empty()) {
    const std::string nameless = fmt::format("/proc/self/fd/{}", fd_);
    const std::string directory = directory_of(target_);
    int error = EEXIST;
    for (int attempt = 0; error == EEXIST && attempt < 1000; ++attempt) {
      const std::string name = fmt::format("{}/.psim-{}.{}", directory, ::getpid(), attempt);
      const int linked =
          ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW);
      error = linked == 0 ? 0 : errno;
      if (error == 0) temporary_ = name;
    }
    if (error != 0) refuse(error);
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) refuse(errno);
  temporary_.clear();
}

void AtomicFile::commit() {
  flush();
  if (write_error_ != 0) refuse(write_error_);
  if (!straight_) name_the_file();
  const int closed = ::close(fd_);
  fd_ = -1;
  if (closed != 0) refuse(errno);
}

}  // namespace psim::cli
