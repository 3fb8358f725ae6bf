// What bodies do in some frames of a scene.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"

namespace psim::laws {

/// One thread on the best ISA: that others give the same bits is tested elsewhere.
std::unique_ptr<World> world_of(const Scene& scene);

/// States of all bodies by id, the start first, then one entry a frame. A body that is gone is where it was last.
using Course = std::vector<std::vector<BodyState>>;

/// Runs the scene. `each`, if given, sees the world after every frame and ends the run by returning false.
Course course_of(const Scene& scene, int frames, const std::function<bool(World&, int)>& each = {});

/// The length by which errors are measured: the largest distance between bodies at the start, with their sizes and
/// the ways that they would go freely in these frames.
double size_of(const Scene& scene, int frames);

}  // namespace psim::laws
