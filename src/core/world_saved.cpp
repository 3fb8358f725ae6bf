// World::save and restore. What there is to remember is image.h's; here is in which order, and how contacts
// come back.
#include <algorithm>
#include <cmath>

#include "float_settings.h"
#include "image.h"
#include "invariant.h"

namespace psim {
namespace {

using kernels::kBlock;

std::string differs(const WorldDesc& a, const WorldDesc& b) {
  const bool same = a.bounds.xmin == b.bounds.xmin && a.bounds.xmax == b.bounds.xmax && a.bounds.ymin == b.bounds.ymin &&
                    a.bounds.ymax == b.bounds.ymax && a.boundary == b.boundary;
  return same ? "" : "the saved world has other bounds or another boundary";
}

}  // namespace

// All but manifolds. `lists`: they last, and are made again.
template <class A>
void World::Impl::image(A& a, bool& lists) {
  numbers(a, frame, steps, escaped, stiff_substep, last_substep, impact_rate, list_frames, sampled_speed, crowding, loose,
          once, first_mass, first_radius, least_radius, plan_stale, lists_stale, impulses_valid, substeps, kept_contacts,
          ahead.built, ahead.waits, ahead.spoiled, ahead.horizon, saved.work, list_reach, lists);
  for (float& soft : manifold_soft) a.value(soft);
  Image::visit(a, first_surface);
  Image::visit(a, traits);
  Image::visit(a, plan);
  list(a, doubtful, [&](BodyId& id) { Image::visit(a, id); });
  list(a, held, [&](auto& h) { numbers(a, h.first, h.second.x, h.second.y); });
  list(a, bullets, [&](std::uint32_t& id) { a.value(id); });
  list(a, fixed, [&](FixedBody& f) { numbers(a, f.x, f.y, f.angle, f.radius, f.id, f.first_shape); });
  list(a, frozen, [&](BodyState& s) {
    Image::visit(a, s.id);
    numbers(a, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type);
  });
  a.vector(saved.origin);
  Image::bodies(a, bodies, lists || ahead.built);
  if constexpr (!A::kLoading) saved.dead_radii = bodies.dead_radii();
  list(a, saved.dead_radii, [&](float& r) { a.value(r); });
  Image::shapes(a, shapes);
  Image::broad(a, broad);
  Image::contacts(a, contacts);
  Image::solved(a, solved);
  Image::joints(a, joints);
  Image::sleepers(a, sleepers, bodies.id_count);
  Image::events(a, events);
  Saved& s = saved;
  list(a, s.strip_pairs, [&](std::uint32_t& n) { a.value(n); });
  list(a, s.strip_singles, [&](std::uint32_t& n) { a.value(n); });
  if (!lists || loose) {
    Image::table(a, table);
    a.vector(s.of_body);
    list(a, s.many, [&](std::uint32_t& n) { a.value(n); });
    a.vector(s.other);
    a.vector(s.s_body);
    a.vector(s.s_shape);
  }
  for (std::vector<float>* c : {&s.impulse, &s.friction, &s.gap, &s.s_impulse, &s.s_friction, &s.s_nx, &s.s_ny, &s.s_gap}) {
    a.vector(*c);
  }
}

void World::save(std::vector<std::byte>& out) {
  Impl& w = *impl_;
  using Work = Saved::Work;
  w.settle_lists();
  const bool checked = w.ahead.part != Part::check && w.ahead.part != Part::measure;
  w.saved.work = !checked ? Work::none : !w.ahead.built ? Work::checked : !w.ahead.sorted ? Work::measured : Work::sorted;
  w.saved.origin.clear();
  if (w.ahead.sorted || w.broad.has_moved_on()) w.broad.copy_origin(w.saved.origin);
  w.turn_back();
  const bool stale = w.lists_stale;
  w.lists_stale = stale || w.ahead.built;
  bool lists = !w.lists_stale && !w.once && w.bodies.count != 0 && w.bodies.dead == 0 && w.table.body_count != 0;
  w.keep_contacts(lists && !w.loose);
  if (w.plan.shapes) w.manifolds.keep_impulses(w.pool);
  Saver& saver = w.saved.saver;
  saver.clear();
  Image::visit(saver, w.desc);
  w.image(saver, lists);
  Image::manifolds(saver, w.manifolds, w.bodies.count);
  const WorkerPool::Awake awake(w.pool);
  saver.finish(out, w.pool);
  w.lists_stale = stale;
  w.turn_back();
}

// each(a number of a contact, what is kept of it): in lists that last, in their order.
template <class Each>
void World::Impl::each_lane(const Each& each) {
  Saved& s = saved;
  const auto visit = [&](Column<float>& column, std::vector<float>& kept, std::size_t lane, std::size_t at) {
    if (!kept.empty()) each(column[lane], kept[at]);
  };
  pool.run(table.strips.size(), [&](std::size_t k) {
    const Strip& strip = table.strips[k];
    std::size_t at = s.strip_pairs[k];
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p, ++at) {
      const std::size_t lane = table.contact[p];
      visit(contacts.impulse, s.impulse, lane, at);
      visit(contacts.friction, s.friction, lane, at);
      visit(contacts.gap, s.gap, lane, at);
    }
    at = s.strip_singles[k];
    for (const SinglePair& single : table.singles[k]) {
      visit(contacts.s_impulse, s.s_impulse, single.contact, at);
      visit(contacts.s_friction, s.s_friction, single.contact, at);
      visit(contacts.s_nx, s.s_nx, single.contact, at);
      visit(contacts.s_ny, s.s_ny, single.contact, at);
      visit(contacts.s_gap, s.s_gap, single.contact, at++);
    }
  });
}

