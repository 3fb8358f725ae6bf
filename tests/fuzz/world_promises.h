// What the public headers promise of a world, whatever was done to it. Answers as text, so that those of
// two worlds can be compared; one that begins with "fault" says which promise is broken.
#pragma once

#include <string>
#include <vector>

#include "psim/psim.h"

namespace psim::fuzz {

/// Everything that can be read out: finite, counted, in order. Nothing if all of it holds. Without `questions`, queries
/// about all bodies are left out.
std::string broken_promise(World& world, bool questions = true);

/// Whether the last step of two worlds told the same.
bool same_events(const World& one, const World& other);

/// What the last step told of.
std::string events_answer(const World& world);
/// Of a report all that does not depend on the machine.
std::string report_answer(const StepReport& report);
std::string ray_answer(const World& world, Vec2 from, Vec2 to, const QueryFilter& filter);
std::string cast_answer(const World& world, const Shape& shape, Vec2 from, double angle, Vec2 way, double rotation,
                        const QueryFilter& filter);
std::string near_answer(const World& world, const Shape& shape, Vec2 at, double reach, const QueryFilter& filter);
/// Some moves of a mover, which does not push.
std::string mover_answer(World& world, Vec2 at, Vec2 velocity, const QueryFilter& filter);
std::string bodies_answer(const World& world, const std::vector<BodyId>& bodies);
std::string closest_answer(const World& world, Vec2 point, double reach, const QueryFilter& filter);

}  // namespace psim::fuzz
