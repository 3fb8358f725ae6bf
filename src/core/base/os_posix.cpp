#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <new>

#include "base/os.h"

namespace psim::os {

#if !defined(__EMSCRIPTEN__)
namespace {

void* at(std::uintptr_t address) { return reinterpret_cast<void*>(address); }  // NOLINT(performance-no-int-to-ptr)

std::size_t rounded(std::size_t bytes) {
  static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return (bytes + page - 1) / page * page;
}

}  // namespace
#endif

std::filesystem::path path_of(std::string_view utf8) { return utf8; }

std::string name_of(const std::filesystem::path& path) { return path.string(); }

FileToRead open_to_read(const std::string& name) { return FileToRead(std::fopen(name.c_str(), "rbe")); }

void* take_pages(std::size_t bytes) {
#if defined(__EMSCRIPTEN__)
  void* const begin = ::operator new (bytes, std::align_val_t{kLargePage});
  return std::memset(begin, 0, bytes);
#else
  // The system places pages of any size where it likes: what lies around a multiple of kLargePage goes back.
  constexpr std::uintptr_t page = kLargePage;
  void* const all = ::mmap(nullptr, bytes + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) throw std::bad_alloc();
  const auto low = reinterpret_cast<std::uintptr_t>(all), begin = (low + page - 1) / page * page;
  const std::uintptr_t end = begin + rounded(bytes);
  if (begin != low) ::munmap(all, begin - low);
  if (end != low + rounded(bytes + page)) ::munmap(at(end), low + rounded(bytes + page) - end);
#if defined(MADV_HUGEPAGE)
  (void)::madvise(at(begin), bytes / kLargePage * kLargePage, MADV_HUGEPAGE);
#endif
  return at(begin);
#endif
}

void give_pages_back(void* begin, std::size_t bytes) {
#if defined(__EMSCRIPTEN__)
  ::operator delete (begin, std::align_val_t{kLargePage});
  (void)bytes;
#else
  ::munmap(begin, rounded(bytes));
#endif
}

double thread_work_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

}  // namespace psim::os
