// Collects pairs of hulls, so that a kernel finds the manifolds of eight at once, with the same bits as collide().
// A batch holds pairs of one kind: of like numbers of vertices.
#pragma once

#include <bit>
#include <cstdint>

#include "collide/collide.h"
#include "collide_views.h"
#include "kernel_table.h"

namespace psim {

class CollideBatch {
 public:
  static constexpr std::uint32_t kSizes = 4;  ///< discs, lines, up to four vertices, more
  static constexpr std::uint32_t kKinds = (kSizes - 1) * kSizes;

  /// The kind of a pair. kKinds if no kernel knows it: of two discs.
  static std::uint32_t kind_of(const Hull& a, const Hull& b);

  std::uint32_t count() const { return count_; }
  bool full() const { return count_ == kernels::kBlock; }
  /// Appends a pair of the kind of the batch. Its hulls must stay where they are until its manifold was taken.
  void add(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin);
  /// Finds the manifolds. `kind` is that of the pairs. Returns whether a kernel found them.
  bool solve(const kernels::KernelTable& kernels, std::uint32_t kind);
  /// The manifold of the pair that was added as number `k`.
  Manifold manifold(std::uint32_t k) const;
  /// How many manifolds were found one by one.
  std::uint32_t alone() const { return static_cast<std::uint32_t>(std::popcount(block_.hard & ((1u << count_) - 1u))); }
  void clear() { count_ = swapped_ = 0; }

 private:
  kernels::HullPairs block_;
  const Hull* a_[kernels::kBlock];
  const Hull* b_[kernels::kBlock];
  std::uint32_t count_ = 0;
  std::uint32_t swapped_ = 0;  // a bit for each lane whose A is the B of the kernel
};

}  // namespace psim
