#include "window/scene_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "psim/scene.h"

namespace psim::view {

std::vector<std::string> scene_names() {
  namespace fs = std::filesystem;
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {fs::path("scenes"), program / ".." / ".." / "scenes"}) {
    if (!fs::is_directory(folder, error)) continue;
    std::vector<std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".json") {
        files.push_back(entry.path().lexically_normal().string());
      }
    }
    std::ranges::sort(files);
    names.insert(names.end(), files.begin(), files.end());
    break;
  }
  return names;
}

}  // namespace psim::view
