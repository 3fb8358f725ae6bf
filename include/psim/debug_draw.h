// What a world looks like, handed to the host's own drawing.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "psim/api.h"
#include "psim/types.h"

namespace psim {

/// What is drawn.
enum class DrawKind : std::uint8_t {
  dynamic_body,    ///< awake
  kinematic_body,  ///< that the host moves
  static_body,     ///< that stands fixed
  asleep,          ///< a dynamic body that sleeps
  frozen,          ///< a body whose numbers were broken
  sensor,          ///< a body or part that only feels
  joint,           ///< from anchor to anchor, or to a body's place
  contact,         ///< where two bodies touch, and its normal
  force,           ///< of a contact or joint, N times DebugDrawOptions::force_scale
  bounds,          ///< of the world
  particle         ///< of a fluid
};

/// The host draws by overriding these. They are called by World::debug_draw, one after the other on its thread, and must
/// neither throw nor call the world. All places are of the world, in metres; a line of a body has `radius` on both sides.
class PSIM_API DebugDraw {
 public:
  virtual ~DebugDraw();
  /// A disc with a spoke at `angle`, rad. A particle is a disc of half a spacing, without angle and body (kNoBody).
  virtual void circle(Vec2 centre, double radius, double angle, DrawKind kind, BodyId body) = 0;
  /// A convex part: 2 corners of a line or capsule, else 3 to 8 counter-clockwise; rounded by `radius`.
  virtual void polygon(std::span<const Vec2> corners, double radius, DrawKind kind, BodyId body) = 0;
  /// From one point to another.
  virtual void line(Vec2 from, Vec2 to, DrawKind kind) = 0;
  /// A dot.
  virtual void point(Vec2 at, DrawKind kind) = 0;
};

/// What is wanted.
struct DebugDrawOptions {
  bool bodies = true;                 ///< circles and polygons
  bool joints = true;                 ///< lines between anchors
  bool contacts = false;              ///< dots, and lines of their normals
  bool forces = false;                ///< lines: of contacts the mean of the last step, of joints its last substep
  bool bounds = true;                 ///< the sides of a world that is not open
  double force_scale = 0.01;          ///< m/N
  double normal_length = 0.2;         ///< m
  std::optional<Bounds> region = {};  ///< only bodies, contacts and particles that may reach into it
  bool particles = true;              ///< circles of fluids
};

}  // namespace psim
