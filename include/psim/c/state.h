/// @file
/// C API: what is read out of a world.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Columns of every living body in id order, all of `count` numbers; id[k] is the index of row k.
typedef struct psim_state {
  uint32_t struct_size;  ///< set by psim_state_init
  uint32_t reserved;     ///< 0
  size_t count;          ///< rows
  const uint32_t* id;    ///< psim_body_id::index
  const double* x;       ///< metres, as in psim_body_state
  const double* y;       ///< metres
  const double* angle;   ///< radians
  const double* vx;      ///< m/s
  const double* vy;      ///< m/s
  const double* omega;   ///< rad/s
  const double* radius;  ///< metres
  const uint8_t* type;   ///< psim_body_type
} psim_state;

/// What a renderer reads while the next step runs: the newest complete frame. `x_prev` and `x` are
/// one step apart: draw x_prev + alpha (x - x_prev). Columns of `count` numbers, by id.
typedef struct psim_snapshot {
  uint32_t struct_size;     ///< set by psim_snapshot_init
  uint32_t reserved;        ///< 0
  uint64_t frame;           ///< psim_world_frame
  size_t count;             ///< rows
  const uint32_t* id;       ///< psim_body_id::index
  const float* x;           ///< metres from `origin`
  const float* y;           ///< metres from `origin`
  const float* x_prev;      ///< a step before
  const float* y_prev;      ///< a step before
  const float* angle;       ///< radians
  const float* angle_prev;  ///< a step before
  const float* radius;      ///< metres
  const float* speed;       ///< m/s
  const uint8_t* asleep;    ///< 1: it sleeps
  psim_vec2 origin;         ///< metres: the middle of the bounds
} psim_snapshot;

/// Sums over every body, in double precision and in id order.
typedef struct psim_diagnostics {
  uint32_t struct_size;     ///< set by psim_diagnostics_init
  uint32_t reserved;        ///< 0
  double kinetic;           ///< J, rotation included
  double potential;         ///< J: uniform gravity from y = 0 (x = 0), and wells
  double momentum_x;        ///< kg m/s
  double momentum_y;        ///< kg m/s
  double angular_momentum;  ///< kg m^2/s about the origin
  double max_penetration;   ///< metres: the deepest overlap as bodies stand now; 0 before the first step
} psim_diagnostics;

/// One stage of the plan.
typedef struct psim_plan_entry {
  const char* stage;   ///< such as "solver.friction"
  const char* reason;  ///< why it is needed or not
  int32_t needed;      ///< flag
  int32_t reserved;    ///< 0
} psim_plan_entry;

/// A stage and in how many frames it had nothing to do.
typedef struct psim_skip_entry {
  const char* stage;  ///< such as "solver.friction"
  uint64_t frames;    ///< above 0
} psim_skip_entry;

/// One span of a stage on one thread, nanoseconds from the first psim_world_start_trace.
typedef struct psim_trace_event {
  const char* name;  ///< of the stage; lives as long as the program
  int32_t thread;    ///< 0: the one that steps
  int32_t reserved;  ///< 0
  int64_t begin_ns;  ///< nanoseconds
  int64_t end_ns;    ///< nanoseconds
} psim_trace_event;

/// Work done since the world was made.
typedef struct psim_lane_counts {
  uint64_t vector;  ///< elements done in lanes
  uint64_t scalar;  ///< elements done one at a time
} psim_lane_counts;

/// How full the blocks of some kernels were in the steps that were looked at; a block counts once a step.
typedef struct psim_lane_use {
  const char* kernels;  ///< what they work on, such as "contacts"
  uint64_t lanes;       ///< of the blocks
  uint64_t used;        ///< of those, with something in them
} psim_lane_use;

/// Sets the defaults.
static inline void psim_state_init(psim_state* state) { psim_init(state, PSIM_STRUCT_STATE, (uint32_t)sizeof *state); }

/// Sets the defaults.
static inline void psim_snapshot_init(psim_snapshot* snapshot) {
  psim_init(snapshot, PSIM_STRUCT_SNAPSHOT, (uint32_t)sizeof *snapshot);
}

/// Sets the defaults.
static inline void psim_diagnostics_init(psim_diagnostics* diagnostics) {
  psim_init(diagnostics, PSIM_STRUCT_DIAGNOSTICS, (uint32_t)sizeof *diagnostics);
}

/// Columns of every living body, built on demand: O(bodies).
PSIM_API psim_result psim_world_state(psim_world* world, psim_state* state);

/// Turns snapshots on or off (flag): after every step one is put into a lock-free buffer.
PSIM_API psim_result psim_world_enable_snapshots(psim_world* world, int32_t on);

/// The newest snapshot. One thread may call this at any time, also while another steps; the columns
/// stay as they are until it calls again. PSIM_NOTHING before the first frame.
PSIM_API psim_result psim_world_latest_snapshot(psim_world* world, psim_snapshot* snapshot);

/// 64-bit hash over every living body's position, angle and velocities in id order: the same for every
/// instruction set, number of threads and compiler. 0 for NULL or a broken world.
PSIM_API uint64_t psim_world_state_hash(const psim_world* world);

/// Energies, momenta and the deepest overlap. O(bodies + contacts).
PSIM_API psim_result psim_world_diagnostics(psim_world* world, psim_diagnostics* diagnostics);

/// Work done in lanes and one at a time.
PSIM_API psim_result psim_world_lane_counts(const psim_world* world, psim_lane_counts* counts);

/// Counts how full the kernels' blocks are, in every 16th step from now on; nothing on the scalar instruction set.
PSIM_API psim_result psim_world_count_lane_use(psim_world* world);

/// What was counted, `*count` kinds; they stay until the next call of this function.
PSIM_API psim_result psim_world_lane_use(psim_world* world, const psim_lane_use** uses, size_t* count);

/// Bytes that the world holds; 0 for NULL.
PSIM_API size_t psim_world_memory_bytes(const psim_world* world);

/// The stages and whether this world needs them, `*count` of them.
PSIM_API psim_result psim_world_plan(psim_world* world, const psim_plan_entry** entries, size_t* count);

/// Memory of the arrays that are there for one stage alone, bytes, in the order of psim_world_plan.
PSIM_API psim_result psim_world_plan_bytes(psim_world* world, const size_t** bytes, size_t* count);

/// In how many frames each stage was skipped, `*count` of them.
PSIM_API psim_result psim_world_skipped(psim_world* world, const psim_skip_entry** entries, size_t* count);

/// Starts recording spans of stages.
PSIM_API psim_result psim_world_start_trace(psim_world* world);

/// Steps record nothing until the next psim_world_start_trace; what was recorded stays to be taken.
PSIM_API psim_result psim_world_stop_trace(psim_world* world);

/// What was recorded since the last call, `*count` spans; they stay until the next call of this
/// function.
PSIM_API psim_result psim_world_take_trace(psim_world* world, const psim_trace_event** events, size_t* count);

#ifdef __cplusplus
}
#endif
