// Contacts of two hulls, a pair a lane: separating axes and clipping, operation by operation as
// src/core/collide.cpp does them one pair at a time. Both sides of its branches are computed and
// one is selected, so that a lane has the bits that collide() gives its pair, whatever pairs lie
// beside it. What is rare (cores deep in each other, outlines that floats cannot tell apart) is
// not worth the lanes' time: `hard` names those pairs, and the caller asks collide().
//
// kA, kB: vertices of the hulls, 2 (segment, capsule) or 4 (box, any quadrilateral).
#pragma once

#include "collide_views.h"

namespace psim::kernels {
namespace {

// As in collide.cpp.
constexpr float kFarAway = 3.402823466e38f;
constexpr float kAxisPreference = 1e-3f;
constexpr float kLengthNoise = 1e-6f;

template <class L>
struct LaneVec {
  typename L::F x, y;
};

template <class L>
[[gnu::always_inline]] inline typename L::F dot(LaneVec<L> a, LaneVec<L> b) {
  return L::add(L::mul(a.x, b.x), L::mul(a.y, b.y));
}
template <class L>
[[gnu::always_inline]] inline LaneVec<L> minus(LaneVec<L> a, LaneVec<L> b) {
  return {L::sub(a.x, b.x), L::sub(a.y, b.y)};
}
template <class L>
[[gnu::always_inline]] inline LaneVec<L> times(LaneVec<L> a, typename L::F s) {
  return {L::mul(a.x, s), L::mul(a.y, s)};
}
template <class L>
[[gnu::always_inline]] inline LaneVec<L> choose(typename L::F mask, LaneVec<L> yes, LaneVec<L> no) {
  return {L::select(mask, yes.x, no.x), L::select(mask, yes.y, no.y)};
}
/// `q` holds cosine and sine.
template <class L>
[[gnu::always_inline]] inline LaneVec<L> rotate(LaneVec<L> q, LaneVec<L> v) {
  return {L::sub(L::mul(q.x, v.x), L::mul(q.y, v.y)), L::add(L::mul(q.y, v.x), L::mul(q.x, v.y))};
}
template <class L>
[[gnu::always_inline]] inline LaneVec<L> unrotate(LaneVec<L> q, LaneVec<L> v) {
  return {L::add(L::mul(q.x, v.x), L::mul(q.y, v.y)), L::sub(L::mul(q.x, v.y), L::mul(q.y, v.x))};
}

/// A hull's vertices and normals, and its radius.
template <class L, int kN>
struct LaneCore {
  LaneVec<L> vertex[kN], normal[kN];
  typename L::F radius, reach;
};

template <class L, int kN>
[[gnu::always_inline]] inline LaneCore<L, kN> load_core(const float* const* hull) {
  typename L::F x[4], y[4], nx[4], ny[4], inner, count;
  L::gather4(hull, kHullX, x[0], x[1], x[2], x[3]);
  L::gather4(hull, kHullY, y[0], y[1], y[2], y[3]);
  L::gather4(hull, kHullNx, nx[0], nx[1], nx[2], nx[3]);
  L::gather4(hull, kHullNy, ny[0], ny[1], ny[2], ny[3]);
  LaneCore<L, kN> c;
  for (int k = 0; k < kN; ++k) {
    c.vertex[k] = {x[k], y[k]};
    c.normal[k] = {nx[k], ny[k]};
  }
  L::gather4(hull, kHullRound, c.radius, c.reach, inner, count);
  return c;
}

/// An edge: its normal, ends and number.
template <class L>
struct LaneEdge {
  typename L::F separation;
  LaneVec<L> normal, first, last;
  typename L::F at;
};

/// The edge along whose normal the other core is farthest.
template <class L, int kN, int kM>
[[gnu::always_inline]] inline LaneEdge<L> best_axis(const LaneCore<L, kN>& core,
                                                    const LaneCore<L, kM>& other) {
  LaneEdge<L> best;
#pragma GCC unroll 4  // vertices stay in registers
  for (int k = 0; k < kN; ++k) {
    auto lowest = L::set1(kFarAway);
    for (int j = 0; j < kM; ++j) lowest = L::min(dot(core.normal[k], other.vertex[j]), lowest);
    const auto separation = L::sub(lowest, dot(core.normal[k], core.vertex[k]));
    const LaneVec<L> last = core.vertex[(k + 1) % kN];
    if (k == 0) {
      const auto far = L::set1(-kFarAway);
      best = {L::select(L::less(far, separation), separation, far), core.normal[0], core.vertex[0], last,
              L::set1(0)};
      continue;
    }
    const auto better = L::less(best.separation, separation);
    best.separation = L::select(better, separation, best.separation);
    best.normal = choose(better, core.normal[k], best.normal);
    best.first = choose(better, core.vertex[k], best.first);
    best.last = choose(better, last, best.last);
    best.at = L::select(better, L::set1(static_cast<float>(k)), best.at);
  }
  return best;
}

/// Of the vertex after number `at` of `count`.
template <class L>
[[gnu::always_inline]] inline typename L::F next_of(typename L::F at, typename L::F count) {
  const auto next = L::add(at, L::set1(1));
  return L::select(L::less(next, count), next, L::set1(0));
}

template <class L>
[[gnu::always_inline]] inline typename L::F feature_of(typename L::F kind, typename L::F first,
                                                       typename L::F second) {
  return L::add(L::add(L::mul(kind, L::set1(64)), L::mul(first, L::set1(8))), second);
}

template <class L>
[[gnu::always_inline]] inline void store_point(HullPairs::Point& p, std::uint32_t k, LaneVec<L> b,
                                               LaneVec<L> d, typename L::F gap,
                                               typename L::F feature) {
  L::store(p.ax + k, L::add(b.x, d.x));
  L::store(p.ay + k, L::add(b.y, d.y));
  L::store(p.bx + k, b.x);
  L::store(p.by + k, b.y);
  L::store(p.gap + k, gap);
  L::store(p.feature + k, feature);
}

template <class L, int kA, int kB>
void collide_hulls(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  using F = typename L::F;
  using V = LaneVec<L>;
  constexpr std::uint32_t kAll = (1u << L::width) - 1;
  constexpr int kMost = kA > kB ? kA : kB;
  const F zero = L::set1(0), half = L::set1(0.5f), one = L::set1(1), far = L::set1(kFarAway);
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto a = load_core<L, kA>(c->a + k);
      auto b = load_core<L, kB>(c->b + k);
      const V frame{L::load(c->ac + k), L::load(c->as + k)}, qb{L::load(c->bc + k), L::load(c->bs + k)};
      const V d{L::load(c->dx + k), L::load(c->dy + k)};
      const F margin = L::load(c->margin + k);
      const F size = L::min(a.reach, b.reach), both_reach = L::add(a.reach, b.reach);
      const F noise = L::mul(L::set1(kLengthNoise), both_reach);
      const F whole = L::add(both_reach, margin);
      F out = L::less(L::mul(whole, whole), dot(d, d));

      // Axes of A, origin at B's centre.
      const V back = unrotate(frame, d);
      for (V& v : a.vertex) v = minus(v, back);
      const V q{L::add(L::mul(frame.x, qb.x), L::mul(frame.y, qb.y)),
                L::sub(L::mul(frame.x, qb.y), L::mul(frame.y, qb.x))};
      for (V& v : b.vertex) v = rotate(q, v);
      for (V& v : b.normal) v = rotate(q, v);

      const F radii = L::add(a.radius, b.radius), reach = L::add(radii, margin);
      const auto of_a = best_axis(a, b);
      out = L::either(out, L::less(reach, of_a.separation));
      const auto of_b = best_axis(b, a);
      out = L::either(out, L::less(reach, of_b.separation));
      if (L::bits(out) == kAll) {
        L::store(c->nx + k, zero);
        L::store(c->ny + k, zero);
        continue;
      }

      const F preferred = L::mul(L::set1(kAxisPreference), size);
      const F use_b = L::less(L::add(of_a.separation, preferred), of_b.separation);
      const F most = L::max(of_a.separation, of_b.separation);
      const V normal = choose(use_b, of_b.normal, of_a.normal);
      const V first = choose(use_b, of_b.first, of_a.first), last = choose(use_b, of_b.last, of_a.last);
      const F edge = L::select(use_b, of_b.at, of_a.at);
      const F edge_count = L::select(use_b, L::set1(kB), L::set1(kA));
      const F ends[2] = {edge, next_of<L>(edge, edge_count)};

      // The other core's edge that faces the normal most squarely, from vertex `high` to `low`.
      F least_turn = far, facing = zero;
      V low, high, facing_normal;
      for (int j = 0; j < kMost; ++j) {
        // Where a core has no vertex j, another one, never taken.
        const int ja = j % kA, jb = j % kB;
        const V n = choose(use_b, a.normal[ja], b.normal[jb]);
        const V from = choose(use_b, a.vertex[ja], b.vertex[jb]);
        const V to = choose(use_b, a.vertex[(j + 1) % kA], b.vertex[(j + 1) % kB]);
        const F sine = L::abs(L::sub(L::mul(normal.x, n.y), L::mul(normal.y, n.x)));
        F turned = L::select(L::less(dot(normal, n), zero), sine, L::add(L::set1(2), sine));
        if (j >= kA) turned = L::select(use_b, far, turned);
        if (j >= kB) turned = L::select(use_b, turned, far);
        const F better = L::less(turned, least_turn);
        least_turn = L::select(better, turned, least_turn);
        if (j == 0) {
          high = from, low = to, facing_normal = n;
          continue;
        }
        facing = L::select(better, L::set1(static_cast<float>(j)), facing);
        high = choose(better, from, high);
        low = choose(better, to, low);
        facing_normal = choose(better, n, facing_normal);
      }
      const F other_count = L::select(use_b, L::set1(kA), L::set1(kB));

      // Clip it to the reference edge: t along it, h over it.
      const V tangent{L::negate(normal.y), normal.x};
      const F offset = L::mul(half, L::add(dot(normal, first), dot(normal, last)));
      const F t0 = dot(tangent, first), t1 = dot(tangent, last);
      F s0 = dot(tangent, low), s1 = dot(tangent, high);
      const F swap = L::less(s1, s0);
      const F next_facing = next_of<L>(facing, other_count);
      const F names[2] = {L::select(swap, facing, next_facing), L::select(swap, next_facing, facing)};
      const V incident[2] = {choose(swap, high, low), choose(swap, low, high)};
      const F s_low = L::select(swap, s1, s0);
      s1 = L::select(swap, s0, s1);
      s0 = s_low;
      const F h0 = L::sub(dot(normal, incident[0]), offset), h1 = L::sub(dot(normal, incident[1]), offset);
      const F empty = L::either(L::less(s1, t0), L::less(t1, s0));
      const F span = L::sub(s1, s0);
      const F sloped = L::less(zero, span);
      const F slope = L::select(sloped, L::div(L::sub(h1, h0), L::select(sloped, span, one)), zero);
      const F t[2] = {L::max(t0, s0), L::min(t1, s1)};
      const F h[2] = {L::add(h0, L::mul(slope, L::sub(t[0], s0))),
                      L::sub(h1, L::mul(slope, L::sub(s1, t[1])))};

      const F least = L::min(h[0], h[1]);
      const F on_face = L::but_not(
          L::both(L::less_equal(least, L::add(most, noise)),
                  L::either(L::less_equal(most, noise), L::less_equal(L::sub(most, noise), least))),
          empty);
      // Not on A's face: on that of B, if B's axis is the better one by a hair; deep in each other; or
      // the nearest points are vertices.
      F hard = L::but_not(L::either(L::but_not(L::less(of_a.separation, of_b.separation), use_b),
                                    L::less(most, L::negate(noise))),
                          on_face);

      // Points of the face, in the same order whoever the reference is.
      const V outward = choose(use_b, V{L::negate(normal.x), L::negate(normal.y)}, normal);
      const F ahead = L::select(use_b, L::sub(b.radius, a.radius), L::sub(a.radius, b.radius));
      const F renamed = L::both(use_b, L::less(L::set1(0.95f), dot(outward, facing_normal)));
      const F two = L::less(preferred, L::sub(t[1], t[0]));
      const F kind = L::select(use_b, one, zero);
      const auto face_point = [&](F of_high, F& gap, V& at, F& feature) {
        const F height = L::select(of_high, h[1], h[0]), along = L::select(of_high, t[1], t[0]);
        gap = L::sub(height, radii);
        const F level = L::add(offset, L::mul(half, L::add(height, ahead)));
        at = {L::add(L::mul(normal.x, level), L::mul(tangent.x, along)),
              L::add(L::mul(normal.y, level), L::mul(tangent.y, along))};
        feature = L::select(renamed,
                            feature_of<L>(zero, facing, L::select(of_high, ends[1], ends[0])),
                            feature_of<L>(kind, edge, L::select(of_high, names[1], names[0])));
      };
      F gap1, gap2, feature1, feature2;
      V at1, at2;
      const F first_is_high = L::select(two, use_b, L::less(h[1], h[0]));
      face_point(first_is_high, gap1, at1, feature1);
      face_point(L::less(kind, half), gap2, at2, feature2);
      const F near2 = L::both(L::both(two, on_face), L::less_equal(gap2, margin));
      V n = outward;

      const F all = L::less_equal(zero, zero);
      const F at_vertices = L::but_not(all, L::either(L::either(on_face, out), hard));
      if (L::bits(at_vertices) != 0) {  // the nearest two of the ends of A's edge and of B's
        const V ref[2] = {first, last};
        F square = far;
        V from = choose(use_b, incident[0], first), to = choose(use_b, first, incident[0]);
        F va = L::select(use_b, names[0], ends[0]), vb = L::select(use_b, ends[0], names[0]);
        for (int i = 0; i < 2; ++i) {
          const V on_a = choose(use_b, incident[i], ref[i]);
          const F name_a = L::select(use_b, names[i], ends[i]);
          for (int j = 0; j < 2; ++j) {
            const V on_b = choose(use_b, ref[j], incident[j]);
            const V way = minus(on_b, on_a);
            const F this_square = dot(way, way);
            const F better = L::less(this_square, square);
            square = L::select(better, this_square, square);
            from = choose(better, on_a, from);
            to = choose(better, on_b, to);
            va = L::select(better, name_a, va);
            vb = L::select(better, L::select(use_b, ends[j], names[j]), vb);
          }
        }
        const F distance = L::sqrt(square);
        const F apart = L::less(L::mul(L::set1(kLengthNoise), size), distance);
        const F divisor = L::select(apart, distance, one);
        const V way = minus(to, from);
        const V line = choose(apart, V{L::div(way.x, divisor), L::div(way.y, divisor)}, outward);
        // The line between them is the shortest if both are the farthest of their cores along it.
        F front = dot(line, from), rear = dot(line, to);
        for (const V& v : a.vertex) front = L::max(dot(line, v), front);
        for (const V& v : b.vertex) rear = L::min(dot(line, v), rear);
        const F elsewhere = L::both(apart, L::less(L::sub(rear, front), L::sub(distance, noise)));
        hard = L::either(hard, L::both(at_vertices, elsewhere));
        const F gap = L::sub(distance, radii);
        const F deep = L::add(b.radius, L::mul(half, gap));
        const V at = minus(to, times(line, deep));
        // Nothing within the margin: no normal either.
        out = L::either(out, L::but_not(at_vertices, L::either(hard, L::less_equal(gap, margin))));
        n = choose(at_vertices, line, n);
        at1 = choose(at_vertices, at, at1);
        gap1 = L::select(at_vertices, gap, gap1);
        feature1 = L::select(at_vertices, feature_of<L>(L::set1(2), va, vb), feature1);
      }
      const F near1 = L::less_equal(gap1, margin);

      const V world = rotate(frame, n);
      L::store(c->nx + k, L::select(out, zero, world.x));
      L::store(c->ny + k, L::select(out, zero, world.y));
      // If the first is too far away, the second is the only one.
      const V arm1 = rotate(frame, choose(near1, at1, at2)), arm2 = rotate(frame, at2);
      store_point<L>(c->point[0], k, arm1, d, L::select(near1, gap1, gap2),
                     L::select(near1, feature1, feature2));
      store_point<L>(c->point[1], k, arm2, d, gap2, feature2);
      c->has[0] |= L::bits(L::but_not(L::either(near1, near2), out)) << k;
      c->has[1] |= L::bits(L::but_not(L::both(near1, near2), out)) << k;
      c->hard |= L::bits(L::but_not(hard, out)) << k;
    }
  }
}

