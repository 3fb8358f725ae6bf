// Fixed geometry, and the bodies that sleep, which are part of it meanwhile.
#include "sleep/sleepers.h"
#include "state/describe.h"

namespace psim {

// A plain disc that sleeps is not written here: its Sleeper and its properties say all.
template <class A>
void StaticShapes::describe(A& a, const BodyStore& bodies) {
  numbers(a, count_, whole_wanted_, dirty_);
  a.list(hulls_, [&](Hull& hull) { visit(a, hull); });
  if constexpr (A::kLoading) {
    if (!a.fits(count_)) count_ = 0;
    statics_.reserve(count_);
    std::fill_n(statics_.data(), count_, StaticShape{});
  }
  const auto each_flag = [&](auto... flag) {
    (a.packed(count_, [&](std::size_t k) -> bool& { return statics_[k].*flag; }), ...);
  };
  using S = StaticShape;
  each_flag(&S::segment, &S::face, &S::whole, &S::alive, &S::asleep, &S::lone);
  std::vector<std::uint32_t> told;
  for (std::uint32_t k = 0; k < count_; ++k) {
    if (statics_[k].alive && statics_[k].lone) {
      if constexpr (A::kLoading) statics_[k].owner = kNoSlot;  // until its sleeper is there
    } else {
      told.push_back(k);
    }
  }
  const auto each = [&](const auto& field) {
    a.packed(
        told.size(), [&](std::size_t k) -> auto& { return field(statics_[told[k]]); });
  };
  for (LatticePoint S::*point : {&S::p, &S::q}) {
    each([&](S & s) -> auto& { return (s.*point).x; });
    each([&](S & s) -> auto& { return (s.*point).y; });
    each([&](S & s) -> auto& { return (s.*point).dx; });
    each([&](S & s) -> auto& { return (s.*point).dy; });
  }
  each([](S & s) -> auto& { return s.radius; });
  each([](S & s) -> auto& { return s.restitution; });
  each([](S & s) -> auto& { return s.friction; });
  each([](S & s) -> auto& { return s.owner; });
  each([](S & s) -> auto& { return s.hull; });
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
  a.packed(
      n, [&](std::size_t k) -> auto& { return names[k].other; });
  a.packed(
      n, [&](std::size_t k) -> auto& { return names[k].fixed; });
  for (const int point : {0, 1}) {
    a.packed(
        n, [&](std::size_t k) -> auto& { return touches[k]->impulse[point]; });
    a.packed(
        n, [&](std::size_t k) -> auto& { return touches[k]->friction[point]; });
  }
  a.packed(
      n, [&](std::size_t k) -> auto& { return touches[k]->points; });
  a.packed(
      n, [&](std::size_t k) -> auto& { return touches[k]->per_mass; });
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
  numbers(a, woke, changed, watching_);
  if constexpr (A::kLoading) list.assign(bodies.asleep, Sleeper{});
  const std::size_t n = list.size();
  const auto each = [&](const auto& field) {
    a.packed(
        n, [&](std::size_t k) -> auto& { return field(list[k]); });
  };
  each([](Sleeper & s) -> auto& { return s.at.x; });
  each([](Sleeper & s) -> auto& { return s.at.y; });
  each([](Sleeper & s) -> auto& { return s.at.dx; });
  each([](Sleeper & s) -> auto& { return s.at.dy; });
  each([](Sleeper & s) -> auto& { return s.angle; });
  each([](Sleeper & s) -> auto& { return s.id; });
  each([](Sleeper & s) -> auto& { return s.first_shape; });
  each([](Sleeper & s) -> auto& { return s.pieces; });
  each([](Sleeper & s) -> auto& { return s.touches; });
  each([](Sleeper & s) -> auto& { return s.depth; });
  each([](Sleeper & s) -> auto& { return s.group; });
  each([](Sleeper & s) -> auto& { return s.loose; });
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
  describe_rest(a, bodies);
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
void Sleepers::describe_rest(A& a, const BodyStore& bodies) {
  if constexpr (A::kLoading) std::fill_n(rest_.data(), rest_.capacity(), Rest{});
  if (!watching_ && list.empty()) return;
  rest_.reserve(bodies.id_count);
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    if (bodies.info[id].place != Place::asleep) a.plain(&rest_[id], 1);
  }
}

PSIM_DESCRIBED(StaticShapes, const BodyStore&);
PSIM_DESCRIBED(Sleepers, BodyStore&, StaticShapes&);

}  // namespace psim
