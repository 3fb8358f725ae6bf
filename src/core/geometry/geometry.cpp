// The public functions of geometry. Each makes the outlines of its shapes, relative to the place of the question, and asks
// them one by one.
#include "psim/geometry.h"

#include <cmath>
#include <new>
#include <string>

#include "base/elementary.h"
#include "base/machine.h"
#include "base/room.h"
#include "geometry/turning.h"
#include "psim/limits.h"

namespace psim {
namespace {

bool in_range(Vec2 point) { return limits::kCoordinate.contains(point); }
bool in_range(const Pose& at) { return in_range(at.position) && limits::kAngle.contains(at.angle); }
bool in_range(const ShapeMove& move) {
  return in_range(move.from) && in_range(move.translation) && std::fabs(move.rotation) <= kMostRotation;
}

// In the shape's own frame; none if it is refused.
std::vector<Outline> outlines_of(const Shape& shape) {
  std::vector<Outline> outlines;
  std::string error;
  make_outlines(shape, outlines, error);
  return outlines;
}

// An outline where it stands.
struct Placed {
  Outline outline;
  Box box;  // about its core
};

// Seen from a place; none if the shape is refused or does not stand anywhere.
std::vector<Placed> placed(const Shape& shape, const Pose& at, Vec2 from) {
  std::vector<Placed> list;
  if (!in_range(at)) return list;
  const SineCosine turn = sine_cosine(at.angle);
  for (const Outline& own : outlines_of(shape)) {
    const Outline outline = outline_of(own, turn, at.position - from);
    list.push_back({outline, box_of(outline)});
  }
  return list;
}

// No two points of the two are nearer; minus infinity where the boxes overlap.
double least_distance(const Placed& a, const Placed& b) {
  const double x = greater(a.box.low.x - b.box.high.x, b.box.low.x - a.box.high.x);
  const double y = greater(a.box.low.y - b.box.high.y, b.box.low.y - a.box.high.y);
  if (x < 0 && y < 0) return -HUGE_VAL;
  return length_of({greater(x, 0.0), greater(y, 0.0)}) - a.outline.radius - b.outline.radius;
}

// An outline on its way, in a circle that holds it and goes with it.
struct Moving {
  Turning turning;
  Vec2 centre;  // m, at the start
  double reach = 0;

  Moving(const Outline& own, const ShapeMove& move, Vec2 from)
      : turning{own, move.from.angle, move.rotation, move.from.position - from, move.translation} {
    if (!turning.turns()) turning.rotation = 0;
    const Outline start = turning.outline_at(0);
    centre = turning.turns() ? turning.from : box_of(start).middle();
    for (int k = 0; k < start.count; ++k) reach = greater(length_of(start.v[k] - centre), reach);
    reach += start.radius;
  }
};

// Two outlines on their ways, and where they first touch.
struct Meeting {
  Vec2 way;           // m: of a, seen from b
  double length = 0;  // m
  Vec2 u;             // along the way, of length 1
  std::optional<ShapeHit> best = {};

  explicit Meeting(Vec2 relative) : way(relative), length(length_of(relative)) {
    if (length > 0) u = {way.x / length, way.y / length};
  }

  bool may_touch(const Moving& a, const Moving& b) const {
    const Vec2 to = b.centre - a.centre;
    const double miss = length > 0 ? std::fabs(cross(to, u)) : length_of(to);
    return miss <= (a.reach + b.reach) * (1 + 1e-12);
  }

  // A share of the ways; < 0: they do not touch before the best.
  RayEntry touch(const Turning& a, const Turning& b) const {
    const double limit = best ? best->fraction : 1;
    if (a.turns() || b.turns()) return touch_turning(a, b, limit);
    RayEntry entry = enter(difference(a.outline_at(0), b.outline_at(0)), u, limit * length);
    if (entry.at > 0) entry.at = lesser(entry.at / length, limit);
    return entry;
  }

