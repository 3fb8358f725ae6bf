// Which variants this CPU runs, asked once through cpu_features.
#include "psim/isa.h"

#include <cpuinfo_x86.h>

#include "kernel_select.h"

namespace psim {
namespace {

struct Found {
  bool sse41 = false;
  bool avx2 = false;
};

const Found& found() {
  static const Found result = [] {
    const cpu_features::X86Info info = cpu_features::GetX86Info();
    return Found{info.features.sse4_1 != 0, info.features.avx2 != 0};
  }();
  return result;
}

}  // namespace

std::string_view isa_name(Isa isa) {
  switch (isa) {
    case Isa::scalar: return "scalar";
    case Isa::sse: return "sse";
    case Isa::avx2: return "avx2";
  }
  return "?";
}

std::optional<Isa> parse_isa(std::string_view name) {
  for (const Isa isa : kAllIsas) {
    if (name == isa_name(isa)) return isa;
  }
  return std::nullopt;
}

int isa_lanes(Isa isa) { return isa == Isa::avx2 ? 8 : isa == Isa::sse ? 4 : 1; }

bool isa_available(Isa isa) {
  if (isa == Isa::avx2) return found().avx2;
  if (isa == Isa::sse) return found().sse41;
  return true;
}

Isa best_isa() {
  return isa_available(Isa::avx2) ? Isa::avx2 : isa_available(Isa::sse) ? Isa::sse : Isa::scalar;
}

const kernels::KernelTable& kernels_of(Isa isa) {
  switch (isa) {
    case Isa::avx2: return kernels::kAvx2Kernels;
    case Isa::sse: return kernels::kSseKernels;
    default: return kernels::kScalarKernels;
  }
}

}  // namespace psim
