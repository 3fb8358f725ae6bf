// Who is there: the tables of what bodies share, bodies by id, the columns of those that move, the lists of those that
// do not, fixed geometry, and the bodies that sleep, which are part of it meanwhile.
#include "bodies/population.h"
#include "sleep/sleepers.h"
#include "state/describe.h"

namespace psim {
namespace {

std::size_t count_of(const BodyStore& b, Place place) {
  const auto is_there = [place](const BodyInfo& info) { return info.place == place; };
  return static_cast<std::size_t>(std::count_if(b.info.data(), b.info.data() + b.id_count, is_there));
}

}  // namespace

template <class A>
void BodyPropertyTable::describe(A& a, std::size_t kinds) {
  a.list(list_, [&](Entry& e) {
    values(a, e.value, e.users);
    a.require(e.value.kind < kinds);
  });
  describe_free(a, free_, 0, list_.size(), [&](std::size_t k) { return list_[k].users == 0; });
  a.value(last_);
}

template <class A>
void BodyKindTable::describe(A& a, const ShapeTable& hulls) {
  a.list(list_, [&](Entry& e) {
    BodyKind& k = e.value;
    values(a, k.first_hull, k.hull_count, k.centre_x, k.centre_y, k.inner, k.filter, k.bullet, k.sensor, e.users);
    a.require(k.inner >= 0 && (k.hull_count == 0 ? k.first_hull == 0 : e.users == 0 || hulls.has(k)));
  });
  describe_free(a, free_, 1, list_.size(), [&](std::size_t k) { return list_[k].users == 0; });
  a.value(last_);
  a.require(!list_.empty() && list_[0].value == BodyKind{} && last_ < list_.size());
}

bool ShapeTable::has(const BodyKind& kind) const {
  const std::uint32_t k = index_of(kind.first_hull);
  return k < sets_.size() && sets_[k].first == kind.first_hull && sets_[k].count == kind.hull_count &&
         sets_[k].users != 0;
}

template <class A>
void ShapeTable::describe(A& a) {
  values(a, hulls_);
  a.require(!hulls_.empty());
  a.list(sets_, [&](Set& s) {
    values(a, s.first, s.count, s.users);
    a.require(s.first >= 1 && s.count >= 1 && s.first < hulls_.size() && s.count <= hulls_.size() - s.first);
  });
  describe_free(a, free_, 0, sets_.size(), [&](std::size_t k) { return sets_[k].users == 0; });
  if constexpr (!A::kLoading) return;
  by_hash_.clear();
  std::uint32_t end = 1;  // of the sets before
  for (std::uint32_t k = 0; k < sets_.size() && a.ok(); ++k) {
    const Set& s = sets_[k];
    a.require(s.first >= end);
    end = s.first + s.count;
    for (std::uint32_t h = s.first; h < end; ++h) a.require(hulls_[h].count >= 1);
    if (s.users == 0 || !a.ok()) continue;
    const auto first = hulls_.begin() + s.first;
    by_hash_.emplace(hash({first, first + s.count}), k);
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
  std::size_t unused = 0;
  values(a, id_count, unused);
  if constexpr (A::kLoading) {
    if (!a.fits(id_count)) id_count = 0;
    info.reserve(id_count);
    for (std::uint32_t k = 0; k < std::max(ids, id_count); ++k) info[k] = BodyInfo{};  // as if never used
  }
  columns(
      a, id_count, [&](std::size_t k) -> BodyInfo& { return info[k]; }, &BodyInfo::place, &BodyInfo::generation,
      &BodyInfo::properties);
  describe_free(a, free_ids, 0, id_count, [&](std::size_t k) { return info[k].place == Place::none; });
}

template <class A>
void BodyStore::describe_slots(A& a, bool lists) {
  // Some worlds alone have these.
  bool turns = !rim_speed.empty(), remainders = !vel_remainder.empty(), offsets = !disp_remainder.empty();
  values(a, count, turns, remainders, offsets);
  if constexpr (A::kLoading) {
    if (!a.fits(count)) count = 0;
    reserve_slots(1);  // even of none: columns that the plan wants are there
    keep_rotation(turns);
    keep_remainders(remainders, remainders && offsets);
  }
  const std::size_t n = count;
  a.plain(pos, 2 * n);
  a.plain(vel, 2 * n);
  a.plain(disp, 2 * n);
  a.packed(id, n);
  a.packed(radius, n);
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
    a.require(count - dead == count_of(*this, Place::moving));
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
  values(a, first_properties.mass, first_radius, least_radius, first_properties);
  a.require(first_radius >= 0 && least_radius >= 0);
  a.refuse_nan(true);
  bodies.describe(a, lists);
  std::size_t at = 0;
  a.list(fixed, [&](FixedBody& f) {
    values(a, f.x, f.y, f.angle, f.radius, f.id, f.first_shape);
    if constexpr (A::kLoading) a.require(f.radius >= 0 && bodies.put(f.id, Place::fixed, at++));
  });
  statics.describe(a, bodies);
  a.refuse_nan(false);
  for (const FixedBody& f : fixed) a.require(f.first_shape <= statics.size());
  at = 0;
  a.list(frozen, [&](BodyState& s) {
    values(a, s.id, s.x, s.y, s.angle, s.vx, s.vy, s.omega, s.radius, s.type);
    if constexpr (A::kLoading) a.require(bodies.put(s.id.index, Place::frozen, at++));
  });
  a.list(kinematics, [&](auto& k) {
    a.index(bodies.id_count, k.first);
    values(a, k.second);
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

// ---- fixed geometry, and bodies that sleep

// A plain disc that sleeps is not written here: its Sleeper and its properties say all.
template <class A>
void StaticShapes::describe(A& a, const BodyStore& bodies) {
  values(a, count_, whole_wanted_, dirty_);
  values(a, hulls_);
  if constexpr (A::kLoading) {
    if (!a.fits(count_)) count_ = 0;
    statics_.reserve(count_);
    std::fill_n(statics_.data(), count_, StaticShape{});
  }
  using S = StaticShape;
  columns(
      a, count_, [&](std::size_t k) -> S& { return statics_[k]; }, &S::segment, &S::face, &S::whole, &S::alive,
      &S::asleep, &S::lone);
  std::vector<std::uint32_t> told;
  for (std::uint32_t k = 0; k < count_; ++k) {
    if (statics_[k].alive && statics_[k].lone) {
      if constexpr (A::kLoading) statics_[k].owner = kNoSlot;  // until its sleeper is there
    } else {
      told.push_back(k);
    }
  }
  const auto shape = [&](std::size_t k) -> S& { return statics_[told[k]]; };
  lattice_points(a, told.size(), [&](std::size_t k) -> LatticePoint& { return shape(k).p; });
  lattice_points(a, told.size(), [&](std::size_t k) -> LatticePoint& { return shape(k).q; });
  columns(a, told.size(), shape, &S::radius, &S::restitution, &S::friction, &S::owner, &S::hull);
  for (auto& runs : runs_) a.packed(runs, std::uint64_t{count_} + 1);
  a.list(left_, [&](auto& run) { a.index(std::uint64_t{count_} + 1, run.first, run.second); });
  std::vector<std::uint8_t> hull_used(hulls_.size());
  if constexpr (A::kLoading) {
    check_pieces(a, told, bodies, hull_used);
    check_runs(a);
  }
  describe_free(a, free_hulls_, 0, hulls_.size(), [&](std::size_t k) { return hull_used[k] == 0; });
}

template <class A>
void StaticShapes::check_pieces(A& a, const std::vector<std::uint32_t>& told, const BodyStore& bodies,
                                std::vector<std::uint8_t>& hull_used) {
  alive_ = count_ - told.size();
  for (const std::uint32_t k : told) {
    const StaticShape& s = statics_[k];
    a.require(s.owner < bodies.id_count);
    if (!a.ok() || !s.alive) continue;
    ++alive_;
    a.require(s.radius >= 0 && s.radius < 1e30f);
    a.require(bodies.info[s.owner].place == (s.asleep ? Place::asleep : Place::fixed));
    if (!s.whole) continue;
    a.require(s.hull < hulls_.size());
    if (a.ok()) a.require(hulls_[s.hull].count != 0 && hull_used[s.hull]++ == 0);
  }
}

// Numbers that nobody has, by run: each once.
template <class A>
void StaticShapes::check_runs(A& a) const {
  std::vector<std::uint8_t> taken(count_);
  const auto run = [&](std::uint32_t first, std::uint32_t length) {
    a.require(a.ok() && length <= count_ && first <= count_ - length);
    for (std::uint32_t k = first; a.ok() && k < first + length; ++k) a.require(!statics_[k].alive && taken[k]++ == 0);
  };
  for (std::uint32_t length = 0; length <= kLongestRun; ++length) {
    for (const std::uint32_t first : runs_[length]) run(first, length);
  }
  for (const auto& [first, length] : left_) run(first, length);
}

bool StaticShapes::lay_lone(std::uint32_t number, const StaticShape& piece) {
  if (number >= count_ || !statics_[number].lone || statics_[number].owner != kNoSlot) return false;
  statics_[number] = piece;
  statics_[number].asleep = true;
  return true;
}

bool StaticShapes::sleeps(std::uint32_t first, std::uint32_t pieces, std::uint32_t owner) const {
  if (pieces == 0 || pieces > count_ || first > count_ - pieces) return false;
  return std::all_of(statics_.data() + first, statics_.data() + first + pieces,
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

// Touches by who has them: `own` says which body that is of the k-th.
template <class A, class Own>
void describe_touches(A& a, const std::vector<Touch*>& touches, std::uint32_t ids, const Own& own) {
  struct Name {
    std::uint32_t other = 0;
    bool fixed = false;
  };
  const std::size_t n = touches.size();
  std::vector<Name> names(n);
  if constexpr (!A::kLoading) {
    for (std::size_t k = 0; k < n; ++k) {
      const Touch& t = *touches[k];
      names[k] = {t.of_fixed() || t.first() == own(k) ? t.second() : t.first(), t.of_fixed()};
    }
  }
  const auto touch = [&](std::size_t k) -> Touch& { return *touches[k]; };
  columns(
      a, n, [&](std::size_t k) -> Name& { return names[k]; }, &Name::other, &Name::fixed);
  for (const int point : {0, 1}) {
    a.packed(n, [&](std::size_t k) -> float& { return touch(k).impulse[point]; });
    a.packed(n, [&](std::size_t k) -> float& { return touch(k).friction[point]; });
  }
  columns(a, n, touch, &Touch::points, &Touch::per_mass);
  if constexpr (A::kLoading) {
    for (std::size_t k = 0; k < n && a.ok(); ++k) {
      a.require((names[k].fixed || names[k].other < ids) && touches[k]->points <= 2);
      touches[k]->key =
          names[k].fixed ? TouchKey::fixed(own(k), names[k].other) : TouchKey::bodies(own(k), names[k].other);
    }
  }
}

}  // namespace

template <class A>
void TouchMemory::describe(A& a, std::uint32_t ids) {
  std::vector<Touch> read(A::kLoading ? 0 : list_.size());
  std::vector<std::uint32_t> own(read.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    read[k] = list_[k];
    own[k] = list_[k].first();
  }
  a.packed(own, ids);
  read.resize(own.size());
  std::vector<Touch*> touches;
  touches.reserve(read.size());
  for (Touch& t : read) touches.push_back(&t);
  describe_touches(a, touches, ids, [&](std::size_t k) { return own[k]; });
  if constexpr (A::kLoading) {
    clear();
    for (std::size_t k = 0; k < read.size() && a.ok(); ++k) add(read[k]);
  }
}

template <class A>
void Sleepers::describe(A& a, BodyStore& bodies, StaticShapes& statics) {
  values(a, woke, changed, watching_);
  if constexpr (A::kLoading) list.assign(count_of(bodies, Place::asleep), Sleeper{});
  lattice_points(a, list.size(), [&](std::size_t k) -> LatticePoint& { return list[k].at; });
  using S = Sleeper;
  columns(
      a, list.size(), [&](std::size_t k) -> S& { return list[k]; }, &S::angle, &S::id, &S::first_shape, &S::pieces,
      &S::touches, &S::depth, &S::group, &S::creeps);
  if constexpr (A::kLoading) put_sleepers(a, bodies, statics);
  std::vector<Touch*> told;  // those of no sleeper are left out
  std::vector<std::uint32_t> own;
  for (const Sleeper& s : list) {
    for (std::uint32_t k = 0; k < s.touches; ++k) {
      told.push_back(&touches[s.first_touch + k]);
      own.push_back(s.id);
    }
  }
  describe_touches(a, told, bodies.id_count, [&](std::size_t k) { return own[k]; });
  recent.describe(a, bodies.id_count);
  describe_watched(a, bodies);
}

// Sleepers that were read take their places in the other tables.
template <class A>
void Sleepers::put_sleepers(A& a, BodyStore& bodies, StaticShapes& statics) {
  std::uint64_t pieces_of_all = 0, touches_of_all = 0;
  for (std::size_t k = 0; k < list.size() && a.ok(); ++k) {
    Sleeper& s = list[k];
    a.require(std::isfinite(s.at.dx) && std::isfinite(s.at.dy) && std::isfinite(s.angle));
    a.require(bodies.put(s.id, Place::asleep, k));
    if (!a.ok()) break;
    if (bodies.kind(s.id).hull_count == 0) {
      a.require(statics.lay_lone(s.first_shape, lone_piece(s.at, s.id, bodies.properties(s.id))));
    }
    a.require(statics.sleeps(s.first_shape, s.pieces, s.id));
    pieces_of_all += s.pieces;
    s.first_touch = static_cast<std::uint32_t>(touches_of_all);
    touches_of_all += s.touches;
    if (!a.fits(touches_of_all)) break;
  }
  if (!a.ok()) list.clear();
  touches.assign(a.ok() ? touches_of_all : 0, Touch{});
  a.require(a.ok() && statics.make_grids(pieces_of_all));
}

// How long bodies that are awake have stayed where they are.
template <class A>
void Sleepers::describe_watched(A& a, const BodyStore& bodies) {
  if constexpr (A::kLoading) std::fill_n(watched_.data(), watched_.capacity(), Watched{});
  if (!watching_ && list.empty()) return;
  watched_.reserve(bodies.id_count);
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    if (bodies.info[id].place != Place::asleep) a.plain(&watched_[id], 1);
  }
}

PSIM_DESCRIBED(StaticShapes, const BodyStore&);
PSIM_DESCRIBED(Sleepers, BodyStore&, StaticShapes&);

}  // namespace psim
