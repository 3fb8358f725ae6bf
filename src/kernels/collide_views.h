// Pairs of hulls for the narrow phase, 8 side by side. Vertices are not copied in: a lane points at
// its two hulls, and the kernel turns eight of them into registers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {

/// Where the floats of a hull lie: x, y, nx and ny of up to 8 vertices, then radius and reach.
inline constexpr std::size_t kHullX = 0, kHullY = 8, kHullNx = 16, kHullNy = 24, kHullRound = 32;

struct alignas(kAlign) HullPairs {
  const float* a[kBlock];  ///< hulls; every lane points at one
  const float* b[kBlock];
  float vertices_a[kBlock], vertices_b[kBlock];  ///< how many a hull has
  float ac[kBlock], as[kBlock];                  ///< rotation of A: cosine, sine
  float bc[kBlock], bs[kBlock];
  float dx[kBlock], dy[kBlock];  ///< m: from A's centre to B's
  float margin[kBlock];          ///< m: points further apart are left out

  float nx[kBlock], ny[kBlock];  ///< from A to B
  float apart[kBlock];           ///< m: of a lane without points: its hulls have no smaller gap, but for rounding
  struct Point {
    float ax[kBlock], ay[kBlock];  ///< m: arm of A, world axes
    float bx[kBlock], by[kBlock];  ///< m: arm of B
    float gap[kBlock];             ///< m
    float feature[kBlock];         ///< a small whole number
  } point[2];
  std::uint32_t has[2];  ///< lanes that have a first point, a second one: bit k for lane k
  std::uint32_t hard;    ///< lanes that the kernel leaves to collide(); the rest of such a lane is of no use
};

}  // namespace psim::kernels
