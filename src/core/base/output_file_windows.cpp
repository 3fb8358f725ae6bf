#include <fcntl.h>
#include <io.h>
#include <windows.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>

#include "base/os.h"
#include "base/output_file.h"

namespace psim {

struct OutputFile::Old {
  DWORD attributes;
};

namespace {

constexpr int kMostNames = 1000;
constexpr std::size_t kLongestName = 255;  // of a file without its folders, on NTFS
constexpr std::size_t kMostAtOnce = 1 << 30;

// The errors of the C library are what psim words.
int errno_of(DWORD error) {
  switch (error) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME:
    case ERROR_BAD_NETPATH:
      return ENOENT;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
    case ERROR_WRITE_PROTECT:
      return EACCES;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS:
      return EEXIST;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
      return ENOSPC;
    case ERROR_DIRECTORY:
      return ENOTDIR;
    case ERROR_FILENAME_EXCED_RANGE:
      return ENAMETOOLONG;
    default:
      return EIO;
  }
}

HANDLE handle_of(int fd) { return reinterpret_cast<HANDLE>(::_get_osfhandle(fd)); }

// Whether the file goes when its last handle is closed, which the end of the process does too.
bool mark_to_go(HANDLE file, bool goes) {
  FILE_DISPOSITION_INFO mark{};
  mark.DeleteFile = goes;
  return ::SetFileInformationByHandle(file, FileDispositionInfo, &mark, sizeof mark) != 0;
}

int descriptor_of(HANDLE file) {
  const int fd = ::_open_osfhandle(reinterpret_cast<std::intptr_t>(file), _O_BINARY | _O_NOINHERIT);
  if (fd < 0) ::CloseHandle(file);
  return fd;
}

}  // namespace

OutputFile::OutputFile(const std::string& path) {
  const Old old{::GetFileAttributesW(os::path_of(path).c_str())};
  const bool exists = old.attributes != INVALID_FILE_ATTRIBUTES;
  if (exists && (old.attributes & FILE_ATTRIBUTE_DIRECTORY) != 0) {
    fail(EISDIR);
  } else if (exists && (old.attributes & FILE_ATTRIBUTE_READONLY) != 0) {
    fail(EACCES);
  } else if (!open_straight(path, old) && error_ == 0 && find_target(path, exists)) {
    open_beside(exists);
  }
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) ::_close(fd_);
  if (!temporary_.empty()) ::DeleteFileW(os::path_of(temporary_).c_str());  // after path_for_program
}

bool OutputFile::fail(int error) {
  if (error_ == 0) error_ = error;
  return false;
}

// Devices (NUL, CON) and pipes (\\.\pipe\...) are no files of a disk.
bool OutputFile::open_straight(const std::string& path, const Old&) {
  const HANDLE file = ::CreateFileW(os::path_of(path).c_str(), GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE,
                                    nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) {
    const int error = errno_of(::GetLastError());
    return error == ENOENT ? false : fail(error);
  }
  if (::GetFileType(file) == FILE_TYPE_DISK) {
    ::CloseHandle(file);
    return false;
  }
  fd_ = descriptor_of(file);
  return fd_ >= 0 || fail(errno);
}

bool OutputFile::find_target(const std::string& name, bool exists) {
  std::filesystem::path path = os::path_of(name);
  std::error_code failed;
  if (path.empty()) return fail(ENOENT);
  if (!path.has_filename()) return fail(EISDIR);
  if (path.filename().native().size() > kLongestName) return fail(ENAMETOOLONG);
  path = exists ? canonical(path, failed) : absolute(path, failed);
  if (failed) return fail(failed.default_error_condition().value());
  target_ = os::name_of(path);
  return true;
}

// Gives `take` names beside the target until it takes one. Returns its last error.
int OutputFile::take_name(const std::function<bool(const std::string&)>& take) {
  static std::atomic<unsigned> count = 0;
  const std::string folder = target_.substr(0, target_.find_last_of("/\\") + 1);
  int error = EEXIST;
  for (int k = 0; error == EEXIST && k < kMostNames; ++k) {
    temporary_ = folder + ".psim-" + std::to_string(::GetCurrentProcessId()) + "." + std::to_string(count++);
    error = take(temporary_) ? 0 : errno_of(::GetLastError());
  }
  if (error != 0) temporary_.clear();
  return error;
}

// MoveFileEx opens the file beside us, so it is shared.
void OutputFile::open_beside(bool) {
  HANDLE file = INVALID_HANDLE_VALUE;
  const int error = take_name([&](const std::string& name) {
    file = ::CreateFileW(os::path_of(name).c_str(), GENERIC_WRITE | DELETE,
                         FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr, CREATE_NEW,
                         FILE_ATTRIBUTE_NORMAL, nullptr);
    return file != INVALID_HANDLE_VALUE;
  });
  if (error != 0) {
    fail(error);
  } else if (!mark_to_go(file, true)) {
    fail(errno_of(::GetLastError()));
    ::CloseHandle(file);
  } else {
    fd_ = descriptor_of(file);
    if (fd_ < 0) fail(errno);
  }
}

// Other programs do not open a file that is marked to go, nor one that is open here to be deleted.
std::string OutputFile::path_for_program(int) {
  if (fd_ >= 0 && !target_.empty()) {
    mark_to_go(handle_of(fd_), false);
    ::_close(fd_);
    fd_ = -1;
  }
  return temporary_;
}

void OutputFile::write(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size != 0 && error_ == 0) {
    const int n = ::_write(fd_, from, static_cast<unsigned>(std::min(size, kMostAtOnce)));
    if (n <= 0) {
      fail(n < 0 ? errno : ENOSPC);
    } else {
      from += n;
      size -= static_cast<std::size_t>(n);
    }
  }
}

bool OutputFile::give_name(bool to_disk) {
  if (fd_ >= 0) {  // or another program has written it
    const HANDLE file = handle_of(fd_);
    if (to_disk && ::FlushFileBuffers(file) == 0) return fail(errno_of(::GetLastError()));
    if (!mark_to_go(file, false)) return fail(errno_of(::GetLastError()));
  }
  const DWORD how = MOVEFILE_REPLACE_EXISTING | (to_disk ? MOVEFILE_WRITE_THROUGH : 0);
  if (::MoveFileExW(os::path_of(temporary_).c_str(), os::path_of(target_).c_str(), how) == 0) {
    return fail(errno_of(::GetLastError()));
  }
  temporary_.clear();
  return true;
}

bool OutputFile::commit(bool to_disk) {
  if (error_ != 0) return false;
  if (!target_.empty() && !give_name(to_disk)) return false;
  const int closed = fd_ >= 0 ? ::_close(fd_) : 0;
  fd_ = -1;
  return closed == 0 || fail(errno);
}

}  // namespace psim
