// Scene texts for the tests of the parser: what they become, and what is said of bad ones.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>

#include "psim/scene.h"

namespace psim::test {

/// A whole scene with these top-level members beside psim and world.
inline std::string scene_text(std::string_view members) {
  return "{\"psim\": 1, \"world\": {\"bounds\": [-50, -50, 50, 50]},\n" + std::string(members) + "}";
}

inline Scene parsed_scene(const std::string& text) {
  std::string error;
  std::optional<Scene> scene = parse_scene(text, "f", error);
  EXPECT_TRUE(scene) << error << "\n" << text;
  return scene ? *scene : Scene();
}

/// What `psim --check` says of it.
inline std::string check_lines(const std::string& text) {
  std::string all;
  for (const std::string& line : check_scene(parsed_scene(text))) all += line + "\n";
  return all;
}

/// The text is refused in one line that names this place and holds this.
inline void expect_refused(const std::string& text, std::string_view path, std::string_view words) {
  std::string error;
  EXPECT_FALSE(parse_scene(text, "f", error)) << text;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  EXPECT_TRUE(error.starts_with("f:")) << error;
  EXPECT_NE(error.find(": " + std::string(path) + ": "), std::string::npos)
      << "expected at: " << path << "\nsaid:        " << error;
  EXPECT_NE(error.find(words), std::string::npos) << "expected: " << words << "\nsaid:     " << error;
}

}  // namespace psim::test
