// What contacts carry from step to step, taken out of a world and brought back (World::save, restore).
//
// Lists that last are not saved: they are made again from where the bodies were when they were made, and
// impulses go to the same pairs. That waits until somebody needs the lists. Where lists are for one step, or
// are to be made anew, the pairs that carry something are saved instead.
#pragma once

#include <cstdint>
#include <vector>

#include "archive.h"

namespace psim {

struct Saved {
  // By pair and single of lists that last, or by saved ones.
  std::vector<float> impulse, friction, gap, s_impulse, s_friction, s_nx, s_ny, s_gap;
  // Pairs and singles, where lists do not last.
  static constexpr std::uint8_t kMany = 255;
  std::vector<std::uint8_t> of_body;  ///< by slot: pairs that it owns; kMany: see the next of `many`
  std::vector<std::uint32_t> many, other, s_body, s_shape;
  std::vector<float> dead_radii;
  std::vector<std::uint32_t> strip_pairs, strip_singles;  ///< by strip: how many; of lists that last, the first
  /// One more pair of a slot; slots come in order.
  void count_of(std::uint32_t slot) {
    if (of_body[slot] + 1 < kMany) {
      ++of_body[slot];
    } else if (of_body[slot] == kMany) {
      ++many.back();
    } else {
      of_body[slot] = kMany;
      many.push_back(kMany);
    }
  }
  bool missing = false;       ///< the lists of a restored state are
  /// Of a step that is under way over frames: lists serve; bodies are measured; they are sorted, too.
  enum class Work : std::uint8_t { none, checked, measured, sorted };
  Work work = Work::none;
  std::vector<std::uint32_t> origin;  ///< where bodies lay when the contacts were laid out, if they moved on
  bool bare = false;          ///< contacts have impulses alone
  std::uint64_t builds = 0;   ///< ContactStore::builds() then
  Saver saver;                ///< its memory
};

}  // namespace psim
