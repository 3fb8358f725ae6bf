// Passes over manifolds, as contact_kernel.h has them for discs. Normal impulses of the two points
// are found together: with K = J M^-1 J^T, compliance on its diagonal, and l the stored impulses,
//   0 <= l',  A l' + q >= 0,  l' . (A l' + q) = 0,   A = K + diag(soft K),  q = vn + bias - K l
// which is solved by going through its four cases (Baraff 1994; Catto 2006). Friction: one row a
// point, in the relax pass alone.
//
// kFixedA: A is static or kinematic; it is read and never written.
#pragma once

#include "manifold_views.h"
#include "stream_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

// Points whose matrix has a determinant below this share of its diagonal's product are close to each other, and how
// much of K_12 holds the difference of their changes back in the relax pass.
constexpr float kClose = 0.01f, kHeld = 0.02f;

/// Motion of the two bodies of some lanes.
template <class L>
struct TwoBodies {
  typename L::F vax, vay, ua, vbx, vby, ub;
};

template <class L>
[[gnu::always_inline]] inline TwoBodies<L> gather_motion(const float* vel, const float* spin,
                                                         const std::uint32_t* slot) {
  TwoBodies<L> m;
  L::template gather<2>(vel, slot, m.vax, m.vay);
  L::template gather<2>(vel, slot + 1, m.vbx, m.vby);
  m.ua = L::template gather1<2>(spin, slot);
  m.ub = L::template gather1<2>(spin, slot + 1);
  return m;
}

template <class L, bool kFixedA>
[[gnu::always_inline]] inline void scatter_motion(float* vel, float* spin,
                                                  const std::uint32_t* slot,
                                                  const TwoBodies<L>& m) {
  if constexpr (!kFixedA) {
    L::template scatter<2>(vel, slot, m.vax, m.vay);
    L::template scatter1<2>(spin, slot, m.ua);
  }
  L::template scatter<2>(vel, slot + 1, m.vbx, m.vby);
  L::template scatter1<2>(spin, slot + 1, m.ub);
}

/// Impulses along n (and spins by at, bt) or, with the arms exchanged, along t.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void apply_impulse(TwoBodies<L>& m, typename L::F px,
                                                 typename L::F py, typename L::F turn_a,
                                                 typename L::F turn_b, typename L::F wa,
                                                 typename L::F wb, typename L::F ga,
                                                 typename L::F gb) {
  if constexpr (!kFixedA) {
    m.vax = L::sub(m.vax, L::mul(wa, px));
    m.vay = L::sub(m.vay, L::mul(wa, py));
    m.ua = L::sub(m.ua, L::mul(ga, turn_a));
  }
  m.vbx = L::add(m.vbx, L::mul(wb, px));
  m.vby = L::add(m.vby, L::mul(wb, py));
  m.ub = L::add(m.ub, L::mul(gb, turn_b));
}

/// The smaller of l' that solve the two-point problem; q is without the stored impulses.
template <class L>
[[gnu::always_inline]] inline void solve_two(typename L::F a11, typename L::F a12,
                                             typename L::F a22, typename L::F q1,
                                             typename L::F q2, typename L::F& l1,
                                             typename L::F& l2) {
  const auto zero = L::set1(0), one = L::set1(1);
  const auto det = L::sub(L::mul(a11, a22), L::mul(a12, a12));
  // Points that all but coincide carry the load alone, one of them.
  const auto sound = L::less(L::mul(L::set1(1e-4f), L::mul(a11, a22)), det);
  const auto inverse = L::div(one, L::select(sound, det, one));
  const auto both1 = L::mul(inverse, L::sub(L::mul(a12, q2), L::mul(a22, q1)));
  const auto both2 = L::mul(inverse, L::sub(L::mul(a12, q1), L::mul(a11, q2)));
  const auto only1 = L::div(L::negate(q1), a11), only2 = L::div(L::negate(q2), a22);
  const auto both_hold =
      L::both(sound, L::both(L::less_equal(zero, both1), L::less_equal(zero, both2)));
  // What is left at the other point: not less than nothing, or, of points that all but coincide, more than otherwise.
  const auto left2 = L::add(L::mul(a12, only1), q2), left1 = L::add(L::mul(a12, only2), q1);
  constexpr std::uint32_t kAll = (1u << L::width) - 1;
  auto enough1 = zero, enough2 = zero;
  if (L::bits(sound) != kAll) [[unlikely]] {
    enough1 = L::select(sound, zero, L::min(left1, zero));
    enough2 = L::select(sound, zero, L::min(left2, zero));
  }
  const auto holds1 = L::both(L::less_equal(zero, only1), L::less_equal(enough1, left2));
  const auto holds2 = L::both(L::less_equal(zero, only2), L::less_equal(enough2, left1));
  l1 = L::select(both_hold, both1, L::select(holds1, only1, zero));
  l2 = L::select(both_hold, both2,
                 L::select(holds1, zero, L::select(holds2, only2, zero)));
}

