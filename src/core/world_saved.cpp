// World::save and restore. What there is to remember is image.h's; here is in which order. How contacts come
// back is world_saved_contacts.cpp's.
#include "float_settings.h"
#include "image.h"

namespace psim {
namespace {

std::string differs(const WorldDesc& a, const WorldDesc& b) {
  const bool same = a.bounds.xmin == b.bounds.xmin && a.bounds.xmax == b.bounds.xmax && a.bounds.ymin == b.bounds.ymin &&
                    a.bounds.ymax == b.bounds.ymax && a.boundary == b.boundary;
  return same ? "" : "the saved world has other bounds or another boundary";
}

}  // namespace

// All but manifolds. `lists`: they last, and are made again.
template <class A>
void World::Impl::image(A& a, bool& lists) {
  numbers(a, frame, steps, escaped, stiff_substep, last_substep, impact_rate, list_frames,
          sampled_speed, crowding, loose, once, first_mass, first_radius, least_radius, plan_stale,
          lists_stale, impulses_valid, substeps, kept_contacts, ahead.part, ahead.at, ahead.sorted,
          ahead.built, ahead.laid, ahead.spread, ahead.waits, ahead.spoiled, ahead.horizon,
          list_reach, list_skin, list_span, select_span, lists, saved.candidates);
  list(a, saved.done,
       [&](Saved::Done& d) { numbers(a, d.part, d.at, d.span, d.id, d.vx, d.vy, d.spin); });
  for (float& soft : manifold_soft) a.value(soft);
  Image::visit(a, first_surface);
  Image::visit(a, traits);
  Image::visit(a, plan);
  list(a, doubtful, [&](BodyId& id) { Image::visit(a, id); });
  list(a, held, [&](auto& h) { numbers(a, h.first, h.second.x, h.second.y); });
  list(a, bullets, [&](std::uint32_t& id) { a.value(id); });
  a.refuse_nan(true);
  records(a, fixed, [](auto& record, FixedBody& f) { numbers(record, f.x, f.y, f.angle, f.radius, f.id, f.first_shape); });
  a.refuse_nan(false);
  list(a, frozen, [&](BodyState& s) {
    Image::visit(a, s.id);
    numbers(a, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type);
  });
  a.vector(saved.origin);
  a.refuse_nan(true);
  Image::bodies(a, bodies, lists || ahead.built);
  if constexpr (!A::kLoading) saved.dead_radii = bodies.dead_radii();
  list(a, saved.dead_radii, [&](float& r) { a.value(r); });
  Image::shapes(a, shapes, sleepers, bodies, probe ? &probe->sleepers : nullptr);
  Image::broad(a, broad);
  a.refuse_nan(false);
  if (lists && !loose) Image::renewal(a, renewal, bodies.count);
  Image::contacts(a, contacts);
  Image::solved(a, solved);
  Image::counts(a, solver, loads, continuous);
  Image::joints(a, joints, probe ? &probe->joints : nullptr);
  Image::sleepers(a, sleepers, bodies);
  Image::events(a, events);
  Saved::InBytes& s = saved.bytes;
  list(a, saved.strip_pairs, [&](std::uint32_t& n) { a.value(n); });
  list(a, saved.strip_singles, [&](std::uint32_t& n) { a.value(n); });
  if (!lists || loose) {
    Image::table(a, table);
    a.in_place(s.of_body);
    a.in_place(s.many);
    a.in_place(s.near);
    a.in_place(s.far);
    a.in_place(s.s_body);
    a.in_place(s.s_shape);
    list(a, saved.renewed, [&](Saved::Pair& p) { numbers(a, p.owner, p.other, p.impulse, p.friction); });
  }
  for (InPlace<float>* c : s.all()) a.in_place(*c);
}

void World::save(std::vector<std::byte>& out) { impl_->save(out); }

void World::Impl::save(std::vector<std::byte>& out) {
  const WorkerPool::Awake awake(pool);
  settle_lists();
  saved.origin.clear();
  if (ahead.sorted || broad.has_moved_on()) broad.copy_origin(saved.origin);
  turn_back();
  saved.candidates = count_work().candidates;
  const bool stale = lists_stale;
  lists_stale = stale || ahead.built;
  bool lists = !lists_stale && !once && bodies.count != 0 && bodies.dead == 0 && table.body_count != 0;
  const bool lasting = lists && !loose;
  count_carried(lasting);
  if (plan.shapes) manifolds.keep_impulses(pool);
  sleepers.pack(bodies, pool);
  Saver& saver = saved.saver;
  saver.clear();
  Image::visit(saver, desc);
  image(saver, lists);
  Image::manifolds(saver, manifolds, bodies.count);
  saver.finish(out, pool, table.body_count != 0 ? table.strips.size() : 0,
               [&](std::size_t strip) {
                 write_carried(strip);
                 if (!lasting) write_names(strip);
               });
  lists_stale = stale;
  turn_back();
}

bool World::restore(std::span<const std::byte> state, std::string& error) { return impl_->restore(state, error); }

bool World::Impl::restore(std::span<const std::byte> state, std::string& error) {
  const FloatSettings settings;  // as in a step: what is made here is what a step would make
  error.clear();
  Loader loader(state, true);
  WorldDesc read;
  Image::visit(loader, read);
  error = loader.error();
  if (error.empty()) error = differs(read, desc);
  if (error.empty()) error = check(read, options);
  if (!error.empty()) return false;
  constexpr std::size_t kSmall = 1 << 16;  // bytes: more memory is given back
  // All of it is read and looked at before anything changes.
  if (!probe) probe = std::make_unique<Impl>(read, RunOptions{options.isa, 1});
  probe->desc = read;
  bool lists = false;
  probe->image(loader, lists);
  Image::manifolds(loader, probe->manifolds, probe->bodies.count);
  loader.end();
  if (loader.ok()) Image::check(loader, *probe, *this, lists);
  const std::optional<std::uint64_t> roster_sum = probe->bodies.roster_sum;
  error = loader.error();
  if (!error.empty()) {
    if (loader.first_bytes() > kSmall) probe.reset();
    return false;
  }
  unprepared = std::vector<std::byte>();
  loader.begin_again();
  Image::visit(loader, read);
  desc = read;
  const bool snapshots = traits.snapshots;
  if (saved.shaped && saved.large) waiting.reset();
  saved.missing = saved.named = saved.shaped = false;
  saved.bytes = {};
  table.body_count = old_table.body_count = 0;
  table.strips.clear();
  candidates.strips.clear();
  renewal.forget();
  image(loader, lists);
  bodies.roster_sum = roster_sum;
  const WorkerPool::Awake awake(pool);
  if (lists && !loose) {
    keep_carried(loader);
  } else {
    take_pairs(loader);
  }
  traits.snapshots = plan.publish = snapshots;
  forces.reset();
  if (plan_stale) {  // its columns are there, and wait for the next plan
    const bool published = applied.publish;
    applied = plan;
    applied.publish = published;
  } else {
    applied.events = plan.events;  // who listens is in the state
    apply_plan();
  }
  bodies.fill_radii(first_radius, traits.same_radius != traits.moving);
  bodies.put_dead_radii(saved.dead_radii);
  if (bodies.count != 0) bodies.pad_tail();
  old_table.body_count = 0;
  contacts.give_up();
  manifolds.forget();  // of bodies that may not be
  ahead.swapped = false;
  broad.set_origin(saved.origin);
  saved.missing = lists;
  saved.undone = ahead.part > Part::count;
  saved.bare = true;
  saved.builds = contacts.builds();
  Image::manifolds(loader, probe->manifolds, bodies.count);
  loader.finish(pool);
  saved.large = loader.first_bytes() > kSmall;
  saved.shaped = lists && !loose && sorts_out();
  if (saved.shaped) {
    probe.swap(waiting);
  } else {
    Image::take(manifolds, probe->manifolds, bodies.count, governor.on());
  }
  if (saved.large) probe.reset();
  columns.forget();
  placed = true;
  queries.forget_moving();
  queries.forget_sleeping();
  queries.forget_fixed();
  error = loader.error();
  return error.empty();
}

// Manifolds are made anew with lists that last, and then put back as they were.
void World::Impl::put_manifolds() {
  saved.shaped = false;
  Image::take(manifolds, waiting->manifolds, bodies.count, governor.on());
  if (saved.large) waiting.reset();
  if (manifolds.fit(table.strips.size())) return;
  spoil_lists();  // other bytes than were saved
  manifolds.clear();
  saved.undone = false;
}

// What was done of the present step, from where its bodies are saved or its lists serve; everybody as fast as then.
void World::Impl::work_again() {
  saved.undone = false;
  const FloatSettings settings;
  const double visits = loads.visits(), listed = list_span, selected = select_span;
  ahead.at = 0;
  if (ahead.sorted) {
    if (!loose) {
      table.swap(old_table);
      ahead.swapped = true;
    }
    broad.move_again(bodies, kernels, pool, loose ? candidates : table);
    ahead.part = Part::search;
  } else if (ahead.built) {
    broad.count_again(bodies, kernels, pool);
    ahead.part = Part::move;
  } else {
    ahead.part = after_check();
  }
  bodies.find_slots();
  const auto swap_motion = [this](Saved::Done& push) {
    if (push.span > 0) return;
    const std::size_t slot = bodies.info[push.id].slot;
    std::swap(bodies.vel[2 * slot], push.vx);
    std::swap(bodies.vel[2 * slot + 1], push.vy);
    if (!bodies.spin.empty()) std::swap(bodies.spin[slot], push.spin);
  };
  for (auto push = saved.done.rbegin(); push != saved.done.rend(); ++push) swap_motion(*push);
  StepReport ignored;
  for (Saved::Done& done : saved.done) {
    swap_motion(done);
    const auto part = static_cast<Part>(done.part);
    while (done.span > 0 && ahead.part != Part::done &&
           (ahead.part < part || (ahead.part == part && ahead.at < done.at))) {
      const std::size_t end = pieces();
      work({done.span, done.span}, ignored,
           ahead.part == part ? std::min<std::size_t>(end, done.at) : end);
    }
  }
  loads.set_visits(visits);
  list_span = listed;
  select_span = selected;
}

std::unique_ptr<World> World::from_state(std::span<const std::byte> state, const RunOptions& options, std::string& error) {
  Loader loader(state);
  WorldDesc desc;
  Image::visit(loader, desc);
  error = loader.error();
  if (!error.empty()) return nullptr;
  auto world = create(desc, options, error);
  if (!world || !world->restore(state, error)) return nullptr;
  return world;
}

std::uint64_t hash_of(const std::byte* data, std::size_t size) {
  std::uint64_t hash = 0x9E3779B97F4A7C15u ^ size;
  const auto mix = [](std::uint64_t& to, std::uint64_t v) {
    to = (to ^ v) * 0xD6E8FEB86659FD93u;
    to ^= to >> 32;
  };
  const auto take = [&] {
    std::uint64_t v;
    std::memcpy(&v, data, 8);
    data += 8, size -= 8;
    return v;
  };
  if (size >= 32) {  // four that do not wait for each other
    std::uint64_t lane[4] = {hash, hash + 1, hash + 2, hash + 3};
    while (size >= 32) {
      for (std::uint64_t& l : lane) mix(l, take());
    }
    for (const std::uint64_t l : lane) mix(hash, l);
  }
  while (size >= 8) mix(hash, take());
  std::uint64_t last = 0;
  if (size != 0) std::memcpy(&last, data, size);
  mix(hash, last);
  return hash ^ (hash >> 29);
}

}  // namespace psim
