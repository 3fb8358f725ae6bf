// Passes over manifolds, as contact_kernel.h has them for discs. Normal impulses of the two points
// are found together: with K = J M^-1 J^T, compliance on its diagonal, and l the stored impulses,
//   0 <= l',  A l' + q >= 0,  l' . (A l' + q) = 0,   A = K + diag(soft K),  q = vn + bias - K l
// which is solved by going through its four cases (Baraff 1994; Catto 2006). Friction: one row, in the
// relax pass alone.
//
// kFixedA: A is static or kinematic; it is read and never written.
#pragma once

#include "lane_vec.h"
#include "manifold_lanes.h"
#include "manifold_views.h"
#include "views.h"

namespace psim::kernels {
namespace {

// Points whose matrix has a determinant below this share of its diagonal's product are close to each other, and how
// much of K_12 holds the difference of their changes back in the relax pass.
constexpr float kClose = 0.01f, kHeld = 0.02f;

constexpr float kFarApart = 1e20f;  // m

/// kSurfaces: some contacts have surfaces.
template <class L, bool kFixedA, bool kSurfaces>
PSIM_INLINE inline void warm_all(const BodyView& b, ManifoldBlock* blocks, SurfaceBlock* surfaces, float scale,
                                 std::uint32_t begin, std::uint32_t end) {
  const F<L> warm = scale;
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p = c->point[0];
      auto& r = c->point[1];
      const auto l1 = L::load(p.impulse + k) * warm, t1 = L::load(p.friction + k) * warm;
      const auto l2 = L::load(r.impulse + k) * warm, t2 = L::load(r.friction + k) * warm;
      L::store(p.impulse + k, l1);
      L::store(p.friction + k, t1);
      L::store(r.impulse + k, l2);
      L::store(r.friction + k, t2);
      const auto nx = L::load(c->nx + k), ny = L::load(c->ny + k);
      const auto l = l1 + l2, t = t1 + t2;
      const auto px = l * nx - t * ny;
      const auto py = l * ny + t * nx;
      const auto turn = [&](const float* n1, const float* s1, const float* n2, const float* s2) {
        return l1 * L::load(s1 + k) + t1 * L::load(n1 + k) + (l2 * L::load(s2 + k) + t2 * L::load(n2 + k));
      };
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel, b.rim_speed, slot);
      apply_impulse<L, kFixedA>(m, px, py, turn(p.an, p.at, r.an, r.at), turn(p.bn, p.bt, r.bn, r.bt),
                                L::load(c->wa + k), L::load(c->wb + k), L::load(c->ga + k), L::load(c->gb + k));
      if constexpr (kSurfaces) {
        SurfaceBlock& s = surfaces[c - blocks];
        const auto roll = L::load(s.roll + k) * warm;
        L::store(s.roll + k, roll);
        turn_against<L, kFixedA>(m, s, k, roll, L::load(c->ga + k), L::load(c->gb + k));
      }
      scatter_motion<L, kFixedA>(b.vel, b.rim_speed, slot, m);
    }
  }
}

/// v += w l n and friction, of the impulses of the last substep, scaled by `scale`. `surfaces`: null where no contact has
/// any.
template <class L, bool kFixedA>
void warm_manifolds(const BodyView& b, ManifoldBlock* blocks, SurfaceBlock* surfaces, float scale, std::uint32_t begin,
                    std::uint32_t end) {
  if (surfaces == nullptr) return warm_all<L, kFixedA, false>(b, blocks, surfaces, scale, begin, end);
  warm_all<L, kFixedA, true>(b, blocks, surfaces, scale, begin, end);
}

/// With what velocity the bodies part at a point.
template <class L>
PSIM_INLINE inline F<L> parting_speed(const TwoBodies<L>& before, F<L> nx, F<L> ny, F<L> at, F<L> bt) {
  return nx * (before.vbx - before.vax) + ny * (before.vby - before.vay) + (before.ub * bt - before.ua * at);
}

/// How the bodies of some lanes have moved against each other since the frame's start.
template <class L>
struct Shift {
  F<L> moved;             // along n, of B against A
  Vec<L> turn_a, turn_b;  // arm changes
  F<L> round_a, round_b;