/// v += w l n and friction, of the impulses of the last substep, scaled by `scale`.
template <class L, bool kFixedA>
void warm_manifolds(const BodyView& b, ManifoldBlock* blocks, float scale, std::uint32_t begin,
                    std::uint32_t end) {
  const auto warm = L::set1(scale);
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p = c->point[0];
      auto& r = c->point[1];
      const auto l1 = L::mul(L::load(p.impulse + k), warm), t1 = L::mul(L::load(p.friction + k), warm);
      const auto l2 = L::mul(L::load(r.impulse + k), warm), t2 = L::mul(L::load(r.friction + k), warm);
      L::store(p.impulse + k, l1);
      L::store(p.friction + k, t1);
      L::store(r.impulse + k, l2);
      L::store(r.friction + k, t2);
      const auto nx = L::load(c->nx + k), ny = L::load(c->ny + k);
      const auto l = L::add(l1, l2), t = L::add(t1, t2);
      const auto px = L::sub(L::mul(l, nx), L::mul(t, ny));
      const auto py = L::add(L::mul(l, ny), L::mul(t, nx));
      const auto turn = [&](const float* n1, const float* s1, const float* n2, const float* s2) {
        return L::add(L::add(L::mul(l1, L::load(s1 + k)), L::mul(t1, L::load(n1 + k))),
                      L::add(L::mul(l2, L::load(s2 + k)), L::mul(t2, L::load(n2 + k))));
      };
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      apply_impulse<L, kFixedA>(m, px, py, turn(p.an, p.at, r.an, r.at),
                                turn(p.bn, p.bt, r.bn, r.bt), L::load(c->wa + k),
                                L::load(c->wb + k), L::load(c->ga + k), L::load(c->gb + k));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

/// Approach of a point before the kick; where it is an impact, what it should part with.
template <class L>
[[gnu::always_inline]] inline typename L::F manifold_bounces(const TwoBodies<L>& before,
                                                             typename L::F nx, typename L::F ny,
                                                             typename L::F at, typename L::F bt,
                                                             typename L::F s, typename L::F e,
                                                             const ContactParams& p,
                                                             typename L::F& target) {
  const auto vn0 = L::add(L::add(L::mul(nx, L::sub(before.vbx, before.vax)),
                                 L::mul(ny, L::sub(before.vby, before.vay))),
                          L::sub(L::mul(before.ub, bt), L::mul(before.ua, at)));
  target = L::mul(e, vn0);
  const auto fast = L::less(vn0, L::set1(-p.impact_floor));
  const auto near = L::less(L::add(s, L::mul(vn0, L::set1(p.h))), L::set1(0));
  return L::both(L::both(fast, near), L::less(L::set1(0), e));
}

template <class L, bool kFixedA, bool kBounce>
void solve_manifolds(const BodyView& b, ManifoldBlock* blocks, const ContactParams& p,
                     std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0), open = L::set1(-0.0f);
  const auto inv_h = L::set1(p.inv_h), push = L::set1(-p.push);
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      typename L::F dax, day, dbx, dby, tax, tay, tbx, tby;
      L::template gather<2>(b.disp, slot, dax, day);
      L::template gather<2>(b.disp, slot + 1, dbx, dby);
      L::template gather<2>(b.turn, slot, tax, tay);
      L::template gather<2>(b.turn, slot + 1, tbx, tby);
      const auto nx = L::load(c->nx + k), ny = L::load(c->ny + k);
      const auto wa = L::load(c->wa + k), wb = L::load(c->wb + k);
      const auto ga = L::load(c->ga + k), gb = L::load(c->gb + k);
      const auto ra = L::load(c->round_a + k), rb = L::load(c->round_b + k);
      const auto soft = L::load(c->soft + k), rate = L::load(c->rate + k);
      const auto moved = L::add(L::mul(nx, L::sub(dbx, dax)), L::mul(ny, L::sub(dby, day)));
      const auto vn = L::add(L::mul(nx, L::sub(m.vbx, m.vax)), L::mul(ny, L::sub(m.vby, m.vay)));
      const auto w = L::add(wa, wb);
      TwoBodies<L> before{};
      if constexpr (kBounce) before = gather_motion<L>(b.vel0, b.spin0, slot);
      struct Row {
        typename L::F at, bt, l, k, a, q, apart;
      };
      const auto row = [&](ManifoldBlock::Point& point) {
        Row x;
        const auto an = L::load(point.an + k), bn = L::load(point.bn + k);
        x.at = L::load(point.at + k);
        x.bt = L::load(point.bt + k);
        x.l = L::load(point.impulse + k);
        const auto turned_a = L::add(L::mul(tax, L::sub(an, ra)), L::mul(tay, x.at));
        const auto turned_b = L::add(L::mul(tbx, L::add(bn, rb)), L::mul(tby, x.bt));
        const auto s = L::add(L::load(point.gap + k), L::add(moved, L::sub(turned_b, turned_a)));
        x.apart = L::less(zero, s);
        auto bias = L::select(x.apart, L::mul(s, inv_h), L::max(L::mul(s, rate), push));
        auto compliance = L::select(x.apart, zero, soft);
        if constexpr (kBounce) {
          typename L::F target;
          const auto hit = manifold_bounces<L>(before, nx, ny, x.at, x.bt, s, L::load(c->e + k), p,
                                               target);
          bias = L::select(hit, L::min(target, bias), bias);
          compliance = L::select(hit, zero, compliance);
        }
        if (!p.again) L::store(point.start + k, x.l);
        x.k = L::add(w, L::add(L::mul(ga, L::mul(x.at, x.at)), L::mul(gb, L::mul(x.bt, x.bt))));
        x.a = L::add(x.k, L::mul(compliance, x.k));
        x.q = L::add(L::add(vn, L::sub(L::mul(m.ub, x.bt), L::mul(m.ua, x.at))), bias);
        return x;
      };
      const Row x = row(c->point[0]), y = row(c->point[1]);
      const auto k12 = L::add(w, L::add(L::mul(ga, L::mul(x.at, y.at)), L::mul(gb, L::mul(x.bt, y.bt))));
      const auto q1 = L::sub(x.q, L::add(L::mul(x.k, x.l), L::mul(k12, y.l)));
      const auto q2 = L::sub(y.q, L::add(L::mul(k12, x.l), L::mul(y.k, y.l)));
      typename L::F l1, l2;
      solve_two<L>(x.a, k12, y.a, q1, q2, l1, l2);
      l1 = L::max(l1, zero), l2 = L::max(l2, zero);  // -0 is for open points
      const auto d1 = L::sub(l1, x.l), d2 = L::sub(l2, y.l);
      L::store(c->point[0].impulse + k,
               L::select(L::both(x.apart, L::less_equal(l1, zero)), open, l1));
      L::store(c->point[1].impulse + k,
               L::select(L::both(y.apart, L::less_equal(l2, zero)), open, l2));
      const auto d = L::add(d1, d2);
      const auto sa = L::load(c->share_a + k), sb = L::load(c->share_b + k);
      apply_impulse<L, kFixedA>(m, L::mul(d, nx), L::mul(d, ny),
                                L::add(L::mul(d1, x.at), L::mul(d2, y.at)),
                                L::add(L::mul(d1, x.bt), L::mul(d2, y.bt)), L::mul(wa, sa),
                                L::mul(wb, sb), L::mul(ga, sa), L::mul(gb, sb));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

template <class L, bool kFixedA, bool kBounce>
void relax_manifolds(const BodyView& b, ManifoldBlock* blocks, const ContactParams& p,
                     std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0);
  constexpr std::uint32_t kAll = (1u << L::width) - 1;
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p1 = c->point[0];
      auto& p2 = c->point[1];
      const auto l1 = L::load(p1.impulse + k), l2 = L::load(p2.impulse + k);
      const auto t1 = L::load(p1.friction + k), t2 = L::load(p2.friction + k);
      // All open, nothing to take back, and nothing owed from this substep.
      auto left = L::either(L::either(L::differ(l1, zero), L::differ(l2, zero)),
                            L::either(L::differ(t1, zero), L::differ(t2, zero)));
      if constexpr (!kFixedA) {
        left = L::either(left, L::either(L::less(zero, L::load(p1.start + k)),
                                         L::less(zero, L::load(p2.start + k))));
      }
      if ((L::bits(l1) & L::bits(l2)) == kAll && !L::bits(left)) {
        L::store(p1.friction + k, zero);
        L::store(p2.friction + k, zero);
        if (kBounce && !p.more) {
          L::store(p1.start + k, zero);
          L::store(p2.start + k, zero);
        }
        continue;
      }
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      const auto nx = L::load(c->nx + k), ny = L::load(c->ny + k);
      const auto sa = L::load(c->share_a + k), sb = L::load(c->share_b + k);
      const auto wa = L::load(c->wa + k), wb = L::load(c->wb + k);
      const auto ga = L::load(c->ga + k), gb = L::load(c->gb + k);
      const auto my_wa = L::mul(wa, sa), my_wb = L::mul(wb, sb);
      const auto my_ga = L::mul(ga, sa), my_gb = L::mul(gb, sb);
      const auto w = L::add(wa, wb);
      const auto at1 = L::load(p1.at + k), bt1 = L::load(p1.bt + k);
      const auto at2 = L::load(p2.at + k), bt2 = L::load(p2.bt + k);
      const auto vn = L::add(L::mul(nx, L::sub(m.vbx, m.vax)), L::mul(ny, L::sub(m.vby, m.vay)));
      auto vn1 = L::add(vn, L::sub(L::mul(m.ub, bt1), L::mul(m.ua, at1)));
      auto vn2 = L::add(vn, L::sub(L::mul(m.ub, bt2), L::mul(m.ua, at2)));
      typename L::F was1{}, was2{};
      if constexpr (kBounce) {
        const auto before = gather_motion<L>(b.vel0, b.spin0, slot);
        const auto e = L::load(c->e + k), closed = L::set1(-1e30f);
        typename L::F target;
        was1 = L::both(manifold_bounces<L>(before, nx, ny, at1, bt1, closed, e, p, target),
                       L::less(zero, l1));
        vn1 = L::add(vn1, L::select(was1, target, zero));
        was2 = L::both(manifold_bounces<L>(before, nx, ny, at2, bt2, closed, e, p, target),
                       L::less(zero, l2));
        vn2 = L::add(vn2, L::select(was2, target, zero));
      }
      const auto k11 = L::add(w, L::add(L::mul(ga, L::mul(at1, at1)), L::mul(gb, L::mul(bt1, bt1))));
      const auto k22 = L::add(w, L::add(L::mul(ga, L::mul(at2, at2)), L::mul(gb, L::mul(bt2, bt2))));
      const auto k12 = L::add(w, L::add(L::mul(ga, L::mul(at1, at2)), L::mul(gb, L::mul(bt1, bt2))));
      // Close to each other, two points share what there is as they did: of the changes, their difference is held back.
      const auto close = L::less(L::sub(L::mul(k11, k22), L::mul(k12, k12)), L::mul(L::set1(kClose), L::mul(k11, k22)));
      auto a11 = k11, a12 = k12, a22 = k22;
      if (L::bits(close)) [[unlikely]] {
        const auto some = L::both(close, L::mul(L::set1(kHeld), k12));
        const auto held = L::select_sign(l1, zero, L::select_sign(l2, zero, some));
        a11 = L::add(k11, held), a12 = L::sub(k12, held), a22 = L::add(k22, held);
      }
      // An open point takes no part: far from closing.
      const auto far = L::set1(1e30f);
      const auto q1 = L::select_sign(l1, far, L::sub(vn1, L::add(L::mul(a11, l1), L::mul(a12, l2))));
      const auto q2 = L::select_sign(l2, far, L::sub(vn2, L::add(L::mul(a12, l1), L::mul(a22, l2))));
      typename L::F n1, n2;
      solve_two<L>(a11, a12, a22, q1, q2, n1, n2);
      n1 = L::select_sign(l1, l1, L::max(n1, zero));
      n2 = L::select_sign(l2, l2, L::max(n2, zero));
      const auto d1 = L::sub(n1, l1), d2 = L::sub(n2, l2);
      L::store(p1.impulse + k, n1);
      L::store(p2.impulse + k, n2);
      const auto d = L::add(d1, d2);
      apply_impulse<L, kFixedA>(m, L::mul(d, nx), L::mul(d, ny),
                                L::add(L::mul(d1, at1), L::mul(d2, at2)),
                                L::add(L::mul(d1, bt1), L::mul(d2, bt2)), my_wa, my_wb, my_ga,
                                my_gb);
      const auto mu = L::load(c->mu + k);
      typename L::F rub_sum = zero, rub_turn_a = zero, rub_turn_b = zero;
      const auto rub = [&](ManifoldBlock::Point& point, typename L::F l, typename L::F t,
                           typename L::F sign) {
        const auto an = L::load(point.an + k), bn = L::load(point.bn + k);
        const auto vt = L::add(L::sub(L::mul(nx, L::sub(m.vby, m.vay)),
                                      L::mul(ny, L::sub(m.vbx, m.vax))),
                               L::sub(L::mul(m.ub, bn), L::mul(m.ua, an)));
        const auto kt = L::add(w, L::add(L::mul(ga, L::mul(an, an)), L::mul(gb, L::mul(bn, bn))));
        const auto cap = L::mul(mu, L::max(l, zero));
        const auto wish = L::sub(t, L::div(vt, kt));
        const auto kept =
            L::select_sign(sign, zero, L::max(L::min(wish, cap), L::negate(cap)));
        const auto dt = L::sub(kept, t);
        L::store(point.friction + k, kept);
        const auto turn_a = L::mul(dt, an), turn_b = L::mul(dt, bn);
        apply_impulse<L, kFixedA>(m, L::negate(L::mul(dt, ny)), L::mul(dt, nx), turn_a, turn_b,
                                  my_wa, my_wb, my_ga, my_gb);
        rub_sum = L::add(rub_sum, dt);
        rub_turn_a = L::add(rub_turn_a, turn_a);
        rub_turn_b = L::add(rub_turn_b, turn_b);
      };
      rub(p1, n1, t1, l1);
      rub(p2, n2, t2, l2);
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
      if constexpr (!kFixedA) {
        const auto one = L::set1(1);
        if (!p.more && L::bits(L::either(L::less(sa, one), L::less(sb, one)))) {
          // What shares kept back is the next substep's from its start: it repeats v - v0.
          const auto lasts = [&](const ManifoldBlock::Point& point, typename L::F n, typename L::F was) {
            const auto start = L::max(L::load(point.start + k), zero);
            const auto kept = kBounce ? L::select(was, L::min(n, start), n) : n;
            return L::sub(L::max(kept, zero), start);
          };
          const auto o1 = lasts(p1, n1, was1), o2 = lasts(p2, n2, was2), o = L::add(o1, o2);
          auto before = gather_motion<L>(b.vel0, b.spin0, slot);
          const auto owed = [&](typename L::F mine, typename L::F share) {
            return L::mul(L::negate(mine), L::sub(one, share));
          };
          apply_impulse<L, false>(
              before, L::sub(L::mul(o, nx), L::mul(rub_sum, ny)),
              L::add(L::mul(o, ny), L::mul(rub_sum, nx)),
              L::add(L::add(L::mul(o1, at1), L::mul(o2, at2)), rub_turn_a),
              L::add(L::add(L::mul(o1, bt1), L::mul(o2, bt2)), rub_turn_b), owed(wa, sa),
              owed(wb, sb), owed(ga, sa), owed(gb, sb));
          scatter_motion<L, false>(b.vel0, b.spin0, slot, before);
        }
      }
      if (kBounce && !p.more) {
        const auto keep = [&](ManifoldBlock::Point& point, typename L::F n, typename L::F was) {
          const auto lasts = L::min(n, L::max(L::load(point.start + k), zero));
          L::store(point.start + k, L::both(was, L::sub(n, lasts)));
          L::store(point.impulse + k, L::select(was, lasts, n));
        };
        keep(p1, n1, was1);
        keep(p2, n2, was2);
      }
    }
  }
}

