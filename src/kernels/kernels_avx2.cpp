// The kernels for AVX2. Only this file is compiled for it; see docs/kernels.md.
#include "lanes_avx2.h"
// The kernels below are templates on the Lanes of the header above.
#include "table_of.h"

namespace psim::kernels {

constinit const KernelTable kAvx2Kernels = table_of<Lanes>();

}  // namespace psim::kernels
