// The equation of state of the fluid of hard discs, Z = p A / (N k T) over the packing (the share
// of the area that discs cover), in the limit of many discs.
// Kolafa & Rottner, Mol. Phys. 104 (2006) 3435.
#pragma once

#include <array>

namespace reference {

struct HardDiscFluid {
  double packing = 0;
  double compressibility = 0;
};

inline constexpr std::array<HardDiscFluid, 5> kHardDiscFluid = {
    {{0.1, 1.236144}, {0.2, 1.570366}, {0.3, 2.063261}, {0.4, 2.829330}, {0.5, 4.106358}}};

}  // namespace reference
