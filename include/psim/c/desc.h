/// @file
/// C API: descriptions that the caller fills in. Each begins with struct_size, which psim_NAME_init sets, as it does the
/// defaults. New fields come at the end. <psim/limits.h> says which numbers are allowed.
#pragma once

#include <string.h>

#include "psim/c/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The world and how it is stepped.
typedef struct psim_world_desc {
  uint32_t struct_size;            ///< set by psim_world_desc_init
  int32_t boundary;                ///< psim_boundary; default walls
  psim_bounds bounds;              ///< metres; default -500 to 500 on both axes; 1e-9 to 1e9 m wide
  psim_vec2 gravity;               ///< m/s^2; default (0, -9.81)
  double linear_damping;           ///< 1/s, >= 0: dv/dt = -c v, integrated exactly; default 0
  psim_material wall;              ///< of the four sides, when boundary is walls
  const psim_field* fields;        ///< wells and drag; NULL if there are none
  size_t field_count;              ///< how many there are; default 0
  double dt;                       ///< seconds a frame, above 0, at most 10; default 1/60
  int32_t substeps;                ///< 1 to 64; default 4
  int32_t integrator;              ///< psim_integrator, of wells and drag; default verlet
  double restitution_threshold;    ///< m/s, >= 0: slower impacts do not bounce; default 0
  int32_t sleeping;                ///< flag: bodies at rest are left out of the steps; default 1
  int32_t reserved;                ///< 0
  double skin;                     ///< 0.25 to 4: factor on the skin of neighbour lists; default 1
  uint64_t max_bytes;              ///< that the world may take, 0 (the default) for any number
  int32_t restitution_mixing;      ///< psim_mixing, of two materials in contact; default the larger
  int32_t friction_mixing;         ///< psim_mixing; default the geometric mean
  double wall_tangent_speed;       ///< m/s, as in psim_surface: of the walls; default 0
  double wall_rolling_resistance;  ///< 0 to 1, as in psim_surface: of the walls; default 0
  const psim_medium* media;        ///< wind and water; NULL if there are none
  size_t medium_count;             ///< how many there are; default 0
} psim_world_desc;

/// How the caller wants the world run. None of it changes a bit of the result.
typedef struct psim_run_options {
  uint32_t struct_size;  ///< set by psim_run_options_init
  int32_t isa;           ///< psim_isa; default the best
  int32_t threads;       ///< 1 to 256; 1, the default, runs without workers
  int32_t reserved;      ///< 0
} psim_run_options;

/// One body. Dynamic bodies turn about their centre of mass, kinematic ones about `position`; `velocity` is of that point.
typedef struct psim_body_desc {
  uint32_t struct_size;     ///< set by psim_body_desc_init
  int32_t type;             ///< psim_body_type; default dynamic
  psim_shape shape;         ///< default a disc of radius 0.5 m
  psim_vec2 position;       ///< metres, inside the world's bounds; default (0, 0)
  double angle;             ///< radians; default 0
  psim_vec2 velocity;       ///< m/s; default (0, 0)
  double angular_velocity;  ///< rad/s; default 0
  psim_material material;   ///< what it is made of
  double mass;              ///< kg, wins over the density; 0, the default: from the density
  double gravity_scale;     ///< factor on the world's gravity and wells; default 1
  int32_t fixed_rotation;   ///< flag: contacts do not turn it
  int32_t bullet;           ///< flag: does not pass through other moving bodies either, however fast
  int32_t sensor;           ///< flag: touches nothing but the world's walls, tells who overlaps it
  psim_filter filter;       ///< who it collides with
  /// Several shapes that move as one, instead of `shape`; NULL, the default: `shape`. They may overlap: mass, centre of
  /// mass and inertia are the sums over the parts. No chain in a dynamic body.
  const psim_shape_part* parts;
  size_t part_count;          ///< how many there are
  double linear_damping;      ///< 1/s, >= 0: dv/dt = -c v, integrated exactly; of a dynamic body; default 0
  double angular_damping;     ///< 1/s, >= 0: the same of the angular velocity; default 0
  int32_t lock_x;             ///< flag: it does not move along x
  int32_t lock_y;             ///< flag: it does not move along y
  int32_t lock_angle;         ///< flag: it does not turn
  int32_t reserved;           ///< 0
  double tangent_speed;       ///< m/s, as in psim_surface; default 0
  double rolling_resistance;  ///< 0 to 1, as in psim_surface; default 0
  /// Solid only for what comes against this direction, in the body's frame; (0, 0), the default: from all sides.
  psim_vec2 one_way;
  /// Where `shape` is a chain, each of its segments has one of these surfaces; NULL, the default: all have the body's.
  const psim_surface* surfaces;
  size_t surface_count;  ///< how many there are
  uint64_t user_data;    ///< whatever the caller likes: psim_world_user_data
  int32_t disabled;      ///< flag: it takes no part in the world until psim_world_set_enabled
  int32_t pre_solve;     ///< flag: the caller is shown its new contacts: psim_world_set_pre_solve
  int32_t sleepless;     ///< flag: it stays awake, of a dynamic body
  int32_t reserved_3;    ///< 0
} psim_body_desc;

