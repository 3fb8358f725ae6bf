// The governor asks the step table for costs and knows no part by name.
#include "step/governor.h"

#include <algorithm>
#include <cmath>

#include "step/step_table.h"

namespace psim {

using namespace cost;

double rest_ns(const UnitCosts& c, const WorkCounts& w) {
  const bool bounces = w.sweeps > 0;
  const double a_lane = bounces ? (w.has.mixed ? kMixedMarking : kMarking) : w.has.mixed ? kMixed : 0;
  return c.narrow * (n(w.contacts) + a_lane * n(w.lanes)) + (w.has.copies ? c.load_body * n(w.solved) : 0) +
         c.column * (n(w.manifolds.writes) + kInItsLane * n(w.manifolds.pairs)) +
         (w.has.sorted ? c.joint_sorted : c.joint) * n(w.joints) + (c.move + (w.has.stops ? c.stop : 0)) * n(w.bodies) +
         c.sleep * n(w.sleep_looks) + (w.has.stops ? c.flight * n(w.flights) : 0);
}

double substep_ns(const UnitCosts& c, const WorkCounts& w) {
  const double free = std::max(0.0, 1 - 2 * n(w.touching) / std::max(n(w.lanes), 1.0));
  const auto cost = [&](const SweepCost& of) { return of.any + of.free * free; };
  const double pressing = w.sweeps > 0 ? (w.has.mixed ? kMixedBouncing : kBouncing) : w.has.mixed ? kMixedTouch : 1;
  const double sweeps =
      w.sweeps > 0 ? cost(kFirstSweep) + cost(w.has.mixed ? kNextMixedSweep : kNextSweep) * (w.sweeps - 1) : 0;
  return c.body_pass * n(w.solved) + (c.pass + c.sweep * sweeps) * n(w.lanes) +
         kSweepStrips * c.strip * n(w.lists.strips) * w.sweeps + c.touch * pressing * n(w.touching) +
         kSparse * (c.pass + c.touch) * n(w.loaded_lanes) + c.strip * n(w.lists.strips) +
         c.shape_pass * n(w.manifolds.lanes) + c.joint_pass * n(w.joints);
}

double fluid_part_ns(const UnitCosts& c, std::size_t particles, const FluidWork& w) {
  return c.particle * (w.bodies ? kAmongBodies : 1) *
         (static_cast<double>(particles) + kTile * w.tiles + kTilePass * w.passes);
}

namespace {

// Lists for more frames are worth it if a frame then takes no more than this share of what it takes now.
constexpr double kWorthIt = 0.95;

// Bodies in a crowd have as many contacts as they have neighbours: so many pairs a body. Large ones among small ones
// have more.
constexpr double kNeighbours = 3;

WorkCounts grown(const WorkCounts& w, const Governor::Growth& by) {
  WorkCounts then = w;
  const double now = std::max(n(w.contacts), 1.0);
  const double crowd = w.has.mixed && w.sweeps > 0 ? n(w.lists.candidates) * by.candidates : kNeighbours * n(w.bodies);
  const double most = std::min(n(w.lists.candidates) * by.candidates, crowd) / now;
  const double contacts = w.lists.candidates == 0 ? 1 : std::max(std::min(by.time, most), 1.0);
  const auto grow = [](double factor, auto&... counts) {
    ((counts = static_cast<std::uint64_t>(n(counts) * factor)), ...);
  };
  grow(by.candidates, then.lists.candidates, then.manifolds.pairs, then.manifolds.looks, then.manifolds.writes);
  grow(contacts, then.contacts, then.lanes, then.solved);
  then.solved = std::min(then.solved, std::max(w.bodies, w.solved));
  then.lists.tests *= by.candidates;
  return then;
}

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

// Substeps that fit beside the rest.
int fitting(const UnitCosts& costs, const WorkCounts& w, double ns, int most) {
  const double each = substep_ns(costs, w), room = ns - rest_ns(costs, w);
  if (room < 0) return 0;
  if (!(each > 0) || room >= most * each) return most;
  return static_cast<int>(std::floor(room / each));
}

// Lists that a step would make.
struct Lists {
  int frames = 1;      // that they serve
  double a_frame = 0;  // ns of a step's work for each of them
};
Lists lists_for(const Governor& g, const WorkCounts& w, int most, const std::function<Governor::Growth(int)>& growth) {
  const UnitCosts costs = g.costs();
  const double room = g.room_ns() - costs.step;
  const auto all = [&](const WorkCounts& then, int frames) {
    return ahead_ns(costs, then) + rest_ns(costs, then) + frames * substep_ns(costs, then);
  };
  Lists best{1, all(w, 1)};
  if (best.a_frame <= room) return best;
  for (int frames = 2; frames <= StepDetail::kMostFrames; ++frames) {
    const WorkCounts then = growth ? grown(w, growth(frames)) : w;
    if (fitting(costs, then, room, most) < frames) break;  // no substep is longer than a frame
    const double a_frame = all(then, frames) / frames;
    if (a_frame < kWorthIt * best.a_frame) best = {frames, a_frame};
    if (a_frame > room) continue;
    const WorkCounts later = growth ? grown(w, growth(frames + 1)) : w;
    const bool spare = frames < StepDetail::kMostFrames && fitting(costs, later, room, most) > frames;
    return {frames + (spare ? 1 : 0), a_frame};  // one to spare: counts change
  }
  return best;
}

Governor::Choice offer(const Governor& g, const WorkCounts& w, double left, double fluids, int elapsed, int horizon,
                       int most) {
  const UnitCosts costs = g.costs();
  const double room = g.room_ns() - costs.step - fluids;
  const int fits = fitting(costs, w, left, most), next = fitting(costs, w, room, most);
  Governor::Choice of;
  of.substeps = left >= room ? std::max(fits, 1) : fits;
  of.frames = std::max(std::min({of.substeps, elapsed, horizon}), 1);
  const int later = std::min({std::max(next, 1), elapsed + 1, horizon});
  of.solves = of.substeps >= 1 && of.frames * (elapsed + 1) >= later * elapsed;
  if ((of.solves ? fits : next) != 0) of.pace = of.solves ? 1.0 * of.frames / elapsed : 1.0 * later / (elapsed + 1);
  return of;
}

// What is left of a frame, and what it may not put off.
struct Frame {
  double spent = 0;        // ns that are predicted so far
  int elapsed = 1;         // frames of the step, this one among them
  bool late = false;       // the step was made to begin again too often: it ends in this frame
  bool committed = false;  // contacts were changed in place and not remembered: the step ends in this frame
};

// Does pieces until the next one does not fit; at least one.
void do_pieces(StepContext& c, const Span& span, Frame& frame, StepReport& report) {
  const UnitCosts costs = c.governor.costs();
  const double room_ns = c.governor.room_ns();
  StepProgress& now = c.progress;
  while (!all_done(now)) {
    const StepPart& part = step_parts()[now.part];
    const std::size_t all = part.pieces(c);
    const WorkCounts counts = count_work(c);
    // It changes contacts that lie as they were in the step before.
    const bool in_place = part.in_place && !now.makes_lists() && !c.neighbours.selects();
    if (in_place && now.at == 0 && !step_parts()[now.part - 1u].in_place) {
      const double left = ahead_ns(costs, counts, true) + rest_ns(costs, counts) + substep_ns(costs, counts);
      now.spread = frame.elapsed > 1 || frame.spent + left > room_ns;
      if (now.spread) frame.spent += kRemembered * costs.keep * n(counts.manifolds.pairs);
    }
    const bool whole = frame.late || (in_place && !now.spread);
    std::size_t end = now.at;
    for (; end < all; ++end) {
      const double cost =
          part.piece_ns != nullptr ? part.piece_ns(costs, c, counts, end) : part.whole_ns(costs, counts);
      if (frame.spent + cost > room_ns && frame.spent > costs.step && !whole) break;
      frame.spent += cost;
    }
    if (end == now.at && all != 0) break;
    frame.committed = frame.committed || (in_place && !now.spread);
    report.detail.pieces += static_cast<std::uint32_t>(end - now.at);
    run_part(c, span, report, end);
  }
}

// All is ready: does the step end in this frame, with how many substeps, and how many frames does it make up for?
// `fluids`: ns that these take, as far as that leaves a step for the bodies.
void choose_end(StepContext& c, double dt, double fluids, bool first, Frame& frame, StepDetail& detail) {
  const UnitCosts costs = c.governor.costs();
  const WorkCounts counts = count_work(c);
  int horizon = c.progress.horizon;
  const bool lasting = !c.neighbours.selects() && !c.progress.makes_lists();
  if (frame.elapsed > 1 && horizon > 1 && lasting && !c.neighbours.serve(dt * std::min(frame.elapsed, horizon))) {
    horizon = 1;
  }
  const int most = std::min(c.desc.substeps, 255);
  const double room = c.governor.room_ns(), rest = costs.step + rest_ns(costs, counts),
               each = substep_ns(costs, counts);
  const double kept =
      std::min({fluids, c.governor.fluids_room_ns(rest + most * each), std::max(room - rest - each, 0.0)});
  const Governor::Choice choice =
      c.governor.choose(counts, room - frame.spent - kept, frame.elapsed, horizon, most, kept);
  detail.solves = choice.solves || frame.late || frame.committed || first;
  if (!detail.solves) return;
  detail.substeps = static_cast<std::uint8_t>(std::max(choice.substeps, 1));
  detail.frames = static_cast<std::uint8_t>(choice.frames);
  const bool few = choice.solves ? choice.sweeps != 0 : counts.sweeps > Governor::kFewSweeps;
  detail.sweeps = few ? Governor::kFewSweeps : 0;
  detail.pieces = 0;
  frame.spent +=
      fluids + rest_ns(costs, counts) + detail.substeps * substep_ns(costs, with_sweeps(counts, detail.sweeps));
}

}  // namespace

CostModel::CostModel() : CostModel(cost_model(UnitCosts{})) {}

bool Governor::sound(const GovernorDesc& desc) {
  const CostModel::Numbers numbers = desc.costs.numbers();
  return desc.budget_ms > 0 &&
         std::all_of(numbers.begin(), numbers.end(), [](double ns) { return ns >= 0 && std::isfinite(ns); });
}

int Governor::horizon(const WorkCounts& w, int most, const std::function<Growth(int)>& growth) const {
  const Lists whole = lists_for(*this, w, most, growth);
  if (w.sweeps <= kFewSweeps || whole.a_frame <= room_ns() - costs().step) return whole.frames;
  const Lists cut = lists_for(*this, with_sweeps(w, kFewSweeps), most, growth);
  return cut.a_frame < kWorthIt * whole.a_frame ? cut.frames : whole.frames;
}

Governor::Choice Governor::choose(const WorkCounts& w, double left, int elapsed, int horizon, int most,
                                  double fluids) const {
  const Choice whole = offer(*this, w, left, fluids, elapsed, horizon, most);
  if (w.sweeps <= kFewSweeps) return whole;
  Choice cut = offer(*this, with_sweeps(w, kFewSweeps), left, fluids, elapsed, horizon, most);
  cut.sweeps = kFewSweeps;
  return whole.pace > 0 && cut.pace <= whole.pace ? whole : cut;
}

double Governor::fluids_room_ns(double of_bodies) const {
  constexpr double kLeast = 0.5, kMost = 0.875;  // of the room
  return std::clamp(room_ns() - of_bodies, kLeast * room_ns(), kMost * room_ns());
}

double Governor::govern_fluids(const StepContext& c, double dt, StepDetail& detail) const {
  const FluidWork work = c.fluids.work(dt, c.desc.gravity);
  if (work.parts == 0) return 0;
  double of_bodies = costs().step;
  if (c.bodies.awake() != 0) {
    const WorkCounts bodies = count_work(c);
    of_bodies += ahead_ns(costs(), bodies) + rest_ns(costs(), bodies) + c.desc.substeps * substep_ns(costs(), bodies);
  }
  const double each = fluid_part_ns(costs(), c.fluids.size(), work);
  const int fit = std::max(static_cast<int>(std::min(fluids_room_ns(of_bodies) / each, 255.0)), 1);
  const int most = fit < work.parts ? std::min<int>(fit, StepDetail::kMostFluidParts) : 0;
  detail.fluid_parts = static_cast<std::uint8_t>(most);
  return each * std::min(fit, work.parts);
}

void Governor::spend_frame(StepContext& c, double dt, StepReport& report) const {
  const bool first = c.ledger.frames == 0;
  StepProgress& now = c.progress;
  StepDetail& detail = report.detail;
  if (now.untouched()) {
    const auto growth = [&c](int frames) { return list_growth(c, frames); };
    now.horizon = static_cast<std::uint8_t>(first ? 1 : horizon(count_work(c), std::min(c.desc.substeps, 255), growth));
  }
  detail.horizon = now.horizon;
  const Span span{dt, dt * detail.horizon};
  const double fluids = govern_fluids(c, dt, detail);
  Frame frame{costs().step, now.waits + 1, now.spoiled != 0 && now.waits >= kPatience};
  if (first) run_parts(c, span, report);
  do_pieces(c, span, frame, report);
  detail.solves = false;
  if (all_done(now)) choose_end(c, dt, fluids, first, frame, detail);
  // A step that makes up for several frames may take more parts, which do not fit.
  if (detail.frames > 1) govern_fluids(c, dt * detail.frames, detail);
  report.predicted_ms = frame.spent * 1e-6;
}

bool Governor::fits_again(const StepContext& c, StepReport& report) const {
  const UnitCosts ns = costs();
  const WorkCounts work = count_work(c);
  double spent = report.predicted_ms * 1e6;
  if (spent + ahead_ns(ns, work) + rest_ns(ns, work) <= room_ns()) return true;
  spent -= report.detail.substeps * substep_ns(ns, with_sweeps(work, report.detail.sweeps));
  report.predicted_ms = spent * 1e-6;
  return false;
}

}  // namespace psim
