// Scenes of R.U.B.E., the editor of Box2D worlds (iforce2d.net/rube), as its JSON export has them.
// In: the document; out: a Scene, with notes on what is approximated or left out. Throws SceneError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "file/parse_node.h"
#include "psim/scene.h"

namespace psim::scene {

/// An object with an array "body" and no key "psim".
bool is_rube(const Node& root);

Scene read_rube(const Node& root);

// ---- what rube.cpp and rube_joints.cpp share ------------------------------------------------------

/// A body of the file, and what it weighs.
struct RubeBody {
  BodyType type = BodyType::static_body;
  bool in_scene = false;
  std::uint64_t id = 0;  ///< in the scene
  double mass = 0;       ///< kg; 0: does not move
  double inertia = 0;    ///< kg m^2 about the centre of mass
};

/// A number, or the eight hex digits of a float.
double rube_number(const Node& node, Range range);
double rube_number_or(const Node& parent, std::string_view key, double absent, Range range);
/// {"x": ..., "y": ...}, or 0 for the origin.
Vec2 rube_vec2_or(const Node& parent, std::string_view key, Vec2 absent, Range range);

void read_rube_joints(const Node& root, const std::vector<RubeBody>& bodies, Scene& scene);

}  // namespace psim::scene
