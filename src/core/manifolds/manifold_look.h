// How the two sides of a pair stand in this step: shared by the files that make manifolds.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "manifolds/collide_batch.h"
#include "manifolds/manifolds.h"

namespace psim {

/// Frames of motion within which contacts are looked for.
inline constexpr auto kAheadFrames = static_cast<float>(kMarginFrames);

/// Looks at the pairs of a step.
struct Manifolds::Look {
  /// How the two sides of a pair stand now.
  struct Stand {
    LatticePoint at;  // from A (or 0) to B
    Rotor qa, qb;
    float vx, vy;  // m/s: the velocity of B relative to A
    float inner;   // m: the smaller inner radius
    float wanted;  // m: bodies with a smaller gap may touch within the step
  };
  /// Pairs of one kind that wait until a kernel has a full batch.
  struct Waiting {
    struct Lane {
      ManifoldPair* pair;
      Stand now;
      const Hull* a;
      const Hull* b;
      std::optional<Hull> own_a, own_b;  // hulls that are made for the pair
    };
    CollideBatch batch;
    Lane lane[kernels::kBlock];
  };

  const Hull& hull_of(std::size_t slot, std::uint16_t part, std::optional<Hull>& disc) const;
  bool lasts(ManifoldPair& pair, Stand& now) const;
  void find(ManifoldPair& pair, const Stand& now, Waiting* waiting, Looks& looks) const;
  void settle(Waiting& waiting, std::uint32_t kind, Looks& looks) const;
  void take(ManifoldPair& pair, const Stand& now, const Manifold& found, const Hull* a, const Hull& hull_b) const;
  Looks look(std::span<ManifoldPair> pairs) const;

  // manifold_ahead.cpp
  bool end_on(const ManifoldPair& pair, const Hull& piece, const Manifold& m, Vec2& face) const;
  void smooth_joint(ManifoldPair& pair, const Hull& hull, Rotor q, const Hull& piece, float margin) const;
  void judge(ManifoldPair& pair, const Stand& now) const;
  void foresee(ManifoldPair& pair, const Hull& a, Rotor qa, const Hull& hull, Vec2 way, float mx, float my,
               float inner) const;
  void see_fixed(std::span<ManifoldPair> pairs) const;

  const Manifolds& manifolds;
  const ManifoldParams& params;
  const BodyStore& b = manifolds.s_.bodies;
  const StaticShapes& statics = manifolds.s_.statics;
  const Lattice& lattice = manifolds.s_.lattice;
  const float g = manifolds.g_;
  const float dt = static_cast<float>(params.dt);
};

}  // namespace psim
