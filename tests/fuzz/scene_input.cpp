#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "inputs.h"
#include "psim/scene.h"

namespace psim::fuzz {
namespace {

// More take too long for a fuzzer.
constexpr std::uint64_t kMostBodies = 1000;
constexpr int kSteps = 3;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Takes digits and the colon behind them off the front.
bool take_number(std::string_view& text) {
  std::size_t digits = 0;
  while (digits < text.size() && is_digit(text[digits])) ++digits;
  if (digits == 0 || digits == text.size() || text[digits] != ':' || text[0] == '0') return false;
  text.remove_prefix(digits + 1);
  return true;
}

std::string run(const Scene& scene) {
  std::string error;
  const std::unique_ptr<World> world = build_world(scene, {}, error);
  if (!world) {
    const bool one_line = !error.empty() && error.find('\n') == error.npos;
    return one_line ? "" : "build_world refuses with: " + error;
  }
  if (world->body_count() != scene.body_count()) return "not as many bodies as the scene has";
  for (int k = 0; k < kSteps; ++k) world->step();
  const PublishedState s = world->published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (!std::isfinite(s.x[k] + s.y[k] + s.angle[k] + s.vx[k] + s.vy[k] + s.omega[k])) {
      return "body " + std::to_string(s.id[k]) + " is not finite";
    }
  }
  return {};
}

}  // namespace

std::string refusal_fault(const std::string& error, const std::string& file) {
  std::string_view rest = error;
  if (!rest.starts_with(file + ':')) return "does not begin with the file: " + error;
  rest.remove_prefix(file.size() + 1);
  if (!take_number(rest) || !take_number(rest)) return "has no LINE:COL: " + error;
  if (rest.find(": ") == rest.npos || !rest.starts_with(' ')) return "has no path: " + error;
  for (const char c : error) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return "is not one plain line: " + error;
  }
  return {};
}

std::string scene_input(Bytes bytes) {
  const std::string text(bytes.begin(), bytes.end());
  std::string error;
  const std::optional<Scene> scene = parse_scene(text, "f", error);
  if (!scene) return refusal_fault(error, "f");
  if (!error.empty()) return "accepted, but says: " + error;

  const std::string written = scene_to_json(*scene);
  const std::optional<Scene> again = parse_scene(written, "written", error);
  if (!again) return "what is written is refused: " + error;
  if (scene_to_json(*again) != written) return "written twice, it differs";

  if (scene->body_count() > kMostBodies) return {};
  for (const std::string& line : check_scene(*scene)) {
    if (line.empty() || line.find('\n') != line.npos) return "check_scene says: " + line;
  }
  return run(*scene);
}

std::string rube_input(Bytes text) { return scene_input(text); }

}  // namespace psim::fuzz
