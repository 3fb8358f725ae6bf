// What the format can say and this version cannot simulate. Such scenes are read to the end, so
// that their other errors come first, and then refused. A feature that becomes available leaves
// this list.
#pragma once

#include <string>

#include "parse_node.h"

namespace psim::scene {

enum class Feature { boxes, polygons, capsules, moving_segments, joints };

constexpr const char* feature_name(Feature feature) {
  switch (feature) {
    case Feature::boxes:
      return "a box";
    case Feature::polygons:
      return "a polygon";
    case Feature::capsules:
      return "a capsule";
    case Feature::moving_segments:
      return "a segment or chain that is not \"type\": \"static\"";
    case Feature::joints:
      return "a joint";
  }
  return "";
}

/// Collects the first use of such a feature.
class Availability {
 public:
  void uses(Feature feature, const Node& where) {
    if (first_.message.empty()) {
      first_ = {where.path(),
                std::string(feature_name(feature)) + " is not available in this version",
                PointAt::value};
    }
  }
  /// Throws SceneError if there was one.
  void check() const {
    if (!first_.message.empty()) throw first_;
  }

 private:
  SceneError first_;
};

}  // namespace psim::scene
