// What the host asks of a world and is told of a step: queries, events, contacts, rows of the bodies, sums. The
// observers answer; here they get what they need.
#include <cmath>

#include "query/queries.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Queries ask(Owners& w) { return {w.observers.queries, w.observed()}; }

// Notes which slot each body has now, where bodies were sorted since contacts were laid out.
void find_moved(Owners& w) {
  std::vector<std::uint32_t> origin;
  if (w.progress.sorted() || w.neighbours.broad.origin.moved_on()) w.neighbours.broad.origin.copy(origin);
  w.observers.contacts.set_moved(origin);
}

}  // namespace

void World::set_event_options(const EventOptions& options) {
  Owners& w = impl_->settled();
  w.observers.events.set_options(options);
  w.population.traits.events = w.observers.events.on();
}

Events World::events() const { return impl_->observers.events.view(); }

std::optional<RayHit> World::ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  return ask(*impl_).ray_cast(from, to, filter);
}

std::vector<RayHit> World::ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  return ask(*impl_).ray_cast_all(from, to, filter);
}

std::vector<BodyId> World::overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const {
  return ask(*impl_).overlap(shape, position, angle, filter);
}

std::vector<BodyId> World::in_region(const Bounds& region, const QueryFilter& filter) const {
  return ask(*impl_).in_region(region, filter);
}

std::optional<ClosestHit> World::closest(Vec2 point, double reach, const QueryFilter& filter) const {
  return ask(*impl_).closest(point, reach, filter);
}

std::uint64_t World::state_hash() const { return psim::state_hash(impl_->observed()); }

PublishedState World::published() { return impl_->observers.columns.fill(impl_->observed()); }

Diagnostics World::diagnostics() const {
  Owners& w = impl_->settled();
  Diagnostics d = sum_motion(w.observed());
  for (const Sleeper& s : w.sleep.sleepers.list) {
    d.max_penetration = std::fmax(d.max_penetration, static_cast<double>(s.depth));
  }
  if (w.neighbours.stale || !w.contacts_stand() || w.contacts.bare || w.ledger.frames == 0) return d;
  // The narrow phase over the present lists gives the present separations.
  ContactStore& discs = w.contacts.discs;
  discs.find_gaps(w.walls, 0, 0, w.neighbours.table);
  float deepest = w.contacts.manifolds.deepest();
  const auto look = [&](const Column<float>& gaps, std::size_t blocks) {
    for (std::size_t l = 0; l < blocks * kernels::kBlock; ++l) deepest = std::fmax(deepest, -gaps[l]);
  };
  look(discs.pairs.gap, discs.pairs.blocks);
  look(discs.fixed.gap, discs.fixed.blocks);
  d.max_penetration = std::fmax(d.max_penetration, static_cast<double>(deepest));
  return d;
}

std::span<const std::uint32_t> World::strips() {
  const FloatSettings settings;
  const WorkerPool::Awake awake(impl_->pool);
  Owners& w = impl_->settled();
  ContactList& list = w.observers.contacts;
  list.strips.assign(w.bodies.id_count, kNoStrip);
  if (w.ledger.steps == 0) return list.strips;
  find_moved(w);
  turn_back(w);
  w.pool.run(w.neighbours.table.body_count != 0 ? w.neighbours.table.strips.size() : 0, [&](std::size_t index) {
    const Strip& s = w.neighbours.table.strips[index];
    for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
      const std::uint32_t slot = list.slot(i);
      const std::uint32_t id = slot < w.bodies.count ? w.bodies.id[slot] : kNoSlot;
      if (id != kNoSlot) list.strips[id] = static_cast<std::uint32_t>(index);
    }
  });
  turn_back(w);
  return list.strips;
}

// The impulses and the table are those of the last step meanwhile, even where the work for the next one has begun.
std::span<const Contact> World::contacts() {
  if (impl_->ledger.steps == 0) return {};
  const FloatSettings settings;
  const WorkerPool::Awake awake(impl_->pool);
  Owners& w = impl_->settled();
  LastStep last;
  last.begun = !w.progress.untouched() || w.progress.at != 0 || !w.contacts_stand();
  last.with_manifolds = w.plan.manifolds;
  last.substeps = w.dynamics.substeps;
  if (w.plan.model.model == kernels::Model::plain) last.disc_mass = w.population.first_properties.mass;
  find_moved(w);
  turn_back(w);
  if (last.begun && w.plan.manifolds) w.contacts.manifolds.keep_impulses();
  const std::span<const Contact> found = find_contacts(w.observed(), last, w.observers.contacts);
  turn_back(w);
  return found;
}

std::size_t World::memory_bytes() const {
  const Owners& w = *impl_;
  return w.memory.bytes + w.population.bytes() + w.neighbours.bytes() + w.contacts.manifolds.bytes() +
         w.contacts.stacks.bytes() + w.joints.bytes() + w.dynamics.solver.bytes() + w.sleep.sleepers.bytes() +
         w.observers.bytes() + w.unprepared.capacity() + sizeof(Owners);
}

}  // namespace psim
