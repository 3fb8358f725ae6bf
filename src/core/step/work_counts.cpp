#include "step/work_counts.h"

#include <algorithm>

#include "step/step_table.h"

namespace psim {
namespace {

// Lanes that a manifold under a heavy load takes in a sweep: few of those share a block.
constexpr std::uint64_t kLoadedLanes = 2;

// Lanes of the manifolds that were looked at for this step, those under heavy loads as often as they are swept; 0 if
// none is under a heavy load.
std::uint64_t loaded_manifold_lanes(const Contacts& contacts) {
  const HeavyLoads& loads = contacts.loads;
  if (!loads.any()) return 0;
  std::uint64_t active = 0, loaded = 0;
  for (const ManifoldPair& pair : contacts.manifolds.pairs()) {
    if (!pair.active) continue;
    ++active;
    if (pair.stack != ManifoldPair::kNoStack) continue;
    loaded += (pair.a != ManifoldPair::kNone && loads.at(pair.a)) || loads.at(pair.b);
  }
  return loaded == 0 ? 0 : active + kLoadedLanes * (HeavyLoads::kSweeps - 1) * loaded;
}

ManifoldCounts count_manifolds(const StepContext& c) {
  const Manifolds& m = c.contacts.manifolds;
  ManifoldCounts of;
  of.pairs = m.pair_count();
  of.looks = m.expected_looks();
  of.lanes = kernels::kBlock * m.totals().pass_blocks;
  if (all_done(c.progress)) {
    of.lanes = std::max({of.lanes, loaded_manifold_lanes(c.contacts), m.expected_lanes()});
    of.writes = m.expected_writes();
  } else {
    of.writes = c.neighbours.stale || c.progress.makes_lists() ? of.pairs : of.looks;
  }
  return of;
}

ListCounts count_lists(const StepContext& c) {
  const NeighbourLists& lists = c.neighbours;
  ListCounts of;
  if (lists.selects()) {
    if (lists.candidates.strips.empty()) of.candidates = lists.made.candidates;
    for (const Strip& s : lists.candidates.strips) of.candidates += s.pair_end - s.pair_begin;
  }
  of.strips = lists.table.strips.size();
  of.cells = lists.broad.cells().cell_count();
  of.visits = c.contacts.loads.visits;
  of.tests = lists.broad.cells().tests() * static_cast<double>(c.bodies.awake());
  of.near = lists.broad.near().pairs();
  return of;
}

// Bodies and contacts that sleep looks at after this step (Sleep::step).
std::uint64_t count_sleep_looks(const StepContext& c, const WorkCounts& work) {
  if (!c.plan.sleep) return 0;
  const std::uint64_t met = work.contacts + 4 * work.manifolds.pairs, step = c.ledger.steps + 1;
  std::uint64_t looks = 0;
  if (!c.sleep.sleepers.empty()) looks += 2 * met;
  if (step % Sleepers::kWatchFrames == 0) looks += work.bodies;
  if (step % (2 * Sleepers::kWatchFrames) == 0) looks += 2 * work.bodies + 2 * met;
  return looks;
}

}  // namespace

WorkCounts count_work(const StepContext& c) {
  const ContactStore& discs = c.contacts.discs;
  WorkCounts work;
  work.bodies = c.bodies.awake();
  work.solved = c.contacts.solved.count();
  work.contacts = discs.pairs.count + discs.fixed.count;
  work.lanes = kernels::kBlock * discs.pass_blocks();
  work.loaded_lanes = kernels::kBlock * discs.loaded_blocks();
  work.touching = c.dynamics.solver.closed();
  work.sweeps = c.plan.restitution ? c.dynamics.solver.sweeps() : 0;
  work.joints = c.joints.count();
  work.flights = c.dynamics.continuous.looked();
  work.manifolds = count_manifolds(c);
  work.lists = count_lists(c);
  work.has.sorted = c.progress.makes_lists();
  work.has.fixed = c.statics.any();
  work.has.loads = c.plan.loads;
  work.has.rough = c.plan.model.model == kernels::Model::rough;
  work.has.mixed = c.neighbours.selects() && c.plan.radii;
  work.has.uneven = c.plan.uneven;
  work.has.copies = c.contacts.solved.compact();
  work.has.stops = c.plan.continuous;
  work.has.long_lists = c.progress.horizon > 1;
  work.sleep_looks = count_sleep_looks(c, work);
  return work;
}

}  // namespace psim
