#include "workload.h"

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <exception>
#include <map>
#include <utility>

#include "base/machine.h"
#include "psim/isa.h"

namespace psim::bench {
namespace {

// CPU time of this thread: neighbours on a shared machine count less than in wall time.
double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

using Key = std::pair<std::string, std::uint32_t>;

// The workload in use. Only one is kept: a million contacts of the largest model are 300 MB.
Workload& workload(const Key& key, const MakeWorkload& make) {
  static Key current;
  static std::unique_ptr<Workload> work;
  if (!work || current != key) {
    work.reset();
    work = make(key.second);
    current = key;
  }
  return *work;
}

// Seconds a pass of the scalar variant: from its own benchmark if that ran before, else measured
// here once, as the median of a few rounds.
std::map<Key, double>& scalar_seconds() {
  static std::map<Key, double> seconds;
  return seconds;
}

double measure_scalar(Workload& work) {
  const kernels::KernelTable& k = kernels_of(Isa::scalar);
  const int batch = std::max(1, work.passes_a_start);
  std::array<double, 5> rounds{};
  for (double& round : rounds) {
    double spent = 0;
    int passes = 0;
    while (spent < 4e-3) {
      work.restart();
      const double begin = cpu_seconds();
      for (int i = 0; i < batch; ++i) work.pass(k);
      spent += cpu_seconds() - begin;
      passes += batch;
    }
    round = spent / passes;
  }
  std::nth_element(rounds.begin(), rounds.begin() + 2, rounds.end());
  return rounds[2];
}

void run(benchmark::State& state, const Key& key, const MakeWorkload& make, Isa isa) {
  if (!isa_available(isa)) {
    state.SkipWithError(("skipped: this CPU lacks " + std::string(isa_name(isa))).c_str());
    return;
  }
  Workload* made = nullptr;
  try {
    made = &workload(key, make);
  } catch (const std::exception& e) {  // too little memory for a million, say
    state.SkipWithError(e.what());
    return;
  }
  Workload& work = *made;
  const kernels::KernelTable& k = kernels_of(isa);
  work.restart();
  work.pass(k);  // caches, page tables and branch predictors are warm in a running world
  double spent = 0;
  if (work.passes_a_start == 0) {
    const double begin = cpu_seconds();
    for (auto _ : state) work.pass(k);
    spent = cpu_seconds() - begin;
  } else {
    const int batch = work.passes_a_start;
    while (state.KeepRunningBatch(batch)) {
      state.PauseTiming();
      work.restart();
      state.ResumeTiming();
      const double begin = cpu_seconds();
      for (int i = 0; i < batch; ++i) work.pass(k);
      spent += cpu_seconds() - begin;
    }
  }
  const double pass_s = spent / static_cast<double>(state.iterations());
  auto& scalar = scalar_seconds();
  if (isa == Isa::scalar) {
    scalar[key] = pass_s;
  } else if (!scalar.contains(key)) {
    scalar[key] = measure_scalar(work);
  }
  const double elements = static_cast<double>(work.elements);
  const double passes = static_cast<double>(state.iterations());
  state.SetItemsProcessed(static_cast<std::int64_t>(elements * passes));
  state.SetBytesProcessed(static_cast<std::int64_t>(elements * work.bytes * passes));
  state.counters["ns_per_element"] = 1e9 * pass_s / elements;
  state.counters["speedup_vs_scalar"] = scalar[key] / pass_s;
}

}  // namespace

void register_kernel(const std::string& name, const MakeWorkload& make) {
  for (const std::uint32_t size : kSizes) {
    for (const Isa isa : kAllIsas) {
      const std::string full = name + "/" + std::string(isa_name(isa)) + "/" + std::to_string(size);
      benchmark::RegisterBenchmark(full.c_str(), [key = Key(name, size), make, isa](benchmark::State& s) {
        run(s, key, make, isa);
      })->Unit(benchmark::kMicrosecond);
    }
  }
}

}  // namespace psim::bench
