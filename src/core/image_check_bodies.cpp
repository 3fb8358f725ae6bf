// Who is there, and what for: tables, bodies, the ids of the slots, the plan.
#include <chrono>
#include <cstring>

#include "image_check.h"

namespace psim {

namespace {

// Of ids: whether a multiset of them is another. Every id counts as a number that nobody who made the bytes knows.
struct IdSums {
  std::uint64_t sum = 0;  // dead slots count nothing
  std::uint32_t odd = 0;  // its high bit: some are none
};

// (id + first) (id ^ second) in 64 bits: what every x86-64 does several at a time.
struct Key {
  std::uint32_t first, second;
};

Key key_of_process() {
  static const Key key = [] {
    static const char here = 0;
    const auto now = static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
    const std::uint64_t seed[2] = {now, reinterpret_cast<std::uintptr_t>(&here)};
    const std::uint64_t hash = hash_of(reinterpret_cast<const std::byte*>(seed), sizeof seed);
    return Key{static_cast<std::uint32_t>(hash), static_cast<std::uint32_t>(hash >> 32)};
  }();
  return key;
}

IdSums sum_of_slots(const std::byte* from, std::size_t n, std::uint32_t ids) {
  const Key key = key_of_process();
  std::uint64_t sum = 0;
  std::uint32_t odd = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::uint32_t id;
    std::memcpy(&id, from + 4 * k, sizeof id);
    const std::uint32_t there = id != kNoSlot ? ~0u : 0u;
    sum += std::uint64_t{(id + key.first) & there} * (id ^ key.second);
    odd |= (id | (ids - 1 - id)) & there;
  }
  return {sum, odd};
}

std::uint64_t sum_of_run(std::uint32_t first, std::uint32_t n) {
  const Key key = key_of_process();
  std::uint64_t sum = 0;
  std::uint32_t plus = first + key.first, number = first;
  for (std::uint32_t k = 0; k < n; ++k, ++plus, ++number) sum += std::uint64_t{plus} * (number ^ key.second);
  return sum;
}

}  // namespace

template <class W>
void Image::Check<W>::tables() {
  const BodyStore& b = w.bodies;
  for (const SurfaceTable::Entry& e : b.surfaces.list_) {
    const Surface& s = e.surface;
    require(s.inv_mass >= 0 && s.mass >= 0 && s.spin_gain >= 0 && s.radius >= 0 && s.restitution >= 0 &&
            s.restitution <= 1 && s.friction >= 0 && s.make < b.makes.list_.size());
  }
  require(!b.makes.list_.empty() && b.makes.list_[0].make == Make{});
  require(!b.hulls.hulls_.empty() && b.makes.last_ < b.makes.list_.size());
  const std::vector<Hull>& hulls = b.hulls.hulls_;
  for (std::size_t k = 1; k < hulls.size() && ok(); ++k) hull(hulls[k]);
  std::vector<std::uint8_t> taken(hulls.size());
  for (const ShapeTable::Set& s : b.hulls.sets_) {
    require(s.first >= 1 && s.count >= 1 && s.first < hulls.size() && s.count <= hulls.size() - s.first);
    for (U32 k = s.first; ok() && k < s.first + s.count; ++k) require(taken[k]++ == 0);
  }
  for (const MakeTable::Entry& e : b.makes.list_) {
    if (e.make.hull_count == 0) require(e.make.first_hull == 0);
    require(e.make.inner >= 0);
  }
}

