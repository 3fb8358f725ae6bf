// In: two hulls, their rotations and places. Out: a manifold or the nearest points. Nothing is kept.
// A pair of m and n vertices costs O(m n): about 65 ns for two boxes that touch, 25 ns for two boxes
// or 10 ns for a box and a disc that are just out of reach (Intel Xeon, g++ 12.2).
#include "manifolds/collide.h"

#include <cmath>
#include <limits>
#include <utility>

namespace psim {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();

/// By how much an axis of B must be better than the best one of A to be taken, and how far apart two points must lie to
/// count as two: shares of the smaller reach of the hulls.
constexpr float kPreference = 1e-3f;
/// The rounding of all lengths, as a share of the reach of the hulls.
constexpr float kNoise = 1e-6f;

struct Vec {
  float x, y;
};

Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
Vec operator-(Vec a) { return {-a.x, -a.y}; }
Vec operator*(float f, Vec a) { return {f * a.x, f * a.y}; }
Vec rotate(Rotor q, Vec v) { return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y}; }
Vec unrotate(Rotor q, Vec v) { return {q.c * v.x + q.s * v.y, q.c * v.y - q.s * v.x}; }
float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }

/// A hull's core (the vertices without the radius) in the frame of the test: axes of A, origin at
/// B's centre. The numbers of B must be exact there: where sizes differ much, A is the ground.
struct Core {
  float x[Hull::kMost], y[Hull::kMost], nx[Hull::kMost], ny[Hull::kMost];
  float radius;
  int count;

