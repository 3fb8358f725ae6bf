// Rules of `--check` that have files of their own.
#pragma once

#include <string>
#include <vector>

#include "check/overlaps.h"
#include "check/survey.h"
#include "psim/scene.h"

namespace psim {

using Lines = std::vector<std::string>;

// polygons.cpp: what of the vertices is put right.
void check_polygons(const Scene& scene, Lines& lines);

// joints.cpp
/// Whether the anchors of a joint stay as far apart as it says.
bool is_rigid_rod(const JointDesc& joint);
void check_joints(const Scene& scene, const Survey& survey, Lines& lines);
/// Pairs that a joint without `collide` ties.
MayOverlap jointed_pairs(const Scene& scene);

// feasible.cpp: joints that cannot all keep what they say.
void check_feasible(const Scene& scene, const Survey& survey, Lines& lines);

}  // namespace psim