template <class W>
void Image::Check<W>::roster() {
  const BodyStore& b = w.bodies;
  same_roster = !now.bodies.roster_changed && b.roster == now.bodies.roster;
  std::uint64_t id = 0, kinematic = 0;
  std::vector<std::uint64_t> surface_users(b.surfaces.list_.size()), make_users(b.makes.list_.size());
  std::vector<std::uint64_t> hull_users(b.hulls.hulls_.size());  // by first hull
  for (const AlikeBodies& run : b.roster) {
    first_of_run.push_back(static_cast<U32>(id));
    id += run.count;
    require(run.count != 0 && id <= ids());
    of_place[static_cast<std::size_t>(run.place)] += run.count;
    require(run.surface < surface_users.size() || (run.place == Place::none && run.surface == 0));
    if (!ok()) return;
    if (run.place == Place::none) continue;
    const Surface& s = b.surfaces[run.surface];
    surface_users[run.surface] += run.count;
    make_users[s.make] += run.count;
    const Make& make = b.makes[s.make];
    if (make.hull_count != 0) {
      require(make.first_hull < hull_users.size());
      if (!ok()) return;
      hull_users[make.first_hull] += run.count;
    }
    require((run.place == Place::fixed) == (s.type == BodyType::static_body));
    if (run.place == Place::moving || run.place == Place::asleep) {
      require(s.radius > 0 && (s.type == BodyType::dynamic_body ? s.mass > 0 : s.inv_mass == 0));
      if (s.type == BodyType::kinematic_body) kinematic += run.count;
    }
  }
  require(id == ids());
  if (!ok()) return;
  for (std::size_t k = 0; k < surface_users.size(); ++k) require(surface_users[k] == b.surfaces.list_[k].users);
  for (std::size_t k = 1; k < make_users.size(); ++k) require(make_users[k] == b.makes.list_[k].users);
  for (const ShapeTable::Set& s : b.hulls.sets_) {
    require(hull_users[s.first] == s.users);
    hull_users[s.first] = 0;
  }
  for (const std::uint64_t users : hull_users) require(users == 0);  // of no set
  for (std::size_t k = 1; k < make_users.size(); ++k) {
    const Make& make = b.makes.list_[k].make;
    if (make_users[k] == 0 || make.hull_count == 0) continue;
    require(std::any_of(b.hulls.sets_.begin(), b.hulls.sets_.end(), [&](const ShapeTable::Set& s) {
      return s.first == make.first_hull && s.count == make.hull_count;
    }));
  }
  free_list(b.surfaces.free_, surface_users.size(), 0, [&](std::size_t k) { return surface_users[k] == 0; });
  free_list(b.makes.free_, make_users.size(), 1, [&](std::size_t k) { return make_users[k] == 0; });
  free_list(b.hulls.free_, b.hulls.sets_.size(), 0, [&](std::size_t k) { return b.hulls.sets_[k].users == 0; });
  const auto count = [&](Place place) { return of_place[static_cast<std::size_t>(place)]; };
  require(b.dead <= b.count && count(Place::moving) == b.count - b.dead);
  require(count(Place::fixed) == b.fixed && count(Place::fixed) == w.fixed.size());
  require(count(Place::frozen) == w.frozen.size() && count(Place::none) == b.free_ids.size());
  require(count(Place::asleep) == b.asleep);
  require(b.moving == count(Place::moving) + b.asleep && b.living == ids() - b.free_ids.size());
  require(b.kinematic == 0 || b.kinematic == kinematic);
  if (!ok() || b.free_ids.empty()) return;
  std::vector<std::uint8_t> seen(ids());
  for (const U32 k : b.free_ids) require(k < ids() && place_of(k) == Place::none && seen[k]++ == 0);
}

// Ids of the slots: each body that moves is there once.
template <class W>
void Image::Check<W>::columns() {
  slot_ids = a.seen(w.bodies.id, slots());
  const IdSums found = sum_of_slots(slot_ids.from, slots(), ids());
  std::optional<std::uint64_t>& wanted = w.bodies.roster_sum;
  wanted = same_roster ? now.bodies.roster_sum : std::nullopt;
  if (!wanted) {
    wanted = 0;
    U32 id = 0;
    for (const AlikeBodies& run : w.bodies.roster) {
      if (run.place == Place::moving) *wanted += sum_of_run(id, run.count);
      id += run.count;
    }
  }
  require(ids() < 1u << 31 && (found.odd >> 31) == 0 && found.sum == *wanted);
}

