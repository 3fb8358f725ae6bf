// What psim tells without running: itself, its scenes, a scene's plan and its faults.
#pragma once

#include <string>

#include "options/options.h"

namespace psim::cli {

/// The compiler that made this program, as "g++ 12.2.0".
std::string compiler_name();

int print_version();
int print_scenes();
/// The stages that the scene needs and those left out, with reasons.
int explain_scene(const Options& options);
/// What will go wrong when the scene runs; returns 1 if there is anything.
int check_scene_file(const Options& options);

}  // namespace psim::cli
