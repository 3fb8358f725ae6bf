// Joints as the passes want them: blocks of 8 of one kind that share no dynamic body, one struct a
// block, so that a pass walks through memory in one stream.
//
// A row has a unit normal n and levers s = (arm / R) x n; with u = omega R and g = R^2 / I
//   vn = n.(vB - vA) + sB uB - sA uA
//   an impulse l: vA -= wA l n, uA -= gA sA l, vB += wB l n, uB += gB sB l
// A row of angles is the same with n = 0, s = 1 / R.
#pragma once

#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {

/// What a joint of a world becomes. `driven` and `slide` have limits and a motor; a `linkage` has no blocks, nor has one
/// that does nothing but keep its bodies from colliding.
enum class JointKind : std::uint8_t { rod, spring, pin, driven, slide, weld, linkage, none };
inline constexpr int kJointKinds = 6;  // those with blocks

/// The two bodies of each lane and the arms from their centres to the anchors.
struct JointBodies {
  std::uint32_t body[2 * kBlock];                            ///< A and B of each lane
  float wa[kBlock], wb[kBlock];                              ///< 1/kg
  float ga0[kBlock], gb0[kBlock];                            ///< R^2 / I, 1/kg
  float ga[kBlock], gb[kBlock];                              ///< the same as far as the load lets a body turn
  float ra[kBlock], rb[kBlock];                              ///< 1 / R, 1/m
  float ax0[kBlock], ay0[kBlock], bx0[kBlock], by0[kBlock];  ///< arms / R at the frame's start
  float ax[kBlock], ay[kBlock], bx[kBlock], by[kBlock];      ///< the same now
  float ea[kBlock], eb[kBlock];  ///< N s: half of what turning the impulses adds to those of the levers
};

/// Rod, rope and spring: one row along the line of the anchors. First what every pass reads.
struct alignas(kAlign) LineBlock : JointBodies {
  float nx[kBlock], ny[kBlock], c[kBlock];  ///< now
  float curvature[kBlock];                  ///< 1 / distance of the anchors, 1/m
  float mass[kBlock];                       ///< kg
  float l[kBlock];                          ///< N s
  float top[kBlock];                        ///< N s: most impulse; rods: infinite, ropes: 0 (they only pull)
  float ex[kBlock], ey[kBlock];             ///< N s: half of what turning the normal adds to the impulse
  std::uint32_t central;  ///< 1: anchors of all lanes are the bodies' centres, which do not turn them; else 0
  alignas(kAlign) float dx0[kBlock];
  float dy0[kBlock];                ///< m: from anchor to anchor at the frame's start
  float far0[kBlock];               ///< m: its length
  float c0[kBlock];                 ///< m: that length less the joint's length
  float push[kBlock];               ///< springs: k h, N s/m
  float drag[kBlock], lag[kBlock];  ///< springs, kg: times the speeds before and after, times the one before
};

/// The anchors coincide: two rows.
struct alignas(kAlign) PinBlock : JointBodies {
  float cx0[kBlock], cy0[kBlock];               ///< m: B's anchor from A's at the frame's start
  float cx[kBlock], cy[kBlock];                 ///< now
  float m11[kBlock], m12[kBlock], m22[kBlock];  ///< kg: inverse of K
  float px[kBlock], py[kBlock];                 ///< N s
};

/// A row with two ends and a motor, on the angle or along the axis.
struct Drive {
  float lower[kBlock], upper[kBlock];  ///< rad or m
  float speed[kBlock];                 ///< rad/s or m/s
  float most[kBlock];                  ///< N m s or N s a substep
  float limit_l[kBlock], motor_l[kBlock];
};

/// A pin with a row of angles. An impulse of 1 N m s in that row takes the impulse g along in the pin, so that the
/// anchors stay together (Schur complement).
struct alignas(kAlign) TwistBlock : PinBlock {
  float angle0[kBlock], angle[kBlock];  ///< rad: B - A - reference
  float gx[kBlock], gy[kBlock];         ///< 1/m: impulse of the pin
  float mass[kBlock];                   ///< kg m^2, with it
};

struct alignas(kAlign) DrivenBlock : TwistBlock {
  Drive drive;
};

struct alignas(kAlign) WeldBlock : TwistBlock {
  float push[kBlock], drag[kBlock], lag[kBlock];  ///< soft ones, as in LineBlock; 0: rigid
  float l[kBlock];                                ///< N m s
};

/// B moves along an axis of A and does not turn against it.
struct alignas(kAlign) SlideBlock : JointBodies {
  float ux0[kBlock], uy0[kBlock];      ///< axis at the frame's start
  float along0[kBlock], off0[kBlock];  ///< m: of B's anchor from A's at the frame's start
  float angle0[kBlock];                ///< rad: B - A - reference
  float ux[kBlock], uy[kBlock];        ///< axis now
  float along[kBlock], off[kBlock], angle[kBlock];
  float lean_a[kBlock],
      lean_b[kBlock];                           ///< levers of the row across the axis (for A, of B's anchor)
  float pull_a[kBlock], pull_b[kBlock];         ///< of the row along it
  float m11[kBlock], m12[kBlock], m22[kBlock];  ///< inverse of K: across, angle
  float gl[kBlock], gt[kBlock];                 ///< what 1 N s along takes along across, and as an angle
  float mass[kBlock];                           ///< kg: along, with it
  float l[kBlock], turn_l[kBlock];              ///< N s, N m s
  float ex[kBlock], ey[kBlock];
  Drive drive;
};

/// Constants of a pass.
struct JointParams {
  float h = 0;
  float inv_h = 0;
  float rate = 0;      ///< 1/s: velocity that corrects a position error, over the error
  float warm = 1;      ///< factor on stored impulses
  bool again = false;  ///< not the first sweep of the pass
};

/// Blocks of one kind.
using JointBlocks = void*;

/// Here `part_joints` sums what joints did to the velocities of bodies in this substep. Between its two calls
/// around a pass these hold the rest of the velocities.
struct JointShare {
  float* vel = nullptr;              ///< m/s records
  float* rim_speed = nullptr;        ///< m/s
  float* push = nullptr;             ///< m/s records: for the drift alone, to take position errors back
  float* push_rim_speed = nullptr;   ///< m/s
  float* push0 = nullptr;            ///< m/s records: scratch of the drift
  float* push0_rim_speed = nullptr;  ///< m/s: likewise
};

}  // namespace psim::kernels
