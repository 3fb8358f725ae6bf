// The work of a step before its substeps, written once: a table of parts, each of many pieces. The step runs it, the
// governor asks it for costs and spreads it over frames, saved states say how far it came, and docs/step.md shows it
// (`step-table` prints it).
//
// However many pieces are done at a time, the lists come out the same. A part runs only if it applies when its turn
// comes; the next part is always the next row that applies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "psim/report.h"
#include "step/step_context.h"

namespace psim {

/// Some pieces of a part: from the `begin`-th to before the `end`-th.
struct PieceRange {
  std::size_t begin = 0, end = 0;
};

struct StepPart {
  std::string_view name;
  Stage stage;            ///< whose time it counts as
  std::string_view does;  ///< one line for people
  std::string_view cut;   ///< what a piece is, for people
  bool (*applies)(const StepContext&);
  std::size_t (*pieces)(const StepContext&);
  void (*run)(StepContext&, const Span&, StepReport&, PieceRange);
  /// Predicted ns of one piece (nullptr: the part has one), and of the whole part where only counts are known.
  double (*piece_ns)(const UnitCosts&, const StepContext&, const WorkCounts&, std::size_t piece);
  double (*whole_ns)(const UnitCosts&, const WorkCounts&);
  /// It changes contacts that lie as they were in the step before. Once begun it must end in the same frame, unless
  /// those contacts were remembered first (StepProgress::spread).
  bool in_place = false;
};

/// All parts, in order. StepProgress::part counts them; as many as there are: all is done.
std::span<const StepPart> step_parts();
inline bool all_done(const StepProgress& progress) { return progress.part >= step_parts().size(); }
/// Predicted ns of all parts, if lists are made; or of those alone that change contacts in place.
double ahead_ns(const UnitCosts& costs, const WorkCounts& work, bool in_place = false);
/// The row of a part.
std::uint8_t part_named(std::string_view name);
/// The first row from `row` on that applies.
std::uint8_t next_part(const StepContext& c, std::uint8_t row);

// ---- step_work.cpp: doing the parts

/// Does the pieces of the present part up to the `end`-th; after its last one the next part is the present one.
void run_part(StepContext& c, const Span& span, StepReport& report, std::size_t end);
/// Does so many pieces, or all that is left.
inline constexpr std::size_t kAllPieces = std::numeric_limits<std::size_t>::max();
void run_parts(StepContext& c, const Span& span, StepReport& report, std::size_t pieces = kAllPieces);
/// A frame in which time stands still ends: notes how far the work came.
void note_work(StepContext& c, const Span& span);

/// Shows the contacts of the last step, or again those of this one, as far as there are any: each call swaps them.
void turn_back(StepContext& c);
/// The contacts of this step count from now on: those of the last one go.
void accept_work(StepContext& c);
/// Throws away what was made for this step: all is as the last step left it, but bodies may lie in another order, which
/// the broad phase knows. The contacts' impulses stay with the table that they were laid out by.
void spoil_work(StepContext& c);
/// The host changed a body's velocity, which was `before`. Lists and manifolds that were made for this step do not
/// serve the body if it is much faster now.
void note_push(StepContext& c, std::uint32_t id, const Motion& before);

/// The pairs of bodies that were looked for again (ListRenewal::look) come into the table and get contacts. False if
/// they are too many: then all lists must be made anew.
bool put_renewed(StepContext& c, const kernels::ReachParams& margin);

}  // namespace psim
