// soak [MINUTES [BODIES [THREADS]]]: runs a SoakWorld (60 minutes of game time, 1,000 bodies, 1 thread)
// and writes a CSV row a minute of game time. Exit 1 if a fault was found, or if memory grew: the most of
// the last third against the most of the third before, by over 2 % and 1 MiB.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

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
  return static_cast<double>(usage.ru_utime.tv_sec) +
         static_cast<double>(usage.ru_utime.tv_usec) * 1e-6;
}

// The third of three equal parts, or the second.
std::size_t most(const std::vector<std::size_t>& samples, std::size_t third) {
  const std::size_t n = samples.size();
  return *std::max_element(samples.begin() + static_cast<std::ptrdiff_t>(n * third / 3),
                           samples.begin() + static_cast<std::ptrdiff_t>(n * (third + 1) / 3));
}

bool flat(const char* what, const std::vector<std::size_t>& samples) {
  const std::size_t before = most(samples, 1), after = most(samples, 2);
  const bool grew = after > before + before / 50 + (std::size_t{1} << 20);
  std::fprintf(stderr, "%s: most in the second third %zu bytes, in the last %zu: %s\n", what,
               before, after, grew ? "grows" : "flat");
  return !grew;
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t numbers[3] = {60, 1000, 1};  // minutes, bodies, threads
  const std::size_t most_of[3] = {100'000, 1'000'000, 256};
  for (int k = 1; k < argc; ++k) {
    const char* const end = argv[k] + std::strlen(argv[k]);
    std::size_t value = 0;
    if (k > 3 || std::from_chars(argv[k], end, value).ptr != end || value < 1 ||
        value > most_of[k - 1]) {
      std::fprintf(stderr,
                   "soak: %s: soak [MINUTES [BODIES [THREADS]]], at most 100000, 1000000 and 256\n",
                   argv[k]);
      return 2;
    }
    numbers[k - 1] = value;
  }
  psim::soak::SoakWorld soak(numbers[1], static_cast<int>(numbers[2]));
  std::vector<std::size_t> resident, counted;
  std::printf(
      "minute,resident_bytes,memory_bytes,bodies,asleep,joints,spawned,removed,events,answers,cpu_"
      "s\n");
  for (std::size_t minute = 1; minute <= numbers[0]; ++minute) {
    for (int frame = 0; frame < 3600; ++frame) {
      if (soak.step()) continue;
      std::fprintf(stderr, "soak: %s\n", soak.fault().c_str());
      return 1;
    }
    resident.push_back(resident_bytes());
    counted.push_back(soak.world().memory_bytes());
    std::printf("%zu,%zu,%zu,%zu,%ju,%zu,%ju,%ju,%ju,%ju,%.1f\n", minute, resident.back(),
                counted.back(), soak.world().body_count(), std::uintmax_t{soak.asleep()},
                soak.world().joint_count(), std::uintmax_t{soak.spawned()},
                std::uintmax_t{soak.removed()}, std::uintmax_t{soak.events()},
                std::uintmax_t{soak.answers()}, cpu_seconds());
    std::fflush(stdout);
  }
  std::fprintf(stderr, "state 0x%016jx\n", std::uintmax_t{soak.world().state_hash()});
  if (numbers[0] < 3) return 0;
  const bool resident_flat = flat("resident", resident), counted_flat = flat("counted", counted);
  return resident_flat && counted_flat ? 0 : 1;
}
