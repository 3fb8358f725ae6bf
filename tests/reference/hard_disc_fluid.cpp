#include "hard_disc_fluid.h"

namespace reference {

const std::array<HardDiscFluid, 5> kHardDiscFluid = {
    {{0.1, 1.236144}, {0.2, 1.570366}, {0.3, 2.063261}, {0.4, 2.829330}, {0.5, 4.106358}}};

}  // namespace reference