// Copies what contacts carry. `lasting`: the lists will be made again, in the same order.
void World::Impl::keep_contacts(bool lasting) {
  Saved& s = saved;
  const bool rough = contacts.rough(), gaps = !sleepers.empty();
  for (std::vector<float>* c : {&s.impulse, &s.friction, &s.gap, &s.s_impulse, &s.s_friction, &s.s_nx, &s.s_ny, &s.s_gap}) {
    c->clear();
  }
  s.of_body.clear();
  for (auto* c : {&s.many, &s.other, &s.s_body, &s.s_shape, &s.strip_pairs, &s.strip_singles}) c->clear();
  if (lasting) {
    std::size_t pairs = 0, singles = 0;
    for (std::size_t k = 0; k < table.strips.size(); ++k) {
      s.strip_pairs.push_back(static_cast<std::uint32_t>(pairs));  // where it begins
      s.strip_singles.push_back(static_cast<std::uint32_t>(singles));
      pairs += table.strips[k].pair_end - table.strips[k].pair_begin;
      singles += table.singles[k].size();
    }
    for (std::vector<float>* c : {&s.impulse, &s.friction, &s.gap}) c->resize(pairs);
    for (std::vector<float>* c : {&s.s_impulse, &s.s_friction, &s.s_nx, &s.s_ny, &s.s_gap}) c->resize(singles);
    if (!rough) s.friction.clear(), s.s_friction.clear();
    if (!gaps) s.gap.clear(), s.s_gap.clear();
    each_lane([](float& lane, float& kept) { kept = lane; });
    return;
  }
  s.of_body.assign(table.body_count, 0);
  if (!impulses_valid || table.body_count == 0) {
    s.strip_pairs.assign(table.strips.size(), 0);
    s.strip_singles.assign(table.strips.size(), 0);
    return;
  }
  const bool all = gaps || !sleepers.recent.empty();  // even one without an impulse is known
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& strip = table.strips[k];
    const std::size_t before = s.other.size();
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) {
      const std::uint32_t lane = table.contact[p];
      const float impulse = contacts.impulse[lane], friction = rough ? contacts.friction[lane] : 0.0f;
      if (!all && !(impulse > 0) && friction == 0) continue;
      s.count_of(table.owner[p]);
      s.other.push_back(table.other[p]);
      s.impulse.push_back(impulse);
      if (rough) s.friction.push_back(friction);
      if (gaps) s.gap.push_back(contacts.gap[lane]);
    }
    s.strip_pairs.push_back(static_cast<std::uint32_t>(s.other.size() - before));
    s.strip_singles.push_back(static_cast<std::uint32_t>(table.singles[k].size()));
    for (const SinglePair& single : table.singles[k]) {
      const std::uint32_t lane = single.contact;
      s.s_body.push_back(single.body);
      s.s_shape.push_back(single.shape);
      s.s_impulse.push_back(contacts.s_impulse[lane]);
      s.s_nx.push_back(contacts.s_nx[lane]);
      s.s_ny.push_back(contacts.s_ny[lane]);
      if (rough) s.s_friction.push_back(contacts.s_friction[lane]);
      if (gaps) s.s_gap.push_back(contacts.s_gap[lane]);
    }
  }
}

