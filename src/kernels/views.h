// What kernels see: plain pointers, counts and constants. No world, no thread, no allocator.
// "Record" columns hold {x, y} pairs, 8 bytes a body: a contact touches few lines that way
// (docs/kernels.md has the measured alternatives). A slot is the place of a body in the columns of a
// BodyView.
#pragma once

#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {

/// Constants of the stream kernels for one substep or frame.
struct StreamParams {
  float h = 0;       ///< s, length of the substep (or frame, for integrate)
  float kick_x = 0;  ///< m/s, uniform gravity x h
  float kick_y = 0;
  float damp = 1;            ///< exp(-c h)
  float damp_remainder = 0;  ///< what rounding took from `damp`: for kicks that keep remainders
  float again = 0;           ///< the number of later kicks of the frame, which repeat the first one
  float smooth_limit2 = 0;   ///< (m/s)^2: below it a velocity change counts as smooth (trapezoid)
  float least_spin2 = 0;  ///< rad^2/s^2: what turns slower turns by its new rate, so that what rests loses its tremble
  float coast = 0;        ///< s; closed form of a free body over a frame: d += coast v + fall
  float drop = 0;         ///< s^2; where accelerations are the bodies' own: fall = drop a, kick = coast a
  float fall_x = 0;       ///< m
  float fall_y = 0;
  float pitch_x = 0;  ///< m a lattice step
  float pitch_y = 0;
  float inv_pitch_x = 0;
  float inv_pitch_y = 0;
  float speed_limit2 = 0;  ///< (m/s)^2: faster (or NaN) is reported as bad
  float far_x = 1e30f;     ///< m: nobody goes further in a frame, or it could wrap around the lattice
  float far_y = 1e30f;
};

/// Body columns. Records are {x, y}; every column is readable to kReadPad beyond its end and its
/// blocks of 8 are whole.
struct BodyView {
  std::int32_t* pos = nullptr;        ///< lattice position records
  float* vel = nullptr;               ///< m/s records
  float* vel0 = nullptr;              ///< velocity before the substep's kick, records
  float* disp = nullptr;              ///< m, offset from the lattice point, records
  float* acc = nullptr;               ///< m/s^2 records of this substep, or null: uniform gravity
  float* vel_remainder = nullptr;     ///< m/s records, what vel lost to rounding, or null: not kept
  float* disp_remainder = nullptr;    ///< m records, what disp lost, or null: leapfrog
  float* drift_correction = nullptr;  ///< m records, a method's way less h (v0 + v)/2, or null: leapfrog
  const float* pull = nullptr;        ///< gravity scale, or null: all 1
  float* rim_speed = nullptr;         ///< surface speed omega r, m/s, or null: no rotation
  float* rim_speed0 = nullptr;
  float* arm_change = nullptr;           ///< m records, R (cos d - 1, sin d), or null: nothing with corners or joints
  float* angle_change = nullptr;         ///< rad: d, how far it turned since the frame's start
  float* event_time = nullptr;           ///< s into the substep of the last impact, or null: no impacts
  float* rim_way = nullptr;              ///< m: what impacts of this substep add to the way of the rim, or null
  const std::uint8_t* linked = nullptr;  ///< 0xFF: some list names the body, it takes substeps
};

/// A well as the kernels want it: strength d / (|d|^2 + softening2)^((exponent+1)/2), none where
/// |d|^2 > range2.
struct WellTerms {
  double x = 0, y = 0;  ///< m, in the coordinates of lattice positions
  double strength = 0;
  double softening2 = 0;       ///< m^2
  double range2 = 0;           ///< m^2; infinite: no end
  std::uint32_t whole = 0;     ///< (exponent + 1)/2: whole part
  std::uint32_t fraction = 0;  ///< and 2^32 times the rest, 30 bits of it
};

/// Smooth forces over one substep, for field_kernel.h.
struct FieldParams {
  const WellTerms* wells = nullptr;
  std::uint32_t well_count = 0;
  double period_x = 0, period_y = 0;  ///< m, of a periodic world: the nearest copy of a well pulls; else 0
  double h = 0;                       ///< s
  double pitch_x = 0, pitch_y = 0;    ///< m a lattice step
  double gravity_x = 0, gravity_y = 0;
  double linear = 0;               ///< 1/s: linear drag and damping
  double quadratic = 0;            ///< 1/m
  double fade = 1, fade_span = 0;  ///< exp(-linear h) and (1 - exp(-linear h)) / linear
  double half_fade = 1;            ///< exp(-linear h / 2)
  double smooth = 0;               ///< s^2: (v - v0)^2 / acc^2 up to which contacts act smoothly; < 0: never
};

/// What a scene can ask for besides leapfrog, which needs no method of its own.
enum class Method : std::uint8_t { euler, rk4, symplectic4 };
inline constexpr int kMethods = 3;

/// Margins of the neighbour lists.
struct ReachParams {
  float skin = 0;       ///< m
  float of_radius = 0;  ///< if not 0: the skin of a body is at most this share of its radius
  float time = 0;       ///< s of a body's own motion
  float common_x = 0;   ///< m/s: velocity that motion is measured against
  float common_y = 0;
  float beside = 0;  ///< m: more for fixed shapes, towards which bodies may go while they stay with each other
};

/// Grid that cell keys are computed against.
struct GridView {
  std::int32_t mid_x = 0, mid_y = 0;  ///< lattice point that `offset` cells belong to
  float scale_x = 0, scale_y = 0;     ///< cells a lattice step
  float offset_x = 0, offset_y = 0;   ///< cells
  std::int32_t cols = 0, rows = 0;
  std::uint32_t stride = 0;  ///< keys a row (cols + empty guard cells)
};

