// World::contacts and World::strips. The impulses and the table are those of the last step meanwhile, even where the
// work for the next one has begun.
#include <algorithm>

#include "base/machine.h"
#include "query/contact_finder.h"
#include "world/world_impl.h"

namespace psim {

// Notes which slot each body has now, where bodies were sorted since contacts were laid out.
void World::Impl::find_moved() {
  std::vector<std::uint32_t> origin;
  if (step_work.progress.sorted() || neighbours.broad.has_moved_on()) neighbours.broad.copy_origin(origin);
  observers.contacts.set_moved(origin, bodies.count);
}

ContactListSource World::Impl::contact_source() {
  ContactListSource source{
      bodies, statics, lattice, walls, sleepers, neighbours.table, contacts.discs, contacts.manifolds, pool};
  source.begun = !step_work.untouched() || step_work.progress.at != 0 || !contacts_stand();
  source.restored = saved.bare;
  source.with_manifolds = plan.manifolds;
  source.any_kinematic = !kinematics.empty();
  source.substeps = dynamics.substeps;
  source.usual_substeps = desc.substeps;
  const bool one_mass = plan.model.model == kernels::Model::plain;
  source.disc_mass = one_mass ? static_cast<double>(population.first_mass) : 1.0;
  return source;
}

std::span<const std::uint32_t> World::strips() {
  Impl& w = *impl_;
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool);
  w.settle_lists();
  ContactList& list = w.observers.contacts;
  list.strips.assign(w.bodies.id_count, kNoStrip);
  if (w.steps == 0) return list.strips;
  w.find_moved();
  w.turn_back();
  w.pool.run(w.neighbours.table.body_count != 0 ? w.neighbours.table.strips.size() : 0, [&](std::size_t index) {
    const Strip& s = w.neighbours.table.strips[index];
    for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
      const std::uint32_t slot = list.slot(i);
      const std::uint32_t id = slot < w.bodies.count ? w.bodies.id[slot] : kNoSlot;
      if (id != kNoSlot) list.strips[id] = static_cast<std::uint32_t>(index);
    }
  });
  w.turn_back();
  return list.strips;
}

std::span<const Contact> World::contacts() {
  Impl& w = *impl_;
  if (w.steps == 0) return {};
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool);
  w.settle_lists();
  const ContactListSource source = w.contact_source();
  w.find_moved();
  w.turn_back();
  if (source.begun && w.plan.manifolds) w.contacts.manifolds.keep_impulses(w.pool);
  ContactFinder finder(source, w.observers.contacts);
  finder.find(w.contacts.impulses_valid);
  w.turn_back();
  return finder.order();
}

}  // namespace psim
