// Which pairs have lanes that kernels look at, and how the pairs learn what these lanes have.
//
// A pair whose manifold did not change in a step is noted beside its lane. In later steps the kernel computes its gaps, and
// finds whether it still lasts and counts as before. While it does, it is steady, and a step does not read the pair: 216
// bytes, of which the kernel needs 104. Whether a pair is noted changes no bit of a result.
#include "manifolds/steady_lanes.h"

#include <algorithm>

#include "base/tasks.h"
#include "manifolds/manifold_look.h"
#include "manifolds/stacks.h"

namespace psim {

using kernels::kBlock;
using kernels::LastingBlock;

void SteadyLanes::note(std::size_t blocks, std::uint32_t k, const ManifoldPair& pair, float touching, float deepest) {
  if (then.size() < blocks) {
    LastingBlock unknown{};
    std::ranges::fill(unknown.margin, -1.0f);
    then.resize(blocks, unknown);
    steady.resize(blocks);
  }
  LastingBlock& t = then[pair.lane / kBlock];
  const std::uint32_t l = pair.lane % kBlock;
  const Manifold& m = pair.manifold;
  t.body[2 * l] = pair.of_piece() ? pair.b : pair.a;
  t.body[2 * l + 1] = pair.b;
  t.pair[l] = k;
  t.x[l] = pair.base.x, t.y[l] = pair.base.y;
  t.dx[l] = pair.base.dx, t.dy[l] = pair.base.dy;
  t.ac[l] = pair.turn_a.c, t.as[l] = pair.turn_a.s;
  t.bc[l] = pair.turn_b.c, t.bs[l] = pair.turn_b.s;
  t.nx[l] = m.nx, t.ny[l] = m.ny;
  t.margin[l] = pair.margin;
  t.touching[l] = touching;
  t.deepest[l] = deepest;
  for (int p = 0; p < 2; ++p) {
    const bool there = p < m.count;
    const ManifoldPoint point = there ? m.point[p] : ManifoldPoint{};
    t.gap[p][l] = there ? point.gap : 2 * kernels::kNoPoint;
    t.ax[p][l] = there ? point.ax - pair.round_a * m.nx : 0.0f;
    t.ay[p][l] = there ? point.ay - pair.round_a * m.ny : 0.0f;
    t.bx[p][l] = there ? point.bx + pair.round_b * m.nx : 0.0f;
    t.by[p][l] = there ? point.by + pair.round_b * m.ny : 0.0f;
  }
}

// Whether the kernel may look at a pair from now on: it lies in its lane as it is, and whatever else a step looks for
// cannot be in it.
bool Manifolds::may_be_steady(std::uint32_t k) const {
  const ManifoldPair& pair = pairs_[k];
  if (!pair.active || pair.changed || pair.manifold.count == 0 || !(pair.margin >= 0) || !pair.lasting) return false;
  if (pair.of_floor() || pair.ahead || pair.ghost || pair.rocking || pair.landing || pair.flying || pair.placed ||
      pair.moved || pair.recalled != 0 || pair.rest_frames != 0) {
    return false;
  }
  if (pair.stack != ManifoldPair::kNoStack || pair.was_stack != ManifoldPair::kNoStack) return false;
  if (pair.balanced != ManifoldPair::kBalanced || pair.offset[0] != 0 || pair.offset[1] != 0) return false;
  if (!has_corners(pair.b)) return false;
  if (!pair.of_piece()) return !pair.fixed_a && has_corners(pair.a);
  if (pair.of_wall() || any_kinematic_) return false;
  const StaticShape& piece = s_.statics[pair.shape];
  if (piece.segment || piece.asleep) return false;
  // The only piece near its body.
  const auto is_of_body = [&](const ManifoldPair& o) { return o.of_piece() && o.b == pair.b; };
  return (k == 0 || !is_of_body(pairs_[k - 1])) && (k + 1 == pairs_.size() || !is_of_body(pairs_[k + 1]));
}

// Notes the pairs of a strip whose lanes the kernel may look at, among those that it does not look at yet.
void Manifolds::note_steady(std::size_t index) {
  StripBlocks& strip = strips_[index];
  for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
    if (known_lane_[k] != PairName::kNone || !may_be_steady(k)) continue;
    const ManifoldPair& pair = pairs_[k];
    if (!lies(index, pair)) continue;
    const float inner = s_.bodies.kind(pair.id_b).inner;
    strip.lasting.note(strip.blocks.size(), k, pair, kTouching * inner, pair.of_piece() ? -kDeep * inner : -kNoGap);
    known_lane_[k] = pair.lane;
  }
}

void Manifolds::forget_steady(std::size_t index) {
  strips_[index].lasting.clear();
  if (index + 1 >= begin_.size()) return;
  const auto size = static_cast<std::uint32_t>(known_lane_.size());
  std::fill(known_lane_.begin() + std::min(begin_[index], size),
            known_lane_.begin() + std::min(begin_[index + 1], size), PairName::kNone);
}

