/// @file
/// C API: saved states, by which a world goes back or goes on elsewhere with the same bits
/// (docs/saved-states.md).
///
/// Functions that fill a buffer put the whole length into `*size` and the bytes into the buffer if they
/// fit; a buffer of NULL asks for the length alone, one that is too small is PSIM_ERROR_ARGUMENT. Those
/// without a world put one line into `error` (may be NULL) where they fail.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Writes all that the world must remember to go on with the same bits, `*size` bytes at `*state`,
/// which stay until the next call of this function on the world. Changes no result.
PSIM_API psim_result psim_world_save(psim_world* world, const void** state, size_t* size);

/// Goes back to a saved state of a world with the same bounds and boundary; else PSIM_ERROR_ARGUMENT,
/// and nothing changed. Settings stay: governor, job system, snapshots, trace. All else is as it was saved,
/// what steps tell, too: psim_world_set_event_options of after the save has no effect any more. The bytes must be
/// as psim_world_save wrote them; those of a file or a wire come through psim_unpack_state.
PSIM_API psim_result psim_world_restore(psim_world* world, const void* state, size_t size);

/// A world in a saved state, as psim_world_create makes one; `options` may be NULL.
PSIM_API psim_result psim_world_from_state(const void* state, size_t size, const psim_run_options* options,
                                           psim_world** world, char* error, size_t error_capacity);

/// A state with a header before it: magic, format, length, checksum. 32 bytes longer.
PSIM_API psim_result psim_pack_state(const void* state, size_t state_size, void* packed, size_t capacity, size_t* size);

/// And back. PSIM_ERROR_ARGUMENT if it is no packed state, of another format, cut or damaged.
PSIM_API psim_result psim_unpack_state(const void* packed, size_t packed_size, void* state, size_t capacity,
                                       size_t* size, char* error, size_t error_capacity);

/// Writes a packed state to a file, which is either the whole one or what was there before: written beside under a
/// name of its own, brought to the disk, then renamed. It keeps the old file's mode; the file behind a symbolic link is
/// replaced, not the link; devices and pipes are written as they are. PSIM_ERROR_ARGUMENT if it cannot be written, or
/// the caller may not write it or its folder.
PSIM_API psim_result psim_write_state(const char* path, const void* state, size_t state_size, char* error,
                                      size_t error_capacity);

/// Reads one and unpacks it. PSIM_ERROR_ARGUMENT if it cannot be read, is a device, is cut or damaged.
PSIM_API psim_result psim_read_state(const char* path, void* state, size_t capacity, size_t* size, char* error,
                                     size_t error_capacity);

#ifdef __cplusplus
}
#endif
