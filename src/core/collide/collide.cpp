// In: two hulls, their rotations and places. Out: a manifold or the nearest points. Nothing is kept. What the kernel for
// eight pairs does as well is its text with one lane; what it leaves out as rare is here.
// A pair of m and n vertices costs O(m n): about 65 ns for two boxes that touch, 25 ns for two boxes
// or 10 ns for a box and a disc that are just out of reach (Intel Xeon, g++ 12.2).
#include "collide/collide.h"

#include <limits>

#include "collide_kernel.h"
#include "compiler.h"
#include "lanes_scalar.h"

namespace psim {
namespace {

using OneLane = kernels::ScalarLanes;
using Real = OneLane::F;
using Vec = kernels::Vec<OneLane>;
using Edges = kernels::LaneEdges<OneLane>;
using Clip = kernels::LaneClip<OneLane>;
using Point = kernels::LanePoint<OneLane>;
using kernels::feature_of;

constexpr float kFar = kernels::kFarAway, kNoise = kernels::kLengthNoise;

Real number(int k) { return static_cast<float>(k); }

/// A hull's core (the vertices without the radius) in the frame of the test: axes of A, origin at
/// B's centre. The numbers of B must be exact there: where sizes differ much, A is the ground.
struct Core {
  float x[Hull::kMost], y[Hull::kMost], nx[Hull::kMost], ny[Hull::kMost];
  Real radius;
  int count;

