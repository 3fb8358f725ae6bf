// What the host asks of a world and is told of a step: queries, events, rows of the bodies, sums. The observers answer;
// here they get what they need.
#include <cmath>

#include "world/world_impl.h"

namespace psim {

QuerySource World::Impl::query_source() const {
  Vec2 period;
  if (desc.boundary == Boundary::periodic) {
    period = {desc.bounds.xmax - desc.bounds.xmin, desc.bounds.ymax - desc.bounds.ymin};
  }
  return {bodies, statics, fixed, frozen, sleepers.list, lattice, period, traits.cornered == 0};
}

EventSource World::Impl::event_source() {
  return {bodies,
          contacts.solved,
          contacts.discs,
          contacts.manifolds,
          statics,
          lattice,
          pool,
          !kinematics.empty(),
          bodies.count != bodies.dead,
          sleepers.changed};
}

Queries World::Impl::ask() const { return {queries, query_source(), !kinematics.empty()}; }

void World::set_event_options(const EventOptions& options) {
  impl_->settle_lists();
  impl_->events.set_options(options);
  impl_->traits.events = impl_->events.on();
}

Events World::events() const { return impl_->events.view(); }

std::optional<RayHit> World::ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  return impl_->ask().ray_cast(from, to, filter);
}

std::vector<RayHit> World::ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  return impl_->ask().ray_cast_all(from, to, filter);
}

std::vector<BodyId> World::overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const {
  return impl_->ask().overlap(shape, position, angle, filter);
}

std::vector<BodyId> World::in_region(const Bounds& region, const QueryFilter& filter) const {
  return impl_->ask().in_region(region, filter);
}

std::optional<ClosestHit> World::closest(Vec2 point, double reach, const QueryFilter& filter) const {
  return impl_->ask().closest(point, reach, filter);
}

std::uint64_t World::state_hash() const { return psim::state_hash(impl_->body_source()); }

PublishedState World::published() { return impl_->observers.columns.fill(impl_->body_source()); }

Diagnostics World::diagnostics() const {
  Impl& w = *impl_;
  Diagnostics d = sum_motion(w.body_source(), w.desc);
  for (const Sleeper& s : w.sleepers.list) {
    d.max_penetration = std::fmax(d.max_penetration, static_cast<double>(s.depth));
  }
  w.settle_lists();
  if (w.neighbours.stale || !w.contacts_stand() || w.saved.bare || w.frame == 0) return d;
  // The narrow phase over the present lists gives the present separations.
  ContactStore& discs = w.contacts.discs;
  w.contacts.find_gaps(w.walls, 0, w.neighbours.table);
  float deepest = w.contacts.manifolds.deepest();
  for (std::size_t l = 0; l < std::size_t{discs.pair_blocks()} * kernels::kBlock; ++l) {
    deepest = std::fmax(deepest, -discs.gap[l]);
  }
  for (std::size_t l = 0; l < std::size_t{discs.static_blocks()} * kernels::kBlock; ++l) {
    deepest = std::fmax(deepest, -discs.s_gap[l]);
  }
  d.max_penetration = std::fmax(d.max_penetration, static_cast<double>(deepest));
  return d;
}

std::size_t World::memory_bytes() const {
  const Impl& w = *impl_;
  return w.memory.bytes + w.population.bytes() + w.neighbours.bytes() + w.contacts.manifolds.bytes() +
         w.contacts.stacks.bytes() + w.joints.bytes() + w.dynamics.solver.bytes() + w.sleepers.bytes() +
         w.observers.bytes() + w.unprepared.capacity() + sizeof(Impl);
}

}  // namespace psim
