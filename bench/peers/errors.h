// What is wrong with a state: the same functions of places and velocities for every engine.
#pragma once

#include <vector>

#include "run.h"

namespace psim::peers {

using accuracy::Model;
using accuracy::Run;

/// How deep every two bodies overlap that may touch, and every body and wall, sorted, m. By outlines:
/// what an engine leaves overlapping on purpose counts. Without those that passed a wall. O(n^1.5) in
/// a packed square.
std::vector<double> overlaps(Run& run);

/// Dynamic bodies whose place is beyond a wall.
int passed_walls(Run& run);

/// How far the joint is from where it holds that is furthest off: anchors of a pin apart, of a rod off
/// its length, of a rope beyond it; m.
double joint_gap(Run& run);

struct Displacement {
  double sideways = 0;  ///< m, the largest of all dynamic bodies
  double down = 0;
};
Displacement displacement(Run& run);

}  // namespace psim::peers