/// psim_world_traits reads these of a body, and psim_world_set_traits changes them at any time.
typedef struct psim_body_traits {
  uint32_t struct_size;    ///< set by psim_body_traits_init
  psim_filter filter;      ///< who it collides with; of parts that differ: the usual one
  psim_surface surface;    ///< of parts that differ: the largest restitution and friction, else 0
  psim_vec2 one_way;       ///< as in psim_body_desc; of parts that differ: 0
  int32_t sensor;          ///< flag: as in psim_body_desc; a static body does not change it
  int32_t bullet;          ///< flag: as in psim_body_desc; of a body that moves
  double mass;             ///< kg, of a dynamic body, else 0
  double inertia;          ///< kg m^2 about the centre of mass, of a dynamic body; 0: it does not turn
  double gravity_scale;    ///< of a dynamic body, as all that follows
  double linear_damping;   ///< 1/s
  double angular_damping;  ///< 1/s
  int32_t lock_x;          ///< flag: it does not move along x
  int32_t lock_y;          ///< flag: it does not move along y
  int32_t lock_angle;      ///< flag: it does not turn
  int32_t pre_solve;       ///< flag: as in psim_body_desc; of parts that differ: 0
  int32_t sleepless;       ///< flag: as in psim_body_desc
  int32_t reserved_2;      ///< 0
} psim_body_traits;

/// Many discs that share all but place, size and speed. Columns of `count` numbers; NULL stands for zeros.
typedef struct psim_disc_batch {
  uint32_t struct_size;          ///< set by psim_disc_batch_init
  int32_t type;                  ///< psim_body_type; default dynamic
  size_t count;                  ///< how many discs; at most 4294967294
  psim_column x;                 ///< metres, inside the world's bounds; not NULL
  psim_column y;                 ///< metres; not NULL
  psim_column radius;            ///< metres, > 0; NULL: all have common_radius
  psim_column angle;             ///< radians
  psim_column vx;                ///< m/s
  psim_column vy;                ///< m/s
  psim_column angular_velocity;  ///< rad/s
  double common_radius;          ///< metres, > 0; default 0.5
  psim_material material;        ///< what they are made of
  double mass;                   ///< kg each; 0, the default: from the density
  double gravity_scale;          ///< default 1
  int32_t fixed_rotation;        ///< flag
  int32_t bullet;                ///< flag
  psim_filter filter;            ///< who they collide with
  int32_t reserved;              ///< 0
  double tangent_speed;          ///< m/s, as in psim_surface; default 0
  double rolling_resistance;     ///< 0 to 1, as in psim_surface; default 0
} psim_disc_batch;

