// The kernel for manifolds that last (lasting_kernel.h) reads here how the bodies of each lane stood when their hulls were
// looked at.
#pragma once

#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {

inline constexpr float kNoPoint = 1e20f;  ///< m: a larger gap is that of a point that is not there

/// One struct beside each ManifoldBlock: a frame reads it in one stream.
struct alignas(kAlign) LastingBlock {
  std::uint32_t body[2 * kBlock];      ///< A and B of each lane; any body in a lane that is not known
  std::uint32_t pair[kBlock];          ///< whose lane it is
  std::int32_t x[kBlock], y[kBlock];   ///< lattice steps from A, or from 0 if A is fixed geometry, to B
  float dx[kBlock], dy[kBlock];        ///< m beside them
  float ac[kBlock], as[kBlock];        ///< cosine and sine of A
  float bc[kBlock], bs[kBlock];        ///< of B
  float nx[kBlock], ny[kBlock];        ///< from A to B
  float margin[kBlock];                ///< m: gaps up to here were found; negative: the lane is not known
  float touching[kBlock];              ///< m: bodies with a smaller gap touch
  float deepest[kBlock];               ///< m: with a smaller gap to fixed geometry, continuous collision sees to it
  float gap[2][kBlock];                ///< m, of each point; more than kNoPoint: there is no such point
  float ax[2][kBlock], ay[2][kBlock];  ///< m: arm of A, with its rounding
  float bx[2][kBlock], by[2][kBlock];  ///< of B
};

/// Columns by slot that only bodies with corners have.
struct LastingColumns {
  const float* rotor = nullptr;   ///< records: cosine and sine
  const float* inner = nullptr;   ///< m: inner radius
  const float* radius = nullptr;  ///< m
};

/// Shares of inner radii, and what a step does.
struct LastingParams {
  float pitch_x = 0, pitch_y = 0;  ///< m a lattice step
  float dt = 0;                    ///< s
  float ahead = 0;                 ///< s: motion for which contacts are looked for
  float fall = 0;                  ///< m/s: what gravity adds in a step
  float sinks = 0;                 ///< m: what it closes in a step
  float nearby = 0, lasting = 0, rocking = 0, apart = 0, fallen = 0;
  float slow = 0;  ///< way in a step: what comes upon fixed geometry faster is seen to elsewhere
};

}  // namespace psim::kernels
