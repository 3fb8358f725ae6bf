// A scene as the engines get it: psim's own Scene, read back from its JSON text, and the same
// bodies one by one in the order of their ids, for engines that know nothing of groups.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "psim/scene.h"

namespace psim::accuracy {

/// Frames a second: of scenes, observers and clocks. Settings divide a frame into steps.
inline constexpr int kFrameRate = 60;
inline constexpr double kGravity = 9.81;

struct Model {
  Scene scene;
  std::vector<BodyDesc> bodies;
};

/// Writes the scene as JSON, parses that and lists its bodies; links of groups become joints. Throws
/// std::runtime_error with the parser's line if the scene is refused.
Model make_model(const Scene& scene);

double radius_of(const BodyDesc& body);   ///< of a disc; 0 for all others
double area_of(const BodyDesc& body);     ///< of a disc, a box or a polygon with sharp corners
double mass_of(const BodyDesc& body);     ///< kg, of the same
double inertia_of(const BodyDesc& body);  ///< about the centre of mass
/// The point that a body turns about, in its frame: a dynamic one's centre of mass.
Vec2 centre_of(const BodyDesc& body);

struct Rectangle {
  Vec2 centre;
  double width = 0, height = 0;
};
/// A polygon that is a rectangle along its frame's axes.
std::optional<Rectangle> rectangle_of(const PolygonShape& polygon);
/// Boxes or polygons.
bool has_boxes(const Model& model);
/// Distance of the anchors that a rod or a spring keeps.
double length_of(const Model& model, const SceneJoint& joint);
/// Angle of b against a that the joint keeps or counts from.
double reference_of(const Model& model, const SceneJoint& joint);
/// Scalar constraints that the joints are: two for a pin or a slide, three for a weld.
int joint_rows(const Model& model);

// ---- scenes in few words ----------------------------------------------------------------------

inline Material material(double restitution, double friction = 0) { return {1, restitution, friction}; }
/// Open, and so large that nothing leaves.
Scene open_scene(double half_size, Vec2 gravity = {0, -kGravity});
/// Walls from (0, 0) to (width, height), of the given material.
Scene walled_scene(double width, double height, Material wall, Vec2 gravity = {0, 0});
Scene periodic_scene(double width, double height);

BodyDesc disc(Vec2 position, Vec2 velocity, Material surface, double radius = 0.5);
BodyDesc segment(Vec2 p1, Vec2 p2, Material surface);
/// Level ground through y = 0.
BodyDesc ground(Material surface, double half_length = 100);

BodyDesc box(Vec2 position, Vec2 size, Material surface, double mass = 0);
/// A static box whose upper side is level ground through y = 0.
BodyDesc floor_box(Material surface, double half_length = 50);
/// A static disc of 1 cm to hang things on.
BodyDesc peg(Vec2 position);
/// Ties two bodies of the scene together, by their numbers in it.
SceneJoint& join(Scene& scene, JointType type, std::size_t a, std::size_t b, Vec2 anchor_a = {}, Vec2 anchor_b = {});

}  // namespace psim::accuracy