  /// The separation of a point.
  PSIM_INLINE F<L> separation(const ManifoldBlock::Point& point, std::uint32_t k) const {
    const auto an = L::load(point.an + k), bn = L::load(point.bn + k);
    const auto turned_a = turn_a.x * (an - round_a) + turn_a.y * L::load(point.at + k);
    const auto turned_b = turn_b.x * (bn + round_b) + turn_b.y * L::load(point.bt + k);
    return L::load(point.gap + k) + (moved + (turned_b - turned_a));
  }
};

template <class L>
PSIM_INLINE inline Shift<L> shift_of(const BodyView& b, const ManifoldBlock& c, std::uint32_t k, Vec<L> n) {
  const std::uint32_t* slot = c.body + 2 * k;
  Shift<L> x;
  F<L> dax, day, dbx, dby;
  L::template gather<2>(b.disp, slot, dax, day);
  L::template gather<2>(b.disp, slot + 1, dbx, dby);
  L::template gather<2>(b.arm_change, slot, x.turn_a.x, x.turn_a.y);
  L::template gather<2>(b.arm_change, slot + 1, x.turn_b.x, x.turn_b.y);
  x.turn_a.x = x.turn_a.x + L::load(c.lead_a + k) * x.turn_a.y;
  x.turn_b.x = x.turn_b.x + L::load(c.lead_b + k) * x.turn_b.y;
  x.round_a = L::load(c.round_a + k), x.round_b = L::load(c.round_b + k);
  x.moved = n.x * (dbx - dax) + n.y * (dby - day);
  return x;
}

/// What the solve pass knows of some lanes.
template <class L>
struct SolveLanes {
  TwoBodies<L> m, before;  // now and, with restitution, before the kick
  Vec<L> n;
  Shift<L> shift;
  F<L> wa, wb, ga, gb, soft, rate, e;
  F<L> w;   // wa + wb
  F<L> vn;  // along n: velocity of B against A
  F<L> inv_h, push;
};

/// One point in the solve pass: K_kk, the same with compliance, and q without what stored impulses do.
template <class L>
struct SolvePoint {
  F<L> at, bt, l, k, a, q;
  M<L> apart;
};

template <class L, bool kBounce, bool kInner>
PSIM_INLINE inline SolvePoint<L> solve_point(ManifoldBlock::Point& point, std::uint32_t k, const SolveLanes<L>& lanes,
                                             const ContactParams& p) {
  const F<L> zero = 0;
  SolvePoint<L> x;
  x.at = L::load(point.at + k);
  x.bt = L::load(point.bt + k);
  x.l = L::load(point.impulse + k);
  auto s = lanes.shift.separation(point, k);
  if constexpr (kBounce) s = select(negative(lanes.e), F<L>(kFarApart), s);
  x.apart = zero < s;
  auto bias = select(x.apart, s * lanes.inv_h, max(s * lanes.rate, lanes.push));
  auto compliance = select(x.apart, zero, lanes.soft);
  if constexpr (kBounce) {
    const auto vn0 = parting_speed<L>(lanes.before, lanes.n.x, lanes.n.y, x.at, x.bt);
    const auto impacts = impacts_of<L>(lanes.e, vn0, s, p);
    bias = select(impacts.now, impact_bias<L>(impacts, bias), bias);
    compliance = select(impacts.now, zero, compliance);
    if constexpr (!kInner) L::store(point.start + k, start_of<L>(x.l, impacts.may));
  } else if constexpr (!kInner) {
    L::store(point.start + k, x.l);
  }
  x.k = lanes.w + (lanes.ga * (x.at * x.at) + lanes.gb * (x.bt * x.bt));
  x.a = x.k + compliance * x.k;
  x.q = lanes.vn + (lanes.m.ub * x.bt - lanes.m.ua * x.at) + bias;
  return x;
}

