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

extern const std::array<HardDiscFluid, 5> kHardDiscFluid;

}  // namespace reference
