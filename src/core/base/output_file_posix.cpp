#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>

#include "base/output_file.h"

namespace psim {

struct OutputFile::Old : stat {};

namespace {

constexpr mode_t kAnyoneByUmask = 0666, kOwner = 0600, kGroup = 0070, kPermissions = 0777;
constexpr int kMostNames = 1000;
constexpr int kMostLinks = 40;  // the limit of Linux

std::string path_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

bool is_same_file(const struct stat& file, int fd) {
  struct stat other = {};
  return ::fstat(fd, &other) == 0 && other.st_dev == file.st_dev && other.st_ino == file.st_ino;
}

void keep_owner_and_mode(int fd, const struct stat& old) {
  mode_t mode = old.st_mode & kPermissions;
  if (::fchown(fd, old.st_uid, old.st_gid) != 0 && ::fchown(fd, static_cast<uid_t>(-1), old.st_gid) != 0) {
    mode &= ~kGroup;  // the permissions would go to another group
  }
  ::fchmod(fd, mode);
}

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

}  // namespace

OutputFile::OutputFile(const std::string& path) {
  Old old = {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) {
    fail(errno);
  } else if (exists && S_ISDIR(old.st_mode)) {
    fail(EISDIR);
  } else if (exists && ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) != 0) {
    fail(errno);
  } else if ((!exists || !open_straight(path, old)) && error_ == 0 && find_target(path, exists)) {
    open_beside(exists);
    if (exists && fd_ >= 0) keep_owner_and_mode(fd_, old);
  }
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

bool OutputFile::fail(int error) {
  if (error_ == 0) error_ = error;
  return false;
}

bool OutputFile::open_straight(const std::string& path, const Old& old) {
  for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) {
    if (fd_ < 0 && is_same_file(old, standard)) fd_ = ::fcntl(standard, F_DUPFD_CLOEXEC, 0);
  }
  if (fd_ < 0 && !S_ISREG(old.st_mode)) {
    fd_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd_ < 0) return fail(errno);
  }
  return fd_ >= 0;
}

// Resolves links, so that the file behind a link is replaced and not the link, and so that the process may change its
// folder meanwhile. A link may lead to a file that does not exist yet.
bool OutputFile::find_target(const std::string& name, bool exists) {
  std::filesystem::path path = name;
  std::error_code failed;
  for (int k = 0; k < kMostLinks && !exists; ++k) {
    const std::filesystem::path to = std::filesystem::read_symlink(path, failed);
    if (failed) break;
    path = path.parent_path() / to;  // an absolute target replaces the folder
  }
  if (path.empty()) return fail(ENOENT);
  if (!path.has_filename()) return fail(EISDIR);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  path = exists ? canonical(path, failed) : canonical(folder, failed) / path.filename();
  if (failed) return fail(failed.value());
  target_ = path;
  return true;
}

// Gives `take` names beside the target until it takes one. Returns its last error.
int OutputFile::take_name(const std::function<bool(const std::string&)>& take) {
  static std::atomic<unsigned> count = 0;
  int error = EEXIST;
  for (int k = 0; error == EEXIST && k < kMostNames; ++k) {
    temporary_ = folder_of(target_) + ".psim-" + std::to_string(::getpid()) + "." + std::to_string(count++);
    error = take(temporary_) ? 0 : errno;
  }
  if (error != 0) temporary_.clear();
  return error;
}

void OutputFile::open_beside(bool exists) {
  const mode_t mode = exists ? kOwner : kAnyoneByUmask;
  int error = EOPNOTSUPP;
  if (::access("/proc/self/fd", X_OK) == 0) {  // it can be named later
    fd_ = ::open(folder_of(target_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, mode);
    error = errno;
  }
  if (fd_ < 0 && (error == EOPNOTSUPP || error == EISDIR || error == EINVAL)) {
    error = take_name([&](const std::string& name) {
      fd_ = ::open(name.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, mode);
      return fd_ >= 0;
    });
  }
  if (fd_ < 0) fail(error);
}

std::string OutputFile::path_for_program(int there) { return temporary_.empty() ? path_of(there) : temporary_; }

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
    const int error = take_name([&](const std::string& name) {
      return ::linkat(AT_FDCWD, path_of(fd_).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    });
    if (error != 0) return fail(error);
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    fail(errno);
    ::unlink(temporary_.c_str());
  }
  temporary_.clear();
  if (error_ != 0 || !to_disk) return error_ == 0;
  const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {  // errors are ignored: the file is in its place, only a power cut could still lose its name
    ::fsync(folder);
    ::close(folder);
  }
  return true;
}

bool OutputFile::commit(bool to_disk) {
  if (error_ != 0) return false;
  if (!target_.empty() && !give_name(to_disk)) return false;
  const int closed = ::close(fd_);
  fd_ = -1;
  return closed == 0 || fail(errno);
}

}  // namespace psim
