// In: the shapes of descriptions. Out: hulls and mass properties. This runs when a body is added.
#include "bodies/hull.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>
#include <variant>

#include "base/elementary.h"
#include "base/range_text.h"
#include "base/rotor.h"

namespace psim {
namespace {

constexpr double kSame = 1e-6;  // two points nearer than this share of the size are one

using Points = std::vector<Vec2>;

/// Angle between two unit vectors, 0..pi. tan(angle/4) by square roots, halved three times more;
/// then the series of the arctangent.
double angle_between(Vec2 a, Vec2 b) {
  const double sine = 0.5 * length_of(a - b), cosine = 0.5 * length_of(a + b);  // both of half the angle
  double t = sine / (1 + cosine);
  for (int k = 0; k < 3; ++k) t /= 1 + std::sqrt(1 + t * t);
  const double z = t * t;
  double series = 1.0 / 15;
  for (int n = 13; n > 0; n -= 2) series = 1.0 / n - z * series;
  return 32 * t * series;
}

/// Sums of a plane figure: area, first moments and polar moment about the origin.
struct Sums {
  double area = 0;
  Vec2 first;
  double polar = 0;

  void add(double figure, Vec2 centre, double polar_about_centre) {
    area += figure;
    first = first + figure * centre;
    polar += polar_about_centre + figure * dot(centre, centre);
  }
};

/// A convex polygon (two points: a line) with `radius` around it: the polygon, a rectangle on each
/// edge and a sector at each corner. Steiner: area = A + L r + pi r^2.
Sums rounded_sums(const Points& p, double radius) {
  Sums sums;
  const std::size_t n = p.size();
  for (std::size_t k = 1; k + 1 < n; ++k) {  // triangles from vertex 0
    const Vec2 u = p[k] - p[0], v = p[k + 1] - p[0];
    const double area = 0.5 * cross(u, v);
    const Vec2 centre = p[0] + 1.0 / 3 * (u + v);
    sums.add(area, centre, area * (dot(u, u) + dot(v, v) - dot(u, v)) / 18);
  }
  if (!(radius > 0)) return sums;
  const auto normal = [&](std::size_t k) -> Vec2 {
    const Vec2 e = p[(k + 1) % n] - p[k];
    return 1 / length_of(e) * Vec2{e.y, -e.x};
  };
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 in = normal((k + n - 1) % n), out = normal(k);
    const Vec2 next = p[(k + 1) % n];
    const double edge = length_of(next - p[k]);
    sums.add(edge * radius, 0.5 * (p[k] + next) + 0.5 * radius * out,
             edge * radius * (edge * edge + radius * radius) / 12);
    // The sector's integrals over rho from 0 to r and over its directions u, about the vertex:
    // of rho: area, of rho^2 u: first moment, of rho^3: polar moment.
    const double angle = angle_between(in, out), r2 = radius * radius;
    const double area = 0.5 * angle * r2;
    const Vec2 first = r2 * radius / 3 * Vec2{out.y - in.y, in.x - out.x};
    sums.area += area;
    sums.first = sums.first + area * p[k] + first;
    sums.polar += area * dot(p[k], p[k]) + 2 * dot(p[k], first) + 0.25 * angle * r2 * r2;
  }
  return sums;
}

/// Turns sums about `base` into mass properties.
MassProperties properties_of(const Sums& sums, Vec2 base) {
  const Vec2 offset = 1 / sums.area * sums.first;
  return {sums.area, base + offset, sums.polar / sums.area - dot(offset, offset)};
}

std::string vertex_name(std::ptrdiff_t k) { return "vertex " + std::to_string(k); }

bool fail(std::string& error, std::string text) {
  error = std::move(text);
  return false;
}

bool in_range(std::string_view name, double value, Range range, std::string& error) {
  error = RangeCheck()(name, value, range).error;
  return error.empty();
}

bool check_points(const Points& points, std::string& error) {
  RangeCheck check;
  for (std::size_t k = 0; k < points.size() && check.error.empty(); ++k) {
    if (!limits::kCoordinate.contains(points[k])) check("vertex " + std::to_string(k), points[k], limits::kCoordinate);
  }
  return check.error.empty() || fail(error, check.error);
}

bool check_rounding(double radius, std::string& error) {
  return radius == 0 || in_range("radius, where it is not 0,", radius, limits::kRadius, error);
}

/// The larger side of the box around the points.
double extent_of(const Points& points) {
  const auto [left, right] = std::ranges::minmax(points, {}, &Vec2::x);
  const auto [bottom, top] = std::ranges::minmax(points, {}, &Vec2::y);
  return greater(right.x - left.x, top.y - bottom.y);
}

/// Leaves out vertices that repeat the one before them or lie on the line of their neighbours.
void drop_needless(Points& p, double size) {
  for (std::size_t k = 0; k < p.size() && p.size() > 2;) {
    const std::size_t n = p.size();
    const Vec2 before = p[(k + n - 1) % n], here = p[k], after = p[(k + 1) % n];
    const Vec2 u = here - before, v = after - here, w = after - before;
    const bool repeated = length_of(u) <= kSame * size;
    const bool straight = dot(u, v) > 0 && std::fabs(cross(u, w)) <= kSame * size * length_of(w);
    if (repeated || straight) {
      p.erase(p.begin() + static_cast<std::ptrdiff_t>(k));
      k = 0;  // its neighbours may have become superfluous
    } else {
      ++k;
    }
  }
}

/// Makes the vertices of a polygon counter-clockwise and strictly convex.
bool tidy_polygon(const Points& given, Points& p, std::string& error) {
  if (given.size() < 3 || given.size() > kMostPolygonVertices) {
    return fail(error, "a polygon has 3 to 8 vertices, this one has " + std::to_string(given.size()));
  }
  if (!check_points(given, error)) return false;
  const double size = extent_of(given);
  if (!in_range("a polygon's extent", size, limits::kExtent, error)) return false;
  p = given;
  drop_needless(p, size);
  const double area = rounded_sums(p, 0).area;
  if (area < 0) std::reverse(p.begin(), p.end());
  // All vertices to the left of every edge, those at its ends aside: convex and not self-crossing.
  // First each edge's next vertex, so that a dent is what the message names.
  const std::size_t n = p.size();
  for (std::size_t ahead = 2; ahead < n; ++ahead) {
    for (std::size_t k = 0; k < n; ++k) {
      const Vec2 next = p[(k + 1) % n], other = p[(k + ahead) % n], corner = ahead == 2 ? next : other;
      if (cross(next - p[k], other - p[k]) > 0) continue;
      const auto is_corner = [&](Vec2 v) { return v.x == corner.x && v.y == corner.y; };
      const auto number = std::find_if(given.begin(), given.end(), is_corner) - given.begin();
      return fail(error, "a polygon must be convex and not cross itself; it is not at " + vertex_name(number));
    }
  }
  if (n < 3 || !(std::fabs(area) > kSame * size * size)) {
    return fail(error, "a polygon must have an area (above 1e-6 of its extent squared)");
  }
  return true;
}

/// Whether a figure turns left at each of its `n` vertices, or is a line whose ends differ.
template <class Vertex>
bool is_sound(int n, const Vertex& vertex) {
  for (int k = 0; n > 2 && k < n; ++k) {
    const Vec2 from = vertex(k), edge = vertex((k + 1) % n) - from;
    for (int other = k + 2; other < k + n; ++other) {  // the vertices that are no ends of edge k
      if (!(cross(edge, vertex(other % n) - from) > 0)) return false;
    }
  }
  return n != 2 || vertex(0) != vertex(1);
}

/// Makes the hull of these vertices about `origin`. Fails if floats cannot tell its vertices apart.
bool make_hull(const Points& points, Vec2 origin, double radius, Hull& hull) {
  hull = {};
  hull.radius = static_cast<float>(radius);
  for (const Vec2 p : points) hull.set_vertex(hull.count++, p - origin);
  finish_hull(hull);
  return is_sound(hull.count, [&](int k) { return hull.vertex(k); });
}

constexpr const char* kTooFar = "a shape this small is too far from the body's place for floats";

/// A shape as convex figures, each with a radius around it, in one frame; and its mass.
struct Figures {
  struct Convex {
    Points points;
    double radius = 0;  // m
    bool of_chain = false;
    std::uint32_t part = 0;
  };
  std::vector<Convex> list;
  MassProperties mass;

