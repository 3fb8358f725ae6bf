// What a world notes from step to step for its saved states.
#pragma once

#include <cstdint>
#include <vector>

namespace psim {

struct Saved {
  /// What a step under way over frames consists of so far, in order: work up to a piece of a part, and bodies
  /// that the host pushed in between. Done again, it comes out the same.
  struct Done {
    std::uint32_t part = 0, at = 0;  ///< part: row of the step table (step/step_table.h)
    double span = 0;                 ///< s: that the work was for; 0: a push
    std::uint32_t id = 0;            ///< of the body, and how it moved before, m/s
    float vx = 0, vy = 0, rim_speed = 0;
  };
  std::vector<Done> done;
  std::vector<std::uint32_t> origin;  ///< where bodies lay when the contacts were laid out, if they moved on
  bool bare = false;                  ///< contacts have impulses alone: a state came back
};

}  // namespace psim
