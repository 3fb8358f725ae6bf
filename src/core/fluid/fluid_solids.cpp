#include "fluid/fluid_solids.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

constexpr float kThinnest = 0.5f;  // cells: half the width of a line that holds pressure
constexpr float kRounding =
    1e-6f;  // of coordinates: the direction from a point to another one that is nearer says nothing

float length(Place2 a) { return std::sqrt(a.x * a.x + a.y * a.y); }

// The normal of the edge from vertex k to the next, not normalized: it points out of a polygon.
Place2 normal_of(const FluidSolid& s, std::int32_t k, std::int32_t next) {
  const auto a = static_cast<std::size_t>(k), b = static_cast<std::size_t>(next);
  return {s.y[b] - s.y[a], s.x[a] - s.x[b]};
}

// From the nearest point of an edge to a point.
Place2 way_from_edge(const FluidSolid& s, std::int32_t k, std::int32_t next, Place2 at) {
  const auto a = static_cast<std::size_t>(k), b = static_cast<std::size_t>(next);
  const float ex = s.x[b] - s.x[a], ey = s.y[b] - s.y[a], px = at.x - s.x[a], py = at.y - s.y[a];
  const float square = ex * ex + ey * ey;
  const float t = square > 0 ? std::clamp((px * ex + py * ey) / square, 0.0f, 1.0f) : 0.0f;
  return {px - t * ex, py - t * ey};
}

float width_of(const ConvexOutline& o) {
  if (o.count < 3) return 0;
  double least = 1e300;
  for (std::int32_t k = 0; k < o.count; ++k) {
    const Vec2 a = o.v[k], edge = o.v[k + 1 < o.count ? k + 1 : 0] - a;
    const double across = length_of(edge);
    double most = 0;
    for (std::int32_t j = 0; j < o.count; ++j) most = std::max(most, std::fabs(cross(edge, o.v[j] - a)) / across);
    least = std::min(least, most);
  }
  return static_cast<float>(least);
}

double area_of(const ConvexOutline& o) {
  double twice = 0, around = 0;
  for (std::int32_t k = 0; k < o.count && o.count > 1; ++k) {
    const Vec2 a = o.v[k], b = o.v[k + 1 < o.count ? k + 1 : 0];
    twice += cross(a - o.v[0], b - o.v[0]);
    around += length_of(b - a);
  }
  return twice / 2 + o.radius * (around + 3.14159265358979 * o.radius);
}

}  // namespace

FluidSolid fluid_solid(const ConvexOutline& outline, Vec2 centre, float cell) {
  FluidSolid s;
  s.count = outline.count;
  s.radius = static_cast<float>(outline.radius);
  for (std::int32_t k = 0; k < outline.count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    s.x[at] = static_cast<float>(outline.v[k].x);
    s.y[at] = static_cast<float>(outline.v[k].y);
  }
  s.low_x = *std::min_element(s.x, s.x + s.count);
  s.high_x = *std::max_element(s.x, s.x + s.count);
  s.low_y = *std::min_element(s.y, s.y + s.count);
  s.high_y = *std::max_element(s.y, s.y + s.count);
  const float half = width_of(outline) / 2 + s.radius;
  const float longest = std::max(s.high_x - s.low_x, s.high_y - s.low_y);
  const bool line = longest > cell;
  s.thin = longest > 2 * cell && half < cell;
  ConvexOutline wider = outline;
  if (line && half < kThinnest * cell) {
    s.radius += kThinnest * cell - half;
    wider.radius += static_cast<double>(kThinnest * cell - half);
  }
  s.area = static_cast<float>(area_of(wider));
  s.low_x -= s.radius;
  s.low_y -= s.radius;
  s.high_x += s.radius;
  s.high_y += s.radius;
  s.centre_x = static_cast<float>(centre.x);
  s.centre_y = static_cast<float>(centre.y);
  return s;
}

float FluidSolid::distance(Place2 at, Place2& out) const {
  Place2 way{at.x - x[0], at.y - y[0]}, side{0, 1};
  float nearest = HUGE_VALF, farthest = -HUGE_VALF;  // of the edges, and of the lines that they lie on
  for (std::int32_t k = 0; k < count && count > 1; ++k) {
    const std::int32_t next = k + 1 < count ? k + 1 : 0;
    const Place2 n = normal_of(*this, k, next), w = way_from_edge(*this, k, next, at);
    const auto a = static_cast<std::size_t>(k);
    const float of = length(n), line = of > 0 ? ((at.x - x[a]) * n.x + (at.y - y[a]) * n.y) / of : -HUGE_VALF;
    if (line > farthest) {
      farthest = line;
      side = {n.x / of, n.y / of};
    }
    if (const float l = length(w); l < nearest) {
      nearest = l;
      way = w;
    }
  }
  if (count == 1) nearest = length(way);
  // Within, and beside or on an edge, the line tells the distance. Else it is that from a corner, or from the end of a line.
  const bool on_edge = nearest <= kRounding * (std::fabs(at.x) + std::fabs(at.y));
  if (count > 1 && (farthest >= 0.999f * nearest || on_edge || (count > 2 && farthest < 0))) {
    out = side;
    return farthest - radius;
  }
  out = nearest > 0 ? Place2{way.x / nearest, way.y / nearest} : side;
  return nearest - radius;
}

