// These functions hide how processors differ; only they and src/kernels/lanes_*.h know one. On processors other than
// x86-64, and in builds with PSIM_PORTABLE, they do nothing or use standard C++.
#pragma once

#include <cstdint>

namespace psim {

namespace kernels {
enum class CpuNeed;
}

/// Whether this CPU can run the kernels that need it. Never true of an instruction set that the build lacks.
bool cpu_has(kernels::CpuNeed need);

/// A hint to the CPU that the thread waits in a loop.
void pause_briefly();

/// The floating-point settings of the calling thread (MXCSR of x86-64).
std::uint32_t float_settings();
void set_float_settings(std::uint32_t settings);

/// The settings of every thread during a step: round to nearest, no traps, denormals are flushed and read as zero.
/// Denormals cost twenty times as much as other numbers and mean nothing here.
inline constexpr std::uint32_t kStepFloatSettings = 0x9FC0;

/// SSE code runs at up to half its speed after AVX code that left the upper halves of registers in use. This
/// function declares them unused.
void clear_upper_halves();

}  // namespace psim
