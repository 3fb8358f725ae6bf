// What both files of exported functions share.
#pragma once

#include <emscripten/emscripten.h>
#include <psim.h>

#define PSIM_FLAT extern "C" EMSCRIPTEN_KEEPALIVE

namespace psim::web {

/// One line of text of the last call that failed and had no world to keep it.
inline char error[512] = "";

}  // namespace psim::web