void Manifolds::forget_steady(std::uint32_t k, std::size_t index) {
  if (k >= known_lane_.size() || known_lane_[k] == PairName::kNone) return;
  catch_up(strips_[index], k);
  strips_[index].lasting.forget(std::exchange(known_lane_[k], PairName::kNone));
}

// The pair takes over what its lane has.
void Manifolds::catch_up(const StripBlocks& strip, std::uint32_t k) {
  if (k >= known_lane_.size() || known_lane_[k] == PairName::kNone || !strip.lasting.is_steady(known_lane_[k])) return;
  take_from_lane(strip, pairs_[k]);
  const kernels::ManifoldBlock& c = strip.blocks[known_lane_[k] / kBlock];
  for (int p = 0; p < pairs_[k].manifold.count; ++p) pairs_[k].gap[p] = c.point[p].gap[known_lane_[k] % kBlock];
}

void Manifolds::catch_up(std::size_t index) {
  const StripBlocks& strip = strips_[index];
  if (strip.lasting.steady.empty()) return;
  for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) catch_up(strip, k);
}

void Manifolds::catch_up() {
  if (begin_.empty()) return;
  s_.pool.run(strip_count(), [&](std::size_t index) { catch_up(index); });
}

void Manifolds::take_from_lane(const StripBlocks& strip, ManifoldPair& pair) {
  const std::size_t block = pair.lane / kBlock;
  const std::uint32_t l = pair.lane % kBlock;
  const kernels::ManifoldBlock& c = strip.blocks[block];
  if (!strip.surfaces.empty()) pair.roll = strip.surfaces[block].roll[l];
  for (int p = 0; p < 2; ++p) {
    const float impulse = c.point[p].impulse[l];
    pair.impulse[p] = impulse > 0 ? impulse : 0.0f;
    pair.friction[p] = c.point[p].friction[l];
  }
}

void Manifolds::keep_impulses() {
  if (begin_.empty() || !laid_) return;
  laid_ = false;
  s_.pool.run(strip_count(), [&](std::size_t s) {
    const StripBlocks& strip = strips_[s];
    for (const std::uint32_t k : strip.laid) {
      if (steady_lane(strip, k) != PairName::kNone) {
        catch_up(strip, k);
      } else if (pairs_[k].lane != PairName::kNone) {
        take_from_lane(strip, pairs_[k]);
      }
    }
  });
}

void Manifolds::set_stack_role(std::uint32_t k, ManifoldPair::StackRole role) {
  const std::size_t strip = strip_of(k);
  forget_steady(k, strip);
  ManifoldPair& pair = pairs_[k];
  pair.stack = role;
  if (pair.was_stack == ManifoldPair::kNoStack) strips_[strip].rewrite.push_back(k);
}

void Manifolds::hold_out(std::uint32_t k, std::size_t strip) {
  forget_steady(k, strip);
  pairs_[k].rest_frames = kRestFrames;
}

// Finds the lanes that last; all other pairs take over their impulses. In worlds with surfaces, and while two lists of pairs
// exist, all pairs are looked at one by one. Nothing here can fail, so that a step that fails later can be done again.
void Manifolds::look_in_lanes(const ManifoldParams& params, bool allowed) {
  kernels::LastingParams p;
  p.pitch_x = static_cast<float>(s_.lattice.pitch_x());
  p.pitch_y = static_cast<float>(s_.lattice.pitch_y());
  p.dt = static_cast<float>(params.dt);
  p.ahead = kAheadFrames * p.dt;
  p.fall = g_ * p.dt;
  p.sinks = g_ * p.dt * p.dt;
  p.nearby = kNearby;
  p.lasting = kLasting;
  p.rocking = kRocking;
  p.apart = kApart;
  p.fallen = kFallen;
  p.slow = kSlow;
  const kernels::BodyView view = s_.bodies.view();
  const kernels::LastingColumns columns{rotor_.data(), inner_.data(), s_.bodies.radius.data()};
  s_.pool.run(strip_count(), [&](std::size_t index) {
    StripBlocks& strip = strips_[index];
    SteadyLanes& lanes = strip.lasting;
    if (!allowed && !lanes.then.empty()) {
      catch_up(index);
      forget_steady(index);
    }
    const auto blocks = static_cast<std::uint32_t>(lanes.then.size()), mid = std::min(strip.end[1], blocks);
    const auto look = [&](std::size_t fixed, std::uint32_t begin, std::uint32_t end) {
      s_.kernels.last_manifolds[fixed](view, columns, strip.blocks.data(), lanes.then.data(), p, lanes.steady.data(),
                                       begin, end);
    };
    look(0, 0, mid);
    look(1, mid, blocks);
    for (const std::uint32_t k : strip.laid) {
      if (laid_ && steady_lane(strip, k) == PairName::kNone && pairs_[k].lane != PairName::kNone) {
        take_from_lane(strip, pairs_[k]);
      }
    }
  });
  laid_ = false;
}

}  // namespace psim
