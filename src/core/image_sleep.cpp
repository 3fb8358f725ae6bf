// Fixed geometry and what sleeps, of which it is a part meanwhile (image.h).
#include <algorithm>
#include <cstring>
#include <span>

#include "image.h"

namespace psim {
namespace {

std::span<const std::byte> span_of(const InPlace<std::byte>& c) { return {c.from, c.count}; }

// Appends the touches of a sleeper: they are its own from now on.
void take_touches(Sleeper& sleeper, const std::vector<Touch>& from, std::vector<Touch>& to) {
  const auto begin = from.begin() + sleeper.first_touch;
  sleeper.first_touch = static_cast<std::uint32_t>(to.size());
  to.insert(to.end(), begin, begin + sleeper.touches);
}

// As unpack_sleepers, of n whose pack is the same here and there.
bool copy_sleepers(const Sleepers& from, std::size_t first, std::size_t n, Sleepers& sleepers, BodyStore& b) {
  if (first + n > std::min(from.list.size(), sleepers.list.size())) return false;
  for (std::size_t k = first; k < first + n; ++k) {
    Sleeper& s = sleepers.list[k] = from.list[k];
    if (s.id >= b.id_count || b.info[s.id].place != Place::asleep) return false;
    b.info[s.id].slot = static_cast<std::uint32_t>(k);
    take_touches(s, from.touches, sleepers.touches);
  }
  return true;
}

// What nobody has.
StaticShape gone() {
  StaticShape shape;
  shape.alive = false;
  shape.asleep = true;
  return shape;
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

template <class A>
void Image::visit(A& a, StaticShape& s) {
  visit(a, s.p);
  visit(a, s.q);
  numbers(a, s.radius, s.restitution, s.friction, s.owner, s.hull, s.segment, s.face, s.whole,
          s.alive, s.asleep);
}

// What lone pieces and numbers that nobody has leave.
template <class A>
void Image::standing(A& a, StaticShapes& s) {
  const auto others = [&](const auto& each) {
    for (std::uint32_t k = 0; k < s.count_; ++k) {
      const StaticShape& shape = s.shapes_[k];
      if (shape.alive ? !shape.lone : !shape.asleep) each(k);
    }
    for (const auto& [first, count] : s.left_) {  // contacts may still name them
      for (std::uint32_t k = first; k < first + count; ++k) each(k);
    }
  };
  std::size_t n = 0;
  if constexpr (!A::kLoading) others([&](std::uint32_t) { ++n; });
  n = a.count(n);
  if constexpr (A::kLoading) {
    for (; n > 0 && a.ok(); --n) {
      std::uint32_t k = 0;
      a.value(k);
      if (k >= s.count_) return a.fail("it is damaged");
      visit(a, s.shapes_[k]);
    }
  } else {
    others([&](std::uint32_t k) {
      a.value(k);
      visit(a, s.shapes_[k]);
    });
  }
  for (auto& runs : s.runs_) list(a, runs, [&](std::uint32_t& number) { a.value(number); });
  list(a, s.left_, [&](auto& run) { numbers(a, run.first, run.second); });
  list(a, s.hulls_, [&](Hull& hull) { visit(a, hull); });
  list(a, s.free_hulls_, [&](std::uint32_t& number) { a.value(number); });
}

template <>
void Image::shapes(Saver& a, StaticShapes& s, Sleepers& sleepers, BodyStore&, const Sleepers*) {
  if (s.saved_stale_) {
    Saver numbers;
    standing(numbers, s);
    s.saved_.assign(numbers.first().begin(), numbers.first().end());
    s.saved_stale_ = false;
  }
  numbers(a, s.count_, s.alive_, s.whole_wanted_, s.dirty_);
  a.vector(s.saved_);
  a.count(sleepers.packs_.size());
  for (SleeperPack& pack : sleepers.packs_) a.vector(pack.bytes);
}

// What is there already, the same bytes, stays as it is.
template <>
void Image::shapes(Loader& a, StaticShapes& s, Sleepers& sleepers, BodyStore& b, const Sleepers* read) {
  const std::uint32_t had = s.count_;
  const bool was_dirty = s.dirty_;
  numbers(a, s.count_, s.alive_, s.whole_wanted_, s.dirty_);
  InPlace<std::byte> others;
  a.in_place(others);
  std::vector<InPlace<std::byte>> packs(a.count(0));
  std::size_t asleep = 0;
  for (InPlace<std::byte>& pack : packs) {
    a.in_place(pack);
    if (asleep % SleeperPack::kEach != 0) a.fail("it is damaged");
    asleep += count_in_pack(span_of(pack));
  }
  if (asleep > SleeperPack::kEach * packs.size()) a.fail("it is damaged");
  if (!a.ok()) return;
  if (a.dry()) {
    sleepers.seen_ = {others, {}, std::move(packs)};
    return;
  }
  const bool same_others = !s.saved_stale_ && a.same(others, s.saved_);
  const auto each_of_pack = [&](std::size_t pack, const auto& each) {
    const std::size_t begin = pack * SleeperPack::kEach;
    for (std::size_t k = begin; k < std::min(begin + SleeperPack::kEach, sleepers.list.size()); ++k)
      each(sleepers.list[k]);
  };
  std::vector<bool> same(std::max(packs.size(), sleepers.list.size() / SleeperPack::kEach + 1));
  for (std::size_t k = 0; k < std::min(packs.size(), sleepers.packs_.size()); ++k) {
    same[k] = !sleepers.packs_[k].stale && a.same(packs[k], sleepers.packs_[k].bytes);
    if (!same[k] || b.alike) continue;
    each_of_pack(k, [&](const Sleeper& x) {
      const StaticShape& piece = s.shapes_[x.first_shape];
      const Surface& surface = b.surface(x.id);
      same[k] = same[k] && piece.lone == (b.makes[surface.make].hull_count == 0) &&
                same_bits(piece.radius, surface.radius) &&
                same_bits(piece.restitution, surface.restitution) &&
                same_bits(piece.friction, surface.friction);
    });
  }
  // Out with what changes.
  for (std::uint32_t k = 0; k < had && !same_others; ++k) {
    if (s.shapes_[k].lone && s.shapes_[k].alive) continue;
    if (s.shapes_[k].alive && s.shapes_[k].asleep) s.sleepers_.remove(k);
    s.shapes_[k] = gone();
  }
  // Lone pieces of packs that change are dead until they prove to be where they were.
  std::vector<std::uint32_t> dead, fresh;  // numbers; by place in the list
  for (std::size_t k = 0; k < same.size(); ++k) {
    if (same[k]) continue;
    each_of_pack(k, [&](const Sleeper& x) {
      if (!s.shapes_[x.first_shape].lone) return;
      s.shapes_[x.first_shape].alive = false;
      dead.push_back(x.first_shape);
    });
  }
  s.shapes_.reserve(s.count_);
  for (std::uint32_t k = had; k < s.count_; ++k) s.shapes_[k] = gone();
  sleepers.list.resize(asleep);
  sleepers.packs_.resize(packs.size());
  if (std::find(same.begin(), same.end(), true) == same.end()) {
    sleepers.touches.clear();
    sleepers.touches.reserve(read->touches.size());
  }
  for (std::size_t k = 0; k < packs.size(); ++k) {
    if (same[k]) continue;
    SleeperPack& pack = sleepers.packs_[k];
    pack.bytes.assign(packs[k].from, packs[k].from + packs[k].count);
    pack.stale = false;
    each_of_pack(k, [&](Sleeper& x) {
      const auto at = static_cast<std::uint32_t>(&x - sleepers.list.data());
      x = read->list[at];
      take_touches(x, read->touches, sleepers.touches);
      b.info[x.id].slot = at;
      const Surface& surface = b.surface(x.id);
      if (b.makes[surface.make].hull_count != 0) return;
      StaticShape& piece = s.shapes_[x.first_shape];
      const bool lies = !piece.alive && piece.lone &&
                        std::memcmp(&piece.p, &x.at, sizeof x.at) == 0 &&
                        same_bits(piece.radius, surface.radius);
      if (!lies) return fresh.push_back(at);
      piece = lone_piece(x.at, x.id, surface);
      piece.asleep = true;
    });
  }
  if (std::find(same.begin(), same.end(), false) != same.end()) sleepers.tidy();
  for (const std::uint32_t k : dead) {
    if (s.shapes_[k].alive) continue;
    s.sleepers_.remove(k);
    s.shapes_[k] = gone();
  }
  if (!same_others) {
    s.saved_stale_ = true;
    Loader numbers = Loader::of_numbers(span_of(others));
    standing(numbers, s);
    if (!numbers.ok() || !numbers.at_end()) return a.fail("it is damaged");
    for (std::uint32_t k = 0; k < s.count_; ++k) {
      if (s.shapes_[k].alive && s.shapes_[k].asleep && !s.shapes_[k].lone) s.enter(s.sleepers_, k);
    }
    s.saved_.assign(others.from, others.from + others.count);
    s.saved_stale_ = false;
  }
  if (asleep != 0 && fresh.size() == asleep) s.sleepers_.make_room(s.count_, 2 * asleep);
  for (const std::uint32_t k : fresh) {
    const Sleeper& x = sleepers.list[k];
    StaticShape& piece = s.shapes_[x.first_shape];
    if (piece.alive) return a.fail("it is damaged");
    piece = lone_piece(x.at, x.id, b.surface(x.id));
    piece.asleep = true;
    s.enter(s.sleepers_, x.first_shape);
  }
  // When its grid was made decides whose numbers may be had again.
  if (!s.dirty_ && (was_dirty || !same_others)) s.make_grid();
}

template <class A>
void Image::sleepers(A& a, Sleepers& s, const BodyStore& b) {
  if constexpr (A::kLoading) {
    InPlace<std::byte> recent;
    a.in_place(recent);
    s.seen_.recent = recent;
    if (a.dry()) {
      numbers(a, s.woke, s.changed, s.watching_);
      InPlace<Sleepers::Rest> rests;
      a.in_place(rests);
      s.seen_.rests = rests.count;
      return;
    }
    if (!a.ok() || !unpack_recent(span_of(recent), s, b)) return a.fail("it is damaged");
  } else {
    pack_recent(s, b, s.recent_);
    a.vector(s.recent_);
  }
  numbers(a, s.woke, s.changed, s.watching_);
  // Of who sleeps nothing is known, and nobody is watched: what was known does not count.
  using Rest = Sleepers::Rest;
  static_assert(sizeof(Rest) == 10);
  const auto each_run = [&](const auto& each) {
    std::size_t id = 0;
    for (const AlikeBodies& run : b.roster) {
      if (run.place != Place::asleep) each(id, std::min<std::size_t>(run.count, b.id_count - id));
      id += std::min<std::size_t>(run.count, b.id_count - id);
    }
  };
  std::size_t awake = 0;
  each_run([&](std::size_t, std::size_t n) { awake += n; });
  const std::size_t known = s.watching_ || !s.list.empty() ? awake : 0;
  if constexpr (A::kLoading) {
    const std::size_t kept =
        known != 0 || awake == 0 ? std::min<std::size_t>(b.id_count, s.rest_.capacity()) : 0;
    std::fill_n(s.rest_.data() + kept, s.rest_.capacity() - kept, Rest{});
    InPlace<Rest> rests;
    a.in_place(rests);
    if (rests.count == 0) return;
    if (rests.count != known) return a.fail("it is damaged");
    s.rest_.reserve(b.id_count);
    const std::byte* from = rests.from;
    each_run([&](std::size_t id, std::size_t n) {
      if (awake == b.id_count) {
        a.copies().add(s.rest_.data() + id, from, n * sizeof(Rest));
      } else {
        std::memcpy(s.rest_.data() + id, from, n * sizeof(Rest));
      }
      from += n * sizeof(Rest);
    });
  } else {
    s.rest_.reserve(known != 0 ? b.id_count : 0);
    if (known == 0 || awake == b.id_count) return a.column(s.rest_, known);
    s.rests_.resize(awake);
    Rest* to = s.rests_.data();
    each_run([&](std::size_t id, std::size_t n) { to = std::copy_n(s.rest_.data() + id, n, to); });
    a.vector(s.rests_);
  }
}

// What a dry run saw, into a world that nobody else looks at. Nothing is read that is in `now` already, byte for byte:
// true.
template <class W>
bool Image::unpack(Loader& a, W& seen, const W& now, bool same_roster) {
  BodyStore& b = seen.bodies;
  StaticShapes& s = seen.shapes;
  Sleepers& sleepers = seen.sleepers;
  const auto& packs = sleepers.seen_.packs;
  const auto alike = [](const auto& one, const auto& other, auto what) {
    return std::ranges::equal(one, other, [what](const auto& x, const auto& y) { return x.*what == y.*what; });
  };
  const auto as_before = [&] {
    if (!same_roster || now.shapes.saved_stale_) return false;
    if (packs.size() != now.sleepers.packs_.size() || s.count_ != now.shapes.count_ || s.alive_ != now.shapes.alive_) return false;
    for (std::size_t k = 0; k < packs.size(); ++k) {
      const SleeperPack& pack = now.sleepers.packs_[k];
      if (pack.stale || !a.same(packs[k], pack.bytes)) return false;
    }
    return a.same(sleepers.seen_.others, now.shapes.saved_) &&
           alike(b.surfaces.list_, now.bodies.surfaces.list_, &SurfaceTable::Entry::surface) &&
           alike(b.makes.list_, now.bodies.makes.list_, &MakeTable::Entry::make) &&
           unpack_recent(span_of(sleepers.seen_.recent), now.sleepers, now.bodies, sleepers.recent);
  };
  if (as_before()) return true;
  if (!a.fits(s.count_ / 16)) return false;
  b.info.reserve(b.id_count);
  std::uint32_t id = 0;
  for (const AlikeBodies& run : b.roster) {
    for (std::uint32_t k = 0; k < run.count; ++k, ++id) b.info[id] = {kNoSlot, run.generation, run.surface, run.place};
  }
  sleepers.list.assign(b.asleep, Sleeper{});
  sleepers.touches.clear();
  std::size_t first = 0;
  const std::vector<SleeperPack>& there = now.sleepers.packs_;
  for (std::size_t k = 0; k < packs.size() && a.ok(); ++k) {
    const std::size_t n = count_in_pack(span_of(packs[k]));
    const bool same = k < there.size() && !there[k].stale && a.same(packs[k], there[k].bytes);
    a.require(same ? copy_sleepers(now.sleepers, first, n, sleepers, b)
                   : unpack_sleepers(span_of(packs[k]), first, sleepers, b));
    first += n;
  }
  a.require(first == sleepers.list.size());
  s.shapes_.reserve(s.count_);
  std::fill_n(s.shapes_.data(), s.count_, gone());
  Loader numbers = Loader::of_numbers(span_of(sleepers.seen_.others));
  if (a.ok()) standing(numbers, s);
  a.require(numbers.ok() && numbers.at_end());
  for (std::size_t k = 0; k < sleepers.list.size() && a.ok(); ++k) {
    const Sleeper& x = sleepers.list[k];
    a.require(b.info[x.id].slot == k);
    if (b.make(x.id).hull_count != 0) continue;
    a.require(x.shapes == 1 && x.first_shape < s.count_ && !s.shapes_[x.first_shape].alive);
    if (!a.ok()) break;
    s.shapes_[x.first_shape] = lone_piece(x.at, x.id, b.surface(x.id));
    s.shapes_[x.first_shape].asleep = true;
  }
  a.require(a.ok() && unpack_recent(span_of(sleepers.seen_.recent), sleepers, b));
  return false;
}

template bool Image::unpack(Loader&, World::Impl&, const World::Impl&, bool);
template void Image::sleepers(Saver&, Sleepers&, const BodyStore&);
template void Image::sleepers(Loader&, Sleepers&, const BodyStore&);

}  // namespace psim
