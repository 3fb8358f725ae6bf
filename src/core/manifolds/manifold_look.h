// How the two sides of a pair stand in this step: shared by the files that make manifolds.
#pragma once

#include <cstdint>
#include <optional>

#include "bodies/body_store.h"
#include "manifolds/collide_batch.h"
#include "manifolds/manifolds.h"

namespace psim {

/// Frames of motion within which contacts are looked for.
inline constexpr auto kAheadFrames = static_cast<float>(kMarginFrames);

/// How the two sides of a pair stand now.
struct Manifolds::Stand {
  std::int32_t x, y;     // lattice steps from A (or 0) to B
  float rest_x, rest_y;  // m: the same for the offsets
  Rotor qa, qb;
  float vx, vy;  // m/s: the velocity of B relative to A
  float inner;   // m: the smaller inner radius
  float wanted;  // m: bodies with a smaller gap may touch within the step
};

/// Pairs of one kind that wait until a kernel has a full batch.
struct Manifolds::Waiting {
  struct Lane {
    ManifoldPair* pair;
    Stand now;
    const Hull* a;
    const Hull* b;
    std::optional<Hull> own_a, own_b;  // hulls that are made for the pair
  };
  CollideBatch batch;
  Lane lane[kernels::kBlock];
  Batches batches;
};

/// A hull against the plane at distance `offset` from its centre along the inward normal.
Manifold meet_plane(const Hull& hull, Rotor q, float nx, float ny, float offset, float margin);

}  // namespace psim
