// Contacts of two hulls, a pair a lane: separating axes and clipping, operation by operation as
// src/core/collide.cpp does them one pair at a time. Both sides of its branches are computed and
// one is selected, so that a lane has the bits that collide() gives its pair, whatever pairs lie
// beside it. What is rare (cores deep in each other, outlines that floats cannot tell apart) is
// not worth the lanes' time: `hard` names those pairs, and the caller asks collide().
//
// kA, kB: vertices of the hulls, 2 (segment, capsule) or 4 (box, any quadrilateral).
#pragma once

#include "collide_views.h"
#include "lane_vec.h"

namespace psim::kernels {
namespace {

// As in collide.cpp.
constexpr float kFarAway = 3.402823466e38f;
constexpr float kAxisPreference = 1e-3f;
constexpr float kLengthNoise = 1e-6f;

/// `q` holds cosine and sine.
template <class T>
[[gnu::always_inline]] inline Vec2<T> rotate(Vec2<T> q, Vec2<T> v) {
  return {q.x * v.x - q.y * v.y, q.y * v.x + q.x * v.y};
}
template <class T>
[[gnu::always_inline]] inline Vec2<T> unrotate(Vec2<T> q, Vec2<T> v) {
  return {q.x * v.x + q.y * v.y, q.x * v.y - q.y * v.x};
}

/// A hull's vertices and normals, and its radius.
template <class L, int kN>
struct LaneCore {
  Vec<L> vertex[kN], normal[kN];
  F<L> radius, reach;
};

template <class L, int kN>
[[gnu::always_inline]] inline LaneCore<L, kN> load_core(const float* const* hull) {
  F<L> x[4], y[4], nx[4], ny[4], inner, count;
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
  F<L> separation;
  Vec<L> normal, first, last;
  F<L> at;
};

/// The edge along whose normal the other core is farthest.
template <class L, int kN, int kM>
[[gnu::always_inline]] inline LaneEdge<L> best_axis(const LaneCore<L, kN>& core, const LaneCore<L, kM>& other) {
  LaneEdge<L> best;
#pragma GCC unroll 4  // vertices stay in registers
  for (int k = 0; k < kN; ++k) {
    F<L> lowest = kFarAway;
    for (int j = 0; j < kM; ++j) lowest = min(dot(core.normal[k], other.vertex[j]), lowest);
    const auto separation = lowest - dot(core.normal[k], core.vertex[k]);
    const Vec<L> last = core.vertex[(k + 1) % kN];
    if (k == 0) {
      const F<L> far = -kFarAway;
      best = {select(far < separation, separation, far), core.normal[0], core.vertex[0], last, 0};
      continue;
    }
    const auto better = best.separation < separation;
    best.separation = select(better, separation, best.separation);
    best.normal = select(better, core.normal[k], best.normal);
    best.first = select(better, core.vertex[k], best.first);
    best.last = select(better, last, best.last);
    best.at = select(better, static_cast<float>(k), best.at);
  }
  return best;
}

/// Of the vertex after number `at` of `count`.
template <class L>
[[gnu::always_inline]] inline F<L> next_of(F<L> at, F<L> count) {
  const auto next = at + 1;
  return select(next < count, next, 0);
}

template <class L>
[[gnu::always_inline]] inline F<L> feature_of(F<L> kind, F<L> first, F<L> second) {
  return kind * 64 + first * 8 + second;
}

template <class L>
[[gnu::always_inline]] inline void store_point(HullPairs::Point& p, std::uint32_t k, Vec<L> b, Vec<L> d, F<L> gap,
                                               F<L> feature) {
  L::store(p.ax + k, b.x + d.x);
  L::store(p.ay + k, b.y + d.y);
  L::store(p.bx + k, b.x);
  L::store(p.by + k, b.y);
  L::store(p.gap + k, gap);
  L::store(p.feature + k, feature);
}

template <class L, int kA, int kB>
void collide_hulls(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  constexpr int kMost = kA > kB ? kA : kB;
  const F<L> zero = 0, half = 0.5f, one = 1, far = kFarAway;
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto a = load_core<L, kA>(c->a + k);
      auto b = load_core<L, kB>(c->b + k);
      const Vec<L> frame{L::load(c->ac + k), L::load(c->as + k)}, qb{L::load(c->bc + k), L::load(c->bs + k)};
      const Vec<L> d{L::load(c->dx + k), L::load(c->dy + k)};
      const F<L> margin = L::load(c->margin + k);
      const F<L> size = min(a.reach, b.reach), both_reach = a.reach + b.reach;
      const F<L> noise = kLengthNoise * both_reach;
      const F<L> whole = both_reach + margin;
      M<L> out = whole * whole < dot(d, d);

      // Axes of A, origin at B's centre.
      const Vec<L> back = unrotate(frame, d);
      for (Vec<L>& v : a.vertex) v = v - back;
      const Vec<L> q{frame.x * qb.x + frame.y * qb.y, frame.x * qb.y - frame.y * qb.x};
      for (Vec<L>& v : b.vertex) v = rotate(q, v);
      for (Vec<L>& v : b.normal) v = rotate(q, v);

      const F<L> radii = a.radius + b.radius, reach = radii + margin;
      const auto of_a = best_axis(a, b);
      out = out | (reach < of_a.separation);
      const auto of_b = best_axis(b, a);
      out = out | (reach < of_b.separation);
      if (all(out)) {
        L::store(c->nx + k, zero);
        L::store(c->ny + k, zero);
        continue;
      }

      const F<L> preferred = kAxisPreference * size;
      const M<L> use_b = of_a.separation + preferred < of_b.separation;
      const F<L> most = max(of_a.separation, of_b.separation);
      const Vec<L> normal = select(use_b, of_b.normal, of_a.normal);
      const Vec<L> first = select(use_b, of_b.first, of_a.first), last = select(use_b, of_b.last, of_a.last);
      const F<L> edge = select(use_b, of_b.at, of_a.at);
      const F<L> edge_count = select(use_b, kB, kA);
      const F<L> ends[2] = {edge, next_of<L>(edge, edge_count)};

      // The other core's edge that faces the normal most squarely, from vertex `high` to `low`.
      F<L> least_turn = far, facing = zero;
      Vec<L> low, high, facing_normal;
      for (int j = 0; j < kMost; ++j) {
        // Where a core has no vertex j, another one, never taken.
        const int ja = j % kA, jb = j % kB;
        const Vec<L> n = select(use_b, a.normal[ja], b.normal[jb]);
        const Vec<L> from = select(use_b, a.vertex[ja], b.vertex[jb]);
        const Vec<L> to = select(use_b, a.vertex[(j + 1) % kA], b.vertex[(j + 1) % kB]);
        const F<L> sine = abs(normal.x * n.y - normal.y * n.x);
        F<L> turned = select(dot(normal, n) < zero, sine, 2 + sine);
        if (j >= kA) turned = select(use_b, far, turned);
        if (j >= kB) turned = select(use_b, turned, far);
        const M<L> better = turned < least_turn;
        least_turn = select(better, turned, least_turn);
        if (j == 0) {
          high = from, low = to, facing_normal = n;
          continue;
        }
        facing = select(better, static_cast<float>(j), facing);
        high = select(better, from, high);
        low = select(better, to, low);
        facing_normal = select(better, n, facing_normal);
      }
      const F<L> other_count = select(use_b, kA, kB);

      // Clip it to the reference edge: t along it, h over it.
      const Vec<L> tangent{-normal.y, normal.x};
      const F<L> offset = half * (dot(normal, first) + dot(normal, last));
      const F<L> t0 = dot(tangent, first), t1 = dot(tangent, last);
      F<L> s0 = dot(tangent, low), s1 = dot(tangent, high);
      const M<L> swap = s1 < s0;
      const F<L> next_facing = next_of<L>(facing, other_count);
      const F<L> names[2] = {select(swap, facing, next_facing), select(swap, next_facing, facing)};
      const Vec<L> incident[2] = {select(swap, high, low), select(swap, low, high)};
      const F<L> s_low = select(swap, s1, s0);
      s1 = select(swap, s0, s1);
      s0 = s_low;
      const F<L> h0 = dot(normal, incident[0]) - offset, h1 = dot(normal, incident[1]) - offset;
      const M<L> empty = (s1 < t0) | (t1 < s0);
      const F<L> span = s1 - s0;
      const M<L> sloped = zero < span;
      const F<L> slope = select(sloped, (h1 - h0) / select(sloped, span, one), zero);
      const F<L> t[2] = {max(t0, s0), min(t1, s1)};
      const F<L> h[2] = {h0 + slope * (t[0] - s0), h1 - slope * (s1 - t[1])};

      const F<L> least = min(h[0], h[1]);
      const M<L> on_face = but_not((least <= most + noise) & ((most <= noise) | (most - noise <= least)), empty);
      // Not on A's face: on that of B, if B's axis is the better one by a hair; deep in each other; or
      // the nearest points are vertices.
      M<L> hard = but_not(but_not(of_a.separation < of_b.separation, use_b) | (most < -noise), on_face);

      // Points of the face, in the same order whoever the reference is.
      const Vec<L> outward = select(use_b, Vec<L>{-normal.x, -normal.y}, normal);
      const F<L> ahead = select(use_b, b.radius - a.radius, a.radius - b.radius);
      const M<L> renamed = use_b & (0.95f < dot(outward, facing_normal));
      const M<L> two = preferred < t[1] - t[0];
      const F<L> kind = select(use_b, one, zero);
      const auto face_point = [&](M<L> of_high, F<L>& gap, Vec<L>& at, F<L>& feature) {
        const F<L> height = select(of_high, h[1], h[0]), along = select(of_high, t[1], t[0]);
        gap = height - radii;
        const F<L> level = offset + half * (height + ahead);
        at = {normal.x * level + tangent.x * along, normal.y * level + tangent.y * along};
        feature = select(renamed, feature_of<L>(zero, facing, select(of_high, ends[1], ends[0])),
                         feature_of<L>(kind, edge, select(of_high, names[1], names[0])));
      };
      F<L> gap1, gap2, feature1, feature2;
      Vec<L> at1, at2;
      const M<L> first_is_high = select(two, use_b, h[1] < h[0]);
      face_point(first_is_high, gap1, at1, feature1);
      face_point(kind < half, gap2, at2, feature2);
      const M<L> near2 = two & on_face & (gap2 <= margin);
      Vec<L> n = outward;

      const M<L> at_vertices = but_not(L::every(), on_face | out | hard);
      if (any(at_vertices)) {  // the nearest two of the ends of A's edge and of B's
        const Vec<L> ref[2] = {first, last};
        F<L> square = far;
        Vec<L> from = select(use_b, incident[0], first), to = select(use_b, first, incident[0]);
        F<L> va = select(use_b, names[0], ends[0]), vb = select(use_b, ends[0], names[0]);
        for (int i = 0; i < 2; ++i) {
          const Vec<L> on_a = select(use_b, incident[i], ref[i]);
          const F<L> name_a = select(use_b, names[i], ends[i]);
          for (int j = 0; j < 2; ++j) {
            const Vec<L> on_b = select(use_b, ref[j], incident[j]);
            const Vec<L> way = on_b - on_a;
            const F<L> this_square = dot(way, way);
            const M<L> better = this_square < square;
            square = select(better, this_square, square);
            from = select(better, on_a, from);
            to = select(better, on_b, to);
            va = select(better, name_a, va);
            vb = select(better, select(use_b, ends[j], names[j]), vb);
          }
        }
        const F<L> distance = sqrt(square);
        const M<L> apart = kLengthNoise * size < distance;
        const F<L> divisor = select(apart, distance, one);
        const Vec<L> way = to - from;
        const Vec<L> line = select(apart, Vec<L>{way.x / divisor, way.y / divisor}, outward);
        // The line between them is the shortest if both are the farthest of their cores along it.
        F<L> front = dot(line, from), rear = dot(line, to);
        for (const Vec<L>& v : a.vertex) front = max(dot(line, v), front);
        for (const Vec<L>& v : b.vertex) rear = min(dot(line, v), rear);
        const M<L> elsewhere = apart & (rear - front < distance - noise);
        hard = hard | (at_vertices & elsewhere);
        const F<L> gap = distance - radii;
        const F<L> deep = b.radius + half * gap;
        const Vec<L> at = to - deep * line;
        // Nothing within the margin: no normal either.
        out = out | but_not(at_vertices, hard | (gap <= margin));
        n = select(at_vertices, line, n);
        at1 = select(at_vertices, at, at1);
        gap1 = select(at_vertices, gap, gap1);
        feature1 = select(at_vertices, feature_of<L>(2, va, vb), feature1);
      }
      const M<L> near1 = gap1 <= margin;

      const Vec<L> world = rotate(frame, n);
      L::store(c->nx + k, select(out, zero, world.x));
      L::store(c->ny + k, select(out, zero, world.y));
      // If the first is too far away, the second is the only one.
      const Vec<L> arm1 = rotate(frame, select(near1, at1, at2)), arm2 = rotate(frame, at2);
      store_point<L>(c->point[0], k, arm1, d, select(near1, gap1, gap2), select(near1, feature1, feature2));
      store_point<L>(c->point[1], k, arm2, d, gap2, feature2);
      c->has[0] |= bits(but_not(near1 | near2, out)) << k;
      c->has[1] |= bits(but_not(near1 & near2, out)) << k;
      c->hard |= bits(but_not(hard, out)) << k;
    }
  }
}