/// As spend_contacts: moves what impacts added into the velocities before the kick, so that the next
/// substep does not repeat it.
template <class L, bool kFixedA>
void spend_manifolds(const BodyView& b, ManifoldBlock* blocks, std::uint32_t begin,
                     std::uint32_t end) {
  const auto zero = L::set1(0);
  for (ManifoldBlock* c = blocks + begin; c != blocks + end; ++c) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto& p1 = c->point[0];
      auto& p2 = c->point[1];
      const auto s1 = L::load(p1.start + k), s2 = L::load(p2.start + k);
      const auto hit1 = L::less(zero, s1), hit2 = L::less(zero, s2);
      if (!L::bits(L::either(hit1, hit2))) continue;
      const auto mu = L::load(c->mu + k);
      const auto beyond = [&](ManifoldBlock::Point& point, typename L::F hit) {
        const auto t = L::load(point.friction + k);
        const auto cap = L::mul(mu, L::max(L::load(point.impulse + k), zero));
        const auto held = L::max(L::min(t, cap), L::negate(cap));
        L::store(point.friction + k, L::select(hit, held, t));
        return L::both(hit, L::sub(t, held));
      };
      const auto d1 = L::both(hit1, s1), d2 = L::both(hit2, s2);
      const auto t1 = beyond(p1, hit1), t2 = beyond(p2, hit2);
      const auto nx = L::load(c->nx + k), ny = L::load(c->ny + k);
      const auto l = L::add(d1, d2), t = L::add(t1, t2);
      const auto turn = [&](const float* n1, const float* a1, const float* n2, const float* a2) {
        return L::add(L::add(L::mul(d1, L::load(a1 + k)), L::mul(t1, L::load(n1 + k))),
                      L::add(L::mul(d2, L::load(a2 + k)), L::mul(t2, L::load(n2 + k))));
      };
      const std::uint32_t* slot = c->body + 2 * k;
      auto m = gather_motion<L>(b.vel0, b.spin0, slot);
      apply_impulse<L, kFixedA>(m, L::sub(L::mul(l, nx), L::mul(t, ny)),
                                L::add(L::mul(l, ny), L::mul(t, nx)),
                                turn(p1.an, p1.at, p2.an, p2.at), turn(p1.bn, p1.bt, p2.bn, p2.bt),
                                L::load(c->wa + k), L::load(c->wb + k), L::load(c->ga + k),
                                L::load(c->gb + k));
      scatter_motion<L, kFixedA>(b.vel0, b.spin0, slot, m);
    }
  }
}

