// World::prepare: a first step's work and room ahead of it.
#include "float_settings.h"
#include "stage_timer.h"
#include "world_impl.h"

namespace psim {

// All of a first step but its substeps, for the room that it takes, and again as far as a step can be made ahead. Since
// the host may still change anything, how it was before is kept until the step.
void World::Impl::prepare() {
  if (frame != 0 || prepared() || bodies.count == bodies.dead || !doubtful.empty()) return;
  std::vector<std::byte> before;
  save(before);
  saved.saver = Saver();
  const FloatSettings settings;
  const auto counted = skipped_frames;
  const auto lanes_counted = lanes;
  const Span span{desc.dt, desc.dt};
  StepReport ignored;
  {
    const WorkerPool::Awake awake(pool);
    settle_lists();
    replan();
    tracer.begin();
    refresh_lists(desc.dt, span, ignored);
    if (governor.on()) spare_room();
    if (plan.sleep && sleepers.anyone_slow(bodies)) room_for_sleepers();
  }
  skipped_frames = counted;
  lanes = lanes_counted;
  std::string error;
  restore(before, error);
  const WorkerPool::Awake awake(pool);
  settle_lists();
  replan();
  tracer.begin();
  finish_work(span, ignored);
  if (plan.shapes) {  // a step with as many substeps leaves them as they lie
    substeps = desc.substeps;
    lay_out_manifolds(desc.dt);
  }
  skipped_frames = counted;
  lanes = lanes_counted;
  unprepared = std::move(before);
}

void World::Impl::unprepare() {
  const std::vector<std::byte> before = std::move(unprepared);
  unprepared.clear();
  std::string error;
  restore(before, error);
}

}  // namespace psim
