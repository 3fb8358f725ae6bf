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

/// Before the drift: makes it go by the mean velocity where that is smooth, and puts the push in. For the places that is
/// where gravity and contacts did little, as the drift has it; for the angles, where joints or all together did. Else the
/// drift goes by the new velocities, with all that joints did: a body at rest, whose joints answer what a contact does to
/// it, would move by half of their answer. What rounding leaves of the speeds is nothing that others did.
template <class L>
void hold_joints(const BodyView& b, const JointShare& s, const StreamParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const auto half = Rec<L>(0.5f, 0.5f), zero = Rec<L>(0, 0), limit = Rec<L>(p.smooth_limit2, p.smooth_limit2);
  const auto four_h2 = Rec<L>(4 * p.h * p.h, 4 * p.h * p.h);
  constexpr float kNoise = 1e-12f;  // of the square of a speed
  const auto noise = Rec<L>(kNoise, kNoise);
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::records) {
    const auto v = L::load_rec(b.vel + 2 * i), v0 = L::load_rec(b.vel0 + 2 * i);
    const auto share = L::load_rec(s.vel + 2 * i), push = L::load_rec(s.push + 2 * i);
    const auto bound = b.acc ? limit + four_h2 * norm2(L::load_rec(b.acc + 2 * i)) : limit;
    // v - v0 is then what gravity and contacts did, by which the drift decides.
    const auto rest = noise * (norm2(v) + norm2(v0));
    const auto taken = select(norm2(squarable<L>((v - v0) - share)) <= bound + rest, half * share, zero);
    L::store_rec(s.push + 2 * i, push - taken);
    L::store_rec(s.push0 + 2 * i, push + taken);
    L::store_rec(b.vel + 2 * i, v + (push - taken));
    L::store_rec(b.vel0 + 2 * i, v0 + (push + taken));
  }
  const F<L> none = 0, part = 0.5f, least = p.smooth_limit2;
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    const auto u = L::load(b.rim_speed + i), u0 = L::load(b.rim_speed0 + i), share = L::load(s.rim_speed + i);
    const auto all = u - u0, others = all - share, push = L::load(s.push_rim_speed + i);
    const auto by_others = squarable<L>(others), by_all = squarable<L>(all);
    const auto smooth = ((by_others * by_others <= least + kNoise * (u * u + u0 * u0)) | (by_all * by_all <= least)) &
                        ((share < none) | (none < share));
    const auto taken = select(smooth, part * all, none);
    L::store(s.push_rim_speed + i, push - taken);
    L::store(s.push0_rim_speed + i, push + taken);
    L::store(b.rim_speed + i, u + (push - taken));
    L::store(b.rim_speed0 + i, u0 + (push + taken));
  }
}

/// After the drift: takes back what hold_joints() changed.
template <class L>
void let_go_joints(const BodyView& b, const JointShare& s, std::uint32_t begin, std::uint32_t end) {
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::records) {
    L::store_rec(b.vel + 2 * i, L::load_rec(b.vel + 2 * i) - L::load_rec(s.push + 2 * i));
    L::store_rec(b.vel0 + 2 * i, L::load_rec(b.vel0 + 2 * i) - L::load_rec(s.push0 + 2 * i));
  }
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    L::store(b.rim_speed + i, L::load(b.rim_speed + i) - L::load(s.push_rim_speed + i));
    L::store(b.rim_speed0 + i, L::load(b.rim_speed0 + i) - L::load(s.push0_rim_speed + i));
  }
}

}  // namespace
}  // namespace psim::kernels
