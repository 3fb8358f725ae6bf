// How far the work of the present step has come. A governor may spread that work over several frames, so this is part
// of the world's state between frames, and of its saved states.
#pragma once

#include <cstdint>

namespace psim {

/// What the neighbour lists are within a step.
enum class ListState : std::uint8_t {
  kept,    ///< those of an earlier step
  begun,   ///< new ones are being made for this step
  sorted,  ///< the same, and the bodies lie in an order that the contacts of the last step do not know
};

/// What the contacts are within a step.
enum class ContactState : std::uint8_t {
  kept,      ///< those of the last step stay as they lie
  due,       ///< they will be laid out anew; until then they are those of the last step, and so is the pair table
  replaced,  ///< the pair table is the new one; the contacts of the last step lie by the old table
};

struct StepProgress {
  std::uint8_t part = 0;  ///< the present row of step_parts() (step/step_table.h)
  ListState lists = ListState::kept;
  ContactState contacts = ContactState::kept;
  bool spread = false;       ///< the work may take more than one frame
  std::uint8_t waits = 0;    ///< frames of this step in which time stood still
  std::uint8_t spoiled = 0;  ///< how often the host made the work begin again
  std::uint8_t horizon = 1;  ///< frames that lists made in this step are to serve
  std::uint32_t at = 0;      ///< pieces of the present part that are done

  /// Nothing was done of this step yet.
  bool untouched() const { return part == 0; }
  bool sorted() const { return lists == ListState::sorted; }
  bool makes_lists() const { return lists != ListState::kept; }
  bool lays_out() const { return contacts != ContactState::kept; }
};

/// Seconds of a frame, and of the step that the lists are to serve.
struct Span {
  double frame = 0, step = 0;
};

}  // namespace psim