/// One joint. At least one of the bodies must be dynamic.
typedef struct psim_joint_desc {
  uint32_t struct_size;       ///< set by psim_joint_desc_init
  int32_t type;               ///< psim_joint_type; default distance
  psim_body_id a;             ///< a body
  psim_body_id b;             ///< another
  psim_vec2 anchor_a;         ///< metres, in the frame of a
  psim_vec2 anchor_b;         ///< metres, in the frame of b
  double length;              ///< metres; without has_length as far apart as the anchors are now
  double stiffness;           ///< N/m along a line or axis, N m/rad of an angle; 0: no spring; weld: rigid
  double damping;             ///< N s/m or N m s/rad
  psim_vec2 axis;             ///< prismatic, wheel: direction in the frame of a; default (1, 0)
  double reference;           ///< radians: angle b - a that counts as 0; without has_reference the present
  double lower;               ///< revolute: radians; distance, prismatic, wheel: metres; without has_lower no limit
  double upper;               ///< as lower, and not below it
  double motor_speed;         ///< rad/s or m/s
  double motor_limit;         ///< most torque, N m, or force, N, >= 0; 0: no motor
  int32_t has_length;         ///< flag: length is set
  int32_t has_reference;      ///< flag: reference is set
  int32_t has_lower;          ///< flag: lower is set
  int32_t has_upper;          ///< flag: upper is set
  int32_t collide;            ///< flag: the two bodies still collide
  int32_t reserved;           ///< 0
  psim_vec2 target;           ///< target: metres, a point of the world
  double rest;                ///< revolute, radians; prismatic, metres: where the spring rests
  psim_vec2 linear_velocity;  ///< motor: m/s, of b's anchor against the point of a there
  double angular_velocity;    ///< motor: rad/s
  double force_limit;         ///< motor, target: N; 0: motor: no force, target: any force
  double torque_limit;        ///< motor: N m; 0: no torque
  psim_vec2 ground_a;         ///< pulley: metres, the point of the world over which the rope goes to a
  psim_vec2 ground_b;         ///< pulley: metres, the same to b
  double ratio;               ///< gear, pulley; default 1
  psim_joint_id joint_a;      ///< gear: a revolute or prismatic joint
  psim_joint_id joint_b;      ///< gear: another one
  double frequency;           ///< Hz: instead of stiffness and damping; 0: those count
  double damping_ratio;       ///< with frequency: 1 is the least damping without a swing
  double break_force;         ///< N: gone after a step with more in the mean, the most loaded first; 0: never
  double break_torque;        ///< N m: the same
  uint64_t user_data;         ///< 64 bits of the host
  double linear_stiffness;    ///< weld: N/m, of a spring that holds the anchors together; 0 and no damping: rigid
  double linear_damping;      ///< weld: N s/m, of that spring
  double correction;          ///< motor: 0 to 1, of the way to offset and reference: the share of each step
  psim_vec2 offset;           ///< motor: metres, in the frame of a: from its anchor to that of b
  double pressure;   ///< distance, spring, rope, weld: N/m of the way between the anchors, to the right of a to b
  double wind_drag;  ///< distance, spring, rope: 0 to 1000: the joint catches wind, with this as drag
  double wind_lift;  ///< and with this as lift
  double area;       ///< m^2: a ring of joints with areas, all from a to b, keeps their sum inside; 0: none
} psim_joint_desc;

/// Which bodies a question is about. Default: all but sensors.
typedef struct psim_query_filter {
  uint32_t struct_size;  ///< set by psim_query_filter_init
  uint32_t mask;         ///< bodies whose category is in it
  int32_t dynamic;       ///< flag: dynamic ones
  int32_t kinematic;     ///< flag: kinematic ones
  int32_t fixed;         ///< flag: static ones
  int32_t sensors;       ///< flag: sensors, of the kinds above
  uint32_t category;  ///< bodies whose own mask has one of these bits; default all bits: every body, whatever its mask
  psim_body_id ignore;  ///< this body is not found; default no body
  int32_t one_way;      ///< flag: rays, casts and nearby meet shapes that are solid from one side on that side alone
  int32_t enter_only;   ///< flag: rays and casts pass through what they overlap where they start
  int32_t reserved;     ///< 0
} psim_query_filter;

