#include "window/scene_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace psim::view {

void ScenePanel::show(const Status& status) {
  constexpr float kTreeHeight = 330, kFindWidth = 0.58f;
  // What follows ### is the identity, so that the tree stays open when the name changes.
  if (!ImGui::CollapsingHeader(fmt::format("scene: {}###scenes", status.scene->name).c_str())) return;
  if (tree_.empty()) tree_ = scene_tree(tools_.scenes());
  find_.Draw("find", kFindWidth * ImGui::GetWindowWidth());
  ImGui::BeginChild("scenes", {0, kTreeHeight}, true);
  for (const SceneTopic& topic : tree_) show_topic(topic);
  ImGui::EndChild();
}

void ScenePanel::show_topic(const SceneTopic& topic) {
  if (std::ranges::none_of(topic.leaves, [&](const SceneLeaf& leaf) { return passes(topic, leaf); })) return;
  const auto is_shown = [this](const SceneLeaf& leaf) { return leaf.index == tools_.scene_index(); };
  if (find_.IsActive()) {
    ImGui::SetNextItemOpen(true);
  } else {
    ImGui::SetNextItemOpen(std::ranges::any_of(topic.leaves, is_shown), ImGuiCond_Once);
  }
  if (!ImGui::TreeNode(std::string(topic.name).c_str())) return;
  for (const SceneLeaf& leaf : topic.leaves) {
    if (!passes(topic, leaf)) continue;
    ImGui::PushID(static_cast<int>(leaf.index));  // files of two folders may have one name
    if (ImGui::Selectable(leaf.label.c_str(), is_shown(leaf))) tools_.open_scene(leaf.index);
    ImGui::PopID();
    if (leaf.look_for.empty()) continue;
    ImGui::PushTextWrapPos(0);
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextUnformatted(leaf.look_for.data(), leaf.look_for.data() + leaf.look_for.size());
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
  }
  ImGui::TreePop();
}

bool ScenePanel::passes(const SceneTopic& topic, const SceneLeaf& leaf) const {
  return find_.PassFilter(fmt::format("{} {} {}", topic.name, leaf.label, leaf.look_for).c_str());
}

}  // namespace psim::view