/// kInner: not the first sweep of the pass over these contacts.
template <class L, bool kFixedA, bool kBounce, bool kInner>
void solve_manifolds(const BodyView& b, ManifoldBlock* blocks, const ContactParams& p, std::uint32_t begin,
                     std::uint32_t end) {
  const F<L> zero = 0, open = -0.0f;
  const F<L> inv_h = p.inv_h, push = -p.push;
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = c->body + 2 * k;
      SolveLanes<L> lanes;
      lanes.inv_h = inv_h, lanes.push = push;
      auto& m = lanes.m;
      m = gather_motion<L>(b.vel, b.rim_speed, slot);
      lanes.n = load_vec<L>(c->nx, c->ny, k);
      lanes.shift = shift_of<L>(b, *c, k, lanes.n);
      lanes.wa = L::load(c->wa + k), lanes.wb = L::load(c->wb + k);
      lanes.ga = L::load(c->ga + k), lanes.gb = L::load(c->gb + k);
      lanes.soft = L::load(c->soft + k), lanes.rate = L::load(c->rate + k);
      const auto nx = lanes.n.x, ny = lanes.n.y, wa = lanes.wa, wb = lanes.wb, ga = lanes.ga, gb = lanes.gb;
      lanes.w = wa + wb;
      lanes.vn = nx * (m.vbx - m.vax) + ny * (m.vby - m.vay);
      if constexpr (kBounce) {
        lanes.before = gather_motion<L>(b.vel0, b.rim_speed0, slot);
        lanes.e = L::load(c->e + k);
      }
      const auto x = solve_point<L, kBounce, kInner>(c->point[0], k, lanes, p);
      const auto y = solve_point<L, kBounce, kInner>(c->point[1], k, lanes, p);
      const auto k12 = lanes.w + (ga * (x.at * y.at) + gb * (x.bt * y.bt));
      const auto q1 = x.q - (x.k * x.l + k12 * y.l);
      const auto q2 = y.q - (k12 * x.l + y.k * y.l);
      F<L> l1, l2;
      solve_two<L>(x.a, k12, y.a, q1, q2, l1, l2);
      l1 = max(l1, zero), l2 = max(l2, zero);  // -0 is for open points
      const auto d1 = l1 - x.l, d2 = l2 - y.l;
      L::store(c->point[0].impulse + k, select(x.apart & (l1 <= zero), open, l1));
      L::store(c->point[1].impulse + k, select(y.apart & (l2 <= zero), open, l2));
      const auto d = d1 + d2;
      const auto sa = L::load(c->share_a + k), sb = L::load(c->share_b + k);
      apply_impulse<L, kFixedA>(m, d * nx, d * ny, d1 * x.at + d2 * y.at, d1 * x.bt + d2 * y.bt, wa * sa, wb * sb,
                                ga * sa, gb * sb);
      scatter_motion<L, kFixedA, kInner>(b.vel, b.rim_speed, slot, m);
    }
  }
}

/// What the relax pass knows of some lanes: 1 and 2 are the points.
template <class L>
struct RelaxLanes {
  Vec<L> n;
  F<L> wa, wb, ga, gb, share_a, share_b;
  F<L> at1, bt1, at2, bt2;
  F<L> l1, l2;          // impulses before the pass
  F<L> n1, n2;          // and after it
  M<L> was1{}, was2{};  // impacts with restitution

  /// An impulse of the pass; a body takes its share.
  template <bool kFixedA>
  PSIM_INLINE void apply(TwoBodies<L>& m, F<L> px, F<L> py, F<L> turn_a, F<L> turn_b) const {
    apply_impulse<L, kFixedA>(m, px, py, turn_a, turn_b, wa * share_a, wb * share_b, ga * share_a, gb * share_b);
  }
};

/// Whether all points are open, nothing is to be taken back, and nothing is owed from this substep.
template <class L, bool kFixedA>
PSIM_INLINE inline bool lies_open(const ManifoldBlock& c, std::uint32_t k, F<L> l1, F<L> l2) {
  const F<L> zero = 0;
  const auto& p1 = c.point[0];
  const auto& p2 = c.point[1];
  auto left = (l1 != zero) | (l2 != zero) | ((L::load(p1.friction + k) != zero) | (L::load(p2.friction + k) != zero));
  if constexpr (!kFixedA) left = left | ((L::load(p1.start + k) != zero) | (L::load(p2.start + k) != zero));
  return all(negative(l1) & negative(l2)) && !any(left);
}

