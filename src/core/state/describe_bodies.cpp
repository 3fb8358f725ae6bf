// Who is there: the tables of what bodies share, bodies by id, the columns of those that move, the lists of those that
// do not.
#include <algorithm>
#include <cmath>
#include <span>

#include "psim/limits.h"
#include "state/describe.h"

namespace psim {
template <class T, std::uint32_t kMost, std::size_t kSearched>
template <class Sound>
void SharedTable<T, kMost, kSearched>::describe(Archive& a, std::size_t first, const Sound& sound) {
  a.list(list_, [&](Entry& e) {
    values(a, e.value, e.users);
    a.require(sound(e.value, e.users));
  });
  describe_free(a, free_, first, list_.size(), [&](std::size_t k) { return list_[k].users == 0; });
  a.index(std::max<std::size_t>(list_.size(), 1), last_);
}

template <class T>
bool SharedRuns<T>::has(std::uint32_t first, std::uint32_t count) const {
  const std::uint32_t k = index_of(first);
  return k < runs_.size() && runs_[k].first == first && runs_[k].count == count && runs_[k].users != 0;
}

// Nobody has the hull of number 0: only others have vertices.
static bool is_whole(const Hull& hull) { return hull.count >= 1; }
static bool is_whole(const PartProperties&) { return true; }

template <class T>
void SharedRuns<T>::describe(Archive& a) {
  values(a, all_);
  a.require(!all_.empty());
  a.list(runs_, [&](Run& r) {
    values(a, r.first, r.count, r.users);
    a.require(r.first >= 1 && r.count >= 1 && r.first < all_.size() && r.count <= all_.size() - r.first);
  });
  describe_free(a, free_, 0, runs_.size(), [&](std::size_t k) { return runs_[k].users == 0; });
  if (!a.loading()) return;
  ++changes_;
  by_hash_.clear();
  std::uint32_t end = 1;  // of the runs before
  for (std::uint32_t k = 0; k < runs_.size() && a.ok(); ++k) {
    const Run& r = runs_[k];
    a.require(r.first >= end);
    end = r.first + r.count;
    for (std::uint32_t n = r.first; n < end; ++n) a.require(is_whole(all_[n]));
    if (r.users == 0 || !a.ok()) continue;
    by_hash_.emplace(hash(std::span(all_).subspan(r.first, r.count)), k);
  }
}

template <class T>
bool SharedRuns<T>::used_as(const std::vector<std::uint64_t>& users_of_first) const {
  return std::all_of(runs_.begin(), runs_.end(), [&](const Run& r) { return users_of_first[r.first] == r.users; });
}

namespace {

// By id: what a body is. Where it is, the slots and the lists of those that do not move say (put).
void describe_ids(Archive& a, BodyStore& b) {
  const std::uint32_t ids = b.id_count;
  std::size_t unused = 0;
  values(a, b.id_count, unused);
  if (a.loading()) {
    if (!a.fits(b.id_count)) b.id_count = 0;
    b.info.reserve(b.id_count);
    std::fill_n(b.info.data(), std::max(ids, b.id_count), BodyInfo{});  // as if never used
  }
  const std::span known(b.info.data(), b.id_count);
  columns(a, known, &BodyInfo::place, &BodyInfo::generation, &BodyInfo::properties);
  const auto retired = [](const BodyInfo& i) { return i.place == Place::none && i.generation == kLastGeneration; };
  describe_free(a, b.free_ids, 0, b.id_count,
                [&](std::size_t k) { return known[k].place == Place::none && !retired(known[k]); });
  for (const BodyInfo& i : known) a.require(i.generation != kLastGeneration || i.place == Place::none);
  if (a.loading()) b.retired = static_cast<std::uint32_t>(std::ranges::count_if(known, retired));
}

void describe_slots(Archive& a, BodyStore& b, bool lists) {
  // Some worlds alone have these.
  bool turns = !b.rim_speed.empty(), remainders = !b.vel_remainder.empty(), offsets = !b.disp_remainder.empty();
  values(a, b.count, b.listed, turns, remainders, offsets);
  a.require(b.listed <= b.count);
  if (a.loading()) {
    if (!a.fits(b.count) || !a.ok()) b.count = b.listed = 0;
    b.reserve_slots(1);  // even of none: columns that the plan wants are there
    b.keep_rotation(turns);
    b.keep_remainders(remainders, remainders && offsets);
  }
  const std::size_t n = b.count;
  a.plain(b.pos, 2 * n);
  a.plain(b.vel, 2 * n);
  a.plain(b.disp, 2 * n);
  a.packed(b.id, n);
  a.packed(b.radius, n);
  if (turns) {
    a.plain(b.rim_speed, n);
    a.plain(b.angle, n);
  }
  if (remainders) a.plain(b.vel_remainder, 2 * n);
  if (remainders && offsets) a.plain(b.disp_remainder, 2 * n);
  if (lists) {
    a.plain(b.built, 2 * n);
    a.plain(b.reach, n);
  }
  if (!a.loading()) return;
  b.dead = 0;
  for (std::uint32_t slot = 0; slot < n && a.ok(); ++slot) {
    const bool dead = b.id[slot] == kNoSlot;
    b.dead += dead;
    a.require(b.radius[slot] >= 0 && (dead || put(b, b.id[slot], Place::moving, slot)));
  }
  a.require(b.count - b.dead == count_of(b, Place::moving));
  b.slots_stale = false;
}

// What bodies share is used by as many as it says.
void check_users(Archive& a, const BodyStore& b) {
  std::vector<std::uint64_t> of_properties(b.property_table.size()), of_kind(b.kinds.size());
  for (std::uint32_t k = 0; k < b.id_count && a.ok(); ++k) {
    const Place place = b.info[k].place;
    if (place == Place::none) continue;
    a.require(b.info[k].properties < of_properties.size());
    if (!a.ok()) return;
    ++of_properties[b.info[k].properties];
    const BodyProperties& s = b.properties(k);
    if (place != Place::disabled) a.require((place == Place::fixed) == (s.type() == BodyType::static_body));
    if (place != Place::moving && place != Place::asleep) continue;
    a.require(place != Place::moving || b.radius[b.info[k].slot] == s.radius);
    a.require(s.radius > 0 && (s.type() == BodyType::dynamic_body ? s.mass > 0 : s.inv_mass == 0));
  }
  for (std::uint32_t k = 0; k < of_properties.size() && a.ok(); ++k) {
    a.require(of_properties[k] == b.property_table.users(k));
    of_kind[b.property_table[k].kind] += of_properties[k];
  }
  std::vector<std::uint64_t> of_hull(b.hulls.size()), of_part(b.parts.size());
  for (std::uint32_t k = 1; k < of_kind.size() && a.ok(); ++k) {
    a.require(of_kind[k] == b.kinds.users(k));
    if (of_kind[k] == 0) continue;
    of_hull[b.kinds[k].first_hull] += of_kind[k];
    of_part[b.kinds[k].first_part] += of_kind[k];
  }
  a.require(a.ok() && b.hulls.used_as(of_hull) && b.parts.used_as(of_part));
}

void describe_bodies(Archive& a, BodyStore& b, bool lists) {
  b.hulls.describe(a);
  b.parts.describe(a);
  b.kinds.describe(a, 1, [&](const BodyKind& k, std::uint32_t users) {
    if (!(k.inner >= 0)) return false;
    const bool hulls = k.hull_count != 0, parts = k.part_count != 0;
    if (hulls != (k.first_hull != 0) || parts != (k.first_part != 0)) return false;
    if (users == 0) return true;
    if (hulls && !b.hulls.has(k.first_hull, k.hull_count)) return false;
    for (std::uint32_t n = 0; n < k.hull_count; ++n) {
      if (b.hulls[k.first_hull + n].count == 0) return false;  // the entry that stands for no hull
    }
    return !parts || (k.part_count >= k.hull_count && b.parts.has(k.first_part, k.part_count));
  });
  a.require(b.kinds.size() != 0 && b.kinds[0] == BodyKind{});
  a.refuse_nan(true);  // a mass or a gravity scale beyond what a float holds is infinite
  b.property_table.describe(a, 0, [&](const BodyProperties& p, std::uint32_t) {
    return p.kind < b.kinds.size() && p.radius >= 0 && std::isfinite(p.radius);
  });
  a.refuse_nan(true, true);
  describe_ids(a, b);
  describe_slots(a, b, lists);
  if (a.loading()) check_users(a, b);
}

}  // namespace

static void describe_disabled(Archive& a, Population& p) {
  BodyStore& bodies = p.bodies;
  std::size_t at = 0, hidden = 0;
  a.list(p.disabled, [&](DisabledBody& d) {
    values(a, d.last, d.linear_damping, d.angular_damping, d.first_shape, d.pieces);
    const std::uint32_t id = d.last.id.index;
    if (a.loading()) a.require(put(bodies, id, Place::disabled, at++));
    if (!a.ok()) return;
    const bool fixed = bodies.properties(id).type() == BodyType::static_body;
    a.require(d.last.type == bodies.properties(id).type() && d.last.id.generation == bodies.info[id].generation);
    a.require(d.linear_damping >= 0 && d.angular_damping >= 0);
    a.require((fixed || d.pieces == 0) && p.statics.hides(d.first_shape, d.pieces, id));
    hidden += d.pieces;
  });
  a.require(hidden == p.statics.hidden());
  a.list(p.user_values.entries(), [&](UserValue& u) {
    a.index(bodies.id_count, u.id);
    values(a, u.value);
    a.require(a.ok() && bodies.info[u.id].place != Place::none);
  });
  if (a.loading()) a.require(p.user_values.index());
}

void describe_population(Archive& a, Population& p, bool lists) {
  BodyStore& bodies = p.bodies;
  values(a, p.traits_changed, p.first_properties.mass, p.first_radius, p.least_radius, p.first_properties);
  a.require(p.first_radius >= 0 && p.least_radius >= 0);
  a.refuse_nan(true, true);
  describe_bodies(a, bodies, lists);
  std::size_t at = 0;
  a.list(p.fixed, [&](FixedBody& f) {
    values(a, f);
    if (a.loading()) a.require(f.radius >= 0 && put(bodies, f.id, Place::fixed, at++));
  });
  p.statics.describe(a, bodies);
  describe_disabled(a, p);
  a.refuse_nan(false);
  for (const FixedBody& f : p.fixed) a.require(f.first_shape <= p.statics.size());
  at = 0;
  a.list(p.frozen, [&](BodyState& s) {
    values(a, s);
    if (a.loading()) a.require(put(bodies, s.id.index, Place::frozen, at++));
  });
  a.list(p.kinematics.entries(), [&](KinematicBody& k) {
    a.index(bodies.id_count, k.id);
    values(a, k.velocity);
    a.require(a.ok() && bodies.info[k.id].place == Place::moving &&
              bodies.properties(k.id).type() == BodyType::kinematic_body);
  });
  a.list(p.bullets.entries(), [&](Bullet& b) {
    a.index(bodies.id_count, b.id);
    const bool moves = a.ok() && (bodies.info[b.id].place == Place::moving || bodies.info[b.id].place == Place::asleep);
    a.require(moves && bodies.kind(b.id).bullet);
  });
  a.list(p.restraints.entries(), [&](Restraint& r) {
    a.index(bodies.id_count, r.id);
    values(a, r.linear_damping, r.angular_damping, r.locks);
    const bool moves = a.ok() && (bodies.info[r.id].place == Place::moving || bodies.info[r.id].place == Place::asleep);
    a.require(moves && bodies.kind(r.id).restrained && r.linear_damping >= 0 && r.angular_damping >= 0);
  });
  constexpr Range kPush{-1e60, 1e60};  // many calls of the largest force add up
  a.list(p.applied.entries(), [&](AppliedForce& f) {
    a.index(bodies.id_count, f.id);
    values(a, f.force, f.torque, f.impulse, f.spin);
    a.require(kPush.contains(f.force) && kPush.contains(f.torque) && kPush.contains(f.impulse) &&
              kPush.contains(f.spin));
    a.require(a.ok() && bodies.info[f.id].place == Place::moving);
  });
  if (a.loading()) a.require(p.kinematics.index() && p.bullets.index() && p.restraints.index() && p.applied.index());
}

}  // namespace psim
