// bench: every kernel by ISA and size, whole frames by scene, ISA and threads, and pictures.
//
//   bench --benchmark_filter=Integrate           all variants of one kernel side by side
//   bench --benchmark_filter='/avx2/10000$'      all kernels at one size
//   bench --benchmark_filter=Frame/pile          whole frames of one scene
// Everything takes some minutes. All options: bench --help.
#include <benchmark/benchmark.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/machine.h"
#include "psim/isa.h"
#include "psim/version.h"
#include "workload.h"

int main(int argc, char** argv) {
  const psim::FloatSettings settings;  // velocities that a kernel damps over and over become 0, not denormal
  // Half a second a line, the library's default, would make it a quarter of an hour.
  std::string min_time = "--benchmark_min_time=0.1";
  std::vector<char*> args(argv, argv + argc);
  args.insert(args.begin() + 1, min_time.data());  // the user's own comes later and wins
  int count = static_cast<int>(args.size());
  benchmark::Initialize(&count, args.data());
  if (benchmark::ReportUnrecognizedArguments(count, args.data())) return 2;

  std::string isas;
  for (const psim::Isa isa : psim::kAllIsas) {
    if (!isas.empty()) isas += ", ";
    isas += std::string(psim::isa_name(isa)) + (psim::isa_available(isa) ? "" : " (not here)");
  }
  benchmark::AddCustomContext("psim", PSIM_VERSION_STRING);
  benchmark::AddCustomContext("variants", isas);

  psim::bench::register_stream_kernels();
  psim::bench::register_pair_kernels();
  psim::bench::register_contact_kernels();
  psim::bench::register_manifold_kernels();
  psim::bench::register_collide_kernels();
  psim::bench::register_frames();
  psim::bench::register_states();
  psim::bench::register_queries();
  psim::bench::register_changes();
  psim::bench::register_pictures();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
