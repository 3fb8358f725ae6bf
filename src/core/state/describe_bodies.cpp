// Who is there: the tables of what bodies share, bodies by id, the columns of those that move, the lists of those that
// do not, fixed geometry, and the bodies that sleep, which are part of it meanwhile.
#include <algorithm>
#include <span>

#include "sleep/sleepers.h"
#include "state/describe.h"

namespace psim {
namespace {

std::size_t count_of(const BodyStore& b, Place place) {
  const auto is_there = [place](const BodyInfo& info) { return info.place == place; };
  return static_cast<std::size_t>(std::count_if(b.info.data(), b.info.data() + b.id_count, is_there));
}

}  // namespace

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

// Makes a body that is read the `at`-th of those at a place. False if it is not of them, or is there already.
bool put(BodyStore& b, std::uint32_t body, Place place, std::size_t at) {
  if (body >= b.id_count || b.info[body].place != place || b.info[body].slot != kNoSlot) return false;
  b.info[body].slot = static_cast<std::uint32_t>(at);
  return true;
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
  b.property_table.describe(a, 0, [&](const BodyProperties& p, std::uint32_t) { return p.kind < b.kinds.size(); });
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
  if (a.loading()) a.require(p.kinematics.index() && p.bullets.index() && p.restraints.index());
}

// ---- fixed geometry, and bodies that sleep

// Bit-fields, as a column of bytes.
static void describe_flags(Archive& a, std::span<StaticShape> shapes) {
  std::vector<std::uint8_t> bits;
  for (const StaticShape& s : shapes) {
    bits.push_back(static_cast<std::uint8_t>(s.segment | s.face << 1 | s.whole << 2 | s.alive << 3 | s.asleep << 4 |
                                             s.lone << 5 | s.special << 6 | s.hidden << 7));
  }
  a.packed(bits, 1 << 8);
  a.require(bits.size() == shapes.size());
  for (std::size_t k = 0; k < shapes.size() && a.ok(); ++k) {
    const auto bit = [&](int n) { return (bits[k] >> n & 1) != 0; };
    StaticShape& s = shapes[k];
    s.segment = bit(0), s.face = bit(1), s.whole = bit(2), s.alive = bit(3), s.asleep = bit(4), s.lone = bit(5);
    s.special = bit(6), s.hidden = bit(7);
  }
}

// A plain disc that sleeps is not written here: its Sleeper and its properties say all.
void StaticShapes::describe(Archive& a, const BodyStore& bodies) {
  values(a, count_, listed_, whole_wanted_, dirty_);
  a.require(listed_ <= count_);
  values(a, hulls_);
  if (a.loading()) {
    if (!a.fits(count_)) count_ = 0;
    statics_.reserve(count_);
    std::fill_n(statics_.data(), count_, StaticShape{});
  }
  using S = StaticShape;
  describe_flags(a, std::span(statics_.data(), count_));
  std::vector<std::uint32_t> told;
  for (std::uint32_t k = 0; k < count_; ++k) {
    if (statics_[k].alive && statics_[k].lone) {
      if (a.loading()) statics_[k].owner = kNoSlot;  // until its sleeper is there
    } else {
      told.push_back(k);
    }
  }
  const Mapped shapes{told, [&](std::uint32_t k) -> S& { return statics_[k]; }};
  lattice_points(a, Mapped{shapes, &S::p});
  lattice_points(a, Mapped{shapes, &S::q});
  columns(a, shapes, &S::radius, &S::restitution, &S::friction, &S::owner, &S::hull, &S::part);
  for (auto& runs : runs_) a.packed(runs, std::uint64_t{count_} + 1);
  for (std::vector<Run>* runs : {&gaps_, &left_, &gone_}) {
    a.list(*runs, [&](Run& run) { a.index(std::uint64_t{count_} + 1, run.first, run.second); });
  }
  std::vector<std::uint8_t> hull_used(hulls_.size());
  if (a.loading()) {
    alive_ = count_ - told.size();
    for (const std::uint32_t k : told) {
      const S& s = statics_[k];
      a.require(s.owner < bodies.id_count && !(s.alive && s.hidden));
      if (!a.ok() || !(s.alive || s.hidden)) continue;
      alive_ += s.alive;
      a.require(s.radius >= 0 && s.radius < 1e30f);
      const Place place = s.hidden ? Place::disabled : (s.asleep ? Place::asleep : Place::fixed);
      a.require(bodies.info[s.owner].place == place);
      const BodyKind& kind = bodies.kind(s.owner);
      a.require(kind.first_part == 0 || s.part < kind.part_count);
      a.require(!s.whole || (s.hull < hulls_.size() && hulls_[s.hull].count != 0 && hull_used[s.hull]++ == 0));
    }
    check_runs(a);
  }
  describe_free(a, free_hulls_, 0, hulls_.size(), [&](std::size_t k) { return hull_used[k] == 0; });
}

// Numbers that nobody has, by run: each once.
void StaticShapes::check_runs(Archive& a) const {
  std::vector<std::uint8_t> taken(count_);
  const auto run = [&](std::uint32_t first, std::uint32_t length) {
    a.require(a.ok() && length <= count_ && first <= count_ - length);
    for (std::uint32_t k = first; a.ok() && k < first + length; ++k)
      a.require(!statics_[k].alive && !statics_[k].hidden && taken[k]++ == 0);
  };
  for (std::uint32_t length = 0; length <= kLongestRun; ++length) {
    for (const std::uint32_t first : runs_[length]) run(first, length);
  }
  for (const std::vector<Run>* runs : {&gaps_, &left_, &gone_}) {
    for (const auto& [first, length] : *runs) run(first, length);
  }
}

bool StaticShapes::lay_sleeper(std::uint32_t owner, std::uint32_t first, std::uint32_t pieces,
                               const StaticShape* lone) {
  if (pieces == 0 || pieces > count_ || first > count_ - pieces) return false;
  StaticShape* const shapes = statics_.data() + first;
  if (lone != nullptr) {
    if (!shapes[0].lone || shapes[0].owner != kNoSlot) return false;
    shapes[0] = *lone;
    shapes[0].asleep = true;
  }
  return std::all_of(shapes, shapes + pieces,
                     [owner](const StaticShape& s) { return s.alive && s.asleep && s.owner == owner; });
}

bool StaticShapes::make_grids(std::size_t asleep) {
  sleepers_.clear();
  if (asleep != 0) sleepers_.make_room(count_, 2 * asleep);
  for (std::uint32_t k = 0; k < count_; ++k) {
    if (!statics_[k].alive || !statics_[k].asleep) continue;
    if (asleep-- == 0) return false;
    enter(sleepers_, k);
  }
  make_grid();
  return asleep == 0;
}

namespace {

// A touch, and how it is saved: who has it, and what that body touches.
struct NamedTouch {
  Touch* touch = nullptr;
  std::uint32_t own = 0, other = 0;
  bool fixed = false;
};

void describe_touches(Archive& a, std::vector<NamedTouch>& named, const BodyStore& bodies,
                      const StaticShapes& statics) {
  for (NamedTouch& n : named) {
    const Touch& t = *n.touch;
    n.fixed = t.of_fixed();
    n.other = n.fixed || t.first() == n.own ? t.second() : t.first();
  }
  columns(a, named, &NamedTouch::other, &NamedTouch::fixed);
  const Mapped touches{named, [](const NamedTouch& n) -> Touch& { return *n.touch; }};
  for (const int point : {0, 1}) {
    columns(
        a, touches, [&](Touch& t) -> float& { return t.impulse[point]; },
        [&](Touch& t) -> float& { return t.friction[point]; });
  }
  columns(
      a, touches, [](Touch& t) -> std::uint16_t& { return t.parts.first; },
      [](Touch& t) -> std::uint16_t& { return t.parts.second; });
  columns(a, touches, &Touch::points, &Touch::per_mass);
  if (!a.loading()) return;
  for (const NamedTouch& n : named) {
    const bool wall = n.other >= kWallLeft && n.other <= kWallTop;
    a.require(n.fixed ? wall || n.other < statics.size()
                      : n.other < bodies.id_count && bodies.info[n.other].place != Place::none);
    a.require(n.touch->points <= 2);
    n.touch->key = n.fixed ? fixed_key(n.own, n.other) : pair_key(n.own, n.other);
  }
}

void describe_recent(Archive& a, TouchMemory& memory, const BodyStore& bodies, const StaticShapes& statics) {
  std::vector<Touch> touches;
  if (!a.loading()) touches = memory.all();
  std::vector<std::uint32_t> own(touches.size());
  std::ranges::transform(touches, own.begin(), &Touch::first);
  a.packed(own, bodies.id_count);
  touches.resize(own.size());
  std::vector<NamedTouch> named;
  for (std::size_t k = 0; k < own.size(); ++k) named.push_back({&touches[k], own[k]});
  describe_touches(a, named, bodies, statics);
  if (!a.loading()) return;
  memory.clear();
  for (std::size_t k = 0; k < touches.size() && a.ok(); ++k) memory.add(touches[k]);
}

// Sleepers that were read take their places in the other tables.
void put_sleepers(Archive& a, Sleepers& sleepers, BodyStore& bodies, StaticShapes& statics) {
  std::vector<Sleeper>& list = sleepers.list;
  std::uint64_t pieces = 0, touches = 0;
  sleepers.widest = 0;
  sleepers.dropped = 0;
  for (std::size_t k = 0; k < list.size() && a.ok(); ++k) {
    Sleeper& s = list[k];
    a.require(std::isfinite(s.at.dx) && std::isfinite(s.at.dy) && std::isfinite(s.angle));
    a.require(s.substep > 0 && std::isfinite(s.substep));
    a.require(put(bodies, s.id, Place::asleep, k));
    if (!a.ok()) break;
    sleepers.widest = greater(bodies.properties(s.id).radius, sleepers.widest);
    const StaticShape disc = lone_piece(s.at, s.id, bodies.properties(s.id));
    const bool lone = bodies.kind(s.id).hull_count == 0;
    a.require(statics.lay_sleeper(s.id, s.first_shape, s.pieces, lone ? &disc : nullptr));
    pieces += s.pieces;
    s.first_touch = static_cast<std::uint32_t>(touches);
    touches += s.touches;
    if (!a.fits(touches)) break;
  }
  if (!a.ok()) list.clear();
  sleepers.touches.assign(a.ok() ? touches : 0, Touch{});
  a.require(a.ok() && statics.make_grids(pieces));
}

}  // namespace

void Sleepers::describe(Archive& a, BodyStore& bodies, StaticShapes& statics) {
  values(a, woke, changed, watching_);
  if (a.loading()) list.assign(count_of(bodies, Place::asleep), Sleeper{});
  using S = Sleeper;
  lattice_points(a, Mapped{list, &S::at});
  columns(a, list, &S::angle, &S::id, &S::first_shape, &S::pieces, &S::touches, &S::substep, &S::group, &S::creeps);
  if (a.loading()) put_sleepers(a, *this, bodies, statics);
  std::vector<NamedTouch> told;  // those of no sleeper are left out
  told.reserve(touches.size());
  for (const Sleeper& s : list) {
    for (std::uint32_t k = 0; k < s.touches; ++k) told.push_back({&touches[s.first_touch + k], s.id});
  }
  describe_touches(a, told, bodies, statics);
  describe_recent(a, recent, bodies, statics);
  // For how long bodies that are awake have stayed where they are.
  if (a.loading()) std::fill_n(watched_.data(), watched_.capacity(), Watched{});
  if (!watching_ && list.empty()) return;
  watched_.reserve(bodies.id_count);
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    if (bodies.info[id].place != Place::asleep) a.plain(&watched_[id], 1);
  }
}

}  // namespace psim
