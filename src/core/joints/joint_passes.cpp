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
                       bool tethers) {
  const std::size_t end = tethers ? phases_.size() : joint_phases_;
  for (std::size_t n = 0; n < end; ++n) {
    jobs_.run(phases_[backwards ? end - 1 - n : n], s_.pool, [&](const ListRange& r) {
      pass[r.list / 2][r.list & 1u](view, lists_.blocks(r.list), p, r.begin, r.end);
    });
  }
}

// A whole pass. Its sweeps go forwards and backwards in turn, the first one over tethers, too.
template <class Pass, class Link>
void JointStore::sweep_all(const kernels::BodyView& view, const Pass& pass, const Link& link, bool backwards) {
  JointParams p = params_;
  for (int n = 0, end = sweeps(); n < end; ++n) {
    p.again = n != 0;
    const bool back = ((n & 1) != 0) != backwards;
    sweep(view, pass, p, back, n == 0);
    (linkages_.*link)(view, p, back, s_.pool);
  }
}

// Sets share = v - share. A call before a pass and one after it leave in `share` what the joints did to the velocities.
void JointStore::part(const kernels::BodyView& view) {
  shares_.run(s_.pool, [&](const ListRange& r) { s_.kernels.part_joints(view, share(), r.begin, r.end); });
}

void JointStore::warm_sweeps(const kernels::BodyView& view, float factor) {
  shares_.run(s_.pool, [&](const ListRange& r) {
    clear(share().vel, share().rim_speed, r.begin, r.end);
    s_.kernels.part_joints(view, share(), r.begin, r.end);
  });
  parted_ = true;
  params_.warm = factor;
  sweep(view, s_.kernels.warm_joints, params_, false, true);
  linkages_.warm(view, params_, s_.pool);
}

// Cycles start warm by themselves.
void JointStore::warm(const kernels::BodyView& view, float factor) {
  cycles_.warm = factor;
  if (cycles_.on()) return;
  warm_sweeps(view, factor * cycles_.scale);
  cycles_.scale = 1;
}

void JointStore::solve_sweeps(const kernels::BodyView& view) {
  if (!parted_) part(view);
  parted_ = false;
  sweep_all(view, s_.kernels.solve_joints, &Linkages::solve, false);
  shares_.run(s_.pool, [&](const ListRange& r) {
    s_.kernels.part_joints(view, share(), r.begin, r.end);
    clear(share().push, share().push_rim_speed, r.begin, r.end);
  });
  kernels::BodyView pushed = view;
  pushed.vel = share().push;
  pushed.rim_speed = share().push_rim_speed;
  for (int n = 0; n < sweeps() / 2; ++n) {
    sweep(pushed, s_.kernels.push_joints, params_, (n & 1) != 0, false);
    linkages_.push(pushed, params_, (n & 1) != 0, s_.pool);
  }
}

void JointStore::solve(const kernels::BodyView& view, float drift, float smooth_limit2) {
  if (cycles_.on()) {
    run_cycles(view, drift, smooth_limit2);
  } else {
    solve_sweeps(view);
  }
  articulations_.solve(view, static_cast<double>(drift), static_cast<double>(smooth_limit2), s_.pool);
}

void JointStore::hold_sweeps(const kernels::BodyView& view, const kernels::StreamParams& drift) {
  shares_.run(s_.pool, [&](const ListRange& r) { s_.kernels.hold_joints(view, share(), drift, r.begin, r.end); });
}

void JointStore::let_go_sweeps(const kernels::BodyView& view) {
  shares_.run(s_.pool, [&](const ListRange& r) { s_.kernels.let_go_joints(view, share(), r.begin, r.end); });
}

void JointStore::relax_sweeps(const kernels::BodyView& view) {
  part(view);
  sweep_all(view, s_.kernels.relax_joints, &Linkages::relax, true);
  part(view);
}

void JointStore::relax(const kernels::BodyView& view) {
  if (cycles_.on()) {
    leave_cycles(view);
  } else {
    relax_sweeps(view);
  }
  articulations_.finish(view, s_.bodies.angle.data(), s_.pool);
  if (!fragile_.empty()) add_loads();
}

}  // namespace psim
