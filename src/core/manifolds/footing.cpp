// Which contacts of shapes stand on fixed ground, over other contacts of shapes: those of bodies that hang together with
// something fixed. Bodies that fall together do not, however they touch. Sets of bodies that hang together are found by
// union and find (Tarjan 1975).
//
// In: the active pairs of the step. Out: ManifoldPair::stands and yields, and the pairs whose lanes must be written again.
#include <numeric>
#include <utility>

#include "manifolds/manifolds.h"

namespace psim {
namespace {

constexpr std::uint32_t kGround = 0xFFFFFFFFu;  // the set of the bodies that stand

// The set of a body. Each body names another one of its set, and the first one itself.
std::uint32_t set_of(Column<std::uint32_t>& of, std::uint32_t slot) {
  while (slot != kGround && of[slot] != slot) {
    const std::uint32_t next = of[slot];
    slot = of[slot] = next == kGround ? kGround : of[next];
  }
  return slot;
}

}  // namespace

// Finds the bodies that hang together with fixed ground: their entry in used_ leads to kGround.
void Manifolds::find_standing() {
  std::iota(used_.data(), used_.data() + s_.bodies.count, 0u);
  each_active([&](std::size_t, std::uint32_t k) {
    const PairName& pair = pairs_[k];
    const std::uint32_t b = set_of(used_, pair.b), a = pair.fixed_a ? kGround : set_of(used_, pair.a);
    if (b != kGround) {
      used_[b] = a;
    } else if (a != kGround) {
      used_[a] = b;
    }
  });
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
  bool changed = weighs_ != (g_ > 0);
  for (std::size_t s = 0; s < strip_count(); ++s) changed |= stale_[s] != 0;
  const bool was_cold = std::exchange(cold_, false), weighed = std::exchange(weighs_, g_ > 0);
  if ((!changed && !was_cold) || (!weighs_ && !weighed)) return;  // nothing stands without gravity
  if (weighs_ && changed) find_standing();
  // Where many sweeps do, nobody needs help.
  const auto yield = [&](std::size_t strip, std::uint32_t k, bool yields) {
    ManifoldPair& pair = pairs_[k];
    if (pair.yields == yields) return;
    pair.yields = yields;
    if (stale_[strip] == 0 && !pair.changed) strips_[strip].rewrite.push_back(k);
    pair.changed = true;
  };
  std::size_t turned = 0;
  each_active([&](std::size_t strip, std::uint32_t k) {
    ManifoldPair& pair = pairs_[k];
    const bool stood = pair.stands;
    if (changed) pair.stands = weighs_ && set_of(used_, pair.b) == kGround;
    if (pair.placed || (stood && !pair.stands)) turned += touches(pair) ? 1 : 0;
    if (pair.stands && !stood && !pair.placed && touches(pair))
      pair.rest_frames = kRestFrames;  // what hangs together lands
    yield(strip, k, pair.stands && !pair.fixed_a);
  });
  cold_ = weighs_ && touch_fewer(2 * turned);
  if (cold_) each_active([&](std::size_t strip, std::uint32_t k) { yield(strip, k, false); });
}

}  // namespace psim
