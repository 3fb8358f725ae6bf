#include "base/machine.h"

#include <array>
#include <thread>

#include "isa_list.h"

#if (defined(__x86_64__) || defined(_M_X64)) && !defined(PSIM_PORTABLE)
#include <immintrin.h>
#define PSIM_X86_64 1
#if __has_include(<cpuinfo_x86.h>)
#include <cpuinfo_x86.h>
#define PSIM_CPU_FEATURES 1
#elif defined(_MSC_VER)
#include <intrin.h>
#else
#include <cpuid.h>
#endif
#endif

namespace psim {

#ifdef PSIM_X86_64

namespace {

struct X86Features {
  bool sse4_1, avx2;
};

#ifdef PSIM_CPU_FEATURES
X86Features ask_cpu() {
  const cpu_features::X86Features features = cpu_features::GetX86Info().features;
  return {features.sse4_1 != 0, features.avx2 != 0};
}
#else
// Where there is no cpu_features, the processor is asked directly: leaf 1 of cpuid has SSE4.1, OSXSAVE and AVX, leaf 7
// has AVX2, and XCR0 says whether the system keeps the registers of AVX (Intel SDM, volume 1, 14.3 and 14.7.1).
std::array<std::uint32_t, 4> cpuid(int leaf) {
  std::array<std::uint32_t, 4> r{};
#ifdef _MSC_VER
  __cpuidex(reinterpret_cast<int*>(r.data()), leaf, 0);
#else
  __cpuid_count(leaf, 0, r[0], r[1], r[2], r[3]);
#endif
  return r;
}

std::uint32_t xcr0() {
#ifdef _MSC_VER
  return static_cast<std::uint32_t>(_xgetbv(0));
#else
  std::uint32_t low = 0, high = 0;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
#endif
}

X86Features ask_cpu() {
  constexpr std::uint32_t kSse41 = 1u << 19, kOsXsaveAndAvx = 3u << 27, kAvx2 = 1u << 5, kXmmAndYmm = 6;
  const std::uint32_t ecx = cpuid(1)[2];
  const bool keeps_avx = (ecx & kOsXsaveAndAvx) == kOsXsaveAndAvx && (xcr0() & kXmmAndYmm) == kXmmAndYmm;
  return {(ecx & kSse41) != 0, keeps_avx && cpuid(0)[0] >= 7 && (cpuid(7)[1] & kAvx2) != 0};
}
#endif

const X86Features& cpu() {
  static const X86Features features = ask_cpu();
  return features;
}

constexpr std::uint32_t kStepFloatSettings = 0x9FC0;  // a value of MXCSR

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  if (need == kernels::CpuNeed::nothing) return true;
  return need == kernels::CpuNeed::avx2 ? cpu().avx2 : cpu().sse4_1;
}

void pause_briefly() { _mm_pause(); }

FloatSettings::FloatSettings() : before_(_mm_getcsr()) { _mm_setcsr(kStepFloatSettings); }
FloatSettings::~FloatSettings() { _mm_setcsr(before_); }

#else

bool cpu_has(kernels::CpuNeed need) { return need == kernels::CpuNeed::nothing; }

void pause_briefly() { std::this_thread::yield(); }

FloatSettings::FloatSettings() : before_(0) {}
FloatSettings::~FloatSettings() { (void)before_; }

#endif

}  // namespace psim
