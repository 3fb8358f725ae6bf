#pragma once

namespace psim {

/// Frames of a body's present motion that are looked ahead: what margins of lists allow for, who may touch, who wakes.
/// A quarter more than one frame, since speeds change within a step.
inline constexpr double kMarginFrames = 1.25;

}  // namespace psim