  void add(Points points, double radius, bool of_chain = false) {
    list.push_back({std::move(points), radius, of_chain});
  }
};

/// Finds the figures of a shape. `density`: kg/m^2, of parts that have none of their own.
struct Maker {
  double density;
  Figures& out;
  std::string& error;

  /// Adds one convex figure.
  bool one(Points points, double radius, const MassProperties& mass) {
    out.mass = mass;
    out.add(std::move(points), radius);
    return true;
  }

  bool disc(Vec2 centre, double radius) {
    return one({centre}, radius, {std::numbers::pi * radius * radius, centre, 0.5 * radius * radius});
  }

  bool operator()(const DiscShape& s) {
    return in_range("radius", s.radius, limits::kRadius, error) && disc({}, s.radius);
  }

  bool operator()(const SegmentShape& s) {
    const Points ends{s.p1, s.p2};
    if (!is_line(ends, error)) return false;
    const double span = length_of(s.p2 - s.p1);
    return one(ends, 0, {span, 0.5 * (s.p1 + s.p2), span * span / 12});
  }

  bool operator()(const ChainShape& s) {
    if (s.vertices.size() < (s.loop ? 3 : 2)) {
      return fail(error, s.loop ? "a closed chain has 3 vertices or more" : "a chain has 2 vertices or more");
    }
    if (!is_line(s.vertices, error)) return false;
    const double size = extent_of(s.vertices);
    Points p;  // without repeated vertices, which would be segments of no length
    for (const Vec2 v : s.vertices) {
      if (p.empty() || length_of(v - p.back()) > kSame * kSame * size) p.push_back(v);
    }
    if (s.loop) p.push_back(p[0]);
    Sums sums;
    for (std::size_t k = 0; k + 1 < p.size(); ++k) {
      const double span = length_of(p[k + 1] - p[k]);
      sums.add(span, 0.5 * (p[k] + p[k + 1]) - p[0], span * span * span / 12);
      out.add({p[k], p[k + 1]}, 0, true);
    }
    out.mass = properties_of(sums, p[0]);
    return true;
  }

