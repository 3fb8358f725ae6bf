// Continuous collision: bodies that went far for their size in a step are put back to where they were
// half their inner radius deep in something. Contacts foresee what is near; this finds what a body would have jumped over. Discs
// meet fixed geometry through their own contacts, at any speed (docs/solver.md).
//
// In: motion of the step (disp, swing). Out: the same, cut at the first impact. Velocities stay: the
// next step's contact takes them. Bodies that are slow for their size cost a comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "lattice.h"
#include "manifolds.h"
#include "pair_table.h"
#include "static_shapes.h"
#include "worker_pool.h"

namespace psim {

class Continuous {
  friend struct Image;

 public:
  /// Cuts the motion of fast shapes at fixed geometry, and of `bullets` (ids) at other moving bodies.
  /// Returns how many bodies were cut. O(shapes), and for fast ones what is along their way.
  std::uint32_t stop(BodyStore& bodies, const Manifolds& manifolds, const PairTable& table,
                     const StaticShapes& shapes, const Lattice& lattice,
                     const std::vector<std::uint32_t>& bullets, bool filters, WorkerPool& pool);
  /// At how many fixed shapes fast bodies were looked at by the last stop().
  std::uint64_t looked() const { return looked_; }

  /// Bodies whose way the last call looked at.
  std::uint32_t fast() const { return fast_count_; }

  void release() {
    std::vector<std::vector<std::uint32_t>>().swap(near_);
    std::vector<std::uint32_t>().swap(cut_);
    std::vector<std::uint32_t>().swap(found_fast_);
    std::vector<std::uint32_t>().swap(looks_);
    std::vector<std::uint8_t>().swap(fast_);
  }
  std::size_t bytes() const {
    std::size_t sum = near_.capacity() * sizeof(near_[0]) + (cut_.capacity() + found_fast_.capacity() + looks_.capacity()) * sizeof(cut_[0]) + fast_.capacity();
    for (const auto& near : near_) sum += near.capacity() * sizeof(near[0]);
    return sum;
  }

 private:
  void stop_at_fixed(BodyStore& bodies, const Manifolds& manifolds, const StaticShapes& shapes,
                     const Lattice& lattice, bool filters, std::uint32_t slot,
                     std::vector<std::uint32_t>& near);
  void stop_at_moving(BodyStore& bodies, const Lattice& lattice,
                      std::uint32_t bullet, std::uint32_t other);

  std::vector<std::vector<std::uint32_t>> near_;  // by task
  std::vector<std::uint32_t> cut_, found_fast_;   // by task
  std::vector<std::uint32_t> looks_;              // by task
  std::uint64_t looked_ = 0;
  std::vector<std::uint8_t> fast_;                // by slot: a fast bullet
  std::uint32_t fast_count_ = 0;
};

}  // namespace psim
