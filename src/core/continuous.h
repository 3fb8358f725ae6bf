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
 public:
  /// Cuts the motion of fast shapes at fixed geometry, and of `bullets` (ids) at other moving bodies.
  /// Returns how many bodies were cut. O(shapes), and for fast ones what is along their way.
  std::uint32_t stop(BodyStore& bodies, const Manifolds& manifolds, const PairTable& table,
                     const StaticShapes& shapes, const Lattice& lattice,
                     const std::vector<std::uint32_t>& bullets, bool filters, WorkerPool& pool);
  /// At how many fixed shapes fast bodies were looked at by the last stop().
  std::uint64_t looked() const { return looked_; }

 private:
  void stop_at_fixed(BodyStore& bodies, const Manifolds& manifolds, const StaticShapes& shapes,
                     const Lattice& lattice, bool filters, std::uint32_t slot,
                     std::vector<std::uint32_t>& near);
  void stop_at_moving(BodyStore& bodies, const Lattice& lattice,
                      std::uint32_t bullet, std::uint32_t other);

  std::vector<std::vector<std::uint32_t>> near_;  // by task
  std::vector<std::uint32_t> cut_;                // by task
  std::vector<std::uint32_t> looks_;              // by task
  std::uint64_t looked_ = 0;
  std::vector<std::uint8_t> fast_;                // by slot: a fast bullet
};

}  // namespace psim
