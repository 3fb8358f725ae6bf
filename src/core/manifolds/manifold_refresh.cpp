// Narrow phase of bodies that are not discs. For every pair, in any order and in parallel:
//   lasts    the manifold of the last step still holds: its gaps are computed anew
//   find     it does not hold: the hulls are looked at. Pairs of common kinds wait in batches of eight for a
//            kernel (collide_batch.h); walls and all others are done at once
//   take     the pair takes its new manifold, with the impulses of points that were there before
// Then see_fixed (manifold_ahead.cpp) runs for each body. A strip is a job; a batch never outlives it.
//
// A look at two boxes costs 35 ns in a batch (AVX2), 64 ns alone (2026-11-21, docs/kernels.md).
#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "base/sort_keys.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

// A manifold lasts while no point of its bodies has moved, relative to the other body, by more than this share of the
// smaller inner radius.
constexpr float kLasting = 0.02f;
constexpr float kThin = 0.2f;     // the inner radius counts as at least this share of the reach
constexpr float kFading = 0.95f;  // factor on offsets in a frame
constexpr float kNearby = 0.02f;  // contacts are looked for up to this share of the inner radius

float smaller(float a, float b) { return a < b ? a : b; }  // std::fmin is a call
float larger(float a, float b) { return a > b ? a : b; }

// Gives recalled impulses to the points of the manifold that was found.
void take_recalled(ManifoldPair& pair) {
  const Manifold& m = pair.manifold;
  if (m.count == 2 && pair.recalled == 2) {
    if (runs_backwards(m)) {
      std::swap(pair.impulse[0], pair.impulse[1]);
      std::swap(pair.friction[0], pair.friction[1]);
    }
  } else {  // the number of points changed: they share the sum
    const auto share = [&](float(&of)[2]) {
      const float each = (of[0] + of[1]) / static_cast<float>(std::max(m.count, 1));
      of[0] = each;
      of[1] = m.count == 2 ? each : 0.0f;
    };
    share(pair.impulse);
    share(pair.friction);
  }
  pair.recalled = 0;
  pair.balanced = ManifoldPair::kUnbalanced;
}

}  // namespace

// The hull of a body. That of a disc is made in `disc`.
const Hull& Manifolds::Look::hull_of(std::size_t slot, std::uint16_t part, std::optional<Hull>& disc) const {
  if (!manifolds.has_corners(slot)) return disc.emplace(disc_hull(b.radius[slot]));
  return b.hulls[b.kind(b.id[slot]).first_hull + part];
}

