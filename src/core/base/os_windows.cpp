#include <windows.h>

#include <cerrno>
#include <chrono>
#include <new>

#include "base/os.h"

namespace psim::os {

std::filesystem::path path_of(std::string_view utf8) {
  return std::u8string_view(reinterpret_cast<const char8_t*>(utf8.data()), utf8.size());
}

std::string name_of(const std::filesystem::path& path) {
  const std::u8string name = path.u8string();
  return {name.begin(), name.end()};
}

FileToRead open_to_read(const std::string& name) {
  const std::filesystem::path path = path_of(name);
  FileToRead file(::_wfopen(path.c_str(), L"rbN"));
  std::error_code ignored;
  if (!file && is_directory(path, ignored)) errno = EISDIR;  // it says EACCES
  return file;
}

// Pages of 2 MiB take a privilege, and the system aligns to 64 KiB, which is enough for those that there are.
void* take_pages(std::size_t bytes) {
  void* const begin = ::VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
  if (begin == nullptr) throw std::bad_alloc();
  return begin;
}

void give_pages_back(void* begin, std::size_t) { ::VirtualFree(begin, 0, MEM_RELEASE); }

// The thread's own times come in steps of 16 ms, so the clock has to do: who measures takes the least of several.
double thread_work_ns() {
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace psim::os
