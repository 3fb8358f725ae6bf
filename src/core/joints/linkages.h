// All linkages of a world, and the passes over them in every substep, as joint_kernel_common.h has them for blocks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/tasks.h"
#include "base/worker_pool.h"
#include "joint_views.h"
#include "joints/linkage.h"
#include "views.h"

namespace psim {

class Linkages {
 public:
  /// Room for one more; its number. It is empty.
  std::uint32_t add();
  void remove(std::uint32_t number) { free_.push_back(number); }
  void clear() { all_.clear(), free_.clear(), stop(); }
  Linkage& operator[](std::uint32_t number) { return all_[number]; }
  const Linkage& operator[](std::uint32_t number) const { return all_[number]; }

  /// From now on the passes go over these, whose ends know their bodies. Within a colour no two move one body; those behind
  /// the last colour are solved one by one. O(linkages).
  void lay_out(std::span<const std::uint32_t> some, std::size_t members);
  void stop() { order_.clear(), colours_.clear(); }

  std::size_t count() const { return order_.size(); }
  std::span<const std::uint32_t> order() const { return order_; }
  std::size_t bytes() const { return bytes_of(all_, free_, order_, colours_); }

  void warm(const kernels::BodyView& view, const kernels::JointParams& p, WorkerPool& pool);
  void solve(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool);
  /// `view`: of the velocities for the drift alone.
  void push(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool);
  void relax(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool);

 private:
  template <class Each>
  void run(bool backwards, WorkerPool& pool, const Each& each);

  std::vector<Linkage> all_;
  std::vector<std::uint32_t> free_;
  std::vector<std::uint32_t> order_;  // by colour
  std::vector<BlockRange> colours_;   // in order_
  bool rest_ = false;                 // the last of them is no colour
};

}  // namespace psim
