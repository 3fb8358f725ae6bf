// What a scene says of what is drawn: the shapes of bodies, and joints.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "picture/moment.h"
#include "place/links.h"
#include "place/shape_size.h"

namespace psim::cli {

/// Where a joint is, metres.
struct JointEnds {
  std::array<Vec2, 2> anchor;
  std::array<Vec2, 2> place;       ///< of the bodies; of the world 0
  std::array<bool, 2> moves = {};  ///< whether the side is a body that is not static
};

class SceneShapes {
 public:
  /// Reads the scene as long as it lives.
  explicit SceneShapes(const Scene& scene) : bodies_(scene), joints_(drawn_joints(scene)), known_(scene.body_count()) {}

  /// Whether the scene knows the body and its numbers are finite.
  bool is_drawn(const Moment& moment, std::size_t row) const;
  const BodyDesc& of(std::uint32_t id) const { return bodies_.desc_of(id); }
  /// The points that span a body as it stands, and the radius around them, metres.
  std::vector<Outline> placed(const Moment& moment, std::size_t row) const;
  /// The radius of a circle around a body's place that holds it, metres.
  double reach(const Moment& moment, std::size_t row) const;

  const std::vector<DrawnJoint>& joints() const { return joints_; }
  /// Nothing if the joint is gone, a body is not there or a number is not finite.
  static std::optional<JointEnds> ends_of(const DrawnJoint& joint, const Moment& moment);

 private:
  SceneBodies bodies_;
  std::vector<DrawnJoint> joints_;
  std::uint64_t known_;
};

}  // namespace psim::cli
