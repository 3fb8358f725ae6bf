// Errors of scenes with shapes and joints for the table behind psim --target-error, measured in worlds of psim: no
// closed form says where such bodies are, but laws say what they must not do.
#pragma once

#include <cstdint>

#include "psim/scene.h"

namespace psim::accuracy {

/// What stands and what lies in a heap under gravity: a pyramid, and boxes dropped into a box so many metres wide.
Scene pyramid_of_boxes(std::uint64_t seed);
Scene heap_of_boxes(double width, std::uint64_t seed);
/// Elastic boxes in a pen, no gravity; m/s.
Scene gas_of_boxes(double speed, std::uint64_t seed);
/// A built-in scene of bodies on pins.
Scene pinned(const char* name, std::uint64_t bodies);

/// The larger of two: the overlap at rest in sizes of a body, which 99 % of contacts stay below, and the energy that the
/// scene gained on the way, over the weight of its bodies x their size. Infinite if a body is lost.
double shapes_error(const Scene& scene);
/// The largest relative change of the energy in ten seconds.
double elastic_shapes_error(const Scene& scene);
/// The largest distance between the two anchors of a pin in ten seconds, in sizes of a body.
double joints_error(const Scene& scene);

}  // namespace psim::accuracy
