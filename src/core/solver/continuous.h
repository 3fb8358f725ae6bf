// Continuous collision: a body that moved far for its size in a step is put back to where it was half its inner radius
// deep in something. Contacts foresee what is near; this finds what a body would have jumped over. Discs collide with
// fixed geometry through their own contacts, at any speed (docs/solver.md).
//
// In: the motion of the step (disp, angle_change). Out: the same motion, cut at the first impact. Velocities stay, and
// the contact of the next step answers them. A body that is slow for its size costs a comparison.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "lists/pair_table.h"
#include "manifolds/manifolds.h"

namespace psim {

class Continuous {
 public:
  auto fields() { return std::tie(looked_); }  ///< for saved states

  /// Cuts the motion of fast shapes at fixed geometry, and of `bullets` (ids) at other moving bodies.
  /// Returns how many motions were cut. O(shapes), plus the shapes along the ways of fast ones.
  std::uint32_t stop(BodyStore& bodies, const Manifolds& manifolds, const PairTable& table, const StaticShapes& statics,
                     const Lattice& lattice, const std::vector<std::uint32_t>& bullets, bool filters, WorkerPool& pool);
  /// The number of fixed shapes that the last stop() tested against fast bodies.
  std::uint64_t looked() const { return looked_; }

  /// The number of bodies whose ways the last stop() looked at.
  std::uint32_t fast() const { return fast_count_; }

  void release() {
    std::vector<std::vector<std::uint32_t>>().swap(near_);
    std::vector<std::uint32_t>().swap(cut_);
    std::vector<std::uint32_t>().swap(found_fast_);
    std::vector<std::uint32_t>().swap(looks_);
    std::vector<std::uint8_t>().swap(fast_);
  }
  std::size_t bytes() const {
    std::size_t sum = near_.capacity() * sizeof(near_[0]) +
                      (cut_.capacity() + found_fast_.capacity() + looks_.capacity()) * sizeof(cut_[0]) +
                      fast_.capacity();
    for (const auto& near : near_) sum += near.capacity() * sizeof(near[0]);
    return sum;
  }

 private:
  void stop_at_fixed(BodyStore& bodies, const Manifolds& manifolds, const StaticShapes& statics, const Lattice& lattice,
                     bool filters, std::uint32_t slot, std::vector<std::uint32_t>& near);
  void stop_bullets(BodyStore& bodies, const Manifolds& manifolds, const PairTable& table, const Lattice& lattice,
                    const std::vector<std::uint32_t>& bullets);
  void stop_at_moving(BodyStore& bodies, const Lattice& lattice, std::uint32_t bullet, std::uint32_t other);

  std::vector<std::vector<std::uint32_t>> near_;  // by task
  std::vector<std::uint32_t> cut_, found_fast_;   // by task
  std::vector<std::uint32_t> looks_;              // by task
  std::uint64_t looked_ = 0;
  std::vector<std::uint8_t> fast_;  // by slot: the body is a fast bullet
  std::uint32_t fast_count_ = 0;
};

}  // namespace psim