/// One row of bodies searched against itself and the next row.
struct PairRow {
  const std::int32_t* pos = nullptr;
  const float* reach = nullptr;          ///< m: radius + margin
  const std::uint32_t* key = nullptr;    ///< cell of each body
  const std::uint32_t* start = nullptr;  ///< first body of each cell; start[key+1] its end
  std::int32_t next_row = 0;             ///< key distance from a cell to the cell above it
  float pitch_x = 0, pitch_y = 0;
  // Periodic worlds: the keys of the row's first and last cell, whose bodies also look across the
  // seam. kNoSeam otherwise.
  std::uint32_t seam_first = 0xFFFFFFFFu, seam_last = 0xFFFFFFFFu;
};

/// Where pair search writes: pair p is owner[p], other[p]; those of body i begin at first[i].
struct PairList {
  std::uint32_t* owner = nullptr;
  std::uint32_t* other = nullptr;
  std::uint32_t* first = nullptr;
  std::uint32_t count = 0;     ///< numbers written so far
  std::uint32_t capacity = 0;  ///< numbers that fit
};

/// Flat pairs of slots, and where the chosen ones go.
struct PairSelection {
  const std::uint32_t* owner = nullptr;
  const std::uint32_t* other = nullptr;
  const float* radius = nullptr;
  float pitch_x = 0, pitch_y = 0;
  float time = 0;                      ///< s
  float slack = 0;                     ///< m
  std::uint32_t* out_owner = nullptr;  ///< room for the count and kBlock more
  std::uint32_t* out_other = nullptr;
};

/// Constants of the contact passes of one substep. Soft terms: docs/solver.md.
struct ContactParams {
  float h = 0;
  float inv_h = 0;
  float pitch_x = 0, pitch_y = 0;
  float soft_rate = 0;                 ///< 1/s: mass scale x bias rate
  float soft_mass = 0;                 ///< mass scale
  float soft_impulse = 0;              ///< impulse scale
  float push = 0;                      ///< m/s: fastest push-out
  float refresh = 0;                   ///< m: sideways motion above which a normal is computed anew
  float warm = 0;                      ///< factor on stored impulses (new h / old h)
  float gravity_x = 0, gravity_y = 0;  ///< m/s^2
  float bounce_floor = 0;              ///< m/s: e |vn| below this is left to the solver
  float due = 1e30f;                   ///< s into the substep: later impacts wait for another sweep
  float least_e = 0;                   ///< impacts with less restitution are left to the solver
  float impact_floor = 0;              ///< m/s: slower approaches of touching bodies do not bounce
};

/// Contacts between two bodies, in blocks of 8 that share no body within a colour. Lane l of block
/// k has its floats at [8 k + l] and its slots at body[2 (8 k + l)] (A) and [.. + 1] (B); the
/// normal points from A to B. Impulses: N s, or m/s where all masses are equal (mass 1).
/// A stored normal impulse of -0 marks a contact that is open in this substep.
struct ContactView {
  const std::uint32_t* body = nullptr;
  float* nx = nullptr;
  float* ny = nullptr;
  float* gap = nullptr;  ///< m: separation at displacement 0 along the stored normal
  float* impulse = nullptr;
  const float* rsum = nullptr;  ///< m: sum of radii
  // Unequal masses:
  const float* mass = nullptr;  ///< effective normal mass
  const float* wa = nullptr;    ///< inverse masses
  const float* wb = nullptr;
  // Friction:
  const float* mu = nullptr;
  float* friction = nullptr;     ///< stored tangent impulse
  const float* tmass = nullptr;  ///< effective tangent mass
  const float* qa = nullptr;     ///< r^2 / inertia: change of surface speed a tangent impulse
  const float* qb = nullptr;
  // Restitution:
  const float* e = nullptr;  ///< coefficient
  float* impact = nullptr;   ///< +1: not for impact sweeps, +0: pending, -0: a sweep of this substep settled it
  float* start = nullptr;    ///< impulse at the start of the substep
};

/// Contacts of one body with fixed geometry. The normal points to the body.
struct StaticContactView {
  const std::uint32_t* body = nullptr;  ///< one slot a lane
  float* nx = nullptr;
  float* ny = nullptr;
  float* gap = nullptr;
  float* impulse = nullptr;
  const float* base_x = nullptr;  ///< m: from the fixed point to the body's lattice point
  const float* base_y = nullptr;
  const float* rsum = nullptr;     ///< m: radii of the body and of the fixed point
  const float* refresh = nullptr;  ///< m: as ContactParams::refresh; infinite for flat faces
  const float* mass = nullptr;
  const float* wb = nullptr;
  const float* mu = nullptr;
  float* friction = nullptr;
  const float* tmass = nullptr;
  const float* qb = nullptr;
  const float* e = nullptr;
  float* impact = nullptr;
  float* start = nullptr;
};

/// What an impact sweep is: the first one of the substep, before which all marks are stale; a later one; or a later one
/// where sweeps leave late impacts to those after them (ContactParams::due).
enum class Sweep : std::uint8_t { first, later, sliced };
inline constexpr int kSweeps = 3;

/// Whether contacts have restitution, and which sweep of a pass it is: contacts under heavy loads have several. `edge`
/// is the first one of the solve pass, the last one of the relax pass, or the only one; `inner` is any other.
enum class Bounce : std::uint8_t { none, edge, inner };
inline constexpr int kBounces = 3;

/// Which columns the contact passes read: equal masses; any masses; any masses and friction.
enum class Model : std::uint8_t { plain, massed, rough };
inline constexpr int kModels = 3;

}  // namespace psim::kernels