/// A hull of kN vertices, A, against a disc, B: a hull of one vertex.
template <class L, int kN>
void collide_discs(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  using F = typename L::F;
  using V = LaneVec<L>;
  const F zero = L::set1(0), half = L::set1(0.5f), one = L::set1(1);
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const auto hull = load_core<L, kN>(c->a + k);
      const auto disc = load_core<L, 1>(c->b + k);
      const V frame{L::load(c->ac + k), L::load(c->as + k)}, qb{L::load(c->bc + k), L::load(c->bs + k)};
      const V d{L::load(c->dx + k), L::load(c->dy + k)};
      const F margin = L::load(c->margin + k);
      const F whole = L::add(L::add(hull.reach, disc.reach), margin);
      F out = L::less(L::mul(whole, whole), dot(d, d));
      const V arm = rotate(qb, disc.vertex[0]);
      const V v = unrotate(frame, V{L::add(d.x, arm.x), L::add(d.y, arm.y)});
      const F radius = L::add(hull.radius, disc.radius);
      F distance = L::set1(-kFarAway), edge = zero;
      V normal = hull.normal[0], first = hull.vertex[0], last = hull.vertex[1];
      for (int j = 0; j < kN; ++j) {
        const F separation = dot(hull.normal[j], minus(v, hull.vertex[j]));
        const F better = L::less(distance, separation);
        distance = L::select(better, separation, distance);
        normal = choose(better, hull.normal[j], normal);
        first = choose(better, hull.vertex[j], first);
        last = choose(better, hull.vertex[(j + 1) % kN], last);
        edge = L::select(better, L::set1(static_cast<float>(j)), edge);
      }
      out = L::either(out, L::less(L::add(radius, margin), distance));
      distance = L::mul(half, L::add(distance, dot(normal, minus(v, last))));
      const V from_first = minus(v, first), from_last = minus(v, last);
      const auto across = [&](V from, F& along, F& over) {
        along = L::mul(normal.x, from.y);
        over = L::mul(normal.y, from.x);
      };
      F y0, x0, y1, x1;
      across(from_first, y0, x0);
      across(from_last, y1, x1);
      const F outside = kN == 2 ? L::less_equal(zero, zero) : L::less(zero, distance);
      const F at_last = L::both(outside, L::less(x1, y1));
      const F at_corner = L::either(at_last, L::both(outside, L::less(y0, x0)));
      const V from = choose(at_last, from_last, from_first);
      const F length = L::sqrt(dot(from, from));
      const F apart = L::both(at_corner, L::less(L::mul(L::set1(kLengthNoise), disc.reach), length));
      const F divisor = L::select(apart, length, one);
      V n = choose(apart, V{L::div(from.x, divisor), L::div(from.y, divisor)}, normal);
      distance = L::select(at_corner, length, distance);
      const F corner = L::select(at_last, next_of<L>(edge, L::set1(kN)), edge);
      const F feature = L::select(at_corner, feature_of<L>(L::set1(2), corner, zero),
                                  feature_of<L>(zero, edge, zero));
      const F gap = L::sub(distance, radius);
      const F near = L::but_not(L::less_equal(gap, margin), out);
      n = rotate(frame, n);
      const F deep = L::add(disc.radius, L::mul(half, gap));
      store_point<L>(c->point[0], k, minus(arm, times(n, deep)), d, gap, feature);
      L::store(c->nx + k, L::select(near, n.x, zero));
      L::store(c->ny + k, L::select(near, n.y, zero));
      c->has[0] |= L::bits(near) << k;
    }
  }
}

}  // namespace
}  // namespace psim::kernels
