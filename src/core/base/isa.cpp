// Names, lanes and kernels of the instruction sets, from the rows of isa_list.h.
#include "psim/isa.h"

#include <iterator>

#include "base/machine.h"
#include "isa_list.h"

namespace psim {
namespace {

using kernels::IsaRow;
using kernels::kIsaList;

constexpr const IsaRow& row_of(Isa isa) { return kIsaList[static_cast<std::size_t>(isa)]; }

static_assert(std::size(kIsaList) == std::size(kAllIsas));
static_assert(row_of(Isa::scalar).name == std::string_view("scalar"));
static_assert(row_of(Isa::sse).name == std::string_view("sse"));
static_assert(row_of(Isa::avx2).name == std::string_view("avx2"));
static_assert(row_of(Isa::neon).name == std::string_view("neon"));
static_assert(row_of(Isa::simd128).name == std::string_view("simd128"));

}  // namespace

std::string_view isa_name(Isa isa) { return isa <= kAllIsas[std::size(kAllIsas) - 1] ? row_of(isa).name : "?"; }

std::optional<Isa> parse_isa(std::string_view name) {
  for (const Isa isa : kAllIsas) {
    if (name == isa_name(isa)) return isa;
  }
  return std::nullopt;
}

int isa_lanes(Isa isa) { return row_of(isa).table != nullptr ? row_of(isa).lanes : 0; }

bool isa_available(Isa isa) { return row_of(isa).table != nullptr && cpu_has(row_of(isa).need); }

Isa best_isa() {
  Isa best = Isa::scalar;
  for (const Isa isa : kAllIsas) best = isa_available(isa) ? isa : best;
  return best;
}

const kernels::KernelTable& kernels_of(Isa isa) { return *row_of(isa).table; }

}  // namespace psim