  Vec vertex(int k) const { return {x[k], y[k]}; }
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

/// The edge of the other core that faces a normal most squarely. The sine decides, since it tells edges of nearly the
/// same direction apart where the cosine does not.
template <int kCount>
inline int facing_edge(const Core& core, Vec normal) {
  const int n = kCount ? kCount : core.count;
  int best = 0;
  float least = kFar;
  for (int k = 0; k < n; ++k) {
    const float sine = std::fabs(normal.x * core.ny[k] - normal.y * core.nx[k]);
    const float turned = dot(normal, core.normal(k)) < 0 ? sine : 2 + sine;
    const bool better = turned < least;
    least = better ? turned : least;
    best = better ? k : best;
  }
  return best;
}

/// The part of the incident edge that lies over the reference edge, in the frame of the latter:
/// tangent t along it, height h over it. Low and high are its ends by t.
struct Clip {
  Vec normal, tangent;
  float offset;      // distance of the reference edge from the origin along the normal
  float t[2], h[2];  // the clipped ends
  int vertex[2];     // the ends of the incident edge
  int edge;          // the reference edge
  int ends[2];       // the vertices of the reference edge
  int facing;        // the incident edge
  bool empty;
};

/// Every number is made the same way from either end, so that a mirrored scene gives mirrored bits.
template <int kIncident>
inline Clip clip(const Core& reference, int edge, const Core& incident) {
  Clip c;
  c.edge = edge;
  c.ends[0] = edge;
  c.ends[1] = reference.next(edge);
  c.normal = reference.normal(edge);
  c.tangent = {-c.normal.y, c.normal.x};
  const Vec first = reference.vertex(edge), last = reference.vertex(c.ends[1]);
  c.offset = 0.5f * (dot(c.normal, first) + dot(c.normal, last));
  const float t0 = dot(c.tangent, first), t1 = dot(c.tangent, last);

  c.facing = facing_edge<kIncident>(incident, c.normal);
  int low = incident.next(c.facing), high = c.facing;
  float s0 = dot(c.tangent, incident.vertex(low)), s1 = dot(c.tangent, incident.vertex(high));
  if (s0 > s1) {
    std::swap(s0, s1);
    std::swap(low, high);
  }
  const float h0 = dot(c.normal, incident.vertex(low)) - c.offset;
  const float h1 = dot(c.normal, incident.vertex(high)) - c.offset;
  c.vertex[0] = low;
  c.vertex[1] = high;
  c.empty = s1 < t0 || s0 > t1;
  const float span = s1 - s0;
  const float slope = span > 0 ? (h1 - h0) / span : 0.0f;
  c.t[0] = s0 < t0 ? t0 : s0;
  c.t[1] = s1 > t1 ? t1 : s1;
  c.h[0] = h0 + slope * (c.t[0] - s0);
  c.h[1] = h1 - slope * (s1 - c.t[1]);
  return c;
}

/// The working data of collide(). Points and normals are in the frame of the test.
struct Pair {
  Core a, b;
  Rotor frame;  // the rotation of A: from the frame of the test to the world
  Vec d;        // from the centre of A to that of B, world axes
  float margin;
  float size;   // the smaller reach
  float noise;  // rounding of lengths, m
};

inline void add_point(const Pair& p, Vec at, float gap, int feature, Manifold& m) {
  const Vec b = rotate(p.frame, at);
  m.point[m.count++] = {b.x + p.d.x, b.y + p.d.y, b.x, b.y, gap, static_cast<std::uint16_t>(feature)};
}

/// `normal` goes from A to B.
inline void set_normal(const Pair& p, Vec normal, Manifold& m) {
  const Vec world = rotate(p.frame, normal);
  m.nx = world.x;
  m.ny = world.y;
}

/// Features: 0, an edge of A and a vertex of B; 1, an edge of B and a vertex of A; 2, vertices of A
/// and B. The vertex is the end of the incident edge, even where a corner of the reference edge is nearer:
/// otherwise boxes of the same width on each other would change names all the time.
inline int feature_of(int kind, int first, int second) { return kind << 6 | first << 3 | second; }

inline void face_points(const Pair& p, const Clip& c, bool of_b, Manifold& m) {
  const float radius = p.a.radius + p.b.radius;
  const float ahead = of_b ? p.b.radius - p.a.radius : p.a.radius - p.b.radius;
  const Vec n = of_b ? -c.normal : c.normal;
  set_normal(p, n, m);
  // Nearly parallel edges have the same names, whichever of them is the reference.
  const bool renamed = of_b && dot(n, p.a.normal(c.facing)) > 0.95f;
  const auto add = [&](int end) {
    const float gap = c.h[end] - radius;
    if (!(gap <= p.margin)) return;
    int feature = feature_of(of_b ? 1 : 0, c.edge, c.vertex[end]);
    if (renamed) feature = feature_of(0, c.facing, c.ends[end]);
    const float height = c.offset + 0.5f * (c.h[end] + ahead);
    add_point(p, height * c.normal + c.t[end] * c.tangent, gap, feature, m);
  };
  if (!(c.t[1] - c.t[0] > kPreference * p.size)) {
    add(c.h[1] < c.h[0] ? 1 : 0);
  } else {  // the order is the same, whichever edge is the reference
    add(of_b ? 1 : 0);
    add(of_b ? 0 : 1);
  }
}

/// Makes one point, midway between the surfaces, from a point of the core of B. `normal` goes from A to B.
inline void one_point(const Pair& p, Vec normal, Vec on_b, float gap, int feature, Manifold& m) {
  if (!(gap <= p.margin)) return;
  set_normal(p, normal, m);
  add_point(p, on_b - (p.b.radius + 0.5f * gap) * normal, gap, feature, m);
}

/// Finds the nearest two ends of an edge of A and one of B. Fails if the cores come nearer elsewhere.
inline bool vertex_point(const Pair& p, Vec normal, const int ends_a[2], const int ends_b[2], Manifold& m) {
  float least = kFar;
  int va = ends_a[0], vb = ends_b[0];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Vec way = p.b.vertex(ends_b[j]) - p.a.vertex(ends_a[i]);
      if (!(dot(way, way) < least)) continue;
      least = dot(way, way);
      va = ends_a[i];
      vb = ends_b[j];
    }
  }
  const float distance = std::sqrt(least);
  const Vec from = p.a.vertex(va), to = p.b.vertex(vb);
  if (distance > kNoise * p.size) {
    const Vec way = to - from;
    normal = {way.x / distance, way.y / distance};
    // The line between two points is the shortest if each is the farthest of its core along the line.
    float front = dot(normal, from), rear = dot(normal, to);
    for (int k = 0; k < p.a.count; ++k) {
      const float along = dot(normal, p.a.vertex(k));
      front = along > front ? along : front;
    }
    for (int k = 0; k < p.b.count; ++k) {
      const float along = dot(normal, p.b.vertex(k));
      rear = along < rear ? along : rear;
    }
    if (rear - front < distance - p.noise) return false;
  }
  one_point(p, normal, to, distance - (p.a.radius + p.b.radius), feature_of(2, va, vb), m);
  return true;
}

