#include "run/outputs.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <string>

#include "base/os.h"
#include "options/scene_choice.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

// A name for the file that a path leads to. It may be a link to a file that is still to be made, which
// weakly_canonical takes for a file of its own.
std::string file_behind(const std::string& path) {
  constexpr int kMostLinks = 40;
  std::error_code ignored;
  std::filesystem::path file = std::filesystem::absolute(os::path_of(path), ignored);
  for (int k = 0; k < kMostLinks && is_symlink(file, ignored); ++k) {
    file = file.parent_path() / read_symlink(file, ignored);  // an absolute target replaces the folder
  }
  return os::name_of(weakly_canonical(file, ignored));
}

}  // namespace

OutputFiles::OutputFiles(const Options& options) {
  std::map<std::string, std::string> taken;  // path -> the option that has it
  if (!is_builtin(options.scene)) taken[file_behind(options.scene)] = "--scene";

  if (!options.restore.empty()) taken[file_behind(options.restore)] = "--restore";

  const auto open = [&](std::optional<AtomicFile>& file, const char* option, const std::string& path) {
    if (path.empty()) return;
    const auto [other, is_new] = taken.emplace(file_behind(path), option);
    std::error_code ignored;
    if (!is_new && !is_character_file(os::path_of(path), ignored)) {
      throw UserError(fmt::format("{} {}: is the file of {} too", option, one_line(path), other->second));
    }
    file.emplace(option, path);
  };
  open(state, "--state", options.state);
  open(fluid_state, "--fluid-state", options.fluid_state);
  open(metrics, "--metrics", options.metrics);
  open(trajectory, "--trajectory", options.trajectory);
  open(image, "--image", options.image);
  open(video, "--video", options.pictures.video);
  open(trace, "--trace", options.trace);
  open(governor_log, "--governor-log", options.governor_log);
  open(save, "--save", options.save);
  open(record, "--record", options.record);
}

}  // namespace psim::cli
