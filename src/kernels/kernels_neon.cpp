// The kernels for NEON. Only this file is compiled for it; see docs/kernels.md.
#include "lanes_neon.h"
// The kernels below are templates on the Lanes of the header above.
#include "table_of.h"

namespace psim::kernels {

constinit const KernelTable kNeonKernels = table_of<Lanes>();

}  // namespace psim::kernels
