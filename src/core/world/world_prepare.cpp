// World::prepare: a first step's work and room ahead of it.
#include <algorithm>

#include "base/machine.h"
#include "base/trace.h"
#include "step/motion.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// Room for so many candidates and strips is made in small worlds, too: bodies come together.
constexpr std::size_t kFewPairs = 32768, kFewStrips = 256;

// Lists that serve several frames are longer. To make room for them takes longer than a frame may, so it is made before
// the first frame.
void spare_room(Owners& w) {
  BodyStore& bodies = w.bodies;
  NeighbourLists& lists = w.neighbours;
  Contacts& contacts = w.contacts;
  const std::size_t each = w.plan.radii ? 20 : 12;
  const std::size_t pairs = std::max<std::size_t>(2 * std::max(lists.table.pair_room, lists.candidates.pair_room),
                                                  each * bodies.count + kFewPairs);
  for (PairTable* of : {&lists.table, &lists.old_table, &lists.candidates}) of->spare(bodies.count, pairs);
  const std::size_t all = kernels::round_up_block(bodies.count) + 2 * lists.table.strips.size() + kFewStrips;
  lists.broad.spare(bodies.count, all, pairs);
  if (bodies.count >= BroadPhase::kSmallWorld) lists.renewal.spare(bodies.count);
  for (Column<float>* of : {&bodies.vel, &bodies.disp, &bodies.vel0}) of->reserve(2 * all);
  bodies.pos.reserve(2 * all);
  if (w.plan.manifolds && !lists.table.strips.empty()) {
    const std::size_t cornered = w.population.traits.cornered;
    const std::size_t most = std::min(24 * cornered, 6 * cornered + kFewPairs);
    contacts.manifolds.spare(std::max<std::size_t>(2 * contacts.manifolds.pair_count(), most),
                             lists.table.strips.size());
  }
  contacts.discs.spare(std::max<std::size_t>(2 * kernels::kBlock * contacts.discs.pair_blocks(),
                                             (w.plan.radii ? 8 : 5) * std::size_t{bodies.count}),
                       2 * kernels::kBlock * contacts.discs.static_blocks() + 1024);
  if (!w.plan.forces && !w.plan.turns) {
    contacts.solved.spare(kernels::round_up_block(bodies.count) + 1024, !bodies.rim_speed.empty(), w.plan.restitution);
  }
}

}  // namespace

// All of a first step but its substeps, for the room that it takes, and again as far as a step can be made ahead. Since
// the host may still change anything, how it was before is kept until the step.
void World::prepare() {
  Owners& w = *impl_;
  if (w.ledger.frames != 0 || !w.unprepared.empty() || w.bodies.awake() == 0 || !w.quarantine.doubtful.empty()) {
    return;
  }
  std::vector<std::byte> before;
  psim::save(w, before);
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool);
  const Ledger counted = w.ledger;
  const Span span{w.desc.dt, w.desc.dt};
  StepReport ignored;
  replan(w);
  w.tracer.begin();
  finish_contacts(w, w.desc.dt, span, ignored);
  if (w.governor.on()) spare_room(w);
  if (w.plan.sleep && w.sleep.sleepers.anyone_slow()) w.sleep.make_room(w.sleep_source());
  w.ledger = counted;
  go_back(w, before);
  replan(w);
  w.tracer.begin();
  run_parts(w, span, ignored);
  if (w.plan.manifolds) {  // a step with as many substeps leaves them as they lie
    w.dynamics.substeps = w.desc.substeps;
    lay_out_manifolds(w, w.desc.dt);
  }
  w.ledger = counted;
  w.unprepared = std::move(before);
}

Owners& Owners::settled() {
  if (unprepared.empty()) return *this;
  const std::vector<std::byte> before = std::move(unprepared);
  unprepared.clear();
  go_back(*this, before);
  return *this;
}

}  // namespace psim