/// Finds the normal impulses for the velocities vn1, vn2 of the points and applies them.
template <class L, bool kFixedA>
PSIM_INLINE inline void relax_normals(RelaxLanes<L>& x, TwoBodies<L>& m, F<L> vn1, F<L> vn2) {
  const F<L> zero = 0;
  const auto w = x.wa + x.wb;
  const auto k11 = w + (x.ga * (x.at1 * x.at1) + x.gb * (x.bt1 * x.bt1));
  const auto k22 = w + (x.ga * (x.at2 * x.at2) + x.gb * (x.bt2 * x.bt2));
  const auto k12 = w + (x.ga * (x.at1 * x.at2) + x.gb * (x.bt1 * x.bt2));
  // Close to each other, two points share what there is as they did: of the changes, their difference is held back.
  const auto close = k11 * k22 - k12 * k12 < kClose * (k11 * k22);
  auto a11 = k11, a12 = k12, a22 = k22;
  if (any(close)) [[unlikely]] {
    const auto some = keep(close, kHeld * k12);
    const auto held = select(negative(x.l1), zero, select(negative(x.l2), zero, some));
    a11 = k11 + held, a12 = k12 - held, a22 = k22 + held;
  }
  // An open point takes no part: far from closing.
  const F<L> far = 1e30f;
  const auto q1 = select(negative(x.l1), far, vn1 - (a11 * x.l1 + a12 * x.l2));
  const auto q2 = select(negative(x.l2), far, vn2 - (a12 * x.l1 + a22 * x.l2));
  solve_two<L>(a11, a12, a22, q1, q2, x.n1, x.n2);
  x.n1 = select(negative(x.l1), x.l1, max(x.n1, zero));
  x.n2 = select(negative(x.l2), x.l2, max(x.n2, zero));
  const auto d1 = x.n1 - x.l1, d2 = x.n2 - x.l2, d = d1 + d2;
  x.template apply<kFixedA>(m, d * x.n.x, d * x.n.y, d1 * x.at1 + d2 * x.at2, d1 * x.bt1 + d2 * x.bt2);
}

/// Friction: one row at the middle of the pressure, which the points share as they share the normal impulse. Points one
/// after the other would do differently in a scene and in its mirror image. No share is kept back: bodies on ice keep
/// their momentum.
/// `surface` is read if kSurface.
template <class L, bool kFixedA, bool kSurface>
PSIM_INLINE inline void rub(RelaxLanes<L>& x, TwoBodies<L>& m, ManifoldBlock& c, std::uint32_t k,
                            const SurfaceBlock* surface) {
  const F<L> zero = 0, one = 1;
  auto& p1 = c.point[0];
  auto& p2 = c.point[1];
  const auto n1 = max(x.n1, zero), n2 = max(x.n2, zero), n = n1 + n2;
  const auto share = n1 / select(zero < n, n, one);
  const auto an1 = L::load(p1.an + k), bn1 = L::load(p1.bn + k), an2 = L::load(p2.an + k), bn2 = L::load(p2.bn + k);
  const auto an = an2 + share * (an1 - an2), bn = bn2 + share * (bn1 - bn2);
  auto vt = snapped<L>(x.n.x * (m.vby - m.vay) - x.n.y * (m.vbx - m.vax) + (m.ub * bn - m.ua * an));
  if constexpr (kSurface) vt = vt + L::load(surface->belt + k);
  const auto kt = x.wa + x.wb + (x.ga * (an * an) + x.gb * (bn * bn));
  const auto cap = L::load(c.mu + k) * n;
  const auto t1 = L::load(p1.friction + k), t2 = L::load(p2.friction + k);
  const auto kept = keep(zero < n, max(min(t1 + t2 - vt / kt, cap), -cap));
  const auto kept1 = share * kept, kept2 = kept - kept1;
  L::store(p1.friction + k, kept1);
  L::store(p2.friction + k, kept2);
  const auto d1 = kept1 - t1, d2 = kept2 - t2;
  const auto d = d1 + d2;
  apply_impulse<L, kFixedA>(m, -(d * x.n.y), d * x.n.x, d1 * an1 + d2 * an2, d1 * bn1 + d2 * bn2, x.wa, x.wb, x.ga,
                            x.gb);
}

/// Resistance against rolling: a torque that slows what B turns against A, of at most `resist` times the normal impulse.
template <class L, bool kFixedA>
PSIM_INLINE inline void resist_rolling(const RelaxLanes<L>& x, TwoBodies<L>& m, SurfaceBlock& s, std::uint32_t k) {
  const F<L> zero = 0, one = 1;
  const auto ia = L::load(s.inv_size_a + k), ib = L::load(s.inv_size_b + k);
  const auto n = max(x.n1, zero) + max(x.n2, zero), cap = L::load(s.resist + k) * n;
  const auto spin = snapped<L>(m.ub * ib - m.ua * ia);
  const auto gain = x.ga * (ia * ia) + x.gb * (ib * ib);
  const auto before = L::load(s.roll + k);
  const auto wanted = before - spin / select(zero < gain, gain, one);
  const auto roll = keep((zero < n) & (zero < gain), max(min(wanted, cap), -cap));
  L::store(s.roll + k, roll);
  turn_against<L, kFixedA>(m, s, k, roll - before, x.ga, x.gb);
}

