/// @file
/// C API: result codes, enumerations, and the small structs, which never change.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "psim/api.h"
#include "psim/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A world. Made by psim_world_create, freed by psim_world_destroy.
typedef struct psim_world psim_world;

/// What a call came to: one of psim_result_code.
typedef int32_t psim_result;

/// Below 0: errors. psim_result_string has the words.
enum psim_result_code {
  PSIM_NOTHING = 1,               ///< no error: there is no such thing
  PSIM_OK = 0,                    ///< done
  PSIM_ERROR_ARGUMENT = -1,       ///< NULL, or a value out of its range
  PSIM_ERROR_STRUCT_SIZE = -2,    ///< struct_size was not set, or is of a newer version
  PSIM_ERROR_STALE_ID = -3,       ///< no such body or joint, or no more
  PSIM_ERROR_NOT_MOVABLE = -4,    ///< the body is static, or frozen for its broken numbers
  PSIM_ERROR_UNSUPPORTED = -5,    ///< the CPU lacks the instruction set
  PSIM_ERROR_OUT_OF_MEMORY = -6,  ///< of the system, or of the world's budget; nothing was done
  PSIM_ERROR_INTERNAL = -7,       ///< something threw; the world can only be destroyed
  PSIM_ERROR_BROKEN_WORLD = -8    ///< it happened before
};

/// What moves a body.
enum psim_body_type {
  PSIM_BODY_DYNAMIC = 0,   ///< forces and contacts
  PSIM_BODY_STATIC = 1,    ///< nothing
  PSIM_BODY_KINEMATIC = 2  ///< its velocity, which only the caller changes
};

/// What the sides of the world do.
enum psim_boundary {
  PSIM_BOUNDARY_WALLS = 0,     ///< four planes
  PSIM_BOUNDARY_PERIODIC = 1,  ///< positions wrap and pairs see across the seam
  PSIM_BOUNDARY_OPEN = 2       ///< a body that leaves the bounds is removed and counted
};

/// How the numbers a and b of two materials in contact give that of the contact.
enum psim_mixing {
  PSIM_MIXING_MAX = 0,       ///< the larger
  PSIM_MIXING_MIN = 1,       ///< the smaller
  PSIM_MIXING_MEAN = 2,      ///< (a + b) / 2
  PSIM_MIXING_PRODUCT = 3,   ///< a b
  PSIM_MIXING_GEOMETRIC = 4  ///< sqrt(a b)
};

/// How bodies move under wells and drag; each step of a method is a substep.
enum psim_integrator {
  PSIM_INTEGRATOR_VERLET = 0,      ///< leapfrog: order 2, symplectic
  PSIM_INTEGRATOR_EULER = 1,       ///< semi-implicit Euler: order 1, symplectic
  PSIM_INTEGRATOR_RK4 = 2,         ///< classical Runge-Kutta: order 4, four evaluations
  PSIM_INTEGRATOR_SYMPLECTIC4 = 3  ///< optimised Forest-Ruth: order 4, four evaluations
};

/// Instruction sets. All give the same bits.
enum psim_isa {
  PSIM_ISA_BEST = -1,   ///< the best that this CPU has
  PSIM_ISA_SCALAR = 0,  ///< one lane
  PSIM_ISA_SSE = 1,     ///< SSE4.1
  PSIM_ISA_AVX2 = 2,    ///< AVX2
  PSIM_ISA_NEON = 3,    ///< NEON of aarch64
  PSIM_ISA_SIMD128 = 4  ///< WebAssembly SIMD
};

/// Kinds of psim_shape.
enum psim_shape_type {
  PSIM_SHAPE_DISC = 0,     ///< radius
  PSIM_SHAPE_SEGMENT = 1,  ///< p1, p2; no thickness, solid from both sides
  PSIM_SHAPE_CHAIN = 2,    ///< vertices, loop; static or kinematic
  PSIM_SHAPE_BOX = 3,      ///< width, height; radius rounds it
  PSIM_SHAPE_POLYGON = 4,  ///< vertices; radius rounds it
  PSIM_SHAPE_CAPSULE = 5   ///< p1, p2, radius
};

