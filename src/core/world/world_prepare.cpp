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

}  // namespace

// All of a first step but its substeps, for the room that it takes, and again as far as a step can be made ahead. Since
// the host may still change anything, how it was before is kept until the step.
void World::Impl::prepare() {
  if (frame != 0 || prepared() || population.bodies.awake() == 0 || !quarantine.doubtful.empty()) return;
  std::vector<std::byte> before;
  save(before);
  const FloatSettings settings;
  const Ledger counted = ledger;
  const Span span{desc.dt, desc.dt};
  StepReport ignored;
  {
    const WorkerPool::Awake awake(pool);
    replan();
    tracer.begin();
    finish_contacts(desc.dt, span, ignored);
    if (governor.on()) spare_room();
    if (plan.sleep && sleep.sleepers.anyone_slow()) sleep.make_room(sleep_source());
  }
  ledger = counted;
  go_back(before);
  const WorkerPool::Awake awake(pool);
  replan();
  tracer.begin();
  step_work.finish(context(), span, ignored);
  if (plan.manifolds) {  // a step with as many substeps leaves them as they lie
    dynamics.substeps = desc.substeps;
    lay_out_manifolds(context(), desc.dt);
  }
  ledger = counted;
  unprepared = std::move(before);
}

World::Impl& World::Impl::settled() {
  if (prepared()) {
    const std::vector<std::byte> before = std::move(unprepared);
    unprepared.clear();
    go_back(before);
  }
  return *this;
}

// Lists that serve several frames are longer. To make room for them takes longer than a frame may, so it is made before
// the first frame.
void World::Impl::spare_room() {
  BodyStore& bodies = population.bodies;
  const std::size_t each = plan.radii ? 20 : 12;
  const std::size_t pairs = std::max<std::size_t>(
      2 * std::max(neighbours.table.pair_room, neighbours.candidates.pair_room), each * bodies.count + kFewPairs);
  for (PairTable* of : {&neighbours.table, &neighbours.old_table, &neighbours.candidates})
    of->spare(bodies.count, pairs);
  const std::size_t all = kernels::round_up_block(bodies.count) + 2 * neighbours.table.strips.size() + kFewStrips;
  neighbours.broad.spare(bodies.count, all, pairs);
  if (bodies.count >= BroadPhase::kSmallWorld) neighbours.renewal.spare(bodies.count);
  for (Column<float>* of : {&bodies.vel, &bodies.disp, &bodies.vel0}) of->reserve(2 * all);
  bodies.pos.reserve(2 * all);
  if (plan.manifolds && !neighbours.table.strips.empty()) {
    const std::size_t cornered = population.traits.cornered;
    const std::size_t most = std::min(24 * cornered, 6 * cornered + kFewPairs);
    contacts.manifolds.spare(std::max<std::size_t>(2 * contacts.manifolds.pair_count(), most),
                             neighbours.table.strips.size());
  }
  contacts.discs.spare(std::max<std::size_t>(2 * kernels::kBlock * contacts.discs.pairs.blocks,
                                             (plan.radii ? 8 : 5) * std::size_t{bodies.count}),
                       2 * kernels::kBlock * contacts.discs.fixed.blocks + 1024);
  if (!plan.forces && !plan.turns) {
    contacts.solved.spare(kernels::round_up_block(bodies.count) + 1024, !bodies.rim_speed.empty(), plan.restitution);
  }
}

}  // namespace psim
