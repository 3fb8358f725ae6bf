// Where a value stands in a JSON text. Parsing keeps no positions: a path such as
// bodies[3].shape.disc.radius is looked up in the text when an error has to be reported, and only
// then. The walk is iterative, O(length of the text), and knows no limit of depth.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace psim::scene {

/// One step down a document: a member of an object or an element of an array.
struct PathStep {
  std::string key;
  std::size_t index = 0;
  bool is_index = false;
};
using JsonPath = std::vector<PathStep>;

/// Counts from 1; columns are characters (UTF-8 code points).
struct TextPosition {
  std::size_t line = 1;
  std::size_t column = 1;
};

/// What an error points at: the value at the end of the path, or the key in front of it.
enum class PointAt { value, key, second_key };

TextPosition position_of(std::string_view text, std::size_t offset);

/// The byte at which the value (or key) of `path` begins. The text must be valid JSON up to there.
/// A path that leads nowhere gives the deepest value that it reaches.
std::size_t offset_of(std::string_view text, const JsonPath& path, PointAt at);

/// The byte of the first bracket that opens more than `depth` levels.
std::size_t offset_of_depth(std::string_view text, std::size_t depth);

/// `bodies[3].shape`; the root is `scene`. Keys that are no plain names: materials["my steel"].
std::string path_text(const JsonPath& path);

/// Text from outside, fit for a one-line message: control characters escaped, long text cut.
std::string printable(std::string_view text, std::size_t most = 60);

}  // namespace psim::scene
