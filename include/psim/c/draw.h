/// @file
/// C API: what a world looks like, handed to the caller's own drawing.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What is drawn.
enum psim_draw_kind {
  PSIM_DRAW_DYNAMIC_BODY = 0,    ///< awake
  PSIM_DRAW_KINEMATIC_BODY = 1,  ///< that the host moves
  PSIM_DRAW_STATIC_BODY = 2,     ///< that stands fixed
  PSIM_DRAW_ASLEEP = 3,          ///< a dynamic body that sleeps
  PSIM_DRAW_FROZEN = 4,          ///< a body whose numbers were broken
  PSIM_DRAW_SENSOR = 5,          ///< a body or part that only feels
  PSIM_DRAW_JOINT = 6,           ///< from anchor to anchor, or to a body's place
  PSIM_DRAW_CONTACT = 7,         ///< where two bodies touch, and its normal
  PSIM_DRAW_FORCE = 8,           ///< of a contact or joint, N times force_scale
  PSIM_DRAW_BOUNDS = 9,          ///< of the world
  PSIM_DRAW_PARTICLE = 10        ///< of a fluid
};

/// Says what is wanted, and has the functions that draw it. `kind` is a psim_draw_kind; places are of the world, metres. A function
/// that is NULL is not called. They must not call the world.
typedef struct psim_debug_draw {
  uint32_t struct_size;  ///< set by psim_debug_draw_init
  int32_t bodies;        ///< flag: circles and polygons; default 1
  int32_t joints;        ///< flag: lines between anchors; default 1
  int32_t contacts;      ///< flag: points, and lines of their normals
  int32_t forces;        ///< flag: lines: of contacts the mean of the last step, of joints its last substep
  int32_t bounds;        ///< flag: the sides of a world that is not open; default 1
  int32_t has_region;    ///< flag: only bodies, contacts and particles that may reach into `region`
  int32_t reserved;      ///< 0
  psim_bounds region;    ///< metres
  double force_scale;    ///< m/N; default 0.01
  double normal_length;  ///< metres; default 0.2
  void* user;            ///< given to the functions
  /// A disc with a spoke at `angle`, radians. A particle is a disc of half a spacing, without angle and body.
  void (*circle)(void* user, psim_vec2 centre, double radius, double angle, int32_t kind, psim_body_id body);
  /// A convex part: 2 corners of a line or capsule, else 3 to 8 counter-clockwise; rounded by `radius`.
  void (*polygon)(void* user, const psim_vec2* corners, size_t count, double radius, int32_t kind, psim_body_id body);
  /// From one point to another.
  void (*line)(void* user, psim_vec2 from, psim_vec2 to, int32_t kind);
  /// A dot.
  void (*point)(void* user, psim_vec2 at, int32_t kind);
  int32_t particles;   ///< flag: circles of fluids; default 1
  int32_t reserved_2;  ///< 0
} psim_debug_draw;

/// Sets the defaults.
static inline void psim_debug_draw_init(psim_debug_draw* draw) {
  psim_init(draw, PSIM_STRUCT_DEBUG_DRAW, (uint32_t)sizeof *draw);
}

/// Calls the functions for bounds, then particles by id, bodies by id, joints by index, contacts in their order, as they are now.
/// PSIM_ERROR_ARGUMENT if a number is not finite.
PSIM_API psim_result psim_world_debug_draw(psim_world* world, const psim_debug_draw* draw);

#ifdef __cplusplus
}
#endif