/// What steps tell. Default: nothing.
typedef struct psim_event_options {
  uint32_t struct_size;  ///< set by psim_event_options_init
  int32_t contacts;      ///< flag: who begins and ceases to touch
  int32_t hits;          ///< flag: impacts
  int32_t sensors;       ///< flag: who enters and leaves them
  double hit_speed;      ///< m/s: slower impacts are not told; default 1
  int32_t sleep;         ///< flag: who falls asleep and who wakes
  int32_t moves;         ///< flag: who moved, and whereto
  int32_t fluids;        ///< flag: which particles enter and leave sensors
  int32_t reserved;      ///< 0
} psim_event_options;

/// Costs of work on one machine with one number of threads. psim_measure_costs fills it in; hand it on as it is.
typedef struct psim_cost_model {
  uint32_t struct_size;  ///< set by psim_cost_model_init
  int32_t reserved;      ///< 0
  double step;           ///< a frame, whatever is in it
  double check;          ///< a body: do its lists serve
  double sort;           ///< a body, when lists are made: to its cell
  double search;         ///< a body: its candidates
  double test;           ///< two bodies that are looked at for that
  double pair;           ///< a candidate pair that is found
  double near;           ///< a body: walls near it
  double near_fixed;     ///< a body, where there are fixed shapes or sleepers
  double near_shape;     ///< a fixed shape near a body
  double select;         ///< a candidate pair, when a step selects from them
  double pack;           ///< a pair that was selected, a body that the solver may leave out
  double group;          ///< a manifold, when it is taken out of the lists of discs
  double load;           ///< a contact of discs, where bodies carry much heavier ones
  double colour;         ///< a contact of discs, when contacts are laid out: its colour
  double lay_out;        ///< its lane
  double lay_out_rough;  ///< the same with friction or restitution
  double keep;           ///< a manifold that is kept as it is: its gaps
  double look;           ///< a manifold that is looked at anew
  double stand;          ///< a manifold: who stands on whom
  double column;         ///< a manifold: its lane
  double narrow;         ///< a contact of discs: its normal, its sums
  double load_body;      ///< a body that the solver copies
  double move;           ///< a body: integrate
  double stop;           ///< a body, where shapes fly fast
  double sleep;          ///< a body or a contact, each time that sleep looks at it
  double joint;          ///< a joint
  double joint_sorted;   ///< a joint whose bodies have new slots
  double body_pass;      ///< a body that the solver has
  double pass;           ///< a lane of contacts of discs
  double touch;          ///< a contact that presses
  double sweep;          ///< a lane, in a sweep over impacts, where there is restitution
  double shape_pass;     ///< a manifold
  double joint_pass;     ///< a joint
  double cell;           ///< a cell of the grid, when lists are made
  double flight;         ///< a fixed shape near the way of a fast shape
  double strip;          ///< a strip, each time that its lists are gone through
  double particle;       ///< a particle of a fluid
} psim_cost_model;

/// How a frame's budget is kept by doing less (docs/governor.md).
typedef struct psim_governor_desc {
  uint32_t struct_size;          ///< set by psim_governor_desc_init
  int32_t on;                    ///< flag; default 0: every step is done in full
  double budget_ms;              ///< of a frame; default 1000/60
  const psim_cost_model* costs;  ///< by which work becomes time; NULL: the defaults
} psim_governor_desc;

/// A job: run(job, index) for each index once.
typedef void (*psim_job_function)(void* job, size_t index);

