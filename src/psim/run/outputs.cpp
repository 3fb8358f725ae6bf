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

OutputFiles::OutputFiles(const Options& options) {
  std::map<std::string, std::string> taken;  // path -> the option that has it
  const auto key = [](const std::string& path) {
    std::error_code ignored;
    const auto absolute = std::filesystem::absolute(os::path_of(path), ignored);
    return os::name_of(std::filesystem::weakly_canonical(absolute, ignored));
  };
  if (!is_builtin(options.scene)) taken[key(options.scene)] = "--scene";

  if (!options.restore.empty()) taken[key(options.restore)] = "--restore";

  const auto open = [&](std::optional<AtomicFile>& file, const char* option, const std::string& path) {
    if (path.empty()) return;
    const auto [other, is_new] = taken.emplace(key(path), option);
    std::error_code ignored;
    if (!is_new && !is_character_file(os::path_of(path), ignored)) {
      throw UserError(fmt::format("{} {}: is the file of {} too", option, one_line(path), other->second));
    }
    file.emplace(option, path);
  };
  open(state, "--state", options.state);
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
