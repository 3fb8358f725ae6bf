#include "geometry/convex.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/elementary.h"

namespace psim {
namespace {

// A core with one or two vertices has one edge; another has as many edges as vertices.
template <class O>
int edges(const O& o) {
  return o.count > 2 ? o.count : 1;
}
template <class O>
Vec2 end_of(const O& o, int k) {
  return o.v[k + 1 < o.count ? k + 1 : 0];
}

// The point of the edge from p to q that is nearest to `from`, relative to `from`.
Vec2 to_edge(Vec2 p, Vec2 q, Vec2 from) {
  const Vec2 way = q - p;
  const double square = dot(way, way);
  const double share = square > 0 ? dot(from - p, way) / square : 0;
  return p + std::clamp(share, 0.0, 1.0) * way - from;
}

// Whether a point lies inside the polygon and not on its rim. A core of one or two vertices has no inside.
template <class O>
bool holds(const O& o, Vec2 point) {
  if (o.count < 3) return false;
  for (int k = 0; k < o.count; ++k) {
    if (!(cross(end_of(o, k) - o.v[k], point - o.v[k]) > 0)) return false;
  }
  return true;
}

// From the origin to the nearest point of the core; nothing if the origin lies inside.
template <class O>
std::optional<Vec2> to_core(const O& o) {
  if (holds(o, {})) return {};
  Vec2 best = to_edge(o.v[0], end_of(o, 0), {});
  for (int k = 1; k < edges(o); ++k) {
    const Vec2 to = to_edge(o.v[k], end_of(o, k), {});
    if (dot(to, to) < dot(best, best)) best = to;
  }
  return best;
}

// m: no vertex has a larger sum of coordinates.
double size_of(const Outline& o) {
  double size = 0;
  for (int k = 0; k < o.count; ++k) size = greater(std::fabs(o.v[k].x) + std::fabs(o.v[k].y), size);
  return size;
}

// Of the points of a core that lie farthest along n, to `same` metres: how far, and from where to where along t.
struct Foot {
  double height = -1e300, from = 0, to = 0;  // m
};
Foot foot_of(const Outline& o, Vec2 n, Vec2 t, double same) {
  Foot foot;
  for (int k = 0; k < o.count; ++k) foot.height = greater(dot(n, o.v[k]), foot.height);
  bool first = true;
  for (int k = 0; k < o.count; ++k) {
    if (dot(n, o.v[k]) < foot.height - same) continue;
    const double at = dot(t, o.v[k]);
    foot.from = first ? at : lesser(at, foot.from);
    foot.to = first ? at : greater(at, foot.to);
    first = false;
  }
  return foot;
}

// Whether two feet do not face each other, by more than rounding makes of it.
bool lies_apart(const Foot& a, const Foot& b) {
  const double from = greater(a.from, b.from), to = lesser(a.to, b.to);
  return from > to + 1e-9 * (1 + std::fabs(from) + std::fabs(to));
}

bool cross_over(Vec2 p, Vec2 q, Vec2 r, Vec2 s) {
  const auto sides = [](Vec2 from, Vec2 to, Vec2 a, Vec2 b) {
    return cross(to - from, a - from) * cross(to - from, b - from) <= 0;
  };
  return cross(q - p, s - r) != 0 && sides(p, q, r, s) && sides(r, s, p, q);
}

// Where a ray from the origin enters an outline or a difference.
template <class O>
RayEntry enter_convex(const O& o, Vec2 u, double length) {
  if (o.count == 1) return enter(o.v[0], o.radius, u, length);
  const std::optional<Vec2> core = to_core(o);
  if (!core || dot(*core, *core) < o.radius * o.radius) return {0, {}};
  RayEntry best;
  const auto take = [&](double at, Vec2 normal) {
    if (best.at < 0 || at < best.at) best = {at, normal};
  };
  for (int k = 0; k < o.count; ++k) {  // a line has two sides
    const Vec2 p = o.v[k], edge = end_of(o, k) - p;
    const double span = std::sqrt(dot(edge, edge));
    if (!(span > 0)) continue;
    const Vec2 normal{edge.y / span, -edge.x / span};
    // The ray comes in through the edge, which is moved out by the radius.
    const double height = -dot(normal, p) - o.radius, fall = -dot(normal, u);
    if (!(fall > 0) || height < 0 || height > fall * length) continue;
    const double at = height / fall;
    const double along = dot(at * u - p, edge) / span;
    const double seam = 1e-12 * span;  // so that no ray slips through where two edges meet
    if (along >= -seam && along <= span + seam) take(at, normal);
  }
  if (!(o.radius > 0)) return best;
  for (int k = 0; k < o.count; ++k) {
    const RayEntry corner = enter(o.v[k], o.radius, u, length);
    if (corner.at >= 0) take(corner.at, corner.normal);
  }
  return best;
}

}  // namespace

Box box_of(const Outline& o) {
  Box box{o.v[0], o.v[0]};
  for (int k = 1; k < o.count; ++k) {
    box.low = {lesser(o.v[k].x, box.low.x), lesser(o.v[k].y, box.low.y)};
    box.high = {greater(o.v[k].x, box.high.x), greater(o.v[k].y, box.high.y)};
  }
  return box;
}

void Grown::add(Vec2 at, double radius) {
  box.xmin = lesser(box.xmin, at.x - radius), box.ymin = lesser(box.ymin, at.y - radius);
  box.xmax = greater(box.xmax, at.x + radius), box.ymax = greater(box.ymax, at.y + radius);
}

void Grown::add(const Outline& outline) {
  for (std::int32_t k = 0; k < outline.count; ++k) add(outline.v[k], outline.radius);
}

Outline outline_of(const Hull& hull, SineCosine turn, Vec2 at) {
  Outline out;
  out.count = hull.count;
  out.radius = static_cast<double>(hull.radius);
  for (int k = 0; k < hull.count; ++k) out.v[k] = at + turned(turn, hull.vertex(k));
  return out;
}

Outline outline_of(const Outline& outline, SineCosine turn, Vec2 at) {
  Outline out = outline;
  for (int k = 0; k < out.count; ++k) out.v[k] = at + turned(turn, out.v[k]);
  return out;
}

RayEntry enter(Vec2 centre, double radius, Vec2 u, double length) {
  if (dot(centre, centre) < radius * radius) return {0, {}};
  const double along = dot(centre, u), miss = cross(centre, u);
  const double half2 = radius * radius - miss * miss;  // half the chord, squared
  if (!(half2 >= 0) || !(along > 0)) return {};
  const double at = greater(along - std::sqrt(half2), 0.0);
  if (at > length) return {};
  return {at, radius > 0 ? 1 / radius * (at * u - centre) : Vec2{}};
}

RayEntry enter(const Outline& o, Vec2 u, double length) { return enter_convex(o, u, length); }
RayEntry enter(const Difference& d, Vec2 u, double length) { return enter_convex(d, u, length); }

NearPoint near_point(Vec2 centre, double radius) {
  const double far = std::sqrt(dot(centre, centre));
  if (!(far > radius)) return {};
  const double distance = far - radius;
  return {distance, distance / far * centre};
}

NearPoint near_point(const Outline& o) {
  const std::optional<Vec2> core = to_core(o);
  return core ? near_point(*core, o.radius) : NearPoint{};
}

// Both go round by the directions of their edges, from the lowest vertex on: the edges of the difference are theirs,
// sorted by direction.
Difference difference(const Outline& a, const Outline& b) {
  Outline c = a;
  for (int k = 0; k < c.count; ++k) c.v[k] = -1 * c.v[k];
  const auto lowest = [](const Outline& o) {
    int low = 0;
    for (int k = 1; k < o.count; ++k) {
      if (o.v[k].y < o.v[low].y || (o.v[k].y == o.v[low].y && o.v[k].x < o.v[low].x)) low = k;
    }
    return low;
  };
  const int first_b = lowest(b), first_c = lowest(c);
  const auto vertex = [](const Outline& o, int k) { return o.v[k % o.count]; };
  const int n = b.count > 1 ? b.count : 0, m = c.count > 1 ? c.count : 0;  // edges
  Difference d;
  d.radius = a.radius + b.radius;
  if (n + m == 0) d.v[d.count++] = b.v[0] + c.v[0];
  for (int i = 0, j = 0; i < n || j < m;) {
    const Vec2 p = vertex(b, first_b + i), q = vertex(c, first_c + j);
    d.v[d.count++] = p + q;
    const double turn =
        i == n ? -1.0 : (j == m ? 1.0 : cross(vertex(b, first_b + i + 1) - p, vertex(c, first_c + j + 1) - q));
    if (turn >= 0) ++i;
    if (turn <= 0) ++j;
  }
  return d;
}

Gap gap_between(const Outline& a, const Outline& b) {
  constexpr double kTouch = 1e-10;  // m: nearer cores have no direction from one to the other
  const Difference d = difference(a, b);
  const std::optional<Vec2> core = to_core(d);
  const double far = core ? length_of(*core) : 0;
  if (far > kTouch) return {far - d.radius, -1 / far * *core};
  Gap gap{-1e300, {0, 1}};
  for (int k = 0; k < d.count; ++k) {  // a line has two sides
    const Vec2 edge = end_of(d, k) - d.v[k];
    const double span = length_of(edge);
    if (!(span > 0)) continue;
    const Vec2 normal{edge.y / span, -edge.x / span};
    const double distance = -dot(normal, d.v[k]);
    if (distance > gap.distance) gap = {distance, normal};
  }
  if (gap.distance == -1e300) gap.distance = 0;  // two points in one place
  gap.distance -= d.radius;
  return gap;
}

Vec2 nearest_point(const Outline& a, const Outline& b, Vec2 normal) {
  const Vec2 along = upright(normal);
  const double size_a = size_of(a), size_b = size_of(b);
  Foot mine = foot_of(b, normal, along, 1e-9 * (1 + size_b));
  Foot other = foot_of(a, -1 * normal, along, 1e-9 * (1 + size_a));
  if (lies_apart(mine, other)) {
    // The normal of a gap of 1e-8 m is so rough that it may name the far ends of two sides that are parallel.
    const double rough = 1e-8 * (1 + size_a) * (1 + size_b);
    mine = foot_of(b, normal, along, rough), other = foot_of(a, -1 * normal, along, rough);
  }
  const double from = greater(mine.from, other.from), to = lesser(mine.to, other.to);
  // Where the two do not face each other: the end of b towards a.
  const double at = from <= to ? from / 2 + to / 2 : std::clamp(other.from, mine.from, mine.to);
  return at * along + (mine.height + b.radius) * normal;
}

bool overlap(const Outline& a, const Outline& b) {
  if (holds(a, b.v[0]) || holds(b, a.v[0])) return true;
  const double reach = a.radius + b.radius;
  const auto close = [&](Vec2 way) { return dot(way, way) <= reach * reach; };
  for (int i = 0; i < edges(a); ++i) {
    for (int j = 0; j < edges(b); ++j) {
      const Vec2 p = a.v[i], q = end_of(a, i), r = b.v[j], s = end_of(b, j);
      if (close(to_edge(p, q, r)) || close(to_edge(p, q, s)) || close(to_edge(r, s, p)) || close(to_edge(r, s, q)) ||
          cross_over(p, q, r, s)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace psim
