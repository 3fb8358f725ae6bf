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

namespace {

const cpu_features::X86Features& cpu() {
  static const cpu_features::X86Features features = cpu_features::GetX86Info().features;
  return features;
}

constexpr std::uint32_t kStepFloatSettings = 0x1F80;  // a value of MXCSR
constexpr std::uint32_t kRaised = 0x3F;               // what calculations set: they stay set

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  if (need == kernels::CpuNeed::nothing) return true;
  return (need == kernels::CpuNeed::avx2 ? cpu().avx2 : cpu().sse4_1) != 0;
}

void pause_briefly() { _mm_pause(); }

FloatSettings::FloatSettings() : before_{.control = _mm_getcsr()} { _mm_setcsr(kStepFloatSettings); }
FloatSettings::~FloatSettings() { _mm_setcsr(before_.control | (_mm_getcsr() & kRaised)); }

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
