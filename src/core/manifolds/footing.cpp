// Which contacts of shapes stand on fixed ground, over other contacts of shapes, or hang on it, over joints, too: those of
// bodies that hang together with something fixed. Bodies that fall together do not, however they touch. Sets of bodies that
// hang together are found by union and find (Tarjan 1975).
//
// In: the active pairs of the step. Out: ManifoldPair::stands and yields, and the pairs whose lanes must be written again.
#include <algorithm>
#include <numeric>
#include <utility>

#include "manifolds/manifolds.h"

namespace psim {
namespace {

constexpr std::uint32_t kGround = PairName::kNone;  // the set of the bodies that stand

// The set of a body: its first body, or the ground. Each body names one before it, the first one itself.
std::uint32_t set_of(Column<std::uint32_t>& of, std::uint32_t slot) {
  while (slot != kGround && of[slot] != slot) {
    const std::uint32_t next = of[slot];
    slot = of[slot] = next == kGround ? kGround : of[next];
  }
  return slot;
}

}  // namespace

// The slots of an active pair; a fixed side is the ground.
std::pair<std::uint32_t, std::uint32_t> Manifolds::sides_of_active(const StripBlocks& strip, std::uint32_t k) const {
  const std::uint32_t lane = steady_lane(strip, k);
  if (lane == PairName::kNone) return {pairs_[k].fixed_a ? kGround : pairs_[k].a, pairs_[k].b};
  const std::uint32_t block = lane / kernels::kBlock;
  const std::uint32_t* const body = strip.lasting.then[block].body + 2 * (lane % kernels::kBlock);
  return {block < strip.end[1] ? body[0] : kGround, body[1]};
}

// Finds the bodies that hang together with fixed ground: their entry in used_ is kGround. All strips at once unite their
// own bodies; then one thread goes over the pairs that reach across. The sets do not depend on the order.
void Manifolds::find_standing() {
  std::iota(used_.data(), used_.data() + s_.bodies.count, 0u);
  s_.pool.run(strip_count(), [&](std::size_t s) {
    StripBlocks& strip = strips_[s];
    const SlotRange own = s < ranges_.size() ? ranges_[s] : SlotRange{};
    strip.across.clear();
    for (const std::uint32_t k : strip.active) {
      const auto sides = sides_of_active(strip, k);
      if (own.has(sides.second) && (sides.first == kGround || own.has(sides.first))) {
        unite(sides.first, sides.second);
      } else {
        strip.across.push_back(sides);
      }
    }
  });
  for (std::size_t s = 0; s < strip_count(); ++s) {
    for (const auto& [a, b] : strips_[s].across) unite(a, b);
  }
  name_sets();
}

// Notes which bodies stand. Returns whether they are those of the last step.
bool Manifolds::stand_as_before() {
  const std::size_t n = s_.bodies.count;
  bool same = std::exchange(stood_known_, true);
  for (std::size_t slot = 0; slot < n; ++slot) {
    const std::uint8_t stands = used_[slot] == kGround ? 1 : 0;
    same &= std::exchange(stood_[slot], stands) == stands;
  }
  return same;
}

void Manifolds::unite(std::uint32_t slot_a, std::uint32_t slot_b) {
  const std::uint32_t a = set_of(used_, slot_a), b = set_of(used_, slot_b);
  if (a == b) return;
  if (a != kGround && (b == kGround || a > b)) {
    used_[a] = b;
  } else {
    used_[b] = a;
  }
}

// Lets each body name the first of its set: the one it names did so before.
void Manifolds::name_sets() {
  for (std::uint32_t slot = 0; slot < s_.bodies.count; ++slot) {
    if (used_[slot] != kGround) used_[slot] = used_[used_[slot]];
  }
}

bool Manifolds::footing_is_old() const {
  return g_ > 0 && (!weighs_ || std::ranges::any_of(strips_, &StripBlocks::others));
}

bool Manifolds::touches(const ManifoldPair& pair) const {
  return pair.least_gap() <= kTouching * s_.bodies.kind(pair.id_b).inner;
}

// Whether less than so many pairs touch.
bool Manifolds::touch_fewer(std::size_t many) const {
  std::size_t all = 0;
  for (std::size_t s = 0; s < strip_count() && all < many; ++s) {
    for (const std::uint32_t k : strips_[s].active) {
      all += touches(pairs_[k]) ? 1 : 0;
      if (all >= many) break;
    }
  }
  return all < many;
}

void Manifolds::find_footing() {
  const bool turned_on = weighs_ != (g_ > 0);
  bool changed = turned_on;
  for (std::size_t s = 0; s < strip_count(); ++s) changed |= strips_[s].others;
  const bool was_cold = std::exchange(cold_, false), weighed = std::exchange(weighs_, g_ > 0);
  if ((!changed && !was_cold) || (!weighs_ && !weighed)) return;  // nothing stands without gravity
  if (weighs_ && changed) find_standing();
  const bool tied = weighs_ && changed && !ties.empty();
  // Where the same bodies stand, only pairs that were no contacts in the last step may come to stand.
  const bool as_before = weighs_ && changed && stand_as_before();
  const bool few = as_before && !turned_on && !was_cold && !tied;
  if (!few) catch_up();
  // Where many sweeps do, nobody needs help.
  const auto yield = [&](std::size_t strip, std::uint32_t k, bool yields) {
    ManifoldPair& pair = pairs_[k];
    if (pair.yields == yields) return;
    pair.yields = yields;
    if (stale_[strip] == 0 && !pair.changed) strips_[strip].rewrite.push_back(k);
    pair.changed = true;
  };
  const auto look_again = [&](std::size_t strip, std::uint32_t k) {
    ManifoldPair& pair = pairs_[k];
    const bool stood = pair.stands;
    if (changed) pair.stands = pair.hangs = weighs_ && used_[pair.b] == kGround;
    if (pair.placed || (stood && !pair.stands)) strips_[strip].turned += touches(pair) ? 1 : 0;
    if (pair.stands && !stood && !pair.placed && touches(pair)) hold_out(k, strip);  // a group lands
    if (!tied) yield(strip, k, pair.hangs && !pair.fixed_a);
  };
  s_.pool.run(strip_count(), [&](std::size_t s) {
    strips_[s].turned = 0;
    for (const std::uint32_t k : few ? strips_[s].fresh : strips_[s].active) look_again(s, k);
  });
  std::size_t turned = 0;
  for (std::size_t s = 0; s < strip_count(); ++s) turned += strips_[s].turned;
  if (turned != 0 && few) catch_up();
  cold_ = weighs_ && touch_fewer(2 * turned);
  if (!tied && !cold_) return;
  if (tied) {
    for (const auto& [a, b] : ties) unite(a, b);
    name_sets();
  }
  each_active([&](std::size_t strip, std::uint32_t k) {
    ManifoldPair& pair = pairs_[k];
    if (tied) pair.hangs = used_[pair.b] == kGround;
    yield(strip, k, pair.hangs && !pair.fixed_a && !cold_);
  });
}

}  // namespace psim
