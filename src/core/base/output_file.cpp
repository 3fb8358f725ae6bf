#include "base/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <memory>

namespace psim {
namespace {

constexpr mode_t kAnyoneByUmask = 0666, kOwner = 0600, kGroup = 0070, kPermissions = 0777;
constexpr int kMostNames = 1000;
constexpr int kMostLinks = 40;  // the limit of Linux

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string name_of(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

// The path with links resolved, or empty if there is no such path; errno says why.
std::string real_path(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
  return real ? std::string(real.get()) : std::string();
}

// The target of a link, which need not exist yet; empty if the path is no link.
std::string link_target(const std::string& path) {
  std::string to(PATH_MAX, '\0');
  const ssize_t n = ::readlink(path.c_str(), to.data(), to.size());
  if (n <= 0) return {};
  to.resize(static_cast<std::size_t>(n));
  return to.front() == '/' ? to : folder_of(path) + "/" + to;
}

bool is_same_file(const struct stat& file, int fd) {
  struct stat other = {};
  return ::fstat(fd, &other) == 0 && other.st_dev == file.st_dev && other.st_ino == file.st_ino;
}

}  // namespace

OutputFile::OutputFile(const std::string& path) { open(path); }

OutputFile::~OutputFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

bool OutputFile::fail(int error) {
  if (error_ == 0) error_ = error;
  return false;
}

void OutputFile::open(const std::string& path) {
  struct stat old = {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) {
    fail(errno);
  } else if (exists && S_ISDIR(old.st_mode)) {
    fail(EISDIR);
  } else if (exists && ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) != 0) {
    fail(errno);
  } else if ((!exists || !open_straight(path, old)) && error_ == 0 && find_target(path, exists)) {
    open_beside(exists);
    if (exists && fd_ >= 0) keep_owner_and_mode(old);
  }
}

bool OutputFile::open_straight(const std::string& path, const struct stat& old) {
  for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) {
    if (fd_ < 0 && is_same_file(old, standard)) fd_ = ::fcntl(standard, F_DUPFD_CLOEXEC, 0);
  }
  if (fd_ < 0 && !S_ISREG(old.st_mode)) {
    fd_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd_ < 0) return fail(errno);
  }
  straight_ = fd_ >= 0;
  return straight_;
}

// Resolves links, so that the file behind a link is replaced and not the link, and so that the process may change its
// folder meanwhile.
bool OutputFile::find_target(std::string path, bool exists) {
  if (exists) {
    target_ = real_path(path);
    if (target_.empty()) return fail(errno);
    folder_ = folder_of(target_);
    return true;
  }
  for (int k = 0; k < kMostLinks; ++k) {
    const std::string to = link_target(path);
    if (to.empty()) break;
    path = to;
  }
  if (path.empty()) return fail(ENOENT);
  if (path.back() == '/') return fail(EISDIR);
  folder_ = real_path(folder_of(path));
  if (folder_.empty()) return fail(errno);
  target_ = folder_ + "/" + name_of(path);
  return true;
}

std::string OutputFile::name_beside() const {
  static std::atomic<unsigned> count = 0;
  return folder_ + "/.psim-" + std::to_string(::getpid()) + "." + std::to_string(count++);
}

void OutputFile::open_beside(bool exists) {
  const mode_t mode = exists ? kOwner : kAnyoneByUmask;
  const bool can_be_named_later = ::access("/proc/self/fd", X_OK) == 0;
  errno = EOPNOTSUPP;
  if (can_be_named_later) fd_ = ::open(folder_.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, mode);
  if (fd_ < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
    errno = EEXIST;
    for (int k = 0; fd_ < 0 && errno == EEXIST && k < kMostNames; ++k) {
      temporary_ = name_beside();
      fd_ = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, mode);
    }
    if (fd_ < 0) temporary_.clear();
  }
  if (fd_ < 0) fail(errno);
}

void OutputFile::keep_owner_and_mode(const struct stat& old) {
  mode_t mode = old.st_mode & kPermissions;
  if (::fchown(fd_, old.st_uid, old.st_gid) != 0 && ::fchown(fd_, static_cast<uid_t>(-1), old.st_gid) != 0) {
    mode &= ~kGroup;  // the permissions would go to another group
  }
  ::fchmod(fd_, mode);
}

std::string OutputFile::path_for_program(int there) const {
  return temporary_.empty() ? "/proc/self/fd/" + std::to_string(there) : temporary_;
}

void OutputFile::write(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size != 0 && error_ == 0) {
    const ssize_t n = ::write(fd_, from, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      fail(errno);
    } else {
      from += n;
      size -= static_cast<std::size_t>(n);
    }
  }
}

// A nameless file cannot take a name that is in use, so it gets a temporary one first.
bool OutputFile::give_name(bool to_disk) {
  const auto no_disk = [] { return errno == EINVAL || errno == EOPNOTSUPP || errno == EROFS; };
  if (to_disk && ::fsync(fd_) != 0 && !no_disk()) return fail(errno);
  if (temporary_.empty()) {
    const std::string nameless = "/proc/self/fd/" + std::to_string(fd_);
    int error = EEXIST;
    for (int k = 0; error == EEXIST && k < kMostNames; ++k) {
      const std::string name = name_beside();
      const int linked = ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW);
      error = linked == 0 ? 0 : errno;
      if (error == 0) temporary_ = name;
    }
    if (error != 0) return fail(error);
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    fail(errno);
    ::unlink(temporary_.c_str());
  }
  temporary_.clear();
  if (error_ != 0 || !to_disk) return error_ == 0;
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {  // errors are ignored: the file is in its place, only a power cut could still lose its name
    ::fsync(folder);
    ::close(folder);
  }
  return true;
}

bool OutputFile::commit(bool to_disk) {
  if (error_ != 0) return false;
  if (!straight_ && !give_name(to_disk)) return false;
  const int closed = ::close(fd_);
  fd_ = -1;
  return closed == 0 || fail(errno);
}

}  // namespace psim
