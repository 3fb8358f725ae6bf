// The kernels for SSE4.1. Only this file is compiled for it; see docs/kernels.md.
#include "lanes_sse4.h"
// The kernels below are templates on the Lanes of the header above.
#include "table_of.h"

namespace psim::kernels {

constinit const KernelTable kSseKernels = table_of<Lanes>();

}  // namespace psim::kernels
