// What both files of exported functions share.
#pragma once

#include <emscripten/emscripten.h>
#include <psim.h>

#include "base/worker_pool.h"

#define PSIM_FLAT extern "C" EMSCRIPTEN_KEEPALIVE

namespace psim::web {

/// One line of text of the last call that failed and had no world to keep it.
inline char error[512] = "";

/// The threads of the module, which its worlds share: a browser starts new ones only after the page's code has returned,
/// so that a world could not wait for the end of its own. Null: the caller's thread alone.
inline WorkerPool* workers = nullptr;

/// Lets the world run on them.
void share_workers(psim_world* world);

}  // namespace psim::web
