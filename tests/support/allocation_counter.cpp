// Replaces the global allocation functions by counting ones. A file of its own, so that no caller
// sees through them.
#include "allocation_counter.h"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::uint64_t> g_allocations{0}, g_first_failing{~0ull}, g_last_failing{0};

void* counted(std::size_t bytes, std::size_t alignment) {
  const std::uint64_t number = g_allocations.fetch_add(1, std::memory_order_relaxed) + 1;
  if (number >= g_first_failing.load(std::memory_order_relaxed) &&
      number <= g_last_failing.load(std::memory_order_relaxed)) {
    throw std::bad_alloc();
  }
  const std::size_t whole = (bytes + alignment - 1) / alignment * alignment;
#ifdef _WIN32
  void* p = _aligned_malloc(whole, alignment);
#else
  void* p = std::aligned_alloc(alignment, whole ? whole : alignment);
#endif
  if (!p) throw std::bad_alloc();
  return p;
}

// The standard library's own temporary room.
void* counted_or_null(std::size_t bytes) noexcept {
  try {
    return counted(bytes, alignof(std::max_align_t));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void give_back(void* p) {
#ifdef _WIN32
  _aligned_free(p);
#else
  std::free(p);
#endif
}

}  // namespace

namespace psim::test {

std::uint64_t allocations() { return g_allocations.load(); }
void fail_allocation(std::uint64_t number, bool all) {
  g_last_failing.store(0);
  g_first_failing.store(number);
  g_last_failing.store(number != 0 && all ? ~std::uint64_t{0} : number);
}

}  // namespace psim::test

void* operator new(std::size_t bytes) { return counted(bytes, alignof(std::max_align_t)); }
void* operator new[](std::size_t bytes) { return counted(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t a) { return counted(bytes, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t bytes, std::align_val_t a) { return counted(bytes, static_cast<std::size_t>(a)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return counted_or_null(bytes); }
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept { return counted_or_null(bytes); }
void operator delete(void* p) noexcept { give_back(p); }
void operator delete[](void* p) noexcept { give_back(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { give_back(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { give_back(p); }
void operator delete(void* p, std::size_t) noexcept { give_back(p); }
void operator delete[](void* p, std::size_t) noexcept { give_back(p); }
void operator delete(void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete[](void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }
