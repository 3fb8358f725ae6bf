// What a scene says of the bodies that are drawn: their shapes.
#pragma once

#include "picture/moment.h"
#include "place/links.h"
#include "place/shape_size.h"

namespace psim::cli {

class SceneShapes {
 public:
  /// Reads the scene as long as it lives.
  explicit SceneShapes(const Scene& scene) : bodies_(scene), known_(scene.body_count()) {}

  /// Whether the scene knows the body and its numbers are finite.
  bool is_drawn(const Moment& moment, std::size_t row) const;
  const BodyDesc& of(std::uint32_t id) const { return bodies_.desc_of(id); }
  /// The points that span a body as it stands, and the radius around them, metres.
  std::vector<Outline> placed(const Moment& moment, std::size_t row) const;

 private:
  SceneBodies bodies_;
  std::uint64_t known_;
};

}  // namespace psim::cli