// Whether the manifold of a pair still holds. If so, its gaps are computed anew. Fills in how the pair stands.
bool Manifolds::Look::lasts(ManifoldPair& pair, Stand& now) const {
  const bool fixed = pair.a == ManifoldPair::kNone;
  const std::size_t j = pair.b, i = fixed ? 0 : pair.a;
  const auto rotor = [&](std::size_t slot) { return manifolds.has_corners(slot) ? manifolds.rotor(slot) : Rotor{}; };
  const auto inner_of = [&](std::size_t slot) {
    return manifolds.has_corners(slot) ? manifolds.inner_[slot] : b.radius[slot];
  };
  // The vector from A to B now, and how far it moved since the hulls were looked at.
  now.at = b.point(j);
  if (!fixed) {
    const LatticePoint a = b.point(i);
    now.at = {wrap_sub(now.at.x, a.x), wrap_sub(now.at.y, a.y), now.at.dx - a.dx, now.at.dy - a.dy};
  }
  now.qb = rotor(j);
  now.qa = fixed ? Rotor{} : rotor(i);
  const Vec2 move = lattice.way(pair.base, now.at);
  const auto move_x = static_cast<float>(move.x), move_y = static_cast<float>(move.y);
  // Bodies with a smaller gap may touch within the step.
  now.vx = b.vel[2 * j], now.vy = b.vel[2 * j + 1];
  float rim_speed = std::fabs(b.rim_speed[j]);
  now.inner = inner_of(j);
  if (!fixed) {
    now.vx -= b.vel[2 * i];
    now.vy -= b.vel[2 * i + 1];
    rim_speed += std::fabs(b.rim_speed[i]);
    now.inner = smaller(inner_of(i), now.inner);
  }
  const float closing = std::sqrt(now.vx * now.vx + now.vy * now.vy) + rim_speed + g * dt;
  now.wanted = kNearby * now.inner + kAheadFrames * dt * closing;

  const auto turned = [](Rotor to, Rotor from) { return std::fabs(from.c * to.s - from.s * to.c); };
  const float moved = std::sqrt(move_x * move_x + move_y * move_y) + b.radius[j] * turned(now.qb, pair.turn_b) +
                      (fixed ? 0.0f : b.radius[i] * turned(now.qa, pair.turn_a));
  const bool serves = pair.margin >= 0 && now.wanted + moved <= pair.margin && moved < kLasting * now.inner;
  if (!serves || (!pair.lasting && pair.manifold.count != 0)) return false;
  const Manifold& m = pair.manifold;
  for (int k = 0; k < m.count; ++k) {
    const ManifoldPoint& p = m.point[k];
    // The arms turned with their bodies since then, all but the part that is rounding.
    const auto swung = [&](Rotor to, Rotor from, float rx, float ry) {
      const float c = from.c * to.c + from.s * to.s - 1, s = from.c * to.s - from.s * to.c;
      return m.nx * (c * rx - s * ry) + m.ny * (s * rx + c * ry);
    };
    float s = p.gap + (m.nx * move_x + m.ny * move_y);
    s += swung(now.qb, pair.turn_b, p.bx + pair.round_b * m.nx, p.by + pair.round_b * m.ny);
    if (!fixed) {
      s -= swung(now.qa, pair.turn_a, p.ax - pair.round_a * m.nx, p.ay - pair.round_a * m.ny);
    }
    pair.gap[k] = s;
  }
  return true;
}

// Looks at the hulls of a pair: at once, or together with others of its kind.
void Manifolds::Look::find(ManifoldPair& pair, const Stand& now, Waiting* waiting, Looks& looks) const {
  const std::size_t j = pair.b;
  const float margin = now.wanted + 2 * kLasting * now.inner;
  std::optional<Hull> own_a, own_b;
  const Hull& hull_b = hull_of(j, pair.part_b, own_b);
  pair.round_b = hull_b.radius;
  pair.round_a = 0;
  if (pair.a == ManifoldPair::kNone && pair.shape >= kWallLeft) {
    ++looks.alone;
    const Vec2 low = lattice.way(params.walls.low, now.at), high = lattice.way(params.walls.high, now.at);
    const auto meet = [&](float nx, float ny, double offset) {
      take(pair, now, meet_plane(hull_b, now.qb, nx, ny, static_cast<float>(offset), margin), nullptr, hull_b);
    };
    if (pair.shape == kWallLeft) return meet(1, 0, low.x);
    if (pair.shape == kWallRight) return meet(-1, 0, -high.x);
    if (pair.shape == kWallBottom) return meet(0, 1, low.y);
    return meet(0, -1, -high.y);
  }
  Vec2 way;
  if (pair.a == ManifoldPair::kNone) {
    const double size = b.radius[j] + margin + statics[pair.shape].radius;
    own_a = statics.seen_from(pair.shape, b.point(j), 4 * size);
  } else {
    way = lattice.way({}, now.at);
  }
  const auto dx = static_cast<float>(way.x), dy = static_cast<float>(way.y);
  const Hull& hull_a = own_a ? *own_a : hull_of(pair.a, pair.part_a, own_a);
  pair.round_a = hull_a.radius;
  const std::uint32_t kind = CollideBatch::kind_of(hull_a, hull_b);
  if (kind == CollideBatch::kKinds) {
    ++looks.alone;
    take(pair, now, collide(hull_a, now.qa, hull_b, now.qb, dx, dy, margin), &hull_a, hull_b);
    return;
  }
  Waiting& of_kind = waiting[kind];
  Waiting::Lane& lane = of_kind.lane[of_kind.batch.count()];
  lane.pair = &pair;
  lane.now = now;
  lane.a = own_a ? &lane.own_a.emplace(*own_a) : &hull_a;
  lane.b = own_b ? &lane.own_b.emplace(*own_b) : &hull_b;
  of_kind.batch.add(*lane.a, now.qa, *lane.b, now.qb, dx, dy, margin);
  if (of_kind.batch.full()) settle(of_kind, kind, looks);
}

