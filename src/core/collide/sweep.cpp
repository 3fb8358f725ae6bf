// Planes, motions and rays against one hull. A plane or a ray costs O(vertices), a motion a few calls of nearest().
#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"
#include "collide/closing.h"
#include "collide/collide.h"

namespace psim {
namespace {

constexpr int kMostAdvances = 64;

/// A ray against the circle about (x, y), relative to the start of the ray. Returns the share of the way, or 2.
double enter_circle(double x, double y, double radius, double rx, double ry) {
  const double length2 = rx * rx + ry * ry, along = x * rx + y * ry;
  const double miss = (x * ry - y * rx) / std::sqrt(length2);  // distance of the line from the centre
  const double half2 = radius * radius - miss * miss;          // half the chord, squared
  if (!(half2 >= 0) || !(along > 0)) return 2;
  const double fraction = along / length2 - std::sqrt(half2 / length2);
  return fraction >= 0 && fraction <= 1 ? fraction : 2;
}

}  // namespace

RayCast cast_ray(const Hull& hull, Rotor q, double ox, double oy, double rx, double ry) {
  // All vectors are in the frame of the hull.
  const SineCosine back{-double{q.s}, q.c};
  const Vec2 start = turned(back, {ox, oy}), way = turned(back, {rx, ry});
  const double radius = hull.radius;
  const bool moves = way.x != 0 || way.y != 0;
  double best = 2;
  Vec2 normal;
  double deepest = -1e300;  // the largest height of the start over the line of an edge
  double nearest2 = 1e300;  // squared distance of the start from the outline of the core
  const int edges = hull.count > 1 ? hull.count : 0;
  for (int k = 0; k < edges; ++k) {
    const Vec2 p = hull.vertex(k), e = hull.vertex(hull.next(k)) - p;
    const double span2 = dot(e, e), span = std::sqrt(span2);
    const Vec2 n = span > 0 ? Vec2{e.y / span, -e.x / span} : Vec2{};
    const double height = dot(n, start - p);
    deepest = greater(height, deepest);
    const double share = span2 > 0 ? dot(start - p, e) / span2 : 0;
    const Vec2 u = start - p - lesser(greater(share, 0.0), 1.0) * e;
    nearest2 = lesser(dot(u, u), nearest2);
    // The ray comes in through the edge, which is moved out by the radius.
    const double fall = -dot(n, way);
    if (!(fall > 0) || height < radius) continue;
    const double fraction = (height - radius) / fall;
    const double along = dot(start + fraction * way - p, e);
    const double seam = 1e-9 * span2;  // so that no ray slips through where two edges meet
    if (fraction < best && fraction <= 1 && along >= -seam && along <= span2 + seam) {
      best = fraction;
      normal = n;
    }
  }
  for (int k = 0; k < hull.count; ++k) {
    const Vec2 v = hull.vertex(k) - start;
    nearest2 = lesser(dot(v, v), nearest2);
    if (!moves || !(radius > 0)) continue;
    const double fraction = enter_circle(v.x, v.y, radius, way.x, way.y);
    if (fraction < best) {
      best = fraction;
      normal = {(fraction * way.x - v.x) / radius, (fraction * way.y - v.y) / radius};
    }
  }
  if (nearest2 < radius * radius || (hull.count > 2 && deepest < 0)) return {0, 0, 0};
  if (best > 1) return {};
  normal = turned({q.s, q.c}, normal);
  return {static_cast<float>(best), static_cast<float>(normal.x), static_cast<float>(normal.y)};
}

Manifold meet_plane(const Hull& hull, Rotor q, float nx, float ny, float offset, float margin) {
  Manifold m;
  m.nx = nx;
  m.ny = ny;
  float x[Hull::kMost] = {}, y[Hull::kMost] = {}, gap[Hull::kMost] = {};
  int first = 0;
  for (int k = 0; k < hull.count; ++k) {
    x[k] = q.c * hull.x[k] - q.s * hull.y[k];
    y[k] = q.s * hull.x[k] + q.c * hull.y[k];
    gap[k] = (nx * x[k] + ny * y[k]) + offset - hull.radius;
    if (gap[k] < gap[first]) first = k;
  }
  const auto add = [&](int k) {
    if (!(gap[k] <= margin)) return;
    ManifoldPoint& p = m.point[m.count++];
    const float middle = hull.radius + 0.5f * gap[k];
    p.bx = x[k] - nx * middle;
    p.by = y[k] - ny * middle;
    p.gap = gap[k];
    p.feature = static_cast<std::uint16_t>(k);
  };
  m.point[0].gap = gap[first];
  add(first);
  if (hull.count == 1) return m;
  const int next = (first + 1) % hull.count, before = (first + hull.count - 1) % hull.count;
  const int second = gap[before] < gap[next] ? before : next;
  if (second != first) add(second);
  return m;
}

double time_to_close(double gap, double speed, double growth) {
  const double root = std::sqrt(greater(speed * speed + 2 * growth * gap, 0));
  if (speed > 0) return 2 * gap / (speed + root);
  return growth > 0 ? (root - speed) / growth : 1e30;
}

double time_above(const Hull& hull, SineCosine q, Vec2 n, double gap, double closing, double turn, double growth) {
  double height[Hull::kMost], speed[Hull::kMost], lowest = 1e300, soonest = 1e300;
  for (int k = 0; k < hull.count; ++k) {
    const Vec2 corner = turned(q, hull.vertex(k));
    height[k] = dot(n, corner);
    speed[k] = closing - turn * dot(n, upright(corner));
    lowest = lesser(height[k], lowest);
  }
  for (int k = 0; k < hull.count; ++k) {
    soonest = lesser(time_to_close(gap + (height[k] - lowest), speed[k], growth), soonest);
  }
  return soonest;
}

float time_of_impact(const Hull& a, Rotor qa, const Hull& b, double angle_b, double turn, float dx, float dy, float mx,
                     float my, float slack) {
  // B's points turn about its centre, so those of its core move by at most this much; turning the
  // radius around them moves nothing.
  const double reach = double{b.reach} - b.radius, swing = std::fabs(turn) * reach;
  const double fine = 1e-5 * std::min(double{a.reach}, double{b.reach});
  double target = slack, close_enough = slack + std::max(0.1 * slack, fine);
  double share = 0, most = 1;
  for (int k = 0; k < kMostAdvances; ++k) {
    const Rotor qb = rotor_of(angle_b + share * turn);
    const Nearest now = nearest(a, qa, b, qb, static_cast<float>(dx + share * mx), static_cast<float>(dy + share * my));
    if (k == 0 && now.distance <= close_enough) {
      // The hulls touch from the start, for example because a body slides, rolls or tips over. Contacts see to that.
      // Only a body that would go through is stopped: at half its inner radius deep, and in any case before its
      // middle goes through.
      const Vec2 middle = b.middle_at(angle_b);
      const RayCast path = cast_ray(a, qa, dx + middle.x, dy + middle.y, mx, my);
      const bool outside = path.nx != 0 || path.ny != 0;
      if (path.fraction <= 1 && outside) most = 0.5 * double{path.fraction};
      target = -0.5 * double{b.inner};
      close_enough = target + fine;
      if (now.distance <= close_enough) return static_cast<float>(most);
    }
    if (now.distance <= close_enough) break;
    // Along the present normal the hulls stay apart for at least this long.
    const double gap = now.distance - target, closing = -(double{mx} * now.nx + double{my} * now.ny);
    if (!(swing + closing > 0)) return static_cast<float>(most);
    const double advance = gap / (swing + closing);
    if (swing == 0 || share + advance >= most) {
      share += advance;
    } else {
      const double growth = turn * turn * reach;
      share += greater(advance, time_above(b, {qb.s, qb.c}, {now.nx, now.ny}, gap, closing, turn, growth));
    }
    if (share >= most) return static_cast<float>(most);
  }
  return static_cast<float>(share);
}

}  // namespace psim
