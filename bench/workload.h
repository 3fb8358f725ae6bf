// What a kernel benchmark is made of: a Workload holds the state of one kernel and size, and the
// runner times passes over it with the kernels of every ISA.
//
// Names are <Kernel>/<isa>/<size>, size by size, so that the variants stand side by side. Each line
// reports, besides time:
//   ns_per_element     CPU time of a pass / elements (bodies or contacts, padding not counted)
//   speedup_vs_scalar  against the scalar variant at the same size, measured in the same process
//   bytes_per_second   what the kernel reads and writes, counted by element; caches not considered
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "kernel_table.h"

namespace psim::bench {

inline constexpr std::uint32_t kSizes[] = {1'000, 10'000, 100'000, 1'000'000};

class Workload {
 public:
  virtual ~Workload() = default;

  /// One pass of the kernel over the whole state.
  virtual void pass(const kernels::KernelTable& k) = 0;

  /// Puts the state back to where it started; not timed. Called every `passes_a_start` passes.
  virtual void restart() {}

  std::uint64_t elements = 0;  ///< a pass
  double bytes = 0;            ///< read and written, an element
  int passes_a_start = 0;      ///< 0: the state stays sane for any number of passes
};

using MakeWorkload = std::function<std::unique_ptr<Workload>(std::uint32_t size)>;

/// Registers one kernel for every size and ISA. An ISA that the CPU lacks is reported as skipped.
void register_kernel(const std::string& name, const MakeWorkload& make);

// One function a file.
void register_stream_kernels();
void register_pair_kernels();
void register_contact_kernels();
void register_manifold_kernels();
void register_collide_kernels();
void register_frames();
void register_states();
void register_queries();
void register_changes();
void register_pictures();

}  // namespace psim::bench
