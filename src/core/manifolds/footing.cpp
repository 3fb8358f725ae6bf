// Which contacts of shapes stand on fixed ground, over other contacts of shapes: those of bodies that hang together with
// something fixed. Bodies that fall together do not, however they touch. Sets of bodies that hang together are found by
// union and find (Tarjan 1975).
//
// In: the active pairs of the step. Out: ManifoldPair::yields, and the pairs whose lanes must be written again.
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

void Manifolds::find_footing() {
  std::uint64_t touching = 0, placed = 0;
  bool changed = weighs_ != (g_ > 0);
  for (std::size_t s = 0; s < strip_count(); ++s) {
    touching += strips_[s].touching;
    placed += strips_[s].placed;
    changed |= stale_[s] != 0;
  }
  weighs_ = g_ > 0;
  const bool was_cold = std::exchange(cold_, weighs_ && 2 * placed > touching);
  if (!changed && cold_ == was_cold) return;
  const auto each_active = [&](const auto& visit) {
    for (std::size_t s = 0; s < strip_count(); ++s) {
      for (const std::uint32_t k : strips_[s].active) visit(strips_[s], k);
    }
  };
  const bool stand = weighs_ && !cold_;  // the many sweeps of a cold start need no help
  if (stand) {
    each_active([&](const StripBlocks&, std::uint32_t k) {
      used_[pairs_[k].b] = pairs_[k].b;
      if (!pairs_[k].of_piece()) used_[pairs_[k].a] = pairs_[k].a;
    });
    each_active([&](const StripBlocks&, std::uint32_t k) {
      const std::uint32_t b = set_of(used_, pairs_[k].b), a = pairs_[k].fixed_a ? kGround : set_of(used_, pairs_[k].a);
      if (b != kGround) {
        used_[b] = a;
      } else if (a != kGround) {
        used_[a] = b;
      }
    });
  }
  each_active([&](StripBlocks& strip, std::uint32_t k) {
    ManifoldPair& pair = pairs_[k];
    const bool yields = stand && !pair.fixed_a && set_of(used_, pair.b) == kGround;
    if (pair.yields == yields) return;
    pair.yields = yields;
    if (!pair.changed) strip.rewrite.push_back(k);
    pair.changed = true;
  });
}

}  // namespace psim
