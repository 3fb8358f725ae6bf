#include "model/input_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "output/text.h"
#include "output/user_error.h"

namespace psim::view {
namespace {

constexpr std::array<std::pair<std::string_view, ScriptAction>, 7> kActions = {{{"key", ScriptAction::key},
                                                                                {"move", ScriptAction::move},
                                                                                {"down", ScriptAction::down},
                                                                                {"up", ScriptAction::up},
                                                                                {"wheel", ScriptAction::wheel},
                                                                                {"shot", ScriptAction::shot},
                                                                                {"quit", ScriptAction::quit}}};
constexpr std::array<std::string_view, 3> kButtons = {"left", "right", "middle"};

template <class Number>
bool read(std::string_view word, Number& value) {
  const char* const end = word.data() + word.size();
  const auto [stopped, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && stopped == end;
}

// What is wrong with the line; nothing if it was read.
std::string read_line(const std::vector<std::string>& words, ScriptLine& line) {
  if (!read(words[0], line.frame)) return "must begin with a frame number";
  const std::string_view name = words.size() > 1 ? std::string_view(words[1]) : "";
  const auto* const found = std::ranges::find_if(kActions, [&](const auto& action) { return action.first == name; });
  if (found == kActions.end()) {
    return "after the frame comes key, move, down, up, wheel, shot or quit";
  }
  line.action = found->second;
  const auto needs = [&](std::size_t count) { return words.size() == count + 2; };
  switch (line.action) {
    case ScriptAction::key:
    case ScriptAction::shot:
      if (!needs(1)) return fmt::format("{} takes one word", name);
      line.word = words[2];
      if (line.action == ScriptAction::shot && !line.word.ends_with(".png"))
        return "shot takes a name that ends in .png";
      return "";
    case ScriptAction::move:
      if (needs(2) && read(words[2], line.x) && read(words[3], line.y)) return "";
      return "move takes two numbers of pixels";
    case ScriptAction::wheel:
      if (needs(1) && read(words[2], line.x)) return "";
      return "wheel takes a number of clicks";
    case ScriptAction::quit:
      return needs(0) ? "" : "quit takes nothing";
    default:
      break;
  }
  if (!needs(1)) return fmt::format("{} takes left, right or middle", name);
  for (std::size_t k = 0; k < kButtons.size(); ++k) {
    if (words[2] != kButtons[k]) continue;
    line.button = static_cast<int>(k);
    return "";
  }
  return fmt::format("{} takes left, right or middle", name);
}

}  // namespace

std::vector<ScriptLine> parse_script(std::string_view text, std::string_view file) {
  std::vector<ScriptLine> lines;
  std::istringstream stream{std::string(text)};
  std::size_t number = 0;
  for (std::string row; std::getline(stream, row);) {
    ++number;
    std::istringstream rest(row.substr(0, row.find('#')));
    const std::vector<std::string> words{std::istream_iterator<std::string>(rest), {}};
    if (words.empty()) continue;
    ScriptLine line;
    std::string wrong = read_line(words, line);
    if (wrong.empty() && !lines.empty() && line.frame < lines.back().frame) {
      wrong = fmt::format("frame {} comes after frame {}", line.frame, lines.back().frame);
    }
    if (!wrong.empty()) {
      throw cli::UserError(fmt::format("{}:{}: {}", cli::one_line(file), number, wrong));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<ScriptLine> load_script(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw cli::UserError(fmt::format("--play {}: cannot be read", cli::one_line(path)));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return parse_script(text, path);
}

}  // namespace psim::view