/// Where bodies have turned to since the frame's start: d += h u / R, turn = R (cos d - 1, sin d).
/// Polynomials of fdlibm's kernels on d - 2 pi nearest(d / 2 pi), halved twice for range.
template <class L>
void swing_bodies(const BodyView& b, const float* radius, float h, std::uint32_t begin,
                  std::uint32_t end) {
  const auto one = L::set1(1), two = L::set1(2), step = L::set1(h);
  const auto nearest = L::set1(12582912.0f);  // 1.5 x 2^23: adding it rounds to whole numbers
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::width) {
      const std::size_t i = static_cast<std::size_t>(block) * kBlock + r;
      const auto spin = L::load(b.spin + i), before = L::load(b.swing + i), none = L::set1(0);
      if (!L::bits(L::either(L::differ(spin, none), L::differ(before, none)))) continue;
      const auto size = L::load(radius + i);
      const auto safe = L::select(L::less(L::set1(0), size), size, one);
      auto d = L::add(before, L::mul(step, L::div(spin, safe)));
      L::store(b.swing + i, d);
      // A turn of more than 2^20 in a frame has no direction left.
      d = L::max(L::min(d, L::set1(1e6f)), L::set1(-1e6f));
      const auto turns = L::sub(L::add(L::mul(d, L::set1(0.15915494309f)), nearest), nearest);
      d = L::sub(L::sub(d, L::mul(turns, L::set1(6.28125f))),
                 L::mul(turns, L::set1(1.9353071795e-3f)));
      const auto x = L::mul(d, L::set1(0.25f)), z = L::mul(x, x);
      // |x| <= pi/4: sin x = x + x^3 S(x^2), cos x - 1 = -x^2/2 + x^4 C(x^2).
      const auto s3 = L::add(L::set1(8.3333310e-3f), L::mul(z, L::set1(-1.9839334e-4f)));
      auto sine = L::add(x, L::mul(L::mul(x, z), L::add(L::set1(-0.16666667f), L::mul(z, s3))));
      const auto c3 = L::add(L::set1(-1.3888889e-3f), L::mul(z, L::set1(2.4801588e-5f)));
      auto less_one = L::add(L::mul(z, L::set1(-0.5f)),
                             L::mul(L::mul(z, z), L::add(L::set1(4.1666668e-2f), L::mul(z, c3))));
      for (int doubling = 0; doubling < 2; ++doubling) {  // sin 2x = 2 s c, cos 2x - 1 = -2 s^2
        const auto cosine = L::add(one, less_one);
        less_one = L::negate(L::mul(two, L::mul(sine, sine)));
        sine = L::mul(two, L::mul(sine, cosine));
      }
      // + 0: who did not turn has +0 here, whether or not its register was skipped above.
      L::store_records(b.turn + 2 * i, L::add(L::mul(size, less_one), none),
                       L::add(L::mul(size, sine), none));
    }
  }
}

}  // namespace
}  // namespace psim::kernels
