// The tree of scenes in the panel: closed at first. A click on a scene loads it.
#pragma once

#include <imgui.h>

#include <vector>

#include "model/scene_tree.h"
#include "model/simulation.h"
#include "window/tools.h"

namespace psim::view {

class ScenePanel {
 public:
  explicit ScenePanel(Tools& tools) : tools_(tools) {}

  void show(const Status& status);

 private:
  void show_topic(const SceneTopic& topic);
  bool passes(const SceneTopic& topic, const SceneLeaf& leaf) const;

  Tools& tools_;
  std::vector<SceneTopic> tree_;
  ImGuiTextFilter find_;
};

}  // namespace psim::view