/// Kinds of joint.
enum psim_joint_type {
  PSIM_JOINT_DISTANCE = 0,   ///< a rod: the anchors stay `length` apart
  PSIM_JOINT_SPRING = 1,     ///< stiffness x stretch + damping x its rate
  PSIM_JOINT_ROPE = 2,       ///< the anchors come no further apart than `length`
  PSIM_JOINT_REVOLUTE = 3,   ///< a pin; limits and motor on the angle
  PSIM_JOINT_PRISMATIC = 4,  ///< a slide along `axis` of a; limits and motor along it
  PSIM_JOINT_WELD = 5,       ///< the anchors coincide and the angle is kept
  PSIM_JOINT_WHEEL = 6,      ///< b moves along `axis` of a, with spring and limits, and turns freely or by the motor
  PSIM_JOINT_MOTOR = 7,      ///< drives b against a with limited force and torque
  PSIM_JOINT_TARGET = 8,     ///< a spring from the point `target` of the world to b
  PSIM_JOINT_GEAR = 9,       ///< the way of joint_a + ratio x that of joint_b stays what it is
  PSIM_JOINT_PULLEY = 10,    ///< a rope over two points of the world
  PSIM_JOINT_FILTER = 11     ///< the two bodies do not collide, nothing else
};

/// Kinds of psim_field.
enum psim_field_type {
  PSIM_FIELD_WELL = 0,  ///< attraction to a point
  PSIM_FIELD_DRAG = 1   ///< dv/dt = -linear v - quadratic |v| v
};

/// What surrounds bodies.
enum psim_medium_type {
  PSIM_MEDIUM_WATER = 0,  ///< lifts what is in it by the weight of what that displaces
  PSIM_MEDIUM_WIND = 1    ///< pushes what faces it
};

/// A point or a vector.
typedef struct psim_vec2 {
  double x;  ///< to the right
  double y;  ///< up
} psim_vec2;

/// A rectangle, metres; xmin < xmax and ymin < ymax.
typedef struct psim_bounds {
  double xmin;  ///< left
  double ymin;  ///< bottom
  double xmax;  ///< right
  double ymax;  ///< top
} psim_bounds;

/// The handle of a body. An index is used again after its body was removed, with another generation.
typedef struct psim_body_id {
  uint32_t index;       ///< the body's id in published state and files; 0xFFFFFFFF: no body
  uint32_t generation;  ///< how many bodies had the index before
} psim_body_id;

/// The index of the world as a body of a joint, of generation 0: anchors at it are points of the world.
#define PSIM_WORLD_BODY_INDEX 0xFFFFFFFEu

/// The handle of a joint.
typedef struct psim_joint_id {
  uint32_t index;       ///< 0xFFFFFFFF: no joint
  uint32_t generation;  ///< how many joints had the index before
} psim_joint_id;

/// Surface and bulk. Two in contact mix: restitution by max, friction by geometric mean.
typedef struct psim_material {
  double density;      ///< kg/m^2, > 0; default 1
  double restitution;  ///< 0 to 1; default 0
  double friction;     ///< Coulomb coefficient, 0 to 1000; default 0
} psim_material;

/// How a surface bounces, rubs, runs and resists rolling.
typedef struct psim_surface {
  double restitution;  ///< 0 to 1
  double friction;     ///< Coulomb coefficient, 0 to 1000
  /// m/s: it runs like a belt. Positive carries what lies on it to the right, seen with the outward normal up.
  double tangent_speed;
  /// 0 to 1: the torque against rolling is at most this times the radius of what rolls times the normal force.
  double rolling_resistance;
} psim_surface;

/// Who collides with whom. Two bodies of the same group other than 0 always do (group > 0) or never
/// (group < 0); else if each one's category is in the other's mask.
typedef struct psim_filter {
  uint32_t category;  ///< bits: what the body is; default 1
  uint32_t mask;      ///< bits: the categories that it collides with; default all
  int32_t group;      ///< default 0: none
} psim_filter;

/// What a body is, in its own frame. Made by the functions below; unused fields are 0.
typedef struct psim_shape {
  int32_t type;               ///< psim_shape_type
  int32_t loop;               ///< chain: the last vertex is joined to the first
  double radius;              ///< metres: > 0 for discs and capsules, >= 0 for boxes and polygons
  double width;               ///< metres, > 0: box
  double height;              ///< metres, > 0: box
  psim_vec2 p1;               ///< metres: segment, capsule
  psim_vec2 p2;               ///< metres: segment, capsule
  const psim_vec2* vertices;  ///< metres: polygon 3 to 8, counter-clockwise; chain 2 or more
  size_t vertex_count;        ///< how many there are
} psim_shape;

