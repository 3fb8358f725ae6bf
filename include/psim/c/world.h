/// @file
/// C API: worlds, their steps and how they are run.
#pragma once

#include "psim/c/contacts.h"
#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How many stages a report has room for; psim_stage_name knows those there are.
#define PSIM_STAGE_ROOM 16

/// What one step did. Bad numbers in a running world are quarantined and counted here.
typedef struct psim_step_report {
  uint32_t struct_size;              ///< set by psim_step_report_init
  int32_t rebuilt;                   ///< flag: neighbour lists were rebuilt
  double stage_ms[PSIM_STAGE_ROOM];  ///< wall time a stage
  double total_ms;                   ///< wall time of the step
  uint64_t pairs;                    ///< candidate pairs in the lists
  uint64_t contacts;                 ///< points that touch: at most two a pair
  uint64_t pairs_reused;             ///< of the pairs, those whose contacts lay as they were
  uint64_t awake;                    ///< dynamic and kinematic bodies that are awake after it
  uint64_t asleep;                   ///< dynamic bodies that sleep after it: all others of psim_world_dynamic_count
  uint64_t arena_growths;            ///< allocations that the step had to make
  uint32_t colours;                  ///< most colours that any group of contacts needed
  uint32_t stopped;                  ///< of those, bodies that struck something on their way
  uint32_t escaped;                  ///< bodies that left an open world
  uint32_t quarantined;              ///< bodies frozen because of NaN, infinity or excess
  double predicted_ms;               ///< by the governor's cost model; 0 without a governor
  double virial;                     ///< sum over contacts of normal impulse x centre distance, N s m
  psim_step_detail detail;           ///< how much of it was done
  uint32_t skipped;                  ///< a bit for each psim_skip_name that had nothing to do
  uint32_t fast;                     ///< shapes and bullets so fast for their size that their way was looked at
  uint32_t renewed;                  ///< bodies whose lists alone were made anew
  uint32_t reserved;                 ///< 0
  uint64_t touching;                 ///< of the pairs, those with such contacts
} psim_step_report;

/// Sets the defaults.
static inline void psim_step_report_init(psim_step_report* report) {
  psim_init(report, PSIM_STRUCT_STEP_REPORT, (uint32_t)sizeof *report);
}

/// Checks the description and makes an empty world in `*world`; `options` may be NULL for the
/// defaults. On failure `*world` is NULL and `error` (may be NULL) has one line. The caller frees the
/// world with psim_world_destroy. Starts threads - 1 threads.
PSIM_API psim_result psim_world_create(const psim_world_desc* desc, const psim_run_options* options, psim_world** world,
                                       char* error, size_t capacity);

/// Frees the world and all that it gave out. NULL is allowed. No other call may be under way.
PSIM_API void psim_world_destroy(psim_world* world);

/// One line: what the last call that failed on this world was and why; empty if none did. Where
/// several threads ask at once, the last of all of them. Returns the length of the whole line.
PSIM_API size_t psim_last_error(const psim_world* world, char* buffer, size_t capacity);

/// Advances by the description's dt. `report` may be NULL; it must have been through
/// psim_step_report_init. The same calls give the same bits on every instruction set and any number
/// of threads.
PSIM_API psim_result psim_world_step(psim_world* world, psim_step_report* report);

/// Advances by another dt, seconds, above 0 and at most 10.
PSIM_API psim_result psim_world_step_by(psim_world* world, double dt, psim_step_report* report);

/// A step with the detail that a governor chose in another run: the same bits.
PSIM_API psim_result psim_world_replay(psim_world* world, psim_step_detail detail, psim_step_report* report);

/// The same by another dt, seconds, above 0 and at most 10.
PSIM_API psim_result psim_world_replay_by(psim_world* world, psim_step_detail detail, double dt,
                                          psim_step_report* report);

/// Makes the arrays of a step without taking one, and the lists of the first step, which then costs no
/// more than later ones: for the end of loading, after everything was added. Changes no result; after the first step it
/// does nothing.
PSIM_API psim_result psim_world_prepare(psim_world* world);

/// Changes gravity, m/s^2, within its range; everybody wakes.
PSIM_API psim_result psim_world_set_gravity(psim_world* world, psim_vec2 gravity);

/// Changes the wells and drag of the world; wind and water stay. Everybody wakes. Nothing changes if one is refused.
PSIM_API psim_result psim_world_set_fields(psim_world* world, const psim_field* fields, size_t count);

/// Changes wind and water; wells and drag stay. Everybody wakes. Nothing changes if one is refused.
PSIM_API psim_result psim_world_set_media(psim_world* world, const psim_medium* media, size_t count);

/// Changes the factor on the skin of neighbour lists, 0.25 to 4: the next step makes its lists anew.
PSIM_API psim_result psim_world_set_skin(psim_world* world, double factor);
/// Changes psim_world_desc.max_bytes, 0 for any number; nothing is given back that the world has already.
PSIM_API psim_result psim_world_set_max_bytes(psim_world* world, uint64_t bytes);

/// Lets bodies sleep from now on (flag), or wakes all and keeps them awake.
PSIM_API psim_result psim_world_set_sleeping(psim_world* world, int32_t on);

/// Lets a governor keep the frame's budget from now on, or no more. budget_ms must be above 0.
PSIM_API psim_result psim_world_set_governor(psim_world* world, const psim_governor_desc* desc);

/// Lets `function` decide new contacts of bodies that ask (psim_body_desc.pre_solve), before the first step that solves
/// them; NULL: nobody is asked any more. A decision lasts until the parts are apart. `user` is handed to it, and what it
/// points to must live as long as the function is set. See psim::World::set_pre_solve.
PSIM_API psim_result psim_world_set_pre_solve(psim_world* world, psim_pre_solve function, void* user);

/// Replaces the world's own workers by the caller's, or gives them back (NULL). What `user` points to
/// must live as long as it is set. A parallel_for that leaves jobs out, or throws, breaks the world
/// (PSIM_ERROR_INTERNAL from the step).
PSIM_API psim_result psim_world_set_job_system(psim_world* world, const psim_job_system* jobs);

/// The present description: as created, with the gravity, fields, skin and sleeping set since. `fields` and
/// `media` point into the world and stay valid until psim_world_restore, psim_world_set_fields or psim_world_set_media.
PSIM_API psim_result psim_world_get_desc(const psim_world* world, psim_world_desc* desc);

/// The psim_isa that the kernels use; -1 for NULL.
PSIM_API int32_t psim_world_isa(const psim_world* world);

/// The number of threads, as created; 0 for NULL.
PSIM_API int32_t psim_world_threads(const psim_world* world);

/// Steps taken; 0 for NULL.
PSIM_API uint64_t psim_world_frame(const psim_world* world);

#ifdef __cplusplus
}
#endif
