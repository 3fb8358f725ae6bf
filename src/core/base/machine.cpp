#include "base/machine.h"

#include <thread>

#include "isa_list.h"

#if defined(__x86_64__) && !defined(PSIM_PORTABLE)
#include <cpuinfo_x86.h>
#include <immintrin.h>
#define PSIM_X86_64 1
#elif defined(__aarch64__) && !defined(PSIM_PORTABLE)
#define PSIM_AARCH64 1
#endif

namespace psim {

#ifdef PSIM_X86_64

namespace {

const cpu_features::X86Features& cpu() {
  static const cpu_features::X86Features features = cpu_features::GetX86Info().features;
  return features;
}

constexpr std::uint32_t kStepFloatSettings = 0x1F80;  // a value of MXCSR
constexpr std::uint32_t kRaised = 0x3F;               // what calculations set: they stay set

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  switch (need) {
    case kernels::CpuNeed::nothing:
      return true;
    case kernels::CpuNeed::sse41:
      return cpu().sse4_1 != 0;
    case kernels::CpuNeed::avx2:
      return cpu().avx2 != 0;
    case kernels::CpuNeed::neon:
      return false;
  }
  return false;
}

void pause_briefly() { _mm_pause(); }

FloatSettings::FloatSettings() : before_{.control = _mm_getcsr()} { _mm_setcsr(kStepFloatSettings); }
FloatSettings::~FloatSettings() { _mm_setcsr(before_.control | (_mm_getcsr() & kRaised)); }

#elif defined(PSIM_AARCH64)

namespace {

// The control register FPCR: round to nearest, no traps, denormals as IEEE 754 has them, a NaN keeps its payload.
constexpr std::uint64_t kStepFloatSettings = 0;

std::uint64_t fpcr() {
  std::uint64_t value;
  __asm__ volatile("mrs %0, fpcr" : "=r"(value));
  return value;
}
void set_fpcr(std::uint64_t value) { __asm__ volatile("msr fpcr, %0" : : "r"(value) : "memory"); }

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  return need == kernels::CpuNeed::nothing || need == kernels::CpuNeed::neon;  // NEON is a part of aarch64
}

void pause_briefly() { __asm__ volatile("yield"); }

// FPCR has 64 bits, of which the upper 32 are reserved and read as zero.
FloatSettings::FloatSettings() : before_{.control = static_cast<std::uint32_t>(fpcr())} {
  set_fpcr(kStepFloatSettings);
}
FloatSettings::~FloatSettings() { set_fpcr(before_.control); }

#else

bool cpu_has(kernels::CpuNeed need) { return need == kernels::CpuNeed::nothing; }

void pause_briefly() { std::this_thread::yield(); }

FloatSettings::FloatSettings() {
  std::fegetenv(&before_.all);
  std::fesetenv(FE_DFL_ENV);
}
FloatSettings::~FloatSettings() { std::fesetenv(&before_.all); }

#endif

}  // namespace psim
