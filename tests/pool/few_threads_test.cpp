// The worker pool where the system has no room for all of its threads.
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>

#include "../support/sanitized.h"
#include "pool_support.h"

namespace psim {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

std::size_t address_space_in_use() {
  std::size_t pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * 4096;
}

/// Leaves the process so many bytes of address space; false where that has no effect, as in an emulator.
bool leave(std::size_t bytes) {
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = address_space_in_use() + bytes;
  setrlimit(RLIMIT_AS, &limit);
  void* const more = mmap(nullptr, bytes + 64 * kMiB, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return more == MAP_FAILED;
}

constexpr int kAsked = 256, kDone = 0, kWrong = 1, kNoLimit = 2;

[[noreturn]] void start_within(std::size_t bytes) {
  if (!leave(bytes)) std::exit(kNoLimit);
  int status = kDone;
  {
    WorkerPool pool(kAsked);
    const Awake awake(pool);
    std::fprintf(stderr, "%d threads\n", pool.threads());
    if (pool.threads() >= kAsked || wrong_jobs(pool, 1000) != 0) status = kWrong;
    if (bytes > 100 * kMiB && pool.threads() < 3) status = kWrong;
  }
  std::exit(status);
}

// The stack of a thread takes some 8 MiB of address space, so each amount has room for other numbers of threads.
TEST(WorkerPoolDeathTest, RunsOnFewerThreadsWhereTheSystemHasNoRoomForMore) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer takes address space without end";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const std::size_t mib : {4u, 9u, 20u, 50u, 130u, 400u}) {
    const auto ended = [](int status) {
      return WIFEXITED(status) && (WEXITSTATUS(status) == kDone || WEXITSTATUS(status) == kNoLimit);
    };
    EXPECT_EXIT(start_within(mib * kMiB), ended, "") << mib << " MiB";
  }
}

}  // namespace
}  // namespace psim