/// One of several shapes of a body. All zero but the shape: it stands at the body's place and has its material.
typedef struct psim_shape_part {
  psim_shape shape;           ///< in the part's frame
  psim_vec2 position;         ///< metres: of the part's frame in the body's
  double angle;               ///< radians: of the part's frame in the body's
  double density;             ///< kg/m^2, > 0; read if has_density
  double restitution;         ///< 0..1; read if has_restitution
  double friction;            ///< Coulomb coefficient, 0..1000; read if has_friction
  int32_t has_density;        ///< flag: else that of the body
  int32_t has_restitution;    ///< flag: else that of the body
  int32_t has_friction;       ///< flag: else that of the body
  int32_t has_filter;         ///< flag: else that of the body
  int32_t has_sensor;         ///< flag: else as the body
  int32_t sensor;             ///< flag: touches nothing, tells who overlaps it; its mass counts; read if has_sensor
  psim_filter filter;         ///< who it collides with; read if has_filter
  int32_t pre_solve;          ///< flag: as in psim_body_desc; read if has_pre_solve
  double tangent_speed;       ///< m/s, as in psim_surface; read if has_tangent_speed
  double rolling_resistance;  ///< 0..1, as in psim_surface; read if has_rolling_resistance
  psim_vec2 one_way;          ///< as in psim_body_desc; read if has_one_way
  int32_t has_tangent_speed;  ///< flag: else that of the body
  int32_t has_rolling_resistance;  ///< flag: else that of the body
  int32_t has_one_way;             ///< flag: else that of the body
  int32_t has_pre_solve;           ///< flag: else as the body
} psim_shape_part;

/// A field that acts on all bodies. Fields of the other kind are not read.
typedef struct psim_field {
  int32_t type;        ///< psim_field_type
  int32_t reserved;    ///< 0
  psim_vec2 position;  ///< metres: of a well
  double strength;     ///< well: a = strength d / (|d|^2 + softening^2)^((exponent+1)/2)
  double softening;    ///< metres, >= 0
  double exponent;     ///< 0 to 16; 2: Newton's law
  double range;        ///< metres: zero beyond; 0: no limit
  double linear;       ///< 1/s, >= 0: drag
  double quadratic;    ///< 1/m, >= 0: drag
} psim_field;

/// Wind or water on all bodies. Members of the other kind are not read.
typedef struct psim_medium {
  int32_t type;            ///< psim_medium_type
  int32_t has_region;      ///< flag, of wind: else it blows everywhere; water always has one
  psim_bounds region;      ///< metres
  psim_vec2 velocity;      ///< m/s, of the air, or of the water's flow
  double density;          ///< kg/m^2, > 0
  double drag;             ///< wind: 0 to 1000, factor of the push along the wind
  double lift;             ///< wind: 0 to 1000, factor of the push to the side, of what leans
  double linear_damping;   ///< water: 1/s, of a body that is wholly in it; else the share of its area
  double angular_damping;  ///< water: 1/s, likewise
  uint32_t mask;           ///< parts whose category is in it
  int32_t reserved;        ///< 0
} psim_medium;

/// A push away from a point: on each part of a body it is `impulse_per_length` times the width that the part shows to the
/// point, at the part's nearest point.
typedef struct psim_explosion {
  psim_vec2 position;         ///< metres
  double radius;              ///< metres, >= 0: up to here the push is whole
  double falloff;             ///< metres, >= 0: beyond `radius` the push fades over these to nothing
  double impulse_per_length;  ///< N s/m; below 0 it pulls
  uint32_t mask;              ///< bodies whose category is in it
  uint32_t reserved;          ///< 0
} psim_explosion;

/// Numbers that lie `stride` bytes apart.
typedef struct psim_column {
  const double* data;  ///< the first; NULL: no column
  size_t stride;       ///< bytes from one to the next; 0: one after the other
} psim_column;

enum {
  PSIM_STEP_WAITS = 1,  ///< time stands still: the work ahead of the substeps is spread over frames
  PSIM_STEP_WAKES = 2,  ///< with it: all was ready, but bodies woke and lists are made anew
  /// n times this: fluids move in n parts at most, 1 to 3; 0 times: in as many as it takes
  PSIM_STEP_FLUID_PART = 4,
  /// n times this: n sweeps over impacts in a substep at most, 1 to 15; 0 times: as many as it takes
  PSIM_STEP_SWEEP = 16
};

/// How much of a step was or is to be done in a frame (docs/governor.md).
typedef struct psim_step_detail {
  uint8_t substeps;  ///< 0: as the world's description has it; at most 64
  uint8_t flags;     ///< PSIM_STEP_WAITS, PSIM_STEP_WAKES, n PSIM_STEP_FLUID_PART, n PSIM_STEP_SWEEP, added up
  uint8_t frames;    ///< that the step makes up for, 1 to 8
  uint8_t horizon;   ///< frames that lists made in it serve, 1 to 8
  uint32_t pieces;   ///< of the work ahead, where it waits: done in the frame
} psim_step_detail;

#ifdef __cplusplus
}
#endif