// The saved pairs become the table that impulses are carried from.
void World::Impl::take_pairs() {
  const Saved& s = saved;
  const auto put = [](Column<float>& to, const std::vector<float>& from) {
    to.reserve(from.size() + 1);  // even of none: the column is there
    std::copy(from.begin(), from.end(), to.data());
  };
  put(contacts.impulse, s.impulse);
  put(contacts.gap, s.gap.empty() ? s.impulse : s.gap);
  put(contacts.s_impulse, s.s_impulse);
  put(contacts.s_nx, s.s_nx);
  put(contacts.s_ny, s.s_ny);
  put(contacts.s_gap, s.s_gap.empty() ? s.s_impulse : s.s_gap);
  if (contacts.rough()) {
    put(contacts.friction, s.friction);
    put(contacts.s_friction, s.s_friction);
  }
  const auto n = static_cast<std::uint32_t>(s.other.size());
  table.first.reserve(std::size_t{table.body_count} + 1);
  table.owner.reserve(n);
  table.other.reserve(n);
  table.contact.reserve(n);
  std::copy(s.other.begin(), s.other.end(), table.other.data());
  table.singles.resize(std::max(table.singles.size(), table.strips.size()));
  table.found.resize(table.singles.size());
  table.pair_room = n;
  std::uint32_t p = 0, single = 0;
  auto many = s.many.begin();
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    Strip& strip = table.strips[k];
    strip.pair_begin = p;
    strip.pair_end = p + s.strip_pairs[k];
    for (std::uint32_t i = strip.body_begin; i < strip.body_end; ++i) {
      table.first[i] = p;
      const std::uint32_t count = s.of_body[i] < Saved::kMany ? s.of_body[i] : *many++;
      for (const std::uint32_t end = p + count; p < end; ++p) {
        table.owner[p] = i;
        table.contact[p] = p;
      }
    }
    table.singles[k].clear();
    for (std::uint32_t end = single + s.strip_singles[k]; single < end; ++single) {
      table.singles[k].push_back({s.s_body[single], s.s_shape[single], single});
    }
  }
  table.first[table.body_count] = PairTable::kStripStart;
  for (const Strip& strip : table.strips) {
    if (strip.body_begin < strip.body_end) table.first[strip.body_begin] |= PairTable::kStripStart;
  }
}

bool World::restore(std::span<const std::byte> state, std::string& error) { return impl_->restore(state, error); }

bool World::Impl::restore(std::span<const std::byte> state, std::string& error) {
  error.clear();
  Loader loader(state);
  WorldDesc read;
  Image::visit(loader, read);
  error = loader.error();
  if (error.empty()) error = differs(read, desc);
  if (!error.empty()) return false;
  desc = read;
  const bool snapshots = traits.snapshots;
  saved.missing = false;
  table.body_count = old_table.body_count = 0;
  table.strips.clear();
  bool lists = false;
  image(loader, lists);
  const WorkerPool::Awake awake(pool);
  loader.finish(pool);
  traits.snapshots = plan.publish = snapshots;
  forces.reset();
  if (!plan_stale) apply_plan();
  bodies.fill_radii(first_radius, traits.same_radius != traits.moving);
  bodies.put_dead_radii(saved.dead_radii);
  if (bodies.count != 0) bodies.pad_tail();
  old_table.body_count = 0;
  contacts.give_up();
  manifolds.accept();
  ahead.sorted = ahead.swapped = ahead.spread = false;
  ahead.at = 0;
  ahead.part = saved.work == Saved::Work::checked    ? after_check()
               : saved.work == Saved::Work::measured ? Part::count
                                                     : Part::check;
  ahead.laid = ahead.built || loose;
  broad.set_origin(saved.origin);
  saved.missing = lists || saved.work == Saved::Work::sorted;
  saved.bare = true;
  saved.builds = contacts.builds();
  if (!lists || loose) take_pairs();
  // Manifolds are made anew with the lists, and then put back as they were.
  if (lists && sorts_out()) make_lists_again();
  Image::manifolds(loader, manifolds, bodies.count);
  loader.finish(pool);
  columns.forget();
  placed = true;
  queries.forget_moving();
  queries.forget_sleeping();
  queries.forget_fixed();
  error = loader.error();
  return error.empty();
}

void World::Impl::make_lists_again() {
  saved.missing = false;
  const FloatSettings settings;
  if (saved.work == Saved::Work::sorted) {
    if (!loose) {
      table.swap(old_table);
      ahead.swapped = true;
    }
    broad.build_again(bodies, shapes, kernels, pool, loose ? candidates : table);
    ahead.sorted = true;
    ahead.part = loose ? Part::select : Part::group;
    return;
  }
  if (loose) {
    broad.build_again(bodies, shapes, kernels, pool, candidates);
    return;
  }
  broad.build_again(bodies, shapes, kernels, pool, table);
  lists_stale = impulses_valid = true;
  old_table.body_count = 0;
  const Ahead now = ahead;
  ahead = {};
  ahead.part = Part::group;
  ahead.laid = true;
  StepReport ignored;
  while (ahead.part != after_contacts()) work({}, ignored, pieces());
  accept_work();
  ahead = now;
  contacts.set_builds(saved.builds);
  each_lane([](float& lane, float& kept) { lane = kept; });
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
  const auto mix = [&hash](std::uint64_t v) {
    hash = (hash ^ v) * 0xD6E8FEB86659FD93u;
    hash ^= hash >> 32;
  };
  for (; size >= 8; data += 8, size -= 8) {
    std::uint64_t v;
    std::memcpy(&v, data, 8);
    mix(v);
  }
  std::uint64_t last = 0;
  if (size != 0) std::memcpy(&last, data, size);
  mix(last);
  return hash ^ (hash >> 29);
}

}  // namespace psim
