// What the governor does with a frame: pieces of the step's work as far as they fit, then, if all of them are done, the
// choice of the detail with which the step ends. It asks the step table for costs and knows no part by name.
#include <algorithm>

#include "step/governor.h"
#include "step/step_work.h"

namespace psim {
namespace {

// Frames after which a step that the host makes begin again is done at once, whatever it costs.
constexpr int kPatience = 3;

// How much more lists for so many frames hold than the present ones.
Governor::Growth list_growth(const StepContext& c, int frames) {
  const ListNumbers& made = c.neighbours.made;
  if (!c.neighbours.selects() || !(made.reach > 0)) return {};
  const double touching = 2 * static_cast<double>(c.population.least_radius);
  const double a_frame = std::max(made.reach - touching, 0.0) / (made.span * std::max(made.frames, 1.0));
  const double reach = touching + a_frame * std::max<double>(frames, made.frames);
  return {reach * reach / (made.reach * made.reach), frames / made.selected_span};
}

}  // namespace

// What is left of a frame, and what it may not put off.
struct Governor::Frame {
  double spent = 0;        // ns that are predicted so far
  int elapsed = 1;         // frames of the step, this one among them
  bool late = false;       // the step was made to begin again too often: it ends in this frame
  bool committed = false;  // contacts were changed in place and not remembered: the step ends in this frame
};

// Does pieces until the next one does not fit; at least one.
void Governor::do_pieces(const StepContext& c, StepWork& work, const Span& span, Frame& frame,
                         StepReport& report) const {
  StepProgress& now = work.progress;
  while (!work.done()) {
    const StepPart& part = work.part();
    const std::size_t all = part.pieces(c);
    const WorkCounts counts = count_work(c);
    const bool in_place = work.in_place(c);
    if (in_place && now.at == 0 && !step_parts()[now.part - 1u].in_place) {
      const double left = in_place_ns(costs_, counts) + rest_ns(costs_, counts) + substep_ns(costs_, counts);
      now.spread = frame.elapsed > 1 || frame.spent + left > room_ns();
      if (now.spread) frame.spent += remember_ns(costs_, counts);
    }
    const bool whole = frame.late || (in_place && !now.spread);
    std::size_t end = now.at;
    for (; end < all; ++end) {
      const double cost = part.piece_ns(c, counts, end);
      if (frame.spent + cost > room_ns() && frame.spent > costs_.step && !whole) break;
      frame.spent += cost;
    }
    if (end == now.at && all != 0) break;
    frame.committed = frame.committed || (in_place && !now.spread);
    report.detail.pieces += static_cast<std::uint32_t>(end - now.at);
    work.run(c, span, report, end);
  }
}

// All is ready: does the step end in this frame, with how many substeps, and how many frames does it make up for?
void Governor::choose_end(const StepContext& c, double dt, bool first, Frame& frame, StepDetail& detail) const {
  const WorkCounts counts = count_work(c);
  int horizon = c.progress.horizon;
  const bool lasting = !c.neighbours.selects() && !c.progress.makes_lists();
  if (frame.elapsed > 1 && horizon > 1 && lasting && !c.neighbours.serve(dt * std::min(frame.elapsed, horizon))) {
    horizon = 1;
  }
  const int most = std::min(c.desc.substeps, 255);
  const Choice choice = choose(counts, room_ns() - frame.spent, frame.elapsed, horizon, most);
  detail.solves = choice.solves || frame.late || frame.committed || first;
  if (!detail.solves) return;
  detail.substeps = static_cast<std::uint8_t>(std::max(choice.substeps, 1));
  detail.frames = static_cast<std::uint8_t>(choice.frames);
  const bool few = choice.solves ? choice.sweeps != 0 : counts.sweeps > kFewSweeps;
  detail.sweeps = few ? kFewSweeps : 0;
  detail.pieces = 0;
  frame.spent += rest_ns(costs_, counts) + detail.substeps * substep_ns(costs_, with_sweeps(counts, detail.sweeps));
}

void Governor::spend_frame(const StepContext& c, StepWork& work, double dt, bool first, StepReport& report) const {
  StepProgress& now = work.progress;
  StepDetail& detail = report.detail;
  if (work.untouched()) {
    const auto growth = [&c](int frames) { return list_growth(c, frames); };
    now.horizon = static_cast<std::uint8_t>(first ? 1 : horizon(count_work(c), std::min(c.desc.substeps, 255), growth));
  }
  detail.horizon = now.horizon;
  const Span span{dt, dt * detail.horizon};
  Frame frame{costs_.step, now.waits + 1, now.spoiled != 0 && now.waits >= kPatience};
  if (first) work.finish(c, span, report);
  do_pieces(c, work, span, frame, report);
  detail.solves = false;
  if (work.done()) choose_end(c, dt, first, frame, detail);
  report.predicted_ms = frame.spent * 1e-6;
}

bool Governor::fits_again(const StepContext& c, StepReport& report) const {
  const WorkCounts work = count_work(c);
  double spent = report.predicted_ms * 1e6;
  if (spent + ahead_ns(costs_, work) + rest_ns(costs_, work) <= room_ns()) return true;
  spent -= report.detail.substeps * substep_ns(costs_, with_sweeps(work, report.detail.sweeps));
  report.predicted_ms = spent * 1e-6;
  return false;
}

}  // namespace psim
