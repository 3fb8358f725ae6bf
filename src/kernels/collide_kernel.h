// Contacts of two hulls, a pair a lane: separating axes and clipping. Both sides of a branch are computed and one is
// selected, so that a lane has the bits that collide() gives its pair, whatever pairs lie beside it. What is rare
// (cores deep in each other, outlines that floats cannot tell apart) is not worth the lanes' time: `hard` names those
// pairs, and the caller asks collide(). It is in src/core/collide/collide.cpp, which takes one pair at a time of any
// numbers of vertices, uses the functions below with one lane, and does all else operation by operation as here.
//
// kA, kB: room for vertices of the hulls: 2 (segment, capsule), 4 (triangle, box, any quadrilateral) or 8 (all others).
#pragma once

#include "collide_views.h"
#include "lane_vec.h"

namespace psim::kernels {
namespace {

constexpr float kFarAway = 3.402823466e38f;
/// By how much an axis of B must be better than the best one of A to be taken, and how far apart two points must lie to
/// count as two: shares of the smaller reach of the hulls.
constexpr float kAxisPreference = 1e-3f;
/// The rounding of all lengths, as a share of the reach of the hulls.
constexpr float kLengthNoise = 1e-6f;

/// `q` holds cosine and sine.
template <class T>
PSIM_INLINE inline Vec2<T> rotate(Vec2<T> q, Vec2<T> v) {
  return {q.x * v.x - q.y * v.y, q.y * v.x + q.x * v.y};
}
template <class T>
PSIM_INLINE inline Vec2<T> unrotate(Vec2<T> q, Vec2<T> v) {
  return {q.x * v.x + q.y * v.y, q.x * v.y - q.y * v.x};
}

/// A hull's vertices and normals, and its radius. Behind the last one come copies of its first vertex and edge: such an edge
/// is never the best one, because the first one is not worse.
template <class L, int kN>
struct LaneCore {
  Vec<L> vertex[kN], normal[kN];
  F<L> radius, reach;
  F<L> count;  // of its vertices