/// The caller's job system. `parallel_for` calls function(job, i) for every i from 0 to count - 1
/// once, on any of its threads in any order, and returns when all are done. It is called from the
/// thread that steps, several times a step, and must not call psim on the same world.
typedef struct psim_job_system {
  uint32_t struct_size;  ///< set by psim_job_system_init
  int32_t workers;       ///< how many threads may run jobs at once, 1 or more; default 1
  void* user;            ///< handed to parallel_for
  /// NULL: the world's own workers
  void (*parallel_for)(void* user, size_t count, psim_job_function function, void* job);
} psim_job_system;

/// Which struct psim_init is given.
enum psim_struct {
  PSIM_STRUCT_WORLD_DESC = 1,     ///< psim_world_desc
  PSIM_STRUCT_RUN_OPTIONS = 2,    ///< psim_run_options
  PSIM_STRUCT_BODY_DESC = 3,      ///< psim_body_desc
  PSIM_STRUCT_DISC_BATCH = 4,     ///< psim_disc_batch
  PSIM_STRUCT_JOINT_DESC = 5,     ///< psim_joint_desc
  PSIM_STRUCT_QUERY_FILTER = 6,   ///< psim_query_filter
  PSIM_STRUCT_EVENT_OPTIONS = 7,  ///< psim_event_options
  PSIM_STRUCT_COST_MODEL = 8,     ///< psim_cost_model
  PSIM_STRUCT_GOVERNOR_DESC = 9,  ///< psim_governor_desc
  PSIM_STRUCT_JOB_SYSTEM = 10,    ///< psim_job_system
  PSIM_STRUCT_STEP_REPORT = 11,   ///< psim_step_report
  PSIM_STRUCT_STATE = 12,         ///< psim_state
  PSIM_STRUCT_SNAPSHOT = 13,      ///< psim_snapshot
  PSIM_STRUCT_EVENTS = 14,        ///< psim_events
  PSIM_STRUCT_DIAGNOSTICS = 15,   ///< psim_diagnostics
  PSIM_STRUCT_BODY_TRAITS = 16,   ///< psim_body_traits
  PSIM_STRUCT_MOVER_DESC = 17,    ///< psim_mover_desc
  PSIM_STRUCT_MOVER_STATE = 18,   ///< psim_mover_state
  PSIM_STRUCT_DEBUG_DRAW = 19,    ///< psim_debug_draw
  PSIM_STRUCT_PART_TRAITS = 20,   ///< psim_part_traits
  PSIM_STRUCT_FLUID_DESC = 21,    ///< psim_fluid_desc
  PSIM_STRUCT_FLUID_REPORT = 22,  ///< psim_fluid_report
  PSIM_STRUCT_EMITTER_DESC = 23   ///< psim_emitter_desc
};

/// Fills `size` bytes with the defaults of a struct and sets its struct_size to `size`, which may be that of the struct of
/// another language. It does nothing if the struct is NULL, the kind unknown or the size below 8.
PSIM_API void psim_init(void* object, int32_t kind, uint32_t size);