// Finds the manifolds of the pairs that wait.
void Manifolds::Look::settle(Waiting& waiting, std::uint32_t kind, Looks& looks) const {
  waiting.batch.solve(manifolds.s_.kernels, kind);
  const std::uint32_t alone = waiting.batch.alone();
  looks += {waiting.batch.in_lanes() ? kernels::kBlock : 0u, waiting.batch.count() - alone, alone, 0};
  for (std::uint32_t k = 0; k < waiting.batch.count(); ++k) {
    const Waiting::Lane& lane = waiting.lane[k];
    take(*lane.pair, lane.now, waiting.batch.manifold(k), lane.a, *lane.b);
  }
  waiting.batch.clear();
}

// Puts a manifold that was found into its pair.
void Manifolds::Look::take(ManifoldPair& pair, const Stand& now, const Manifold& found, const Hull* a,
                           const Hull& hull_b) const {
  const bool fixed = pair.a == ManifoldPair::kNone;
  const float margin = now.wanted + 2 * kLasting * now.inner;
  const Manifold old = pair.manifold;
  pair.manifold = found;
  if (fixed && a != nullptr && statics[pair.shape].segment) {
    smooth_joint(pair, hull_b, now.qb, *a, margin);
  }
  pair.base = now.at;
  pair.turn_a = now.qa;
  pair.turn_b = now.qb;
  pair.margin = margin;
  pair.changed = true;
  // The manifold of a rolling body does not last, since its normal turns in every step.
  const Manifold& m = pair.manifold;
  pair.lasting = m.count == 2 || (pair.round_a == 0 && pair.round_b == 0);
  float impulse[2] = {}, friction[2] = {};
  for (int k = 0; k < m.count; ++k) {
    pair.gap[k] = m.point[k].gap;
    for (int o = 0; o < old.count && pair.recalled == 0; ++o) {
      if (old.point[o].feature != m.point[k].feature) continue;
      impulse[k] = pair.impulse[o];
      friction[k] = pair.friction[o];
    }
  }
  if (pair.recalled != 0) {
    take_recalled(pair);
  } else {
    std::copy(impulse, impulse + 2, pair.impulse);
    std::copy(friction, friction + 2, pair.friction);
  }
  judge(pair, now);
  if (pair.ahead && !fixed) {
    foresee(pair, *a, now.qa, hull_b, lattice.way({}, now.at), now.vx * dt, now.vy * dt, now.inner);
  }
}

// Looks at pairs, and counts how.
Manifolds::Looks Manifolds::Look::look(std::span<ManifoldPair> pairs) const {
  // Offsets fade once neither side sleeps: the contact comes to the overlap that belongs to its stiffness.
  const auto fade = [&](ManifoldPair& pair) {
    if (pair.a == PairName::kNone && pair.shape < kWallLeft && statics[pair.shape].asleep) return;
    for (float& offset : pair.offset) offset = std::fabs(offset) > 1e-9f ? kFading * offset : 0.0f;
  };
  Looks looks;
  Waiting waiting[CollideBatch::kKinds];
  for (ManifoldPair& pair : pairs) {
    if (pair.moved) continue;
    pair.stack = ManifoldPair::kNoStack;
    if (pair.rest_frames != 0) --pair.rest_frames;
    if (pair.balanced > 0) fade(pair);
    Stand now;
    if (lasts(pair, now)) {
      judge(pair, now);
      if (!pair.ahead) continue;
    }
    looks.again += pair.margin >= 0 ? 1 : 0;
    find(pair, now, waiting, looks);
  }
  for (std::uint32_t kind = 0; kind < CollideBatch::kKinds; ++kind) {
    if (waiting[kind].batch.count() != 0) settle(waiting[kind], kind, looks);
  }
  return looks;
}