  void take(const Moving& a, const Moving& b, Vec2 from) {
    if (!may_touch(a, b)) return;
    const RayEntry entry = touch(a.turning, b.turning);
    if (entry.at < 0 || (best && entry.at >= best->fraction)) return;
    best = ShapeHit{from + a.turning.from, entry.normal, entry.at};
    if (entry.normal == Vec2{}) return;
    const Outline mine = a.turning.outline_at(entry.at), other = b.turning.outline_at(entry.at);
    best->point = from + nearest_point(mine, other, entry.normal);
  }
};

template <class Answer>
Answer no_room() {
  ran_out_of_memory() = true;
  return Answer();
}

}  // namespace

std::optional<Bounds> shape_bounds(const Shape& shape, const Pose& at) try {
  const FloatSettings settings;
  Grown grown;
  const std::vector<Placed> parts = placed(shape, at, {});
  for (const Placed& part : parts) grown.add(part.outline);
  return parts.empty() ? std::nullopt : std::optional<Bounds>(grown.box);
} catch (const std::bad_alloc&) {
  return no_room<std::optional<Bounds>>();
}

bool shape_holds(const Shape& shape, const Pose& at, Vec2 point) try {
  const FloatSettings settings;
  if (!in_range(point)) return false;
  for (const Placed& part : placed(shape, at, point)) {
    if (!(near_point(part.outline).distance > 0)) return true;
  }
  return false;
} catch (const std::bad_alloc&) {
  return no_room<bool>();
}

std::optional<ShapeHit> shape_ray_cast(const Shape& shape, const Pose& at, Vec2 from, Vec2 to) try {
  const FloatSettings settings;
  if (!in_range(from) || !in_range(to)) return {};
  const Vec2 way = to - from;
  const double length = length_of(way);
  const Vec2 u = length > 0 ? Vec2{way.x / length, way.y / length} : Vec2{};
  RayEntry best;
  for (const Placed& part : placed(shape, at, from)) {
    const RayEntry entry = enter(part.outline, u, best.at < 0 ? length : best.at);
    if (entry.at >= 0 && (best.at < 0 || entry.at < best.at)) best = entry;
  }
  if (best.at < 0) return {};
  return ShapeHit{from + best.at * u, best.normal, length > 0 ? best.at / length : 0};
} catch (const std::bad_alloc&) {
  return no_room<std::optional<ShapeHit>>();
}

std::optional<ShapeGap> shape_distance(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b) try {
  const FloatSettings settings;
  const Vec2 from = at_a.position;
  const std::vector<Placed> mine = placed(a, at_a, from), others = placed(b, at_b, from);
  Gap least{HUGE_VAL, {}};
  const Placed *nearest_a = nullptr, *nearest_b = nullptr;
  for (const Placed& one : mine) {
    for (const Placed& other : others) {
      if (least_distance(one, other) > least.distance) continue;
      const Gap gap = gap_between(one.outline, other.outline);
      if (!(gap.distance < least.distance)) continue;
      least = gap;
      nearest_a = &one, nearest_b = &other;
    }
  }
  if (nearest_a == nullptr) return {};
  const Vec2 to_b = -1 * least.normal;
  return ShapeGap{least.distance, from + nearest_point(nearest_b->outline, nearest_a->outline, to_b),
                  from + nearest_point(nearest_a->outline, nearest_b->outline, least.normal), to_b};
} catch (const std::bad_alloc&) {
  return no_room<std::optional<ShapeGap>>();
}

std::optional<ShapeHit> shape_cast(const Shape& a, const ShapeMove& move_a, const Shape& b,
                                   const ShapeMove& move_b) try {
  const FloatSettings settings;
  if (!in_range(move_a) || !in_range(move_b)) return {};
  const Vec2 from = move_a.from.position;
  const std::vector<Outline> outlines_a = outlines_of(a), outlines_b = outlines_of(b);
  std::vector<Moving> mine, others;
  for (const Outline& own : outlines_a) mine.emplace_back(own, move_a, from);
  for (const Outline& own : outlines_b) others.emplace_back(own, move_b, from);
  Meeting meeting(move_a.translation - move_b.translation);
  for (const Moving& one : mine) {
    for (const Moving& other : others) meeting.take(one, other, from);
  }
  return meeting.best;
} catch (const std::bad_alloc&) {
  return no_room<std::optional<ShapeHit>>();
}

}  // namespace psim
