// The kernel table of an ISA. The caller has checked isa_available.
#pragma once

#include "kernel_table.h"
#include "psim/isa.h"

namespace psim {

const kernels::KernelTable& kernels_of(Isa isa);

}  // namespace psim
