// How far the work of a step has come, and what does it piece by piece. A governor may spread that work over several
// frames, so it is part of the world's state between frames, and of its saved states.
//
// If the host changes bodies between two frames of a step, what was made is thrown away (spoil), and the contacts'
// impulses stay with the table that they were laid out by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "bodies/population.h"
#include "psim/report.h"

namespace psim {

struct StepContext;

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

class StepWork {
 public:
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  /// What a step under way over frames consists of so far, in order: work up to a piece of a part, and bodies that the
  /// host pushed in between. Done again, it comes out the same: saved states hold it.
  struct Done {
    std::uint32_t part = 0, at = 0;  ///< part: row of the step table (step/step_table.h)
    double span = 0;                 ///< s: that the work was for; 0: a push
    std::uint32_t id = 0;            ///< of the body, and how it moved before, m/s
    float vx = 0, vy = 0, rim_speed = 0;
  };

  StepProgress progress;
  std::vector<Done> done_so_far;
  bool detailed = false;  ///< this step follows a given detail: its lists are cut as with a governor

  bool untouched() const { return progress.untouched(); }

  /// Does the pieces of the present part up to the `end`-th; after its last one the next part is the present one.
  void run_part(StepContext& c, const Span& span, StepReport& report, std::size_t end);
  /// Does so many pieces, or all that is left.
  void run(StepContext& c, const Span& span, StepReport& report, std::size_t pieces = kAll);

  /// Shows the contacts of the last step, or again those of this one, as far as there are any: each call swaps them.
  void turn_back(StepContext& c);
  /// The contacts of this step count from now on: those of the last one go.
  void accept(StepContext& c);
  /// Throws away what was made for this step: all is as the last step left it, but bodies may lie in another order,
  /// which the broad phase knows.
  void spoil(StepContext& c);
  /// A frame in which time stands still ends: notes how far the work came.
  void note(const Span& span);
  /// The host changed a body's velocity, which was `before`. Lists and manifolds that were made for this step do not
  /// serve the body if it is much faster now.
  void pushed(StepContext& c, std::uint32_t id, const Motion& before);

 private:
  void begin_again();
};

}  // namespace psim