  static constexpr int size() { return kN; }
  PSIM_INLINE Vec<L> corner(int k) const { return vertex[k]; }
};

template <class L, int kN>
PSIM_INLINE inline LaneCore<L, kN> load_core(const float* const* hull, const float* count) {
  constexpr int kRoom = kN < 4 ? 4 : kN, kFewest = kN == 4 ? 3 : kN == 8 ? 5 : kN;
  F<L> x[kRoom], y[kRoom], nx[kRoom], ny[kRoom], others[2];
  for (std::size_t k = 0; k < kRoom; k += 4) {
    L::gather4(hull, kHullX + k, x[k], x[k + 1], x[k + 2], x[k + 3]);
    L::gather4(hull, kHullY + k, y[k], y[k + 1], y[k + 2], y[k + 3]);
    L::gather4(hull, kHullNx + k, nx[k], nx[k + 1], nx[k + 2], nx[k + 3]);
    L::gather4(hull, kHullNy + k, ny[k], ny[k + 1], ny[k + 2], ny[k + 3]);
  }
  LaneCore<L, kN> c;
  c.count = L::load(count);
  for (int k = 0; k < kN; ++k) {
    c.vertex[k] = {x[k], y[k]};
    c.normal[k] = {nx[k], ny[k]};
    if (k < kFewest) continue;
    const auto has = static_cast<float>(k) < c.count;
    c.vertex[k] = select(has, c.vertex[k], c.vertex[0]);
    c.normal[k] = select(has, c.normal[k], c.normal[0]);
  }
  L::gather4(hull, kHullRound, c.radius, c.reach, others[0], others[1]);
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
PSIM_INLINE inline LaneEdge<L> best_axis(const LaneCore<L, kN>& core, const LaneCore<L, kM>& other) {
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

/// The number of the vertex after number `at`, of `count` vertices.
template <class L>
PSIM_INLINE inline F<L> next_of(F<L> at, F<L> count) {
  const auto next = at + 1;
  return select(next < count, next, 0);
}

/// Names a point. Kind 0: an edge of A and a vertex of B; 1: an edge of B and a vertex of A; 2: vertices of A and B. The
/// vertex is the end of the incident edge, even where a corner of the reference edge is nearer: otherwise boxes of the
/// same width on each other would change names all the time.
template <class L>
PSIM_INLINE inline F<L> feature_of(F<L> kind, F<L> first, F<L> second) {
  return kind * 64 + first * 8 + second;
}

template <class L>
PSIM_INLINE inline void store_point(HullPairs::Point& p, std::uint32_t k, Vec<L> b, Vec<L> d, F<L> gap, F<L> feature) {
  L::store(p.ax + k, b.x + d.x);
  L::store(p.ay + k, b.y + d.y);
  L::store(p.bx + k, b.x);
  L::store(p.by + k, b.y);
  L::store(p.gap + k, gap);
  L::store(p.feature + k, feature);
}

/// Two hulls with the axes of A and the origin at B's centre.
template <class L, int kA, int kB>
struct LanePair {
  LaneCore<L, kA> a;
  LaneCore<L, kB> b;
  Vec<L> frame, d;  // rotation of A; from the centre of A to that of B, world axes
  F<L> margin, size, noise;
  M<L> out;    // too far apart
  F<L> apart;  // the gap of two circles around the hulls
};

template <class L, int kA, int kB>
PSIM_INLINE inline LanePair<L, kA, kB> load_pair(const HullPairs& c, std::uint32_t k) {
  LanePair<L, kA, kB> p;
  p.a = load_core<L, kA>(c.a + k, c.vertices_a + k);
  p.b = load_core<L, kB>(c.b + k, c.vertices_b + k);
  p.frame = load_vec<L>(c.ac, c.as, k);
  const auto qb = load_vec<L>(c.bc, c.bs, k);
  p.d = load_vec<L>(c.dx, c.dy, k);
  p.margin = L::load(c.margin + k);
  const F<L> both_reach = p.a.reach + p.b.reach;
  p.size = min(p.a.reach, p.b.reach);
  p.noise = kLengthNoise * both_reach;
  const F<L> whole = both_reach + p.margin;
  p.out = whole * whole < dot(p.d, p.d);
  p.apart = sqrt(dot(p.d, p.d)) - both_reach;
  const Vec<L> back = unrotate(p.frame, p.d);
  for (Vec<L>& v : p.a.vertex) v = v - back;
  const Vec<L> q{p.frame.x * qb.x + p.frame.y * qb.y, p.frame.x * qb.y - p.frame.y * qb.x};
  for (Vec<L>& v : p.b.vertex) v = rotate(q, v);
  for (Vec<L>& v : p.b.normal) v = rotate(q, v);
  return p;
}

/// The reference edge, which is one of B's in the lanes of use_b, and the incident edge, from vertex `high` to `low`.
template <class L>
struct LaneEdges {
  M<L> use_b;
  Vec<L> normal, first, last;  // of the reference edge
  F<L> edge, ends[2];          // its number, and those of its vertices
  F<L> facing;                 // number of the incident edge
  Vec<L> low{0, 0}, high{0, 0}, facing_normal{0, 0};
};

/// The other core's edge that faces the normal most squarely.
template <class L, int kA, int kB>
PSIM_INLINE inline void find_facing(const LanePair<L, kA, kB>& p, LaneEdges<L>& e) {
  constexpr int kMost = kA > kB ? kA : kB;
  const F<L> zero = 0, far = kFarAway;
  F<L> least_turn = far;
  e.facing = zero;
  for (int j = 0; j < kMost; ++j) {
    // Where a core has no vertex j, another one, never taken.
    const int ja = j % kA, jb = j % kB;
    const Vec<L> n = select(e.use_b, p.a.normal[ja], p.b.normal[jb]);
    const Vec<L> from = select(e.use_b, p.a.vertex[ja], p.b.vertex[jb]);
    const Vec<L> to = select(e.use_b, p.a.vertex[(j + 1) % kA], p.b.vertex[(j + 1) % kB]);
    const F<L> sine = abs(e.normal.x * n.y - e.normal.y * n.x);
    F<L> turned = select(dot(e.normal, n) < zero, sine, 2 + sine);
    if (j >= kA) turned = select(e.use_b, far, turned);
    if (j >= kB) turned = select(e.use_b, turned, far);
    const M<L> better = turned < least_turn;
    least_turn = select(better, turned, least_turn);
    if (j == 0) {
      e.high = from, e.low = to, e.facing_normal = n;
      continue;
    }
    e.facing = select(better, static_cast<float>(j), e.facing);
    e.high = select(better, from, e.high);
    e.low = select(better, to, e.low);
    e.facing_normal = select(better, n, e.facing_normal);
  }
}

/// The incident edge clipped to the reference edge: t along it, h over it, ends in the order of t.
template <class L>
struct LaneClip {
  Vec<L> tangent, incident[2];  // incident: the ends before they were clipped
  F<L> offset, names[2], t[2], h[2];
  M<L> empty;
};

/// Every number is made the same way from either end, so that a mirrored scene gives mirrored bits.
template <class L>
PSIM_INLINE inline LaneClip<L> clip_edge(const LaneEdges<L>& e, F<L> other_count) {
  const F<L> zero = 0, half = 0.5f, one = 1;
  LaneClip<L> c;
  c.tangent = {-e.normal.y, e.normal.x};
  c.offset = half * (dot(e.normal, e.first) + dot(e.normal, e.last));
  const F<L> t0 = dot(c.tangent, e.first), t1 = dot(c.tangent, e.last);
  F<L> s0 = dot(c.tangent, e.low), s1 = dot(c.tangent, e.high);
  const M<L> swap = s1 < s0;
  const F<L> next_facing = next_of<L>(e.facing, other_count);
  c.names[0] = select(swap, e.facing, next_facing), c.names[1] = select(swap, next_facing, e.facing);
  c.incident[0] = select(swap, e.high, e.low), c.incident[1] = select(swap, e.low, e.high);
  const F<L> s_low = select(swap, s1, s0);
  s1 = select(swap, s0, s1);
  s0 = s_low;
  const F<L> h0 = dot(e.normal, c.incident[0]) - c.offset, h1 = dot(e.normal, c.incident[1]) - c.offset;
  c.empty = (s1 < t0) | (t1 < s0);
  const F<L> span = s1 - s0;
  const M<L> sloped = zero < span;
  const F<L> slope = select(sloped, (h1 - h0) / select(sloped, span, one), zero);
  c.t[0] = max(t0, s0), c.t[1] = min(t1, s1);
  c.h[0] = h0 + slope * (c.t[0] - s0), c.h[1] = h1 - slope * (s1 - c.t[1]);
  return c;
}

/// A point, midway between the surfaces, and its name.
template <class L>
struct LanePoint {
  Vec<L> at;
  F<L> gap, feature;
};

/// The points over a face, in the same order whoever the reference is. `two`: they lie far enough from each other.
/// Nearly parallel edges have the same names, whichever of them is the reference.
template <class L, class Pair>
PSIM_INLINE inline void face_points(const Pair& p, const LaneEdges<L>& e, const LaneClip<L>& c, Vec<L> outward,
                                    M<L> two, LanePoint<L>& point1, LanePoint<L>& point2) {
  const F<L> zero = 0, half = 0.5f, one = 1;
  const F<L> radii = p.a.radius + p.b.radius;
  const F<L> ahead = select(e.use_b, p.b.radius - p.a.radius, p.a.radius - p.b.radius);
  const M<L> renamed = e.use_b & (0.95f < dot(outward, e.facing_normal));
  const F<L> kind = select(e.use_b, one, zero);
  const auto point_of = [&](M<L> of_high) -> LanePoint<L> {
    const F<L> height = select(of_high, c.h[1], c.h[0]), along = select(of_high, c.t[1], c.t[0]);
    const F<L> level = c.offset + half * (height + ahead);
    return {{e.normal.x * level + c.tangent.x * along, e.normal.y * level + c.tangent.y * along},
            height - radii,
            select(renamed, feature_of<L>(zero, e.facing, select(of_high, e.ends[1], e.ends[0])),
                   feature_of<L>(kind, e.edge, select(of_high, c.names[1], c.names[0])))};
  };
  point1 = point_of(select(two, e.use_b, c.h[1] < c.h[0]));
  point2 = point_of(kind < half);
}

/// The nearest two of the ends of A's edge and of B's. In the lanes of `at_vertices`, point 1 and the normal become
/// theirs; `hard` are the lanes whose nearest points lie elsewhere.
template <class L, class Pair>
PSIM_INLINE inline void vertex_points(Pair& p, const LaneEdges<L>& e, const LaneClip<L>& c, Vec<L> outward,
                                      M<L> at_vertices, M<L>& hard, Vec<L>& n, LanePoint<L>& point1) {
  const F<L> half = 0.5f, one = 1;
  const Vec<L> ref[2] = {e.first, e.last};
  F<L> square = kFarAway;
  Vec<L> from = select(e.use_b, c.incident[0], e.first), to = select(e.use_b, e.first, c.incident[0]);
  F<L> va = select(e.use_b, c.names[0], e.ends[0]), vb = select(e.use_b, e.ends[0], c.names[0]);
  for (int i = 0; i < 2; ++i) {
    const Vec<L> on_a = select(e.use_b, c.incident[i], ref[i]);
    const F<L> name_a = select(e.use_b, c.names[i], e.ends[i]);
    for (int j = 0; j < 2; ++j) {
      const Vec<L> on_b = select(e.use_b, ref[j], c.incident[j]);
      const Vec<L> way = on_b - on_a;
      const F<L> this_square = dot(way, way);
      const M<L> better = this_square < square;
      square = select(better, this_square, square);
      from = select(better, on_a, from);
      to = select(better, on_b, to);
      va = select(better, name_a, va);
      vb = select(better, select(e.use_b, e.ends[j], c.names[j]), vb);
    }
  }
  const F<L> distance = sqrt(square);
  const M<L> apart = kLengthNoise * p.size < distance;
  const F<L> divisor = select(apart, distance, one);
  const Vec<L> way = to - from;
  const Vec<L> line = select(apart, Vec<L>{way.x / divisor, way.y / divisor}, outward);
  // The line between them is the shortest if both are the farthest of their cores along it.
  F<L> front = dot(line, from), rear = dot(line, to);
  for (int k = 0; k < p.a.size(); ++k) front = max(dot(line, p.a.corner(k)), front);
  for (int k = 0; k < p.b.size(); ++k) rear = min(dot(line, p.b.corner(k)), rear);
  const M<L> elsewhere = apart & (rear - front < distance - p.noise);
  hard = hard | (at_vertices & elsewhere);
  const F<L> gap = distance - (p.a.radius + p.b.radius);
  const Vec<L> at = to - (p.b.radius + half * gap) * line;
  // Nothing within the margin: no normal either.
  p.out = p.out | but_not(at_vertices, hard | (gap <= p.margin));
  n = select(at_vertices, line, n);
  point1.at = select(at_vertices, at, point1.at);
  point1.gap = select(at_vertices, gap, point1.gap);
  point1.feature = select(at_vertices, feature_of<L>(2, va, vb), point1.feature);
}

template <class L, int kA, int kB>
void collide_hulls(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0;
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      auto p = load_pair<L, kA, kB>(*c, k);
      const F<L> radii = p.a.radius + p.b.radius, reach = radii + p.margin;
      const auto of_a = best_axis(p.a, p.b);
      const auto of_b = best_axis(p.b, p.a);
      const F<L> most = max(of_a.separation, of_b.separation);
      L::store(c->apart + k, select(p.out, p.apart, most - radii));
      p.out = p.out | (reach < most);
      if (all(p.out)) {
        L::store(c->nx + k, zero);
        L::store(c->ny + k, zero);
        continue;
      }
      LaneEdges<L> e;
      const F<L> preferred = kAxisPreference * p.size;
      e.use_b = of_a.separation + preferred < of_b.separation;
      e.normal = select(e.use_b, of_b.normal, of_a.normal);
      e.first = select(e.use_b, of_b.first, of_a.first), e.last = select(e.use_b, of_b.last, of_a.last);
      e.edge = select(e.use_b, of_b.at, of_a.at);
      e.ends[0] = e.edge, e.ends[1] = next_of<L>(e.edge, select(e.use_b, p.b.count, p.a.count));
      find_facing(p, e);
      const auto clip = clip_edge<L>(e, select(e.use_b, p.a.count, p.b.count));

      const F<L> least = min(clip.h[0], clip.h[1]);
      const M<L> on_face =
          but_not((least <= most + p.noise) & ((most <= p.noise) | (most - p.noise <= least)), clip.empty);
      // Not on A's face: on that of B, if B's axis is the better one by a hair; deep in each other; or
      // the nearest points are vertices.
      M<L> hard = but_not(but_not(of_a.separation < of_b.separation, e.use_b) | (most < -p.noise), on_face);
      const Vec<L> outward = select(e.use_b, Vec<L>{-e.normal.x, -e.normal.y}, e.normal);
      const M<L> two = preferred < clip.t[1] - clip.t[0];
      LanePoint<L> point1, point2;
      face_points(p, e, clip, outward, two, point1, point2);
      const M<L> near2 = two & on_face & (point2.gap <= p.margin);
      Vec<L> n = outward;
      const M<L> at_vertices = but_not(L::every(), on_face | p.out | hard);
      if (any(at_vertices)) vertex_points(p, e, clip, outward, at_vertices, hard, n, point1);
      const M<L> near1 = point1.gap <= p.margin;

      const Vec<L> world = rotate(p.frame, n);
      L::store(c->nx + k, select(p.out, zero, world.x));
      L::store(c->ny + k, select(p.out, zero, world.y));
      // If the first is too far away, the second is the only one.
      const Vec<L> arm1 = rotate(p.frame, select(near1, point1.at, point2.at)), arm2 = rotate(p.frame, point2.at);
      store_point<L>(c->point[0], k, arm1, p.d, select(near1, point1.gap, point2.gap),
                     select(near1, point1.feature, point2.feature));
      store_point<L>(c->point[1], k, arm2, p.d, point2.gap, point2.feature);
      c->has[0] |= bits(but_not(near1 | near2, p.out)) << k;
      c->has[1] |= bits(but_not(near1 & near2, p.out)) << k;
      c->hard |= bits(but_not(hard, p.out)) << k;
    }
  }
}

/// A hull with room for kN vertices, A, against a disc, B: a hull of one vertex.
template <class L, int kN>
void collide_discs(HullPairs* blocks, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0, half = 0.5f, one = 1;
  for (HullPairs* c = blocks + begin; c != blocks + end; ++c) {
    c->has[0] = c->has[1] = c->hard = 0;
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const auto hull = load_core<L, kN>(c->a + k, c->vertices_a + k);
      const auto disc = load_core<L, 1>(c->b + k, c->vertices_b + k);
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
      const M<L> beyond = radius + margin < distance;
      const F<L> clear = select(out, sqrt(dot(d, d)) - (hull.reach + disc.reach), distance - radius);
      out = out | beyond;
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
      const F<L> corner = select(at_last, next_of<L>(edge, hull.count), edge);
      const F<L> feature = select(at_corner, feature_of<L>(2, corner, zero), feature_of<L>(zero, edge, zero));
      const F<L> gap = distance - radius;
      const M<L> near = but_not(gap <= margin, out);
      L::store(c->apart + k, select(out, clear, gap));
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
