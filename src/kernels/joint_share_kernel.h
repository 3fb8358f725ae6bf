// What joints did in a substep, summed by body: streams over bodies. The drift must know which part of
// v - v0 it was (docs/joints.md).
#pragma once

#include "joint_views.h"
#include "lane_vec.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// Before and after a pass over joints: share = v - share. Twice, with joints alone in between, that
/// adds what they did.
template <class L>
void part_joints(const BodyView& b, const JointShare& s, std::uint32_t begin, std::uint32_t end) {
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::records) {
    L::store_rec(s.vel + 2 * i, L::load_rec(b.vel + 2 * i) - L::load_rec(s.vel + 2 * i));
  }
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    L::store(s.rim_speed + i, L::load(b.rim_speed + i) - L::load(s.rim_speed + i));
  }
}

/// Around the drift (sign 1, then -1): half of the share out of the velocities, and the push in. v - v0
/// is then what gravity and contacts did.
template <class L>
void hold_joints(const BodyView& b, const JointShare& s, float sign, std::uint32_t begin, std::uint32_t end) {
  const auto half = Rec<L>(0.5f * sign, 0.5f * sign), whole = Rec<L>(sign, sign);
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::records) {
    const auto d = half * L::load_rec(s.vel + 2 * i);
    const auto e = whole * L::load_rec(s.push + 2 * i);
    L::store_rec(b.vel + 2 * i, L::load_rec(b.vel + 2 * i) + (e - d));
    L::store_rec(b.vel0 + 2 * i, L::load_rec(b.vel0 + 2 * i) + (e + d));
  }
  const F<L> part = 0.5f * sign, one = sign;
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    const auto d = one * L::load(s.push_rim_speed + i) - part * L::load(s.rim_speed + i);
    L::store(b.rim_speed + i, L::load(b.rim_speed + i) + d);
  }
}

}  // namespace
}  // namespace psim::kernels