// The integral of the part of a box that a line has swept, by the two ways across it.
float share_within(float distance, Place2 out, float wide, float high) {
  const float least = 1e-3f * wide;
  const float a = std::max(std::fabs(out.x) * wide, least), b = std::max(std::fabs(out.y) * high, least), t = -distance;
  const auto ramp = [](float v) { return v > 0 ? v * v / 2 : 0.0f; };
  const float all = (ramp(t + (a + b) / 2) - ramp(t + (a - b) / 2)) - (ramp(t + (b - a) / 2) - ramp(t - (a + b) / 2));
  return std::clamp(all / (a * b), 0.0f, 1.0f);
}

namespace {

// Where a way of length `length` along `u`, of length 1, first comes `apart` near a shape. By steps of the distance, for
// no step can pass the surface (Hart 1996). Returns less than 0 if it does not.
float enter(const FluidSolid& solid, Place2 from, Place2 u, float length, float apart, Place2& out) {
  constexpr int kMostSteps = 64;
  float at = 0;
  for (int k = 0; k < kMostSteps; ++k) {
    const float d = solid.distance({from.x + at * u.x, from.y + at * u.y}, out) - apart;
    if (d <= 1e-3f * apart) return at;
    at += d;
    if (at >= length) return -1;
  }
  return at;
}

}  // namespace

bool passes(const FluidSolid& solid, Place2 from, Place2 to, float apart) {
  if (std::max(from.x, to.x) < solid.low_x - apart || std::min(from.x, to.x) > solid.high_x + apart ||
      std::max(from.y, to.y) < solid.low_y - apart || std::min(from.y, to.y) > solid.high_y + apart) {
    return false;
  }
  const float way = length({to.x - from.x, to.y - from.y});
  Place2 out;
  return way > 0 && enter(solid, from, {(to.x - from.x) / way, (to.y - from.y) / way}, way, apart, out) >= 0;
}

Stop stop_at(const FluidSolid& solid, Place2 from, Place2 to, float apart, float most) {
  const Place2 low{std::min(from.x, to.x), std::min(from.y, to.y)},
      high{std::max(from.x, to.x), std::max(from.y, to.y)};
  if (high.x < solid.low_x - apart || low.x > solid.high_x + apart || high.y < solid.low_y - apart ||
      low.y > solid.high_y + apart) {
    return {};
  }
  Stop stop;
  Place2 out;
  const float d = solid.distance(to, out);
  const float before = solid.distance(from, stop.out);
  // A thin shape counts as wider than it is, so that a particle within it still lies on one of its sides.
  if (before < 0 && !solid.thin) {
    if (d >= apart) return {};
    const float by = std::min(apart - d, most);
    return {true, {to.x + by * out.x, to.y + by * out.y}, out};
  }
  const float way = length({to.x - from.x, to.y - from.y});
  if (before >= apart) {
    if (d >= apart && way < d + before - apart) return {};  // too far from the surface to pass it
    const Place2 u{(to.x - from.x) / way, (to.y - from.y) / way};
    const float at = way > 0 ? enter(solid, from, u, way, apart, stop.out) : -1.0f;
    if (at < 0 && d >= apart) return {};
    if (at >= 0) from = {from.x + at * u.x, from.y + at * u.y};
  } else {
    from = {from.x + (apart - before) * stop.out.x, from.y + (apart - before) * stop.out.y};
    if (d >= apart && (to.x - from.x) * stop.out.x + (to.y - from.y) * stop.out.y >= 0) return {};
  }
  const float into = (to.x - from.x) * stop.out.x + (to.y - from.y) * stop.out.y;
  if (into >= 0) return {true, to, stop.out};
  // It comes back by as far, so that fast particles do not all end on one line.
  stop.at = {to.x - 2 * into * stop.out.x, to.y - 2 * into * stop.out.y};
  stop.stopped = true;
  if (const float left = solid.distance(stop.at, out) - apart; left < 0) {
    stop.at = {stop.at.x - left * out.x, stop.at.y - left * out.y};
  }
  return stop;
}

}  // namespace psim