/// Sets the defaults.
static inline void psim_world_desc_init(psim_world_desc* desc) {
  psim_init(desc, PSIM_STRUCT_WORLD_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_run_options_init(psim_run_options* options) {
  psim_init(options, PSIM_STRUCT_RUN_OPTIONS, (uint32_t)sizeof *options);
}

/// Sets the defaults.
static inline void psim_body_desc_init(psim_body_desc* desc) {
  psim_init(desc, PSIM_STRUCT_BODY_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_disc_batch_init(psim_disc_batch* batch) {
  psim_init(batch, PSIM_STRUCT_DISC_BATCH, (uint32_t)sizeof *batch);
}

/// Sets the defaults.
static inline void psim_joint_desc_init(psim_joint_desc* desc) {
  psim_init(desc, PSIM_STRUCT_JOINT_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_query_filter_init(psim_query_filter* filter) {
  psim_init(filter, PSIM_STRUCT_QUERY_FILTER, (uint32_t)sizeof *filter);
}

/// Sets the defaults.
static inline void psim_event_options_init(psim_event_options* options) {
  psim_init(options, PSIM_STRUCT_EVENT_OPTIONS, (uint32_t)sizeof *options);
}

/// Sets the defaults.
static inline void psim_cost_model_init(psim_cost_model* model) {
  psim_init(model, PSIM_STRUCT_COST_MODEL, (uint32_t)sizeof *model);
}

/// Sets the defaults.
static inline void psim_governor_desc_init(psim_governor_desc* desc) {
  psim_init(desc, PSIM_STRUCT_GOVERNOR_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_job_system_init(psim_job_system* jobs) {
  psim_init(jobs, PSIM_STRUCT_JOB_SYSTEM, (uint32_t)sizeof *jobs);
}

/// Sets all to zero: psim_world_traits fills it.
static inline void psim_body_traits_init(psim_body_traits* traits) {
  psim_init(traits, PSIM_STRUCT_BODY_TRAITS, (uint32_t)sizeof *traits);
}

/// (x, y).
static inline psim_vec2 psim_xy(double x, double y) {
  psim_vec2 v;
  v.x = x;
  v.y = y;
  return v;
}

/// A shape of this type, all else 0.
static inline psim_shape psim_shape_of_type(int32_t type) {
  psim_shape shape;
  memset(&shape, 0, sizeof shape);
  shape.type = type;
  return shape;
}

/// A disc; metres, > 0.
static inline psim_shape psim_disc(double radius) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_DISC);
  shape.radius = radius;
  return shape;
}

/// A rectangle about the body's place; metres, > 0.
static inline psim_shape psim_box(double width, double height) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_BOX);
  shape.width = width;
  shape.height = height;
  return shape;
}

/// All points within `radius` of the line from p1 to p2; metres.
static inline psim_shape psim_capsule(psim_vec2 p1, psim_vec2 p2, double radius) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_CAPSULE);
  shape.p1 = p1;
  shape.p2 = p2;
  shape.radius = radius;
  return shape;
}

/// A line from p1 to p2; metres.
static inline psim_shape psim_segment(psim_vec2 p1, psim_vec2 p2) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_SEGMENT);
  shape.p1 = p1;
  shape.p2 = p2;
  return shape;
}

/// A convex polygon of 3 to 8 vertices, counter-clockwise, metres. The vertices must stay until the body is added.
static inline psim_shape psim_polygon(const psim_vec2* vertices, size_t count) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_POLYGON);
  shape.vertices = vertices;
  shape.vertex_count = count;
  return shape;
}

/// Segments joined end to end, metres; static or kinematic. The vertices must stay until the body is added.
static inline psim_shape psim_chain(const psim_vec2* vertices, size_t count, int32_t loop) {
  psim_shape shape = psim_shape_of_type(PSIM_SHAPE_CHAIN);
  shape.vertices = vertices;
  shape.vertex_count = count;
  shape.loop = loop;
  return shape;
}

/// Attraction to a point: GM, m^3/s^2, by Newton's law, softened within `softening` metres.
static inline psim_field psim_well(psim_vec2 position, double strength, double softening) {
  psim_field field;
  memset(&field, 0, sizeof field);
  field.type = PSIM_FIELD_WELL;
  field.position = position;
  field.strength = strength;
  field.softening = softening;
  field.exponent = 2;
  return field;
}

/// Drag: dv/dt = -linear v - quadratic |v| v; 1/s and 1/m.
static inline psim_field psim_drag(double linear, double quadratic) {
  psim_field field;
  memset(&field, 0, sizeof field);
  field.type = PSIM_FIELD_DRAG;
  field.linear = linear;
  field.quadratic = quadratic;
  return field;
}

#ifdef __cplusplus
}
#endif
