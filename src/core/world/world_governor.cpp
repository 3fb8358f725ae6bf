// The governor from outside: World::set_governor, World::replay, and the room that is made for it before the first step.
#include <algorithm>

#include "world/world_impl.h"

namespace psim {
namespace {

// Room for so many candidates and strips is made in small worlds, too: bodies come together.
constexpr std::size_t kFewPairs = 32768, kFewStrips = 256;

}  // namespace

bool World::set_governor(const GovernorDesc& desc) {
  if (!Governor::sound(desc)) return false;
  impl_->settle_lists();
  impl_->governor.set(desc);
  return true;
}

StepReport World::replay(const StepDetail& detail) { return replay(detail, impl_->desc.dt); }

StepReport World::replay(const StepDetail& detail, double dt) {
  const auto frames = [](int n) { return n >= 1 && n <= StepDetail::kMostFrames; };
  if (detail.substeps > StepDetail::kMostSubsteps || !frames(detail.frames) || !frames(detail.horizon) ||
      (detail.solves && detail.wakes) || detail.sweeps > StepDetail::kMostSweeps) {
    return {};
  }
  return impl_->step(dt, detail, false);
}

// Lists that serve several frames are longer. To make room for them takes longer than a frame may, so it is made before
// the first frame.
void World::Impl::spare_room() {
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
    const std::size_t cornered = traits.cornered;
    const std::size_t most = std::min(24 * cornered, 6 * cornered + kFewPairs);
    contacts.manifolds.spare(std::max<std::size_t>(2 * contacts.manifolds.pair_count(), most),
                             neighbours.table.strips.size());
  }
  contacts.discs.spare(std::max<std::size_t>(2 * kernels::kBlock * contacts.discs.pair_blocks(),
                                             (plan.radii ? 8 : 5) * std::size_t{bodies.count}),
                       2 * kernels::kBlock * contacts.discs.static_blocks() + 1024);
  if (!plan.forces && !plan.turns) {
    contacts.solved.spare(kernels::round_up_block(bodies.count) + 1024, !bodies.rim_speed.empty(), plan.restitution);
  }
}

}  // namespace psim
