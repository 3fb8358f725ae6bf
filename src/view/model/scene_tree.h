// The scenes to choose from, in a tree by topic.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace psim::view {

struct SceneLeaf {
  std::size_t index = 0;  ///< in the list of names
  std::string label;
  std::string_view look_for;  ///< may be empty
};

struct SceneTopic {
  std::string_view name;
  std::vector<SceneLeaf> leaves;
};

/// Each of the names once: built-in scenes by the topics of samples.h, then files.
std::vector<SceneTopic> scene_tree(const std::vector<std::string>& names);

}  // namespace psim::view
