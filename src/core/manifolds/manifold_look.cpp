// Narrow phase of bodies that are not discs. For every pair, in any order and in parallel:
//   lasts    the manifold of the last step still holds: its gaps are computed anew
//   find     it does not hold: the hulls are looked at. Pairs of common kinds wait in batches of eight for a
//            kernel (collide_batch.h); walls and all others are done at once
//   take     the pair takes its new manifold, with the impulses of points that were there before
//   judge    whether the manifold counts in this step; foresee: where bodies will meet that are still apart
// Then see_fixed runs for each body, so that it slides over chains and tiles without a bump.
//
// A look at two boxes costs 35 ns in a batch (AVX2), 64 ns alone (2026-11-21, docs/kernels.md).
#include "manifolds/manifold_look.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace psim {

// Gives recalled impulses to the points of the manifold that was found.
void take_recalled(ManifoldPair& pair) {
  const Manifold& m = pair.manifold;
  if (m.count == 2 && pair.recalled == 2) {
    if (runs_backwards(m)) {
      std::swap(pair.impulse[0], pair.impulse[1]);
      std::swap(pair.friction[0], pair.friction[1]);
    }
  } else {  // the number of points changed: they share the sum
    const auto share = [&](float(&of)[2]) {
      const float each = (of[0] + of[1]) / static_cast<float>(std::max(m.count, 1));
      of[0] = each;
      of[1] = m.count == 2 ? each : 0.0f;
    };
    share(pair.impulse);
    share(pair.friction);
  }
  pair.recalled = 0;
  pair.balanced = ManifoldPair::kUnbalanced;
}

// Looks at pairs that are not steady, and counts how.
Manifolds::Looks Manifolds::look(const ManifoldParams& params, const Cut& cut) {
  const Look look{*this, params};
  // Offsets fade once neither side sleeps: the contact comes to the overlap that belongs to its stiffness.
  const auto fade = [&](ManifoldPair& pair) {
    if (pair.of_sleeper(s_.statics)) return;
    for (float& offset : pair.offset) offset = std::fabs(offset) > 1e-9f ? kFading * offset : 0.0f;
  };
  Looks looks;
  Look::Waiting waiting[CollideBatch::kKinds];
  StripBlocks& strip = strips_[cut.strip];
  for (std::uint32_t k = cut.begin; k < cut.end; ++k) {
    if (steady_lane(strip, k) != PairName::kNone) continue;
    ManifoldPair& pair = pairs_[k];
    if (known_lane_[k] != PairName::kNone) strip.lasting.forget(std::exchange(known_lane_[k], PairName::kNone));
    if (pair.moved) continue;
    pair.stack = ManifoldPair::kNoStack;
    pair.placed = false;
    if (pair.rest_frames != 0) --pair.rest_frames;
    if (pair.balanced > 0) fade(pair);
    Look::Stand now;
    if (look.lasts(pair, now)) {
      look.judge(pair, now);
      if (!pair.ahead) continue;
    }
    looks.again += pair.margin >= 0 ? 1 : 0;
    look.find(pair, now, waiting, looks);
  }
  for (std::uint32_t kind = 0; kind < CollideBatch::kKinds; ++kind) {
    if (waiting[kind].batch.count() != 0) look.settle(waiting[kind], kind, looks);
  }
  return looks;
}

}  // namespace psim