/// A hull of kN vertices, A, against a disc, B: a hull of one vertex.
template <class L, int kN>
void collide_discs(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0, half = 0.5f, one = 1;
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const auto hull = load_core<L, kN>(c->a + k);
      const auto disc = load_core<L, 1>(c->b + k);
      const Vec<L> frame{L::load(c->ac + k), L::load(c->as + k)}, qb{L::load(c->bc + k), L::load(c->bs + k)};
      const Vec<L> d{L::load(c->dx + k), L::load(c->dy + k)};
      const F<L> margin = L::load(c->margin + k);
      const F<L> whole = hull.reach + disc.reach + margin;
      M<L> out = whole * whole < dot(d, d);
      const Vec<L> arm = rotate(qb, disc.vertex[0]);
      const Vec<L> v = unrotate(frame, Vec<L>{d.x + arm.x, d.y + arm.y});
      const F<L> radius = hull.radius + disc.radius;
      F<L> distance = -kFarAway, edge = zero;
      Vec<L> normal = hull.normal[0], first = hull.vertex[0], last = hull.vertex[1];
      for (int j = 0; j < kN; ++j) {
        const F<L> separation = dot(hull.normal[j], v - hull.vertex[j]);
        const M<L> better = distance < separation;
        distance = select(better, separation, distance);
        normal = select(better, hull.normal[j], normal);
        first = select(better, hull.vertex[j], first);
        last = select(better, hull.vertex[(j + 1) % kN], last);
        edge = select(better, static_cast<float>(j), edge);
      }
      out = out | (radius + margin < distance);
      distance = half * (distance + dot(normal, v - last));
      const Vec<L> from_first = v - first, from_last = v - last;
      const auto across = [&](Vec<L> from, F<L>& along, F<L>& over) {
        along = normal.x * from.y;
        over = normal.y * from.x;
      };
      F<L> y0, x0, y1, x1;
      across(from_first, y0, x0);
      across(from_last, y1, x1);
      const M<L> outside = kN == 2 ? L::every() : zero < distance;
      const M<L> at_last = outside & (x1 < y1);
      const M<L> at_corner = at_last | (outside & (y0 < x0));
      const Vec<L> from = select(at_last, from_last, from_first);
      const F<L> length = sqrt(dot(from, from));
      const M<L> apart = at_corner & (kLengthNoise * disc.reach < length);
      const F<L> divisor = select(apart, length, one);
      Vec<L> n = select(apart, Vec<L>{from.x / divisor, from.y / divisor}, normal);
      distance = select(at_corner, length, distance);
      const F<L> corner = select(at_last, next_of<L>(edge, kN), edge);
      const F<L> feature = select(at_corner, feature_of<L>(2, corner, zero), feature_of<L>(zero, edge, zero));
      const F<L> gap = distance - radius;
      const M<L> near = but_not(gap <= margin, out);
      n = rotate(frame, n);
      const F<L> deep = disc.radius + half * gap;
      store_point<L>(c->point[0], k, arm - deep * n, d, gap, feature);
      L::store(c->nx + k, select(near, n.x, zero));
      L::store(c->ny + k, select(near, n.y, zero));
      c->has[0] |= bits(near) << k;
    }
  }
}

}  // namespace
}  // namespace psim::kernels