/// Tests every vertex against every edge: for outlines that are so nearly straight at a corner, or so thin, that floats
/// mistake one edge for the next.
inline void search_point(const Pair& p, Vec normal, Manifold& m) {
  float least = kFar;
  Vec on_b{}, step{};
  int feature = 0;
  for (int kind = 0; kind < 2; ++kind) {
    const Core& edges = kind == 0 ? p.a : p.b;
    const Core& vertices = kind == 0 ? p.b : p.a;
    for (int k = 0; k < edges.count; ++k) {
      const Vec start = edges.vertex(k), end = edges.vertex(edges.next(k));
      const Vec edge = end - start;
      const float square = dot(edge, edge);
      for (int j = 0; j < vertices.count; ++j) {
        const Vec v = vertices.vertex(j);
        const float share = dot(v - start, edge) / (square > 0 ? square : 1);
        const Vec foot = start + std::fmin(std::fmax(share, 0.0f), 1.0f) * edge;
        const Vec gap = v - foot;
        if (!(dot(gap, gap) < least)) continue;
        least = dot(gap, gap);
        step = kind == 0 ? gap : -gap;
        on_b = kind == 0 ? v : foot;
        feature = feature_of(kind, k, j);
      }
    }
  }
  const float distance = std::sqrt(least);
  if (distance > kNoise * p.size) normal = {step.x / distance, step.y / distance};
  one_point(p, normal, on_b, distance - (p.a.radius + p.b.radius), feature, m);
}

/// The deepest vertex below the reference edge.
inline void deepest_point(const Pair& p, const Clip& c, bool of_b, Manifold& m) {
  const Core& core = of_b ? p.a : p.b;
  int deepest = 0;
  float least = kFar;
  for (int k = 0; k < core.count; ++k) {
    const float along = dot(c.normal, core.vertex(k));
    if (!(along < least)) continue;
    least = along;
    deepest = k;
  }
  const float depth = least - c.offset;
  Vec on_b = core.vertex(deepest);
  if (of_b) on_b = on_b - depth * c.normal;
  one_point(p, of_b ? -c.normal : c.normal, on_b, depth - (p.a.radius + p.b.radius),
            feature_of(of_b ? 1 : 0, c.edge, deepest), m);
}

