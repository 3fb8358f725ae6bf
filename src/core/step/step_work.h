// Does the work of the step table (step/step_table.h) piece by piece, and keeps account of how far it came.
//
// If the host changes bodies between two frames of a step, what was made is thrown away (spoil), and the contacts'
// impulses stay with the table that they were laid out by.
#pragma once

#include <limits>
#include <vector>

#include "step/step_table.h"

namespace psim {

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
  bool detailed = false;  ///< this step follows a given detail: in pieces as they were with a governor

  bool untouched() const { return progress.untouched(); }
  bool done() const { return all_done(progress); }
  /// The present part; not if all is done.
  const StepPart& part() const { return step_parts()[progress.part]; }
  /// Whether it changes contacts that lie as they were in the step before.
  bool in_place(const StepContext& c) const {
    return !done() && part().in_place && !progress.makes_lists() && !c.neighbours.selects();
  }

  /// Does the pieces of the present part up to the `end`-th; after its last one the next part is the present one.
  void run_part(const StepContext& c, const Span& span, StepReport& report, std::size_t end);
  /// Does so many pieces, or all that is left.
  void run(const StepContext& c, const Span& span, StepReport& report, std::size_t pieces = kAll);

  /// Shows the contacts of the last step, or again those of this one, as far as there are any: each call swaps them.
  void turn_back(const StepContext& c);
  /// The contacts of this step count from now on: those of the last one go.
  void accept(const StepContext& c);
  /// Throws away what was made for this step: all is as the last step left it, but bodies may lie in another order,
  /// which the broad phase knows.
  void spoil(const StepContext& c);
  /// A frame in which time stands still ends: notes how far the work came.
  void note(const Span& span);
  /// The host changed a body's velocity, which was `before`. Lists and manifolds that were made for this step do not
  /// serve the body if it is much faster now.
  void pushed(const StepContext& c, std::uint32_t id, const Motion& before);

 private:
  void begin_again();
};

/// The pairs of bodies that were looked for again (ListRenewal::look) come into the table and get contacts. False if
/// they are too many: then all lists must be made anew.
bool put_renewed(const StepContext& c);

}  // namespace psim