/// What shares kept back is the next substep's from its start: it repeats v - v0.
template <class L, bool kBounce>
PSIM_INLINE inline void owe_shares(const BodyView& b, const ManifoldBlock& c, std::uint32_t k, const RelaxLanes<L>& x) {
  const F<L> zero = 0, one = 1;
  if (!any((x.share_a < one) | (x.share_b < one))) return;
  const auto lasts = [&](const ManifoldBlock::Point& point, F<L> n, M<L> was) {
    const auto start = kBounce ? abs(L::load(point.start + k)) : max(L::load(point.start + k), zero);
    const auto kept = kBounce ? select(was, min(n, start), n) : n;
    return max(kept, zero) - start;
  };
  const auto o1 = lasts(c.point[0], x.n1, x.was1), o2 = lasts(c.point[1], x.n2, x.was2), o = o1 + o2;
  const std::uint32_t* slot = c.body + 2 * k;
  auto before = gather_motion<L>(b.vel0, b.rim_speed0, slot);
  const auto owed = [&](F<L> mine, F<L> share) { return -mine * (one - share); };
  apply_impulse<L, false>(before, o * x.n.x, o * x.n.y, o1 * x.at1 + o2 * x.at2, o1 * x.bt1 + o2 * x.bt2,
                          owed(x.wa, x.share_a), owed(x.wb, x.share_b), owed(x.ga, x.share_a), owed(x.gb, x.share_b));
  scatter_motion<L, false>(b.vel0, b.rim_speed0, slot, before);
}

/// Does for a point what part_impact of contact_row.h does for a contact.
template <class L>
PSIM_INLINE inline void settle_impact(ManifoldBlock::Point& point, std::uint32_t k, F<L> n, M<L> was) {
  const auto lasts = min(n, abs(L::load(point.start + k)));
  L::store(point.start + k, keep(was, n - lasts));
  L::store(point.impulse + k, select(was, lasts, n));
}

/// As relax_manifolds(). kSurfaces: some contacts have surfaces.
template <class L, bool kFixedA, bool kBounce, bool kInner, bool kSurfaces>
PSIM_INLINE inline void relax_all(const BodyView& b, ManifoldBlock* blocks, SurfaceBlock* surfaces, std::uint32_t begin,
                                  std::uint32_t end) {
  const F<L> zero = 0;
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p1 = c->point[0];
      auto& p2 = c->point[1];
      const auto l1 = L::load(p1.impulse + k), l2 = L::load(p2.impulse + k);
      SurfaceBlock* const surface = kSurfaces ? surfaces + (c - blocks) : nullptr;
      bool rolls = false;
      if constexpr (kSurfaces) rolls = any(L::load(surface->roll + k) != zero);
      if (!rolls && lies_open<L, kFixedA>(*c, k, l1, l2)) {
        L::store(p1.friction + k, zero);
        L::store(p2.friction + k, zero);
        if constexpr (kSurfaces) L::store(surface->roll + k, zero);
        if constexpr (kBounce && !kInner) {
          L::store(p1.start + k, zero);
          L::store(p2.start + k, zero);
        }
        continue;
      }
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel, b.rim_speed, slot);
      RelaxLanes<L> x;
      x.n = load_vec<L>(c->nx, c->ny, k);
      x.share_a = L::load(c->share_a + k), x.share_b = L::load(c->share_b + k);
      x.wa = L::load(c->wa + k), x.wb = L::load(c->wb + k);
      x.ga = L::load(c->ga + k), x.gb = L::load(c->gb + k);
      x.at1 = L::load(p1.at + k), x.bt1 = L::load(p1.bt + k);
      x.at2 = L::load(p2.at + k), x.bt2 = L::load(p2.bt + k);
      x.l1 = l1, x.l2 = l2;
      const auto vn = x.n.x * (m.vbx - m.vax) + x.n.y * (m.vby - m.vay);
      auto vn1 = vn + (m.ub * x.bt1 - m.ua * x.at1);
      auto vn2 = vn + (m.ub * x.bt2 - m.ua * x.at2);
      if constexpr (kBounce) {
        const auto before = gather_motion<L>(b.vel0, b.rim_speed0, slot);
        const F<L> e = L::load(c->e + k);
        x.was1 = struck<L>(L::load(p1.start + k), l1);
        vn1 = vn1 + keep(x.was1, rebound<L>(e, parting_speed<L>(before, x.n.x, x.n.y, x.at1, x.bt1)));
        x.was2 = struck<L>(L::load(p2.start + k), l2);
        vn2 = vn2 + keep(x.was2, rebound<L>(e, parting_speed<L>(before, x.n.x, x.n.y, x.at2, x.bt2)));
      }
      relax_normals<L, kFixedA>(x, m, vn1, vn2);
      L::store(p1.impulse + k, x.n1);
      L::store(p2.impulse + k, x.n2);
      rub<L, kFixedA, kSurfaces>(x, m, *c, k, surface);
      if constexpr (kSurfaces) resist_rolling<L, kFixedA>(x, m, *surface, k);
      scatter_motion<L, kFixedA>(b.vel, b.rim_speed, slot, m);
      if constexpr (!kFixedA && !kInner) owe_shares<L, kBounce>(b, *c, k, x);
      if constexpr (kBounce && !kInner) {
        settle_impact<L>(p1, k, x.n1, x.was1);
        settle_impact<L>(p2, k, x.n2, x.was2);
      }
    }
  }
}