  bool operator()(const BoxShape& s) {
    if (!in_range("width", s.width, limits::kRadius, error) || !in_range("height", s.height, limits::kRadius, error))
      return false;
    if (!check_rounding(s.radius, error)) return false;
    const double x = 0.5 * s.width, y = 0.5 * s.height;
    const Points corners{{-x, -y}, {x, -y}, {x, y}, {-x, y}};
    const Sums sums = rounded_sums(corners, s.radius);
    return one(corners, s.radius, {sums.area, {}, sums.polar / sums.area});
  }

  bool operator()(const PolygonShape& s) {
    Points corners;
    if (!tidy_polygon(s.vertices, corners, error) || !check_rounding(s.radius, error)) return false;
    Points moved;  // about the first vertex: squares of large coordinates would drown small sizes
    for (const Vec2 v : corners) moved.push_back(v - corners[0]);
    return one(corners, s.radius, properties_of(rounded_sums(moved, s.radius), corners[0]));
  }

  bool operator()(const CapsuleShape& s) {
    const Points ends{s.p1, s.p2};
    if (!check_points(ends, error) || !in_range("radius", s.radius, limits::kRadius, error)) return false;
    const Vec2 middle = 0.5 * (s.p1 + s.p2);
    if (length_of(s.p2 - s.p1) <= kSame * s.radius) return disc(middle, s.radius);
    const Sums sums = rounded_sums({s.p1 - middle, s.p2 - middle}, s.radius);
    return one(ends, s.radius, {sums.area, middle, sums.polar / sums.area});
  }

  bool operator()(const CompoundShape& s) {
    if (s.parts.empty()) return fail(error, "a compound has 1 part or more");
    Sums sums;
    Vec2 base;
    for (std::size_t k = 0; k < s.parts.size(); ++k) {
      MassProperties mass;
      if (!part(s.parts[k], static_cast<std::uint32_t>(k), mass))
        return fail(error, "part " + std::to_string(k) + ": " + error);
      if (s.parts.size() == 1) {
        out.mass = mass;
        return true;
      }
      if (k == 0) base = mass.centre;
      sums.add(mass.area, mass.centre - base, mass.area * mass.inertia);
    }
    out.mass = properties_of(sums, base);
    return true;
  }

 private:
  // Adds the figures of a part where they stand in the body. An area counts as often as the part is denser.
  bool part(const ShapePart& part, std::uint32_t number, MassProperties& mass) {
    error = check(part);
    Figures own;
    if (!error.empty() || !std::visit(Maker{density, own, error}, part.shape)) return false;
    const SineCosine turn = sine_cosine(part.angle);
    const auto place = [&](Vec2 v) { return part.position + turned(turn, v); };
    for (Figures::Convex& figure : own.list) {
      for (Vec2& v : figure.points) v = place(v);
      if (!check_points(figure.points, error)) return false;
      figure.part = number;
      out.list.push_back(std::move(figure));
    }
    mass = {own.mass.area * part.density.value_or(density) / density, place(own.mass.centre), own.mass.inertia};
    return true;
  }

