// Input played from a file instead of a hand: `FRAME WHAT ...`, one line each, frames not falling.
//
//   10 key Space          a key goes down and up (SDL's names: Space, Tab, [, F12, Home ...)
//   20 move 640 400       the pointer, pixels from the upper left corner
//   21 down left          left, right or middle
//   40 up left
//   50 wheel -2           clicks, positive zooms in
//   60 shot FILE.png      a picture of this frame
//   90 quit
// Empty lines and what follows a # are skipped.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace psim::view {

enum class ScriptAction : std::uint8_t { key, move, down, up, wheel, shot, quit };

struct ScriptLine {
  std::uint64_t frame = 0;
  ScriptAction action = ScriptAction::key;
  std::string word;     ///< key or file
  double x = 0, y = 0;  ///< move; wheel: clicks in x
  int button = 0;       ///< 0 left, 1 right, 2 middle
};

/// Throws UserError "FILE:LINE: what is wrong".
std::vector<ScriptLine> parse_script(std::string_view text, std::string_view file);
std::vector<ScriptLine> load_script(const std::string& path);

}  // namespace psim::view
