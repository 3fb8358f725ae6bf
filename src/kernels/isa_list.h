// The list of instruction sets, the only one. isa.cpp takes names, lanes and kernels from its rows, CMakeLists.txt
// the files to build and their flags, tools/asm-inspect the objects to look at; both read the rows as text, one line
// a row. The enum Isa of psim/isa.h and psim_isa of the C interface have an entry for each row, in the same order.
//
// A new instruction set is a row here and what docs/kernels.md lists under "A new ISA".
#pragma once

#include "kernel_table.h"

namespace psim::kernels {

/// A CPU runs a variant only if it has this; cpu_has() of src/core/base/machine.cpp asks it.
enum class CpuNeed { nothing, sse41, avx2, neon, simd128 };

struct IsaRow {
  const char* name;          ///< in options, reports and benchmarks
  const char* unit;          ///< kernels_<unit>.cpp, on the lane types of lanes_<unit>.h
  const char* processor;     ///< that the unit is built for; "" for all
  const char* flag;          ///< of the compiler, for that file alone
  int lanes;                 ///< floats a register
  CpuNeed need;              ///< of the CPU
  const KernelTable* table;  ///< null: not in this build
};

/// A build holds the kernels of its own processor; a portable one the scalar kernels alone. The tables of others are
/// not even named.
#if defined(PSIM_PORTABLE)
inline constexpr bool kIsX86 = false, kIsArm = false, kIsWasm = false;
#elif defined(__aarch64__) || defined(_M_ARM64)
inline constexpr bool kIsX86 = false, kIsArm = true, kIsWasm = false;
#elif defined(__wasm__)
inline constexpr bool kIsX86 = false, kIsArm = false, kIsWasm = true;
#else
inline constexpr bool kIsX86 = true, kIsArm = false, kIsWasm = false;
#endif
/// A module of WebAssembly with SIMD cannot even start where there is none: it is built without the scalar kernels.
#if defined(PSIM_SIMD_ALONE)
inline constexpr bool kHasScalar = false;
#else
inline constexpr bool kHasScalar = true;
#endif
constexpr const KernelTable* only_if(bool held, const KernelTable& table) { return held ? &table : nullptr; }

/// All variants; of those for one processor the best one stands last.
inline constexpr IsaRow kIsaList[] = {
    {"scalar", "scalar", "", "", 1, CpuNeed::nothing, only_if(kHasScalar, kScalarKernels)},
    {"sse", "sse4", "x86-64", "-msse4.1", 4, CpuNeed::sse41, only_if(kIsX86, kSseKernels)},
    {"avx2", "avx2", "x86-64", "-mavx2", 8, CpuNeed::avx2, only_if(kIsX86, kAvx2Kernels)},
    {"neon", "neon", "aarch64", "", 4, CpuNeed::neon, only_if(kIsArm, kNeonKernels)},
    {"simd128", "wasm", "wasm", "-msimd128", 4, CpuNeed::simd128, only_if(kIsWasm, kWasmKernels)},
};

}  // namespace psim::kernels
