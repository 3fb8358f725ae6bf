// Ctrl-C: the first one asks the run to end after the current frame, the second one kills.
#pragma once

namespace psim::cli {

/// Starts to listen for SIGINT and SIGTERM.
void catch_interrupts();

/// True once one of them came.
bool interrupted();

}  // namespace psim::cli
