// What the host asks of a world and is told of a step: queries, events, contacts, rows of the bodies, sums. The
// observers answer; here they get what they need.
#include "query/queries.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Queries ask(Owners& w) { return {w.observers.queries, w.observed()}; }

// Notes which slot each body has now, where bodies were sorted since contacts were laid out.
void find_moved(Owners& w, ContactList& list) {
  std::vector<std::uint32_t> origin;
  if (w.progress.sorted() || w.neighbours.broad.origin.moved_on()) w.neighbours.broad.origin.copy(origin);
  list.set_moved(origin);
}

// Calls find(world, last, list) for the contacts of the last step. The impulses and the table are those of that step
// meanwhile, even where the work for the next one has begun.
template <class Find>
auto with_contacts(Owners& w, ContactList& list, const Find& find) {
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool, WorkerPool::Work::other);
  LastStep last = last_step(w);
  last.begun = !w.progress.untouched() || w.progress.at != 0 || !w.contacts_stand();
  find_moved(w, list);
  turn_back(w);
  const struct TurnAgain {
    Owners& w;
    ~TurnAgain() { turn_back(w); }
  } again{w};
  if (last.begun && w.plan.manifolds) w.contacts.manifolds.keep_impulses();
  return find(w.observed(), last, list);
}

}  // namespace

LastStep last_step(const Owners& w) {
  LastStep last;
  last.with_manifolds = w.plan.manifolds;
  last.substeps = w.dynamics.substeps;
  if (w.plan.model.model == kernels::Model::plain) last.disc_mass = w.population.first_properties.mass;
  return last;
}

void World::set_event_options(const EventOptions& options) try {
  Owners& w = impl_->settled();
  w.observers.events.set_options(options);
  w.population.traits.events = w.observers.events.on();
} catch (const std::bad_alloc&) {
  impl_->recover();
}

Events World::events() const { return impl_->observers.events.view(); }

std::optional<RayHit> World::ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).ray_cast(from, to, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::optional<RayHit>>();
}

std::vector<RayHit> World::ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).ray_cast_all(from, to, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<RayHit>>();
}

std::size_t World::ray_cast_batch(std::span<const RayInput> rays, std::span<RayHit> hits,
                                  const QueryFilter& filter) try {
  const FloatSettings settings;
  const WorkerPool::Awake awake(impl_->pool, WorkerPool::Work::other);
  return ask(*impl_).ray_cast_batch(rays, hits, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::size_t>();
}

std::optional<ShapeCastHit> World::shape_cast(const Shape& shape, Vec2 from, double angle, Vec2 translation,
                                              double rotation, const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).shape_cast(shape, from, angle, translation, rotation, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::optional<ShapeCastHit>>();
}

std::size_t World::nearby(const Shape& shape, Vec2 position, double angle, double reach, std::span<NearHit> found,
                          const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).nearby(shape, position, angle, reach, found, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::size_t>();
}

std::vector<BodyId> World::overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const
    try {
  const FloatSettings settings;
  return ask(*impl_).overlap(shape, position, angle, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<BodyId>>();
}

std::vector<BodyId> World::in_region(const Bounds& region, const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).in_region(region, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<BodyId>>();
}

std::optional<ClosestHit> World::closest(Vec2 point, double reach, const QueryFilter& filter) const try {
  const FloatSettings settings;
  return ask(*impl_).closest(point, reach, filter);
} catch (const std::bad_alloc&) {
  return nothing_found<std::optional<ClosestHit>>();
}

std::uint64_t World::state_hash() const try {
  const FloatSettings settings;
  const std::uint64_t hash = psim::state_hash(impl_->observed());
  return !impl_->fluids.active() ? hash : impl_->fluids.hash(hash);
} catch (const std::bad_alloc&) {
  return nothing_found<std::uint64_t>();
}

PublishedState World::published() try {
  const FloatSettings settings;
  return impl_->observers.columns.fill(impl_->observed());
} catch (const std::bad_alloc&) {
  return impl_->ran_out(PublishedState());
}

Diagnostics World::diagnostics() const try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  Diagnostics d = sum_motion(w.observed());
  if (w.ledger.steps == 0) return d;
  ContactList list;  // its own, so that the host's contacts stay
  d.max_penetration = with_contacts(w, list, deepest_contact);
  return d;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(Diagnostics());
}

std::span<const std::uint32_t> World::strips() try {
  const FloatSettings settings;
  const WorkerPool::Awake awake(impl_->pool, WorkerPool::Work::other);
  Owners& w = impl_->settled();
  ContactList& list = w.observers.contacts;
  list.strips.assign(w.bodies.id_count, kNoStrip);
  if (w.ledger.steps == 0) return list.strips;
  find_moved(w, list);
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
} catch (const std::bad_alloc&) {
  return impl_->ran_out(std::span<const std::uint32_t>());
}

std::span<const Contact> World::contacts() try {
  if (impl_->ledger.steps == 0) return {};
  Owners& w = impl_->settled();
  const auto find = [](const Observed& world, const LastStep& last, ContactList& list) {
    return find_contacts(world, last, list);
  };
  return with_contacts(w, w.observers.contacts, find);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(std::span<const Contact>());
}

std::size_t World::memory_bytes() const {
  const Owners& w = *impl_;
  return w.memory.bytes + w.population.bytes() + w.neighbours.bytes() + w.contacts.manifolds.bytes() +
         w.contacts.stacks.bytes() + w.contacts.squeezed.bytes() + w.joints.bytes() + w.dynamics.solver.bytes() +
         w.dynamics.media.bytes() + bytes_of(w.dynamics.pushes) + w.sleep.sleepers.bytes() + w.observers.bytes() +
         w.unprepared.capacity() + sizeof(Owners);
}

}  // namespace psim
