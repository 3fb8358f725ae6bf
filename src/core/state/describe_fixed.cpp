// Fixed geometry, and the bodies that sleep, which are part of it meanwhile.
#include <algorithm>
#include <cmath>
#include <span>

#include "sleep/sleepers.h"
#include "state/describe.h"

namespace psim {

// Whether the part of a point that its lattice leaves is a number, as those of fixed geometry are.
static bool is_near(const LatticePoint& p) { return std::isfinite(p.dx) && std::isfinite(p.dy); }

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
      a.require(s.radius >= 0 && s.radius < 1e30f && is_near(s.p) && is_near(s.q));
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
