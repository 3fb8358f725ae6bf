#include "model/scene_tree.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "builtin/samples.h"

namespace psim::view {

std::vector<SceneTopic> scene_tree(const std::vector<std::string>& names) {
  std::vector<SceneTopic> tree;
  std::vector<bool> placed(names.size());
  for (const Sample& sample : samples()) {
    const auto at = std::ranges::find(names, sample.scene);
    if (at == names.end()) continue;
    if (tree.empty() || tree.back().name != sample.topic) tree.push_back({sample.topic, {}});
    const auto index = static_cast<std::size_t>(at - names.begin());
    tree.back().leaves.push_back({index, *at, sample.look_for});
    placed[index] = true;
  }
  SceneTopic files{"Files", {}};
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (placed[k]) continue;
    const std::filesystem::path path = names[k];
    files.leaves.push_back({k, path.filename().string(), look_for(path.stem().string())});
  }
  if (!files.leaves.empty()) tree.push_back(std::move(files));
  return tree;
}

}  // namespace psim::view
