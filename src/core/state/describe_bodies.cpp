// Who is there: the tables of what bodies share, bodies by id, the columns of those that move, and the lists of those
// that do not.
#include "bodies/population.h"
#include "state/describe.h"

namespace psim {

template <class A>
void BodyPropertyTable::describe(A& a, std::size_t kinds) {
  a.list(list_, [&](Entry& e) {
    visit(a, e.value);
    a.value(e.users);
    a.require(e.value.kind < kinds);
  });
  describe_free(a, free_, 0, list_.size(), [&](std::size_t k) { return list_[k].users == 0; });
  a.value(last_);
}

template <class A>
void BodyKindTable::describe(A& a, const ShapeTable& hulls) {
  a.list(list_, [&](Entry& e) {
    BodyKind& k = e.value;
    numbers(a, k.first_hull, k.hull_count, k.centre_x, k.centre_y, k.inner, k.filter.category, k.filter.mask,
            k.filter.group, k.bullet, k.sensor, e.users);
    a.require(k.inner >= 0 && (k.hull_count == 0 ? k.first_hull == 0 : e.users == 0 || hulls.has(k)));
  });
  describe_free(a, free_, 1, list_.size(), [&](std::size_t k) { return list_[k].users == 0; });
  a.value(last_);
  a.require(!list_.empty() && list_[0].value == BodyKind{} && last_ < list_.size());
}

bool ShapeTable::has(const BodyKind& kind) const {
  const auto found = by_first_.find(kind.first_hull);
  return found != by_first_.end() && sets_[found->second].count == kind.hull_count;
}

template <class A>
void ShapeTable::describe(A& a) {
  a.list(hulls_, [&](Hull& hull) { visit(a, hull); });
  a.require(!hulls_.empty());
  a.list(sets_, [&](Set& s) {
    numbers(a, s.first, s.count, s.users);
    a.require(s.first >= 1 && s.count >= 1 && s.first < hulls_.size() && s.count <= hulls_.size() - s.first);
  });
  describe_free(a, free_, 0, sets_.size(), [&](std::size_t k) { return sets_[k].users == 0; });
  if constexpr (!A::kLoading) return;
  by_hash_.clear();
  by_first_.clear();
  std::vector<std::uint8_t> taken(hulls_.size());
  for (std::uint32_t k = 0; k < sets_.size() && a.ok(); ++k) {
    const Set& s = sets_[k];
    for (std::uint32_t h = s.first; h < s.first + s.count; ++h) a.require(hulls_[h].count >= 1 && taken[h]++ == 0);
    if (s.users == 0 || !a.ok()) continue;
    const auto first = hulls_.begin() + s.first;
    by_hash_.emplace(hash({first, first + s.count}), k);
    by_first_[s.first] = k;
  }
}

template <class A>
void BodyStore::describe(A& a, bool lists) {
  hulls.describe(a);
  kinds.describe(a, hulls);
  property_table.describe(a, kinds.size());
  describe_ids(a);
  describe_slots(a, lists);
  if constexpr (A::kLoading) check_users(a);
}

// By id: what a body is. Where it is, the slots and the lists of those that do not move say (put).
template <class A>
void BodyStore::describe_ids(A& a) {
  const std::uint32_t ids = id_count;
  numbers(a, id_count, kinematic);
  if constexpr (A::kLoading) {
    if (!a.fits(id_count)) id_count = 0;
    info.reserve(id_count);
    for (std::uint32_t k = 0; k < std::max(ids, id_count); ++k) info[k] = BodyInfo{};  // as if never used
  }
  a.packed(id_count, [&](std::size_t k) -> Place& { return info[k].place; });
  a.packed(id_count, [&](std::size_t k) -> std::uint32_t& { return info[k].generation; });
  a.packed(id_count, [&](std::size_t k) -> std::uint32_t& { return info[k].properties; });
  describe_free(a, free_ids, 0, id_count, [&](std::size_t k) { return info[k].place == Place::none; });
  if constexpr (A::kLoading) {
    const auto count_of = [&](Place place) {
      std::size_t n = 0;
      for (std::uint32_t k = 0; k < id_count; ++k) n += info[k].place == place;
      return n;
    };
    fixed = count_of(Place::fixed);
    asleep = count_of(Place::asleep);
    moving = count_of(Place::moving) + asleep;
    living = id_count - free_ids.size();
  }
}

template <class A>
void BodyStore::describe_slots(A& a, bool lists) {
  // Some worlds alone have these.
  bool turns = !rim_speed.empty(), remainders = !vel_remainder.empty(), offsets = !disp_remainder.empty();
  numbers(a, count, turns, remainders, offsets);
  if constexpr (A::kLoading) {
    if (!a.fits(count)) count = 0;
    reserve_slots(1);  // even of none: columns that the plan wants are there
    if (turns) add_rotation();
    if (remainders) add_remainders(offsets);
    if (!remainders) vel_remainder.release();
    if (!offsets) disp_remainder.release();
    if (!turns) drop_rotation();
  }
  const std::size_t n = count;
  a.plain(pos, 2 * n);
  a.plain(vel, 2 * n);
  a.plain(disp, 2 * n);
  a.packed(n, [&](std::size_t k) -> std::uint32_t& { return id[k]; });
  a.packed(n, [&](std::size_t k) -> float& { return radius[k]; });
  if (turns) {
    a.plain(rim_speed, n);
    a.plain(angle, n);
  }
  if (remainders) a.plain(vel_remainder, 2 * n);
  if (remainders && offsets) a.plain(disp_remainder, 2 * n);
  if (lists) {
    a.plain(built, 2 * n);
    a.plain(reach, n);
  }
  if constexpr (A::kLoading) {
    dead = 0;
    std::uint32_t slot = 0;
    for (; slot < count && a.ok(); ++slot) {
      a.require(radius[slot] >= 0);
      if (id[slot] == kNoSlot) {
        ++dead;
      } else {
        a.require(put(id[slot], Place::moving, slot));
      }
    }
    a.require(count - dead == moving - asleep);
    slots_stale = false;
  }
}

/// The body is the `at`-th of those at a place. False if it is not of them, or is there already.
bool BodyStore::put(std::uint32_t body, Place place, std::size_t at) {
  if (body >= id_count || info[body].place != place || info[body].slot != kNoSlot) return false;
  info[body].slot = static_cast<std::uint32_t>(at);
  return true;
}

// What bodies share is used by as many as it says.
template <class A>
void BodyStore::check_users(A& a) const {
  std::vector<std::uint64_t> of_properties(property_table.size()), of_kind(kinds.size());
  for (std::uint32_t k = 0; k < id_count && a.ok(); ++k) {
    const Place place = info[k].place;
    if (place == Place::none) continue;
    a.require(info[k].properties < of_properties.size());
    if (!a.ok()) return;
    ++of_properties[info[k].properties];
    const BodyProperties& s = properties(k);
    a.require((place == Place::fixed) == (s.type == BodyType::static_body));
    if (place != Place::moving && place != Place::asleep) continue;
    a.require(s.radius > 0 && (s.type == BodyType::dynamic_body ? s.mass > 0 : s.inv_mass == 0));
  }
  for (std::uint32_t k = 0; k < of_properties.size() && a.ok(); ++k) {
    a.require(of_properties[k] == property_table.users(k));
    of_kind[property_table[k].kind] += of_properties[k];
  }
  std::vector<std::uint64_t> of_hull(hulls.size());
  for (std::uint32_t k = 1; k < of_kind.size() && a.ok(); ++k) {
    a.require(of_kind[k] == kinds.users(k));
    if (of_kind[k] != 0) of_hull[kinds[k].first_hull] += of_kind[k];
  }
  a.require(a.ok() && hulls.used_as(of_hull));
}

bool ShapeTable::used_as(const std::vector<std::uint64_t>& users_of_first) const {
  return std::all_of(sets_.begin(), sets_.end(), [&](const Set& s) { return users_of_first[s.first] == s.users; });
}

template <class A>
void Population::describe(A& a, bool lists) {
  numbers(a, first_mass, first_radius, least_radius);
  a.require(first_radius >= 0 && least_radius >= 0);
  visit(a, first_properties);
  a.refuse_nan(true);
  bodies.describe(a, lists);
  std::size_t at = 0;
  a.list(fixed, [&](FixedBody& f) {
    numbers(a, f.x, f.y, f.angle, f.radius, f.id, f.first_shape);
    if constexpr (A::kLoading) a.require(f.radius >= 0 && bodies.put(f.id, Place::fixed, at++));
  });
  statics.describe(a, bodies);
  a.refuse_nan(false);
  for (const FixedBody& f : fixed) a.require(f.first_shape <= statics.size());
  at = 0;
  a.list(frozen, [&](BodyState& s) {
    visit(a, s.id);
    numbers(a, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type);
    if constexpr (A::kLoading) a.require(bodies.put(s.id.index, Place::frozen, at++));
  });
  a.list(kinematics, [&](auto& k) {
    a.index(bodies.id_count, k.first);
    numbers(a, k.second.x, k.second.y);
    a.require(a.ok() && bodies.info[k.first].place == Place::moving &&
              bodies.properties(k.first).type == BodyType::kinematic_body);
  });
  a.list(bullets, [&](std::uint32_t& id) {
    a.index(bodies.id_count, id);
    const bool moves = a.ok() && (bodies.info[id].place == Place::moving || bodies.info[id].place == Place::asleep);
    a.require(moves && bodies.kind(id).bullet);
  });
}

PSIM_DESCRIBED(Population, bool);

}  // namespace psim
