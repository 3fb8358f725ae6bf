// The list of instruction sets, the only one. isa.cpp takes names, lanes and kernels from its rows, CMakeLists.txt
// the files to build and their flags, tools/asm-inspect the objects to look at; both read the rows as text, one line
// a row. The enum Isa of psim/isa.h and psim_isa of the C interface have an entry for each row, in the same order.
//
// A new instruction set is a row here and what docs/kernels.md lists under "A new ISA".
#pragma once

#include "kernel_table.h"

namespace psim::kernels {

/// A CPU runs a variant only if it has this; cpu_has() of src/core/base/machine.cpp asks it.
enum class CpuNeed { nothing, sse41, avx2 };

struct IsaRow {
  const char* name;          ///< in options, reports and benchmarks
  const char* unit;          ///< kernels_<unit>.cpp, on the lane types of lanes_<unit>.h
  const char* flag;          ///< of the compiler, for that file alone
  int lanes;                 ///< floats a register
  CpuNeed need;              ///< of the CPU
  const KernelTable* table;  ///< null: not in this build
};

/// A build for any processor has the scalar kernels alone; the tables of the others are not even named.
#ifdef PSIM_PORTABLE
constexpr const KernelTable* unless_portable(const KernelTable&) { return nullptr; }
#else
constexpr const KernelTable* unless_portable(const KernelTable& table) { return &table; }
#endif

/// The best last.
inline constexpr IsaRow kIsaList[] = {
    {"scalar", "scalar", "", 1, CpuNeed::nothing, &kScalarKernels},
    {"sse", "sse4", "-msse4.1", 4, CpuNeed::sse41, unless_portable(kSseKernels)},
    {"avx2", "avx2", "-mavx2", 8, CpuNeed::avx2, unless_portable(kAvx2Kernels)},
};

}  // namespace psim::kernels
