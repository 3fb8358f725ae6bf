// The kernels for WebAssembly's SIMD128. Only this file is compiled for it; see docs/kernels.md.
#include "lanes_wasm.h"
// The kernels below are templates on the Lanes of the header above.
#include "table_of.h"

namespace psim::kernels {

constinit const KernelTable kWasmKernels = table_of<Lanes>();

}  // namespace psim::kernels
