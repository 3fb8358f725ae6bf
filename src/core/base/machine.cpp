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
#elif defined(__aarch64__) && !defined(PSIM_PORTABLE)
#define PSIM_AARCH64 1
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

constexpr std::uint32_t kStepFloatSettings = 0x1F80;  // a value of MXCSR
constexpr std::uint32_t kRaised = 0x3F;               // what calculations set: they stay set

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  switch (need) {
    case kernels::CpuNeed::nothing:
      return true;
    case kernels::CpuNeed::sse41:
      return cpu().sse4_1;
    case kernels::CpuNeed::avx2:
      return cpu().avx2;
    case kernels::CpuNeed::neon:
    case kernels::CpuNeed::simd128:
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

/// A WebAssembly module with SIMD instructions only starts where they are there.
bool cpu_has(kernels::CpuNeed need) {
  const bool on_wasm = need == kernels::CpuNeed::simd128 && kernels::kIsWasm;
  return need == kernels::CpuNeed::nothing || on_wasm;
}

void pause_briefly() { std::this_thread::yield(); }

FloatSettings::FloatSettings() {
  std::fegetenv(&before_.all);
  std::fesetenv(FE_DFL_ENV);
}
FloatSettings::~FloatSettings() { std::fesetenv(&before_.all); }

#endif

}  // namespace psim
