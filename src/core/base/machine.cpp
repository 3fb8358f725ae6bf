#include "base/machine.h"

#include <thread>

#include "isa_list.h"

#if defined(__x86_64__) && !defined(PSIM_PORTABLE)
#include <cpuinfo_x86.h>
#include <immintrin.h>
#define PSIM_X86_64 1
#endif

namespace psim {

#ifdef PSIM_X86_64

bool cpu_has(kernels::CpuNeed need) {
  static const cpu_features::X86Features features = cpu_features::GetX86Info().features;
  if (need == kernels::CpuNeed::nothing) return true;
  return (need == kernels::CpuNeed::avx2 ? features.avx2 : features.sse4_1) != 0;
}

void pause_briefly() { _mm_pause(); }

std::uint32_t float_settings() { return _mm_getcsr(); }
void set_float_settings(std::uint32_t settings) { _mm_setcsr(settings); }

namespace {

[[gnu::target("avx")]] void zero_upper() { _mm256_zeroupper(); }

}  // namespace

void clear_upper_halves() {
  static const bool avx = cpu_features::GetX86Info().features.avx != 0;
  if (avx) zero_upper();
}

#else

bool cpu_has(kernels::CpuNeed need) { return need == kernels::CpuNeed::nothing; }

void pause_briefly() { std::this_thread::yield(); }

std::uint32_t float_settings() { return kStepFloatSettings; }
void set_float_settings(std::uint32_t) {}

void clear_upper_halves() {}

#endif

}  // namespace psim
