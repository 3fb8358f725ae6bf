// The instruction-set variants that one binary holds. All of them give the same bits.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "psim/api.h"

namespace psim {

/// An instruction set that kernels are compiled for.
enum class Isa : std::uint8_t {
  scalar,  ///< one lane, standard C++
  sse,     ///< SSE4.1
  avx2,    ///< AVX2
  neon,    ///< NEON of aarch64
  simd128  ///< WebAssembly SIMD
};

/// All of them, of each processor the best last.
inline constexpr Isa kAllIsas[] = {Isa::scalar, Isa::sse, Isa::avx2, Isa::neon, Isa::simd128};

/// "scalar", "sse", "avx2", "neon" or "simd128".
PSIM_API std::string_view isa_name(Isa isa);

/// The reverse of isa_name; nothing for any other text.
PSIM_API std::optional<Isa> parse_isa(std::string_view name);

/// Register lanes of 32-bit floats: 1, 4 or 8. 0: this build does not hold the variant.
PSIM_API int isa_lanes(Isa isa);

/// True if this build holds the variant and this CPU can run it.
PSIM_API bool isa_available(Isa isa);

/// The best variant that this CPU has.
PSIM_API Isa best_isa();

}  // namespace psim
