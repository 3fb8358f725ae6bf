// The passes over the blocks in every substep, and the sum of what they did to each body.
#include <algorithm>

#include "joints/joint_store.h"

namespace psim {

using kernels::JointParams;
using kernels::kBlock;

namespace {

void clear(float* vel, float* rim_speed, std::uint32_t begin, std::uint32_t end) {
  const std::size_t from = std::size_t{begin} * kBlock, to = std::size_t{end} * kBlock;
  std::fill(vel + 2 * from, vel + 2 * to, 0.0f);
  std::fill(rim_speed + from, rim_speed + to, 0.0f);
}

}  // namespace

template <class Pass>
void JointStore::sweep(const kernels::BodyView& view, const Pass& pass, const JointParams& p, bool backwards,
                       WorkerPool& pool) {
  for (std::size_t n = 0; n < phases_.size(); ++n) {
    const BlockRange& phase = phases_[backwards ? phases_.size() - 1 - n : n];
    pool.run(phase.end - phase.begin, [&](std::size_t i) {
      const BlockRange& job = jobs_[phase.begin + i];
      for (std::uint32_t at = job.begin; at < job.end; ++at) {
        const ListRange& r = ranges_[at];
        pass[r.list / 2][r.list & 1u](view, lists_.blocks(r.list), p, r.begin, r.end);
      }
    });
  }
}

// A whole pass. Its sweeps go forwards and backwards in turn.
template <class Pass>
void JointStore::sweep_all(const kernels::BodyView& view, const Pass& pass, bool backwards, WorkerPool& pool) {
  JointParams p = params_;
  for (int n = 0; n < sweeps_; ++n) {
    p.again = n != 0;
    sweep(view, pass, p, ((n & 1) != 0) != backwards, pool);
  }
}

template <class Each>
void JointStore::for_shares(const Each& each, WorkerPool& pool) {
  pool.run(share_jobs_.size(), [&](std::size_t n) {
    for (std::uint32_t r = share_jobs_[n].begin; r < share_jobs_[n].end; ++r) {
      each(share_ranges_[r].begin, share_ranges_[r].end);
    }
  });
}

// Sets share = v - share. A call before a pass and one after it leave in `share` what the joints did to the velocities.
void JointStore::part(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool) {
  for_shares([&](std::uint32_t begin, std::uint32_t end) { k.part_joints(view, share(), begin, end); }, pool);
}

void JointStore::warm(const kernels::BodyView& view, const kernels::KernelTable& k, float factor, WorkerPool& pool) {
  if (empty()) return;
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) {
        clear(share().vel, share().rim_speed, begin, end);
        k.part_joints(view, share(), begin, end);
      },
      pool);
  parted_ = true;
  params_.warm = factor;
  sweep(view, k.warm_joints, params_, false, pool);
}

void JointStore::solve(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool) {
  if (empty()) return;
  if (!parted_) part(view, k, pool);
  parted_ = false;
  sweep_all(view, k.solve_joints, false, pool);
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) {
        k.part_joints(view, share(), begin, end);
        clear(share().push, share().push_rim_speed, begin, end);
      },
      pool);
  kernels::BodyView pushed = view;
  pushed.vel = share().push;
  pushed.rim_speed = share().push_rim_speed;
  for (int n = 0; n < sweeps_ / 2; ++n) sweep(pushed, k.push_joints, params_, (n & 1) != 0, pool);
}

void JointStore::hold(const kernels::BodyView& view, const kernels::KernelTable& k, float sign, WorkerPool& pool) {
  if (empty()) return;
  for_shares([&](std::uint32_t begin, std::uint32_t end) { k.hold_joints(view, share(), sign, begin, end); }, pool);
}

void JointStore::relax(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool) {
  if (empty()) return;
  part(view, k, pool);
  sweep_all(view, k.relax_joints, true, pool);
  part(view, k, pool);
}

}  // namespace psim
