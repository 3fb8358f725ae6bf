// soak [MINUTES [BODIES [THREADS]]]: runs a SoakWorld (60 minutes of game time, 1,000 bodies, 1 thread)
// and writes a CSV row a minute of game time. Exit 1 if a fault was found, or if memory grew (memory_trend.h).
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "memory_trend.h"
#include "soak_world.h"

namespace {

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) + static_cast<double>(usage.ru_utime.tv_usec) * 1e-6;
}

// In use by malloc's word, large arrays too. 0 where the sanitizers have another malloc.
std::size_t in_use_bytes() {
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

bool flat(const char* what, const psim::soak::MemoryTrend& trend) {
  std::fprintf(stderr, "%s: middle of the second third %zu bytes, of the last %zu: %s\n", what, trend.before,
               trend.after, trend.grows ? "grows" : "flat");
  return !trend.grows;
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t numbers[3] = {60, 1000, 1};  // minutes, bodies, threads
  const std::size_t most_of[3] = {100'000, 1'000'000, 256};
  for (int k = 1; k < argc; ++k) {
    const char* const end = argv[k] + std::strlen(argv[k]);
    std::size_t value = 0;
    if (k > 3 || std::from_chars(argv[k], end, value).ptr != end || value < 1 || value > most_of[k - 1]) {
      std::fprintf(stderr, "soak: %s: soak [MINUTES [BODIES [THREADS]]], at most 100000, 1000000 and 256\n", argv[k]);
      return 2;
    }
    numbers[k - 1] = value;
  }
  psim::soak::SoakWorld soak(numbers[1], static_cast<int>(numbers[2]));
  std::vector<std::size_t> uncounted, counted;
  std::printf(
      "minute,resident_bytes,in_use_bytes,memory_bytes,bodies,asleep,joints,spawned,removed,events,answers,cpu_"
      "s\n");
  for (std::size_t minute = 1; minute <= numbers[0]; ++minute) {
    for (int frame = 0; frame < 3600; ++frame) {
      if (soak.step()) continue;
      std::fprintf(stderr, "soak: %s\n", soak.fault().c_str());
      return 1;
    }
    const std::size_t in_use = in_use_bytes();
    counted.push_back(soak.world().memory_bytes());
    uncounted.push_back(in_use - std::min(in_use, counted.back()));
    std::printf("%zu,%zu,%zu,%zu,%zu,%ju,%zu,%ju,%ju,%ju,%ju,%.1f\n", minute, resident_bytes(), in_use, counted.back(),
                soak.world().body_count(), std::uintmax_t{soak.asleep()}, soak.world().joint_count(),
                std::uintmax_t{soak.spawned()}, std::uintmax_t{soak.removed()}, std::uintmax_t{soak.events()},
                std::uintmax_t{soak.answers()}, cpu_seconds());
    std::fflush(stdout);
  }
  std::fprintf(stderr, "state 0x%016jx\n", std::uintmax_t{soak.world().state_hash()});
  if (numbers[0] < 3) return 0;
  const bool uncounted_flat = flat("in use beside memory_bytes", psim::soak::uncounted_trend(uncounted));
  const bool counted_flat = flat("memory_bytes", psim::soak::counted_trend(counted));
  return uncounted_flat && counted_flat ? 0 : 1;
}
