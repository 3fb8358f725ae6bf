// World::prepare: a first step's work and room ahead of it.
#include "base/machine.h"
#include "base/trace.h"
#include "step/motion.h"
#include "world/world_impl.h"

namespace psim {

// All of a first step but its substeps, for the room that it takes, and again as far as a step can be made ahead. Since
// the host may still change anything, how it was before is kept until the step.
void World::Impl::prepare() {
  if (frame != 0 || prepared() || bodies.count == bodies.dead || !quarantine.doubtful.empty()) return;
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
    if (plan.sleep && sleepers.anyone_slow(bodies)) sleep.make_room(sleep_source());
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

void World::Impl::unprepare() {
  const std::vector<std::byte> before = std::move(unprepared);
  unprepared.clear();
  go_back(before);
}

}  // namespace psim
