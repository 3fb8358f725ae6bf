// Text to JSON document, strictly: no duplicate keys, no numbers beyond double, no depth without
// end, nothing after the document. In goes the text, out comes a document or a SceneError.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "file/json_position.h"

namespace psim::scene {

using Json = nlohmann::json;

/// What is wrong and where; it is caught in parse_scene and goes no further. The byte is looked up
/// from the path unless it is known.
struct SceneError {
  static constexpr std::size_t kLookUp = static_cast<std::size_t>(-1);

  JsonPath path;
  std::string message;
  PointAt at = PointAt::value;
  std::size_t offset = kLookUp;
};

/// Deeper documents are refused; the format itself needs 8 levels.
inline constexpr std::size_t kMaxDepth = 32;

/// Throws SceneError.
Json read_document(std::string_view text);

}  // namespace psim::scene
