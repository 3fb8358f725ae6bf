// Contacts of shapes with corners: two points a manifold, solved together. One struct a block of 8,
// so that a pass walks through memory in one stream.
//
// Arms are given in the contact's own frame and in units of the body's radius R: for r from the
// centre to the point, (n.r, r x n) / R. With u = omega R and g = R^2 / I,
//   vn = n.(vB - vA) + uB bt - uA at,      vt = t.(vB - vA) + uB bn - uA an,   t = (-ny, nx)
//   an impulse l along n: v += w l n, u += g at l;  along t: v += w l t, u += g an l
// While a body turns by d from the start of the frame, T = R (cos d - 1, sin d), its arm moves by
//   n.dr = Tx an + Ty at,   of which a rounded end, radius p R, takes no part: an - p instead of an.
// Arms that are those of a body turned by q since then are turned back: Tx + q Ty instead of Tx.
#pragma once

#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {

struct alignas(kAlign) ManifoldBlock {
  struct Point {
    float an[kBlock], at[kBlock];  ///< arm of A
    float bn[kBlock], bt[kBlock];  ///< arm of B
    float gap[kBlock];             ///< m: separation at the frame's start
    float impulse[kBlock];         ///< N s; -0: open in this substep
    float friction[kBlock];        ///< N s along t
    float start[kBlock];           ///< N s: impulse at the substep's start; once relaxed, with
                                   ///< restitution: of an impact, what is not to be repeated
  };
  std::uint32_t body[2 * kBlock];          ///< A and B of each lane
  float nx[kBlock], ny[kBlock];            ///< from A to B
  Point point[2];                          ///< a lane with one point: the second far apart, arms 0
  float wa[kBlock], wb[kBlock];            ///< 1/kg
  float ga[kBlock], gb[kBlock];            ///< R^2 / I, 1/kg
  float share_a[kBlock], share_b[kBlock];  ///< of an impulse that a body takes in a sweep, <= 1
  float round_a[kBlock], round_b[kBlock];  ///< p: rounding / R
  float lead_a[kBlock], lead_b[kBlock];    ///< q, rad
  float mu[kBlock];
  float e[kBlock];      ///< restitution; negative: the pair is left alone in this substep, as its impact was settled
  float soft[kBlock];   ///< compliance in units of 1 / effective mass
  float rate[kBlock];   ///< 1/s: push-out of an overlap
  float apart[kBlock];  ///< m: from the centre of A to that of B along the normal; 0 if A is fixed geometry
};

/// What some contacts have beside: surfaces that run, and resistance against rolling. One struct for each ManifoldBlock,
/// in worlds that have any.
struct alignas(kAlign) SurfaceBlock {
  float belt[kBlock];    ///< m/s: what the surfaces run along t, B against A
  float resist[kBlock];  ///< m: the torque against rolling is at most this times the normal impulse
  float inv_size_a[kBlock], inv_size_b[kBlock];  ///< 1/m: 1 / R
  float roll[kBlock];                            ///< N m s: of that torque, on B
};

}  // namespace psim::kernels
