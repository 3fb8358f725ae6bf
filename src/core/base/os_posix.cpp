#include <time.h>

#include "base/os.h"

namespace psim::os {

std::filesystem::path path_of(std::string_view utf8) { return utf8; }

std::string name_of(const std::filesystem::path& path) { return path.string(); }

FileToRead open_to_read(const std::string& name) { return FileToRead(std::fopen(name.c_str(), "rbe")); }

double thread_work_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

}  // namespace psim::os