/// kInner: not the last sweep of the pass over these contacts. `surfaces`: null where no contact has any.
template <class L, bool kFixedA, bool kBounce, bool kInner>
void relax_manifolds(const BodyView& b, ManifoldBlock* blocks, SurfaceBlock* surfaces, const ContactParams&,
                     std::uint32_t begin, std::uint32_t end) {
  if (surfaces == nullptr) return relax_all<L, kFixedA, kBounce, kInner, false>(b, blocks, surfaces, begin, end);
  relax_all<L, kFixedA, kBounce, kInner, true>(b, blocks, surfaces, begin, end);
}

/// As spend_contacts: moves what impacts added into the velocities before the kick, so that the next
/// substep does not repeat it.
template <class L, bool kFixedA>
void spend_manifolds(const BodyView& b, ManifoldBlock* blocks, const ContactParams& p, std::uint32_t begin,
                     std::uint32_t end) {
  const F<L> zero = 0;
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p1 = c->point[0];
      auto& p2 = c->point[1];
      const auto s1 = L::load(p1.start + k), s2 = L::load(p2.start + k);
      if (!any((zero < s1) | (zero < s2))) continue;
      const std::uint32_t* slot = c->body + 2 * k;
      const Vec<L> n = load_vec<L>(c->nx, c->ny, k);
      const auto now = gather_motion<L>(b.vel, b.rim_speed, slot);
      const auto shift = shift_of<L>(b, *c, k, n);
      const auto parts = [&](ManifoldBlock::Point& point, F<L> spent) {
        const auto vn = parting_speed<L>(now, n.x, n.y, L::load(point.at + k), L::load(point.bt + k));
        return parted<L>(point.impulse + k, p, spent, vn, shift.separation(point, k));
      };
      const auto hit1 = parts(p1, s1), hit2 = parts(p2, s2);
      const auto mu = L::load(c->mu + k);
      const auto beyond = [&](ManifoldBlock::Point& point, M<L> hit) {
        const auto t = L::load(point.friction + k);
        const auto cap = mu * max(L::load(point.impulse + k), zero);
        const auto held = max(min(t, cap), -cap);
        L::store(point.friction + k, select(hit, held, t));
        return keep(hit, t - held);
      };
      const auto d1 = keep(hit1, s1), d2 = keep(hit2, s2);
      const auto t1 = beyond(p1, hit1), t2 = beyond(p2, hit2);
      const auto l = d1 + d2, t = t1 + t2;
      const auto turn = [&](const float* n1, const float* a1, const float* n2, const float* a2) {
        return d1 * L::load(a1 + k) + t1 * L::load(n1 + k) + (d2 * L::load(a2 + k) + t2 * L::load(n2 + k));
      };
      auto m = gather_motion<L>(b.vel0, b.rim_speed0, slot);
      apply_impulse<L, kFixedA>(m, l * n.x - t * n.y, l * n.y + t * n.x, turn(p1.an, p1.at, p2.an, p2.at),
                                turn(p1.bn, p1.bt, p2.bn, p2.bt), L::load(c->wa + k), L::load(c->wb + k),
                                L::load(c->ga + k), L::load(c->gb + k));
      scatter_motion<L, kFixedA>(b.vel0, b.rim_speed0, slot, m);
    }
  }
}

}  // namespace
}  // namespace psim::kernels
