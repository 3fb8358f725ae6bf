// The scenes to choose from: the built-in ones, and the files in `scenes`.
#pragma once

#include <string>
#include <vector>

namespace psim::view {

/// Names and paths that Simulation::load takes. Files are looked for in ./scenes, then beside the
/// build folder that the program is in.
std::vector<std::string> scene_names();

}  // namespace psim::view
