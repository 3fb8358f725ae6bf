// Ctrl-C: the first one asks the run to end after the current frame, the second one kills.
#pragma once

namespace psim::os {

/// Starts to listen for SIGINT and SIGTERM; on Windows for Ctrl-C, Ctrl-Break and the end of the console.
void catch_interrupts();

/// True once one of them came.
bool interrupted();

}  // namespace psim::os