template <int kA, int kB>
inline Manifold collide_cores(const Hull& a, Rotor qa, const Hull& b, Rotor qb, Vec d, float margin, float preference) {
  const int na = kA ? kA : a.count, nb = kB ? kB : b.count;
  Pair p;
  p.frame = qa;
  p.d = d;
  p.margin = margin;
  p.size = a.reach < b.reach ? a.reach : b.reach;
  p.noise = kNoise * (a.reach + b.reach);
  p.a.count = na;
  p.b.count = nb;
  p.a.radius = a.radius;
  p.b.radius = b.radius;
  const Vec back = unrotate(qa, d);
  for (int k = 0; k < na; ++k) {
    p.a.x[k] = a.x[k] - back.x;
    p.a.y[k] = a.y[k] - back.y;
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

  Manifold m;
  const float reach = a.radius + b.radius + margin;
  const Axis of_a = best_axis<kA, kB>(p.a, p.b);
  if (of_a.separation > reach) return m;
  const Axis of_b = best_axis<kB, kA>(p.b, p.a);
  if (of_b.separation > reach) return m;

  // The distance of the cores is at least `most`. If a point of an edge and one over it are no farther apart, they are
  // the nearest points; otherwise two vertices are.
  const float most = of_a.separation > of_b.separation ? of_a.separation : of_b.separation;
  const auto nearest_is_on = [&](const Clip& c) {
    const float least = c.h[0] < c.h[1] ? c.h[0] : c.h[1];
    return !c.empty && least <= most + p.noise && (most <= p.noise || least >= most - p.noise);
  };
  bool use_b = of_b.separation > of_a.separation + preference * p.size;
  Clip c = use_b ? clip<kA>(p.b, of_b.edge, p.a) : clip<kB>(p.a, of_a.edge, p.b);
  if (!use_b && of_b.separation > of_a.separation && !nearest_is_on(c)) {
    use_b = true;
    c = clip<kA>(p.b, of_b.edge, p.a);
  }
  if (nearest_is_on(c)) {
    face_points(p, c, use_b, m);
  } else if (most < -p.noise) {
    deepest_point(p, c, use_b, m);
  } else {
    const Vec normal = use_b ? -c.normal : c.normal;
    if (!vertex_point(p, normal, use_b ? c.vertex : c.ends, use_b ? c.ends : c.vertex, m)) {
      search_point(p, normal, m);
    }
  }
  return m;
}

/// A disc, which is one vertex, against a hull. `d` leads from the centre of the hull to that of the disc.
inline Manifold collide_vertex(const Hull& hull, Rotor qh, const Hull& disc, Rotor qd, Vec d, float margin) {
  const Vec arm = rotate(qd, {disc.x[0], disc.y[0]});  // from the centre of the disc to its vertex
  const Vec v = unrotate(qh, {d.x + arm.x, d.y + arm.y});
  const float radius = hull.radius + disc.radius;
  Vec n{1, 0};
  float distance = -kFar;
  int edge = 0;
  for (int k = 0; hull.count > 1 && k < hull.count; ++k) {
    const float separation = hull.nx[k] * (v.x - hull.x[k]) + hull.ny[k] * (v.y - hull.y[k]);
    if (!(separation > distance)) continue;
    distance = separation;
    edge = k;
  }
  Manifold m;
  if (distance > radius + margin) return m;
  int feature = feature_of(0, edge, 0);
  int corner = hull.count == 1 ? 0 : -1;
  if (hull.count > 1) {
    const int next = edge + 1 < hull.count ? edge + 1 : 0;
    n = {hull.nx[edge], hull.ny[edge]};
    // Both ends are used alike, so that a mirrored hull gives mirrored bits.
    distance = 0.5f * (distance + dot(n, {v.x - hull.x[next], v.y - hull.y[next]}));
    if (distance > 0 || hull.count == 2) {
      if (n.x * (v.y - hull.y[edge]) < n.y * (v.x - hull.x[edge])) corner = edge;
      if (n.x * (v.y - hull.y[next]) > n.y * (v.x - hull.x[next])) corner = next;
    }
  }
  if (corner >= 0) {
    const float x = v.x - hull.x[corner], y = v.y - hull.y[corner];
    distance = std::sqrt(x * x + y * y);
    if (distance > kNoise * disc.reach) n = {x / distance, y / distance};
    feature = feature_of(2, corner, 0);
  }
  const float gap = distance - radius;
  if (!(gap <= margin)) return m;
  n = rotate(qh, n);
  const float back = disc.radius + 0.5f * gap;
  const Vec at{arm.x - n.x * back, arm.y - n.y * back};  // from the centre of the disc
  m.nx = n.x;
  m.ny = n.y;
  m.count = 1;
  m.point[0] = {at.x + d.x, at.y + d.y, at.x, at.y, gap, static_cast<std::uint16_t>(feature)};
  return m;
}

inline Manifold collide_any(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin,
                            float preference) {
  const float reach = a.reach + b.reach + margin;
  if (dx * dx + dy * dy > reach * reach) return {};
  if (b.count == 1) return collide_vertex(a, qa, b, qb, {dx, dy}, margin);
  if (a.count == 1) {
    Manifold m = collide_vertex(b, qb, a, qa, {-dx, -dy}, margin);
    ManifoldPoint& p = m.point[0];
    if (m.count > 0) {
      m.nx = -m.nx;
      m.ny = -m.ny;
      p = {p.bx, p.by, p.ax, p.ay, p.gap, static_cast<std::uint16_t>(p.feature | feature_of(1, 0, 0))};
    }
    return m;
  }
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
  return collide_any(a, qa, b, qb, dx, dy, margin, kPreference);
}

Nearest nearest(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy) {
  const Manifold m = collide_any(a, qa, b, qb, dx, dy, std::numeric_limits<float>::infinity(), 0);
  const ManifoldPoint& p = m.count > 1 && m.point[1].gap < m.point[0].gap ? m.point[1] : m.point[0];
  return {p.gap, m.nx, m.ny, p.ax - 0.5f * p.gap * m.nx, p.ay - 0.5f * p.gap * m.ny};
}

}  // namespace psim