  int size() const { return count; }
  Vec corner(int k) const { return {x[k], y[k]}; }
  Vec normal(int k) const { return {nx[k], ny[k]}; }
  int next(int k) const { return k + 1 < count ? k + 1 : 0; }
};

/// The edge along whose normal the other core is farthest.
struct Axis {
  float separation = -kFar;
  int edge = 0;
};

/// kCount and kOther are the numbers of vertices, or 0: then the cores say how many.
template <int kCount, int kOther>
inline Axis best_axis(const Core& core, const Core& other) {
  const int n = kCount ? kCount : core.count, m = kOther ? kOther : other.count;
  float lowest[Hull::kMost];
  for (int k = 0; k < n; ++k) lowest[k] = kFar;
  for (int j = 0; j < m; ++j) {
    for (int k = 0; k < n; ++k) {
      const float along = core.nx[k] * other.x[j] + core.ny[k] * other.y[j];
      lowest[k] = along < lowest[k] ? along : lowest[k];
    }
  }
  Axis best;
  for (int k = 0; k < n; ++k) {
    const float separation = lowest[k] - (core.nx[k] * core.x[k] + core.ny[k] * core.y[k]);
    const bool better = separation > best.separation;  // a select, not a jump, which would be taken at random
    best.separation = better ? separation : best.separation;
    best.edge = better ? k : best.edge;
  }
  return best;
}

/// Puts together the reference edge and the edge of the other core that faces its normal most squarely. The sine decides,
/// since it tells edges of nearly the same direction apart where the cosine does not.
template <int kCount>
inline Edges edges_of(const Core& reference, int edge, const Core& incident, bool use_b) {
  const int n = kCount ? kCount : incident.count, end = reference.next(edge);
  const Vec normal = reference.normal(edge);
  int facing = 0;
  Real least = kFar;
  for (int k = 0; k < n; ++k) {
    const Real sine = abs(cross(normal, incident.normal(k)));
    const Real turned = select(dot(normal, incident.normal(k)) < 0, sine, 2 + sine);
    const auto better = turned < least;
    least = select(better, turned, least);
    facing = better ? k : facing;
  }
  Edges e;
  e.use_b = {use_b};
  e.normal = normal;
  e.first = reference.corner(edge), e.last = reference.corner(end);
  e.edge = e.ends[0] = number(edge), e.ends[1] = number(end);
  e.facing = number(facing);
  e.facing_normal = incident.normal(facing);
  e.high = incident.corner(facing), e.low = incident.corner(incident.next(facing));
  return e;
}

/// The working data of collide(). Points and normals are in the frame of the test.
struct Pair {
  Core a, b;
  Vec frame;  // the rotation of A: from the frame of the test to the world
  Vec d;      // from the centre of A to that of B, world axes
  Real margin;
  Real size;   // the smaller reach
  Real noise;  // rounding of lengths, m
  OneLane::M out = OneLane::none();
};

/// `normal` goes from A to B.
inline void set_normal(Vec frame, Vec normal, Manifold& m) {
  const Vec world = rotate(frame, normal);
  m.nx = world.x.v;
  m.ny = world.y.v;
}

/// `b` leads from the centre of B to the point, `d` from the centre of A to that of B.
inline void put_point(Vec b, Vec d, Real gap, Real feature, Manifold& m) {
  const Vec a = b + d;
  m.point[m.count++] = {a.x.v, a.y.v, b.x.v, b.y.v, gap.v, static_cast<std::uint16_t>(feature.v)};
}

inline void add_point(const Pair& p, const Point& point, Manifold& m) {
  if (point.gap <= p.margin) put_point(rotate(p.frame, point.at), p.d, point.gap, point.feature, m);
}

/// Makes one point, midway between the surfaces, from a point of the core of B. `normal` goes from A to B.
inline void one_point(const Pair& p, Vec normal, Vec on_b, Real distance, Real feature, Manifold& m) {
  const Real gap = distance - (p.a.radius + p.b.radius);
  if (!(gap <= p.margin)) return;
  set_normal(p.frame, normal, m);
  add_point(p, {on_b - (p.b.radius + 0.5f * gap) * normal, gap, feature}, m);
}

/// Tests every vertex against every edge: for outlines that are so nearly straight at a corner, or so thin, that floats
/// mistake one edge for the next.
inline void search_point(const Pair& p, Vec normal, Manifold& m) {
  Real least = kFar, feature = 0;
  Vec on_b{0, 0}, step{0, 0};
  for (int kind = 0; kind < 2; ++kind) {
    const Core& edges = kind == 0 ? p.a : p.b;
    const Core& vertices = kind == 0 ? p.b : p.a;
    for (int k = 0; k < edges.count; ++k) {
      const Vec start = edges.corner(k), edge = edges.corner(edges.next(k)) - start;
      const Real square = dot(edge, edge);
      for (int j = 0; j < vertices.count; ++j) {
        const Vec v = vertices.corner(j);
        const Real share = dot(v - start, edge) / select(0 < square, square, 1);
        const Vec foot = start + min(max(share, 0), 1) * edge, gap = v - foot;
        if (!(dot(gap, gap) < least)) continue;
        least = dot(gap, gap);
        step = kind == 0 ? gap : -gap;
        on_b = kind == 0 ? v : foot;
        feature = feature_of<OneLane>(number(kind), number(k), number(j));
      }
    }
  }
  const Real distance = sqrt(least);
  if (kNoise * p.size < distance) normal = {step.x / distance, step.y / distance};
  one_point(p, normal, on_b, distance, feature, m);
}

/// The deepest vertex below the reference edge.
inline void deepest_point(const Pair& p, const Edges& e, const Clip& c, Vec outward, Manifold& m) {
  const bool of_b{e.use_b};
  const Core& core = of_b ? p.a : p.b;
  int deepest = 0;
  Real least = kFar;
  for (int k = 0; k < core.count; ++k) {
    const Real along = dot(e.normal, core.corner(k));
    if (!(along < least)) continue;
    least = along;
    deepest = k;
  }
  const Real depth = least - c.offset;
  Vec on_b = core.corner(deepest);
  if (of_b) on_b = on_b - depth * e.normal;
  one_point(p, outward, on_b, depth, feature_of<OneLane>(of_b ? 1 : 0, e.edge, number(deepest)), m);
}

// Two hulls in the frame of A, with the origin at B's centre.
template <int kA, int kB>
PSIM_INLINE inline void place_cores(const Hull& a, Rotor qa, const Hull& b, Rotor qb, Vec d, float margin, Pair& p) {
  p.frame = {qa.c, qa.s};
  p.d = d;
  p.margin = margin;
  p.size = a.reach < b.reach ? a.reach : b.reach;
  p.noise = kNoise * (a.reach + b.reach);
  const int na = p.a.count = kA ? kA : a.count, nb = p.b.count = kB ? kB : b.count;
  p.a.radius = a.radius;
  p.b.radius = b.radius;
  const Vec back = unrotate(p.frame, d);
  for (int k = 0; k < na; ++k) {
    p.a.x[k] = a.x[k] - back.x.v;
    p.a.y[k] = a.y[k] - back.y.v;
    p.a.nx[k] = a.nx[k];
    p.a.ny[k] = a.ny[k];
  }
  const Rotor q{qa.c * qb.c + qa.s * qb.s, qa.c * qb.s - qa.s * qb.c};
  for (int k = 0; k < nb; ++k) {
    p.b.x[k] = q.c * b.x[k] - q.s * b.y[k];
    p.b.y[k] = q.s * b.x[k] + q.c * b.y[k];
    p.b.nx[k] = q.c * b.nx[k] - q.s * b.ny[k];
    p.b.ny[k] = q.s * b.nx[k] + q.c * b.ny[k];
  }
}

template <int kA, int kB>
inline Manifold collide_cores(const Hull& a, Rotor qa, const Hull& b, Rotor qb, Vec d, float margin, float preference) {
  Pair p;
  place_cores<kA, kB>(a, qa, b, qb, d, margin, p);
  Manifold m;
  const float radii = a.radius + b.radius, reach = radii + margin;
  const Axis of_a = best_axis<kA, kB>(p.a, p.b);
  const Axis of_b = best_axis<kB, kA>(p.b, p.a);
  // The distance of the cores is at least `most`. If a point of an edge and one over it are no farther apart, they are
  // the nearest points; otherwise two vertices are.
  const Real most = of_a.separation > of_b.separation ? of_a.separation : of_b.separation;
  m.point[0].gap = most.v - radii;
  if (most.v > reach) return m;
  const auto nearest_is_on = [&](const Clip& c) {
    const Real least = min(c.h[0], c.h[1]);
    return !c.empty && least <= most + p.noise && (most <= p.noise || most - p.noise <= least);
  };
  const auto edges = [&](bool use_b) {
    return use_b ? edges_of<kA>(p.b, of_b.edge, p.a, true) : edges_of<kB>(p.a, of_a.edge, p.b, false);
  };
  Edges e = edges(of_b.separation > of_a.separation + preference * p.size.v);
  Clip c = kernels::clip_edge<OneLane>(e, number(e.use_b ? p.a.count : p.b.count));
  if (!e.use_b && of_b.separation > of_a.separation && !nearest_is_on(c)) {
    e = edges(true);
    c = kernels::clip_edge<OneLane>(e, number(p.a.count));
  }
  Vec normal = e.use_b ? -e.normal : e.normal;
  Point point[2];
  if (nearest_is_on(c)) {
    const auto two = kernels::kAxisPreference * p.size < c.t[1] - c.t[0];
    kernels::face_points<OneLane>(p, e, c, normal, two, point[0], point[1]);
    set_normal(p.frame, normal, m);
    add_point(p, point[0], m);
    if (two) add_point(p, point[1], m);
  } else if (most < -p.noise) {
    deepest_point(p, e, c, normal, m);
  } else {
    auto elsewhere = OneLane::none();
    const Vec outward = normal;
    kernels::vertex_points<OneLane>(p, e, c, outward, OneLane::every(), elsewhere, normal, point[0]);
    if (elsewhere) {
      search_point(p, outward, m);
    } else if (!p.out) {
      set_normal(p.frame, normal, m);
      add_point(p, point[0], m);
    }
  }
  return m;
}

/// A disc, which is one vertex, against a hull. `d` leads from the centre of the hull to that of the disc.
inline Manifold collide_vertex(const Hull& hull, Rotor qh, const Hull& disc, Rotor qd, Vec d, float margin) {
  const Vec arm = rotate(Vec{qd.c, qd.s}, {disc.x[0], disc.y[0]});  // from the centre of the disc to its vertex
  const Vec frame{qh.c, qh.s}, v = unrotate(frame, d + arm);
  const auto from = [&](int k) { return v - Vec{hull.x[k], hull.y[k]}; };
  const auto normal = [&](int k) { return Vec{hull.nx[k], hull.ny[k]}; };
  const Real radius = hull.radius + disc.radius;
  Vec n{1, 0};
  Real distance = -kFar;
  int edge = 0;
  for (int k = 0; hull.count > 1 && k < hull.count; ++k) {
    const Real separation = dot(normal(k), from(k));
    if (!(distance < separation)) continue;
    distance = separation;
    edge = k;
  }
  Manifold m;
  m.point[0].gap = (distance - radius).v;
  if (radius + margin < distance) return m;
  int corner = hull.count == 1 ? 0 : -1;
  if (hull.count > 1) {
    const int next = hull.next(edge);
    const Vec first = from(edge), last = from(next);
    n = normal(edge);
    // Both ends are used alike, so that a mirrored hull gives mirrored bits.
    distance = 0.5f * (distance + dot(n, last));
    if (hull.count == 2 || 0 < distance) {
      if (n.x * first.y < n.y * first.x) corner = edge;
      if (n.y * last.x < n.x * last.y) corner = next;
    }
  }
  if (corner >= 0) {
    const Vec way = from(corner);
    distance = norm(way);
    if (kNoise * disc.reach < distance) n = {way.x / distance, way.y / distance};
  }
  const Real gap = distance - radius;
  m.point[0].gap = gap.v;
  if (!(gap <= margin)) return m;
  set_normal(frame, n, m);
  const Vec at = arm - (disc.radius + 0.5f * gap) * Vec{m.nx, m.ny};  // from the centre of the disc
  put_point(at, d, gap, feature_of<OneLane>(corner >= 0 ? 2 : 0, number(corner >= 0 ? corner : edge), 0), m);
  return m;
}

inline Manifold collide_any(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin,
                            float preference) {
  const float reach = a.reach + b.reach + margin;
  const float x = kernels::squarable(dx), y = kernels::squarable(dy);
  if (x * x + y * y > reach * reach) {
    Manifold m;
    m.point[0].gap = std::sqrt(x * x + y * y) - (a.reach + b.reach);
    return m;
  }
  if (b.count == 1) return collide_vertex(a, qa, b, qb, {dx, dy}, margin);
  if (a.count == 1) return swapped(collide_vertex(b, qb, a, qa, {-dx, -dy}, margin));
  const Vec d{dx, dy};
  const int counts = a.count << 4 | b.count;  // common pairs have unrolled loops
  if (counts == 0x44) return collide_cores<4, 4>(a, qa, b, qb, d, margin, preference);
  if (counts == 0x24) return collide_cores<2, 4>(a, qa, b, qb, d, margin, preference);
  if (counts == 0x42) return collide_cores<4, 2>(a, qa, b, qb, d, margin, preference);
  if (counts == 0x22) return collide_cores<2, 2>(a, qa, b, qb, d, margin, preference);
  return collide_cores<0, 0>(a, qa, b, qb, d, margin, preference);
}

}  // namespace

Manifold collide(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin) {
  return collide_any(a, qa, b, qb, dx, dy, margin, kernels::kAxisPreference);
}

Manifold swapped(Manifold m) {
  if (m.count == 0) return m;
  m.nx = -m.nx;
  m.ny = -m.ny;
  for (int k = 0; k < m.count; ++k) {
    ManifoldPoint& p = m.point[k];
    p = {p.bx, p.by, p.ax, p.ay, p.gap, static_cast<std::uint16_t>(p.feature | 64u)};
  }
  return m;
}

Nearest nearest(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy) {
  const Manifold m = collide_any(a, qa, b, qb, dx, dy, std::numeric_limits<float>::infinity(), 0);
  const ManifoldPoint& p = m.count > 1 && m.point[1].gap < m.point[0].gap ? m.point[1] : m.point[0];
  return {p.gap, m.nx, m.ny, p.ax - 0.5f * p.gap * m.nx, p.ay - 0.5f * p.gap * m.ny};
}

}  // namespace psim
