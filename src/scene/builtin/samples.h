// The built-in scenes as a tree: topics, and in each the scenes with what to look for.
#pragma once

#include <span>
#include <string_view>

namespace psim {

struct Sample {
  std::string_view topic;
  std::string_view scene;     ///< BuiltinScene::name
  std::string_view look_for;  ///< one sentence: what to look for while it runs
};

/// Every built-in scene once, topic after topic.
std::span<const Sample> samples();

/// What to look for in the scene of this name; empty if it is no sample.
std::string_view look_for(std::string_view scene);

}  // namespace psim
