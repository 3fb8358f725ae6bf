// soak [MINUTES [BODIES [THREADS]]]: runs a SoakWorld (60 minutes of game time, 1,000 bodies, 1 thread)
// and writes a CSV row a minute of game time. soak calls [CALLS [BODIES [THREADS]]]: makes a million calls in a SoakCalls
// of 400 bodies, and writes a row a season. Exit 1 if a fault was found, or if memory grew or steps became slower
// (memory_trend.h).
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "memory_trend.h"
#include "soak_calls.h"
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
  std::fprintf(stderr, "%s: middle of the second third %zu, of the last %zu: %s\n", what, trend.before, trend.after,
               trend.grows ? "grows" : "flat");
  return !trend.grows;
}

using Numbers = std::array<std::size_t, 3>;  // minutes or calls, bodies, threads

int run_calls(const Numbers& numbers) {
  psim::soak::SoakCalls soak(numbers[1], static_cast<int>(numbers[2]));
  std::vector<std::size_t> uncounted, counted, bare, nanoseconds;
  std::printf(
      "season,calls,steps,in_use_bytes,memory_bytes,bare_bytes,bodies,joints,most_asleep,escaped,events,ns_a_step\n");
  for (std::size_t season = 1; soak.calls() < numbers[0]; ++season) {
    const double begin = cpu_seconds();
    const std::uint64_t before = soak.steps();
    if (!soak.season()) {
      std::fprintf(stderr, "soak: season %zu, %s\n", season, soak.fault().c_str());
      return 1;
    }
    nanoseconds.push_back(static_cast<std::size_t>(1e9 * (cpu_seconds() - begin)) / (soak.steps() - before));
    const std::size_t in_use = in_use_bytes();
    counted.push_back(soak.world().memory_bytes());
    uncounted.push_back(in_use - std::min(in_use, counted.back()));
    bare.push_back(soak.bare_bytes());
    std::printf("%zu,%ju,%ju,%zu,%zu,%zu,%zu,%zu,%ju,%ju,%ju,%zu\n", season, std::uintmax_t{soak.calls()},
                std::uintmax_t{soak.steps()}, in_use, counted.back(), bare.back(), soak.world().body_count(),
                soak.world().joint_count(), std::uintmax_t{soak.most_asleep()}, std::uintmax_t{soak.escaped()},
                std::uintmax_t{soak.events()}, nanoseconds.back());
    std::fflush(stdout);
  }
  std::fprintf(stderr, "state 0x%016jx\n", std::uintmax_t{soak.world().state_hash()});
  if (counted.size() < 3 * psim::soak::SoakCalls::kSeasons) return 0;
  using namespace psim::soak;
  const bool uncounted_flat = flat("in use beside memory_bytes, bytes", seasons_trend(uncounted));
  const bool counted_flat = flat("memory_bytes", seasons_trend(counted));
  const bool bare_flat = flat("state without bodies, bytes", seasons_trend(bare));
  const bool time_flat = flat("CPU time a step, ns", memory_trend(nanoseconds, 0.5, 0));
  return uncounted_flat && counted_flat && bare_flat && time_flat ? 0 : 1;
}

int run_minutes(const Numbers& numbers) {
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
  const bool uncounted_flat = flat("in use beside memory_bytes, bytes", psim::soak::uncounted_trend(uncounted));
  const bool counted_flat = flat("memory_bytes", psim::soak::counted_trend(counted));
  return uncounted_flat && counted_flat ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const bool calls = argc > 1 && std::strcmp(argv[1], "calls") == 0;
  Numbers numbers = calls ? Numbers{1'000'000, 400, 1} : Numbers{60, 1000, 1};
  const Numbers most{calls ? std::size_t{1'000'000'000} : 100'000, 1'000'000, 256};
  const int first = calls ? 2 : 1;
  for (int k = first; k < argc; ++k) {
    const char* const end = argv[k] + std::strlen(argv[k]);
    const auto which = static_cast<std::size_t>(k - first);
    std::size_t value = 0;
    if (which > 2 || std::from_chars(argv[k], end, value).ptr != end || value < 1 || value > most[which]) {
      std::fprintf(stderr,
                   "soak: %s: soak [MINUTES [BODIES [THREADS]]], at most 100000, 1000000 and 256, or soak calls "
                   "[CALLS [BODIES [THREADS]]], at most 1000000000 calls\n",
                   argv[k]);
      return 2;
    }
    numbers[which] = value;
  }
  return calls ? run_calls(numbers) : run_minutes(numbers);
}
