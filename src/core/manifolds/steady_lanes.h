// Lanes of a strip whose manifolds last: kernels look at them (lasting_kernel.h), and nobody reads their pairs.
#pragma once

#include <cstdint>
#include <vector>

#include "base/column.h"
#include "lasting_views.h"
#include "manifolds/manifold_pair.h"

namespace psim {

struct SteadyLanes {
  std::vector<kernels::LastingBlock> then;  ///< by block: how the pairs were when their hulls were looked at
  /// By block, a bit for each lane: the manifold lasts, and counts in this step as in the last one. Its gaps and impulses are
  /// in the lane, and its pair may be out of date in them.
  std::vector<std::uint8_t> steady;

  std::uint32_t calm = 0;  ///< steps since other pairs got lanes
  /// Lanes are noted after so many: where pairs come and go, noting them takes longer than looking at them.
  static constexpr std::uint32_t kCalm = 4;

  bool is_steady(std::uint32_t lane) const {
    const std::size_t block = lane / kernels::kBlock;
    return block < steady.size() && (steady[block] >> lane % kernels::kBlock & 1u) != 0;
  }
  void reserve(std::size_t blocks) {
    then.reserve(blocks);
    steady.reserve(blocks);
  }
  /// No lane is known any more.
  void clear() {
    then.clear();
    steady.clear();
    calm = 0;
  }
  /// The pair of a lane does not last any more.
  void forget(std::uint32_t lane) {
    const std::size_t block = lane / kernels::kBlock;
    if (block >= then.size()) return;
    then[block].margin[lane % kernels::kBlock] = -1;
    if (!is_steady(lane))
      return;  // so that threads may forget lanes of one block at once, before any of them is steady
    steady[block] &= static_cast<std::uint8_t>(~(1u << lane % kernels::kBlock));
  }
  /// Notes pair k, which has a lane in so many blocks. `touching`, `deepest`: m, see kernels::LastingBlock.
  void note(std::size_t blocks, std::uint32_t k, const ManifoldPair& pair, float touching, float deepest);

  std::size_t bytes() const { return bytes_of(then, steady); }
};

}  // namespace psim
