// Contacts as sleeping sees them: of discs and of shapes alike, by slot.
#pragma once

#include <algorithm>
#include <cmath>

#include "invariant.h"
#include "world_impl.h"

namespace psim {

inline constexpr float kClosing = 1.25f;  // frames of motion within which a body wakes what it will meet

// A contact of discs, seen from outside.
struct Met {
  std::uint32_t a, b;    // slots; a: kNoSlot if it is fixed
  std::uint32_t shape;   // of a fixed one
  float gap;             // m, at the frame's start
  bool bears;            // it carries an impulse
  Touch touch;
};

// The points of a manifold along its edge, in an order that depends on neither side.
inline void order_points(const ManifoldPair& pair, Touch& touch) {
  const Manifold& m = pair.manifold;
  touch = Touch{};
  touch.points = static_cast<std::uint32_t>(std::max(m.count, 1));
  const bool flip = m.count == 2 && runs_backwards(m);
  for (int k = 0; k < m.count; ++k) {
    const int at = flip ? 1 - k : k;
    touch.impulse[k] = pair.impulse[at];
    touch.friction[k] = pair.friction[at];
  }
}

// each(met): every contact of the present lists that has a body on it, of strips for which wanted(strip) is true; none
// while a step under way over frames makes new ones.
template <class Each, class Wanted>
void World::Impl::each_contact(const Each& each, const Wanted& wanted) const {
  PSIM_ASSERT(!saved.named && !saved.missing && !saved.shaped && !saved.undone);
  if (!contacts_stand()) return;
  const bool rough = contacts.rough();
  Met met;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    if (!wanted(k)) continue;
    const Strip& s = table.strips[k];
    met.shape = kNoSlot;
    met.touch.per_mass = plan.model.model == kernels::Model::plain;
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      met.a = table.owner[p];
      met.b = table.other[p];
      if (bodies.id[met.a] == kNoSlot || bodies.id[met.b] == kNoSlot) continue;
      const std::size_t lane = table.contact[p];
      met.gap = contacts.gap[lane];
      met.touch.impulse[0] = contacts.impulse[lane];
      met.touch.friction[0] = rough ? contacts.friction[lane] : 0.0f;
      met.bears = met.touch.impulse[0] > 0;
      each(met);
    }
    met.a = kNoSlot;
    for (const SinglePair& single : table.singles[k]) {
      if (bodies.id[single.body] == kNoSlot) continue;
      met.b = single.body;
      met.shape = single.shape;
      const std::size_t lane = single.contact;
      met.gap = contacts.s_gap[lane];
      met.touch.impulse[0] = contacts.s_impulse[lane];
      met.touch.friction[0] = rough ? contacts.s_friction[lane] : 0.0f;
      met.bears = met.touch.impulse[0] > 0;
      each(met);
    }
    if (!plan.shapes || k >= manifolds.strip_count()) continue;
    for (const ManifoldPair& pair : manifolds.pairs_of(k)) {
      if (bodies.id[pair.b] == kNoSlot || (pair.a != kNoSlot && bodies.id[pair.a] == kNoSlot)) continue;
      met.a = pair.a;
      met.b = pair.b;
      met.shape = pair.shape;
      switch (pair.manifold.count) {
        case 2: met.gap = std::fmin(pair.gap[0], pair.gap[1]); break;
        case 1: met.gap = pair.gap[0]; break;
        default: met.gap = std::fmax(pair.margin, 0.0f);  // at least: nothing was found within it
      }
      met.bears = manifolds.closed(k, pair);
      order_points(pair, met.touch);
      each(met);
    }
    met.touch = Touch{};
  }
}

inline std::uint64_t key_of(const Met& met, const BodyStore& b, const StaticShapes& shapes) {
  const std::uint32_t id = b.id[met.b];
  if (met.a != kNoSlot) return TouchKey::bodies(b.id[met.a], id);
  if (met.shape < kWallLeft && shapes[met.shape].asleep) {
    return TouchKey::bodies(shapes[met.shape].owner, id);
  }
  return TouchKey::fixed(id, met.shape);
}

}  // namespace psim
