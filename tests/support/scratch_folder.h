// Files of a test: a folder of their own, what they hold, and what a program left behind.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace psim::test {

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A folder of its own, gone with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::random_device random;
    do {
      path_ = std::filesystem::temp_directory_path() / ("psim-test." + std::to_string(random()));
    } while (!std::filesystem::create_directory(path_));
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  /// All names are UTF-8, on every system.
  std::string file(std::string_view name) const { return name_of(path_ / path_of(name)); }
  std::string write(std::string_view name, std::string_view text) const {
    std::ofstream(path_ / path_of(name), std::ios::binary) << text;
    return file(name);
  }
  /// Names of everything in it, sorted.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      names.push_back(name_of(entry.path().filename()));
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  static std::filesystem::path path_of(std::string_view name) { return std::u8string(name.begin(), name.end()); }
  static std::string name_of(const std::filesystem::path& path) {
    const std::u8string name = path.u8string();
    return {name.begin(), name.end()};
  }

  std::filesystem::path path_;
};

struct Outcome {
  int status = -1;  ///< exit status, or minus the signal that ended it
  std::string out, err;
};

}  // namespace psim::test