  static std::string check(const ShapePart& part) {
    RangeCheck check;
    check("position", part.position, limits::kCoordinate)("angle", part.angle, limits::kAngle);
    check("density", part.density.value_or(limits::kDensity.min), limits::kDensity);
    check("restitution", part.restitution.value_or(0), limits::kRestitution);
    check("friction", part.friction.value_or(0), limits::kFriction);
    check("tangent speed", part.tangent_speed.value_or(0), limits::kTangentSpeed);
    check("rolling resistance", part.rolling_resistance.value_or(0), limits::kRollingResistance);
    const Vec2 way = part.one_way.value_or(Vec2{});
    check("one way", way, limits::kCoordinate);
    if (way.x != 0 || way.y != 0) check("the length of one way", length_of(way), limits::kAxis);
    const auto* chain = std::get_if<ChainShape>(&part.shape);
    const bool own = check.error.empty() && chain != nullptr && !chain->materials.empty();
    return own ? "a chain that is a part has no materials of its own" : check.error;
  }
};

/// m: half the least width of a hull.
float half_width(const Hull& hull) {
  double least = hull.count > 2 ? std::numeric_limits<double>::infinity() : 0;
  for (int k = 0; hull.count > 2 && k < hull.count; ++k) {
    double width = 0;
    for (int v = 0; v < hull.count; ++v) {
      width = greater(dot({hull.nx[k], hull.ny[k]}, hull.vertex(k) - hull.vertex(v)), width);
    }
    least = lesser(width, least);
  }
  return static_cast<float>(0.5 * least) + hull.radius;
}

/// A part of a body need not lie about its centre.
void set_apart(Hull& hull) {
  hull.inner = half_width(hull);
  Vec2 sum;
  for (int k = 0; k < hull.count; ++k) sum = sum + hull.vertex(k);
  hull.middle_x = static_cast<float>(sum.x / hull.count);
  hull.middle_y = static_cast<float>(sum.y / hull.count);
}

bool make_hulls_of(const Figures& figures, bool compound, Vec2 origin, HullSet& out) {
  for (const Figures::Convex& figure : figures.list) {
    Hull hull;
    if (make_hull(figure.points, origin, figure.radius, hull)) {
      if (figures.list.size() > 1) set_apart(hull);
      out.parts.push_back(hull);
      if (compound) out.part.push_back(figure.part);
    } else if (!figure.of_chain) {
      return false;
    }
  }
  return !out.parts.empty();
}

}  // namespace

bool make_hulls(const Shape& shape, bool about_centre, HullSet& out, std::string& error, double density) {
  out = {};
  error.clear();
  Figures figures;
  if (!std::visit(Maker{density, figures, error}, shape)) return false;
  out.mass = figures.mass;
  const bool compound = std::holds_alternative<CompoundShape>(shape);
  if (make_hulls_of(figures, compound, about_centre ? out.mass.centre : Vec2{}, out)) return true;
  out = {};
  return fail(error, kTooFar);
}

bool make_outlines(const Shape& shape, std::vector<ConvexOutline>& out, std::string& error) {
  out.clear();
  error.clear();
  Figures figures;
  if (!std::visit(Maker{1, figures, error}, shape)) return false;
  for (const Figures::Convex& figure : figures.list) {
    ConvexOutline& outline = out.emplace_back();
    outline.radius = figure.radius;
    for (const Vec2 v : figure.points) outline.v[outline.count++] = v;
    if (is_sound(outline.count, [&](int k) { return outline.v[k]; })) continue;
    out.clear();
    return fail(error, "a shape this small is too far from its origin");
  }
  return true;
}

bool is_line(const std::vector<Vec2>& points, std::string& error) {
  return check_points(points, error) && in_range("the extent of a line", extent_of(points), limits::kExtent, error);
}

void finish_hull(Hull& hull) {
  double reach = 0, inner = 0;
  for (int k = 0; k < hull.count; ++k) {
    const Vec2 v = hull.vertex(k);
    reach = greater(length_of(v), reach);
    if (hull.count == 1) break;
    const Vec2 e = hull.vertex(hull.next(k)) - v;
    const double edge = length_of(e);
    const Vec2 normal = edge > 0 ? Vec2{e.y / edge, -e.x / edge} : Vec2{1, 0};
    hull.nx[k] = static_cast<float>(normal.x);
    hull.ny[k] = static_cast<float>(normal.y);
    inner = k == 0 ? dot(normal, v) : lesser(inner, dot(normal, v));
  }
  // Rounds to floats: the reach upwards, the inner radius downwards.
  reach += hull.radius;
  inner = greater(inner, 0.0) + hull.radius;
  hull.reach = static_cast<float>(reach);
  if (hull.reach < reach) hull.reach *= 1 + 0x1p-23f;
  hull.inner = static_cast<float>(inner);
  if (hull.inner > inner) hull.inner *= 1 - 0x1p-24f;
}

}  // namespace psim
