// On which side of a line a point lies, without rounding: answers that contradict each other would leave algorithms on
// polygons without a way on.
#pragma once

#include "psim/types.h"

namespace psim {

/// 1 if c lies to the left of the line from a to b, -1 if to the right, 0 if on it. Exact for coordinates that are 0 or
/// of 1e-100 to 1e100 in size.
int side_of(Vec2 a, Vec2 b, Vec2 c);

}  // namespace psim
