/// @page c_api The C API
/// C99 and C++: worlds of rigid bodies in the plane, stepped in fixed frames.
///
///     psim_world_desc desc;
///     psim_world_desc_init(&desc);
///     psim_world* world = NULL;
///     char error[256];
///     if (psim_world_create(&desc, NULL, &world, error, sizeof error) < 0) die(error);
///
/// - SI units, y up, radians, seconds. A flag is 0 for no and anything else for yes.
/// - **Results.** PSIM_OK is 0. Above 0: nothing was found. Below 0: refused, nothing changed, and
///   psim_last_error says why in one line. After PSIM_ERROR_OUT_OF_MEMORY sleeping bodies may have
///   woken, and the call can be made again. After PSIM_ERROR_INTERNAL the world has to be
///   destroyed, and refuses every other call. Nothing throws, prints or exits. A NULL where one is
///   not allowed is PSIM_ERROR_ARGUMENT.
/// - **Structs that begin with `struct_size`** may grow in later versions. Their init function sets
///   it, and the defaults; it must be called before the struct is used, for input or for output.
///   A library newer than the caller takes defaults for fields that the caller does not have; one
///   that is older refuses a longer struct (PSIM_ERROR_STRUCT_SIZE). All other structs stay as they
///   are.
/// - **Pointers that a call gives out** stay valid until the next call that changes the world, or
///   the next call of the same function, unless it says otherwise. Pointers that a call takes are
///   read during the call only.
/// - **Threads.** Worlds are independent. One is used by one thread at a time, but for questions
///   (psim/c/queries.h) and other functions that take a const psim_world*, which any number of threads
///   may call meanwhile nobody changes the world (but psim_world_why_awake); and psim_last_error and
///   psim_world_latest_snapshot.
/// - **Text** goes into a buffer of the caller: at most `capacity` bytes, a zero at the end among
///   them. The functions return the length of the whole text. The buffer may be NULL if the
///   capacity is 0.
#pragma once

#include "psim/c/about.h"
#include "psim/c/bodies.h"
#include "psim/c/contacts.h"
#include "psim/c/desc.h"
#include "psim/c/draw.h"
#include "psim/c/fluid.h"
#include "psim/c/geometry.h"
#include "psim/c/joints.h"
#include "psim/c/mover.h"
#include "psim/c/outline.h"
#include "psim/c/queries.h"
#include "psim/c/recording.h"
#include "psim/c/saved.h"
#include "psim/c/state.h"
#include "psim/c/types.h"
#include "psim/c/world.h"
