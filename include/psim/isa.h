// The instruction-set variants that one binary holds. All of them give the same bits.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace psim {

enum class Isa : std::uint8_t { scalar, sse, avx2 };

inline constexpr Isa kAllIsas[] = {Isa::scalar, Isa::sse, Isa::avx2};

/// "scalar", "sse" or "avx2".
std::string_view isa_name(Isa isa);

/// The reverse of isa_name; nothing for any other text.
std::optional<Isa> parse_isa(std::string_view name);

/// Register lanes of 32-bit floats: 1, 4, 8.
int isa_lanes(Isa isa);

/// True if this CPU (asked by CPUID through cpu_features) can run the variant.
bool isa_available(Isa isa);

/// The best variant that this CPU has.
Isa best_isa();

}  // namespace psim
