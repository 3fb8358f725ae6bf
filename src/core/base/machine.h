// This header tells what the machine can run: its instruction sets, the kernels for them and the floating-point mode of
// a step. Only machine.cpp and src/kernels/lanes_*.h know one processor. On processors other than x86-64 and aarch64, and
// in builds with PSIM_PORTABLE, the functions here do nothing or use standard C++.
#pragma once

#include <cfenv>
#include <cstdint>

#include "psim/isa.h"

namespace psim {

namespace kernels {
enum class CpuNeed;
struct KernelTable;
}  // namespace kernels

/// Whether this CPU can run the kernels that need it. Never true of an instruction set that the build lacks.
bool cpu_has(kernels::CpuNeed need);

/// The kernel table of an ISA (isa.cpp). The caller has checked isa_available.
const kernels::KernelTable& kernels_of(Isa isa);

/// False where threads cannot be started: in WebAssembly without shared memory. One thread then does all the work.
#if defined(__wasm__) && !defined(__EMSCRIPTEN_PTHREADS__)
inline constexpr bool kHasThreads = false;
#else
inline constexpr bool kHasThreads = true;
#endif

/// A hint to the CPU that the thread waits in a loop.
void pause_briefly();

/// Sets the calling thread to the floating-point settings of IEEE 754, from construction to destruction: round to
/// nearest, denormals are numbers like others, no traps. Every public function that computes has one. The host's own
/// settings come back at the end. Flags that were raised meanwhile stay raised on x86-64, as after any function.
class FloatSettings {
 public:
  FloatSettings();
  ~FloatSettings();
  FloatSettings(const FloatSettings&) = delete;
  FloatSettings& operator=(const FloatSettings&) = delete;

 private:
  union {
    std::uint32_t control;  // x86-64: MXCSR; aarch64: FPCR
    std::fenv_t all;
  } before_;
};

}  // namespace psim