// Runs once all pairs of a strip were looked at.
void Manifolds::finish_strip(const Look& look, std::size_t index) {
  StripBlocks& strip = strips_[index];
  const std::span<ManifoldPair> pairs(pairs_.data() + begin_[index], count_of(index));
  for (std::size_t k = 0; k < pairs.size();) {
    std::size_t end = k + 1;
    if (pairs[k].a == PairName::kNone) {
      while (end < pairs.size() && pairs[end].a == PairName::kNone && pairs[end].b == pairs[k].b) ++end;
      look.see_fixed(pairs.subspan(k, end - k));
    }
    k = end;
  }
  const bool laid = stale_[index] == 0;
  bool stale = !laid;
  strip.ghosts.clear();
  strip.active.clear();
  strip.rewrite.clear();
  for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
    const ManifoldPair& pair = pairs_[k];
    stale |= pair.active != (pair.lane != PairName::kNone);
    if (pair.ghost && !pair.moved) strip.ghosts.push_back(std::uint64_t{pair.b} << 32 | pair.shape);
    if (!pair.active) continue;
    strip.active.push_back(k);
    if (!laid) continue;
    if (!pair.changed && pair.lane / kernels::kBlock < strip.blocks.size()) {
      kernels::ManifoldBlock& c = strip.blocks[pair.lane / kernels::kBlock];
      const std::uint32_t l = pair.lane % kernels::kBlock;
      for (int p = 0; p < pair.manifold.count; ++p) c.point[p].gap[l] = pair.gap[p] + pair.offset[p];
    }
    if (pair.changed || pair.was_stack != ManifoldPair::kNoStack) strip.rewrite.push_back(k);
  }
  stale_[index] = stale;
}

void Manifolds::refresh(const ManifoldParams& params, std::size_t begin, std::size_t end) {
  if (begin == 0) {
    keep_impulses();
    g_ = static_cast<float>(length_of(params.gravity));
    constexpr std::size_t kBodies = 1024;  // in a task
    s_.pool.run((shaped_.size() + kBodies - 1) / kBodies, [&](std::size_t t) {
      const std::size_t last = std::min(shaped_.size(), (t + 1) * kBodies);
      for (std::size_t n = t * kBodies; n < last; ++n) {
        const std::size_t i = shaped_[n];
        const Rotor q = rotor_of(s_.bodies.angle[i]);
        rotor_[2 * i] = q.c;
        rotor_[2 * i + 1] = q.s;
        inner_[i] = larger(s_.bodies.kind(s_.bodies.id[i]).inner, kThin * s_.bodies.radius[i]);
      }
    });
  }
  const Look look{*this, params};
  const auto last_of_strip = [&](const Cut& c) { return c.end == begin_[c.strip + 1]; };
  const auto whole = [&](const Cut& c) { return c.begin == begin_[c.strip] && last_of_strip(c); };
  s_.pool.run(end - begin, [&](std::size_t n) {
    Cut& c = cuts_[begin + n];
    c.looks = look.look({pairs_.data() + c.begin, pairs_.data() + c.end});
    if (whole(c)) finish_strip(look, c.strip);
  });
  for (std::size_t k = begin; k < end; ++k) {
    if (last_of_strip(cuts_[k]) && !whole(cuts_[k])) finish_strip(look, cuts_[k].strip);
  }
  if (end != cuts_.size()) return;
  new_pairs_ = 0;
  looks_ = {};
  for (const Cut& c : cuts_) looks_ += c.looks;
  ghosts_.clear();
  for (std::size_t s = 0; s < strip_count(); ++s) {
    ghosts_.insert(ghosts_.end(), strips_[s].ghosts.begin(), strips_[s].ghosts.end());
  }
  sort_keys(ghosts_.begin(), ghosts_.end());
}

float Manifolds::deepest() const {
  float most = 0;
  for (const ManifoldPair& pair : pairs_) {
    for (int k = 0; pair.active && k < pair.manifold.count; ++k) most = std::fmax(most, -pair.gap[k]);
  }
  return most;
}

}  // namespace psim
