/// @file
/// C API: a run written down, and run again (docs/saved-states.md). Replayed it gives the same bits on every
/// instruction set and number of threads, or says at which hash it does not.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Runs a recording in a world of its own.
typedef struct psim_replay psim_replay;

/// From the world's present state on, writes down every change that calls of this API make to it and every step,
/// with a hash of the state after every `every` steps, at least 1. A recording that was under way is gone.
/// psim_world_restore is refused meanwhile. 19 bytes a step, 9 a hash, and what the caller did.
PSIM_API psim_result psim_world_record(psim_world* world, uint64_t every);

/// The recording up to now, with a checksum, `*size` bytes at `*recording`, which stay until the next call of this
/// function on the world. It goes on. PSIM_NOTHING if none is under way.
PSIM_API psim_result psim_world_recording(psim_world* world, const void** recording, size_t* size);

/// Ends the recording; what was not asked for is gone. PSIM_NOTHING if none is under way.
PSIM_API psim_result psim_world_stop_recording(psim_world* world);

/// Opens a recording in `*replay`, whose world runs with `options`, NULL for the defaults. The bytes are copied.
/// PSIM_ERROR_ARGUMENT if they are no recording, of another format, cut or damaged. The caller frees it with
/// psim_replay_close.
PSIM_API psim_result psim_replay_open(const void* recording, size_t size, const psim_run_options* options,
                                      psim_replay** replay, char* error, size_t error_capacity);

/// Frees the replay and its world. NULL is allowed.
PSIM_API void psim_replay_close(psim_replay* replay);

/// Does what was recorded up to the end of the next step. PSIM_NOTHING at the end. psim_last_error of its world has
/// the line where it fails.
PSIM_API psim_result psim_replay_next(psim_replay* replay);

/// The world that it runs in, in the state after the last step, to ask: it belongs to the replay, and is not to be
/// destroyed. NULL for NULL.
PSIM_API psim_world* psim_replay_world(psim_replay* replay);

/// Steps done; 0 for NULL.
PSIM_API uint64_t psim_replay_steps(const psim_replay* replay);

/// Steps in the recording; 0 for NULL.
PSIM_API uint64_t psim_replay_steps_in_all(const psim_replay* replay);

/// Hashes that were compared; 0 for NULL.
PSIM_API uint64_t psim_replay_hashes(const psim_replay* replay);

/// The first step with a hash after which the state was another than recorded; 0: none yet, or NULL. The first step
/// that was another is this one or one since the hash before it. 1 also if the state that it began with is another.
PSIM_API uint64_t psim_replay_differs_at(const psim_replay* replay);

/// 1 once all was run, as many steps as the recording says, and the last state was compared; else 0, as for NULL. If
/// psim_replay_next gives PSIM_NOTHING and this is 0, the recording is damaged.
PSIM_API int32_t psim_replay_complete(const psim_replay* replay);

#ifdef __cplusplus
}
#endif
