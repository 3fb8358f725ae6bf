// From the options to a scene that is ready to be built, and to a world.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "options/options.h"
#include "psim/scene.h"

namespace psim::cli {

/// The scene that the options name, with --particles, --seed, --dt, --substeps, --integrator and
/// --sleep applied.
/// Throws UserError.
Scene choose_scene(const Options& options);

/// True if `name` is a built-in scene (a file of that name is reached as ./name).
bool is_builtin(const std::string& name);

/// True if `name` is a built-in scene whose number of bodies can be chosen.
bool is_sized(const std::string& name);

/// Throws UserError with the bytes needed if the scene's bodies will not fit into memory.
void check_memory(const Scene& scene);

/// One line if a scene is likely to take more memory than it may, or to have more pairs than lists hold; else empty.
std::string memory_warning(const Scene& scene);

/// Says on stderr if the world has fewer threads than were asked for.
void say_if_threads_lack(const World& world, int asked);

/// Builds the world; throws UserError with what the library said.
std::unique_ptr<World> make_world(const Scene& scene, Isa isa, int threads);

}  // namespace psim::cli
