// What the files that make manifolds share: how the two sides of a pair stand in this step.
#pragma once

#include <cstdint>
#include <optional>

#include "collide_batch.h"
#include "manifolds.h"

namespace psim {

inline constexpr float kMarginFrames = 1.25f;  // how far ahead contacts are looked for

/// The two sides of a pair, now.
struct Manifolds::Stand {
  std::int32_t x, y;     // lattice steps from A (or 0) to B
  float rest_x, rest_y;  // m: offsets likewise
  Rotor qa, qb;
  float vx, vy;          // m/s: B against A
  float inner;           // m: of the smaller one
  float wanted;          // m: gap from which they may touch within the step
};

/// Pairs of one kind that wait for a kernel.
struct Manifolds::Waiting {
  struct Lane {
    ManifoldPair* pair;
    Stand now;
    const Hull* a;
    const Hull* b;
    std::optional<Hull> own_a, own_b;  // hulls that lie nowhere else
  };
  CollideBatch batch;
  Lane lane[kernels::kBlock];
  Batches batches;
};

/// A hull against the plane at distance `offset` from its centre along the inward normal.
Manifold meet_plane(const Hull& hull, Rotor q, float nx, float ny, float offset, float margin);

}  // namespace psim