template <class W>
void Image::Check<W>::others() {
  listed(Place::fixed, w.fixed, [](const FixedBody& f) { return f.id; });
  listed(Place::frozen, w.frozen, [](const BodyState& s) { return s.id.index; });
  for (const BodyId& id : w.doubtful) require(id.index < ids());
  for (const auto& h : w.held) {
    require(place_of(h.first) == Place::moving && surface_of(h.first).type == BodyType::kinematic_body);
  }
  for (const U32 id : w.bullets) {
    const Place place = place_of(id);
    require((place == Place::moving || place == Place::asleep) && make_of(id).bullet);
  }
  for (const Saved::Done& d : w.saved.done) require(d.span > 0 || place_of(d.id) == Place::moving);
  for (const FixedBody& f : w.fixed) require(f.first_shape <= w.shapes.count_ && f.radius >= 0);
}

// What the plan follows from, and what it asks for. What is looked up when a plan is made stays as it was.
template <class W>
void Image::Check<W>::traits() {
  Traits t = w.traits;
  for (std::uint64_t* counter : {&t.moving, &t.discs, &t.held_discs, &t.rough_discs, &t.same_mass, &t.same_radius,
                                 &t.same_surface, &t.moving_bounce, &t.moving_rough, &t.kinematic, &t.odd_gravity, &t.fixed,
                                 &t.fixed_bounce, &t.fixed_rough, &t.cornered, &t.filtered, &t.sensors, &t.bullets}) {
    *counter = 0;
  }
  for (const AlikeBodies& run : w.bodies.roster) {
    if (run.place != Place::moving && run.place != Place::asleep && run.place != Place::fixed) continue;
    const Surface& s = w.bodies.surfaces[run.surface];
    const Make& make = w.bodies.makes[s.make];
    const auto add = [&](std::uint64_t& counter, bool yes) { counter += yes ? run.count : 0; };
    add(t.sensors, make.sensor);
    add(t.filtered, make.filter != Filter{});
    if (run.place == Place::fixed) {
      add(t.fixed, true);
      add(t.fixed_bounce, s.restitution > 0);
      add(t.fixed_rough, s.friction > 0);
      continue;
    }
    const bool disc = make.hull_count == 0, held = s.type == BodyType::kinematic_body;
    add(t.moving, true);
    add(t.discs, disc);
    add(t.cornered, !disc);
    add(t.held_discs, disc && held);
    add(t.rough_discs, disc && s.friction > 0);
    add(t.same_mass, disc && s.mass == w.first_mass);
    add(t.same_radius, s.radius == w.first_radius);
    add(t.same_surface, disc && s.mass == w.first_mass && s.restitution == w.first_surface.restitution &&
                            s.friction == w.first_surface.friction && s.spin_gain == w.first_surface.spin_gain);
    add(t.moving_bounce, s.restitution > 0);
    add(t.moving_rough, s.friction > 0);
    add(t.kinematic, held);
    add(t.odd_gravity, !held && s.gravity_scale != 1);
    add(t.bullets, make.bullet);
  }
  t.joints = w.joints.count_;
  t.fields = needs_forces(w.desc.fields);
  t.integrator = w.desc.integrator;
  t.walls = w.desc.boundary == Boundary::walls;
  require(t == w.traits);
  require(!w.plan.rotation || slots() == 0 || a.seen(w.bodies.spin, slots()).from != nullptr);
  if (w.plan_stale) return;
  Plan wanted = make_plan(w.traits);
  wanted.publish = w.plan.publish;
  wanted.events = w.plan.events;
  require(wanted == w.plan);
  require(w.contacts.model_ == w.plan.model || w.lists_stale);
}

template void Image::Check<World::Impl>::tables();
template void Image::Check<World::Impl>::roster();
template void Image::Check<World::Impl>::columns();
template void Image::Check<World::Impl>::others();
template void Image::Check<World::Impl>::traits();

}  // namespace psim
