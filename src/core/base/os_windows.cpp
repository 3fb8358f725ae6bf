#include <windows.h>

#include "base/os.h"

namespace psim::os {

std::filesystem::path path_of(std::string_view utf8) {
  return std::u8string_view(reinterpret_cast<const char8_t*>(utf8.data()), utf8.size());
}

std::string name_of(const std::filesystem::path& path) {
  const std::u8string name = path.u8string();
  return {name.begin(), name.end()};
}

FileToRead open_to_read(const std::string& name) { return FileToRead(::_wfopen(path_of(name).c_str(), L"rbN")); }

double thread_work_ns() {
  FILETIME created, ended, in_kernel, in_program;
  if (::GetThreadTimes(::GetCurrentThread(), &created, &ended, &in_kernel, &in_program) == 0) return 0;
  const auto ns = [](const FILETIME& t) {
    return 100 * (4294967296.0 * static_cast<double>(t.dwHighDateTime) + static_cast<double>(t.dwLowDateTime));
  };
  return ns(in_kernel) + ns(in_program);
}

}  // namespace psim::os
