#include "contacts/edge_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/rotor.h"

namespace psim {
namespace {

// Share of the radius by which the parts of two edges overlap, so that no gap is between them.
constexpr double kSeam = 1e-4;
// Share of the seam by which an edge ends before a corner whose end is the other edge's: a disc on the corner is on one
// edge, not on two.
constexpr double kGiven = 0.99;
constexpr double kStraight = 1e-5;  // sine: edges that turn less go straight on
// Share of the radius: a disc that falls further than that hits the face where it comes.
constexpr double kImpact = 0.02;
constexpr double kSunk = 0.01;  // share of the radius: a disc that carries a load lies this deep at most

bool rises(const EdgeCorner& corner) { return static_cast<double>(corner.sin) > kStraight; }

// How far a place on the line of an edge lies beyond its nearest end. Negative: on the edge.
double beyond_end(const Edge& edge, double at) {
  const auto past = [&](double out, const EdgeCorner& corner) {
    const bool given = corner.length > 0 && corner.other_has_end && !rises(corner);
    return given ? out + kGiven * kSeam * edge.radius : out;
  };
  return greater(past(edge.begin - at, edge.before), past(at - edge.end, edge.after));
}

// What a disc meets beyond an end: `out` from it along the edge, at `height` over the line of the edge.
EdgeContact::Kind beyond(const EdgeCorner& corner, double out, double height, double radius, double way) {
  if (!(corner.length > 0)) return EdgeContact::round;
  const double cosine = static_cast<double>(corner.cos), sine = static_cast<double>(corner.sin);
  const double over = height * cosine - out * sine, past = out * cosine + height * sine;  // in the other edge's frame
  if (rises(corner)) {
    const bool comes = cosine > 0 && over > 0 && past <= static_cast<double>(corner.length) + way;
    return comes && height - radius >= -kSunk * radius ? EdgeContact::face : EdgeContact::nothing;
  }
  if (corner.other_has_end || past > kSeam * radius) return EdgeContact::nothing;
  return sine < -kStraight || cosine < 0 ? EdgeContact::round : EdgeContact::face;
}

}  // namespace

EdgeContact meet_edge(const Edge& edge, Vec2 moved, Vec2 way, double middle) {
  const Vec2 up{-edge.along.y, edge.along.x};
  EdgeContact contact;
  contact.kind = EdgeContact::face;
  const double before = edge.height + dot(up, moved) - edge.radius, fall = -dot(up, way);
  const double share = before > 0 && fall > before && fall > kImpact * edge.radius ? before / fall : 0;
  const double foot = dot(edge.along, moved) + share * dot(edge.along, way);
  const bool comes_down = share > 0 && beyond_end(edge, foot) <= 0;
  if (!comes_down) moved = moved + middle * way;
  const double at = dot(edge.along, moved), height = edge.height + dot(up, moved);
  const bool after = at - edge.end > edge.begin - at;
  if (!comes_down && beyond_end(edge, at) > 0) {
    const double out = after ? at - edge.end : edge.begin - at;
    contact.kind = beyond(after ? edge.after : edge.before, out, height, edge.radius, length_of(way));
  }
  contact.normal = up;
  contact.gap = edge.height - edge.radius;
  if (contact.kind != EdgeContact::round) return contact;
  const double end = after ? edge.end : edge.begin;
  contact.base = edge.height * up - end * edge.along;
  const Vec2 now = contact.base + moved;
  const double far = length_of(now);
  if (far > 0) contact.normal = 1 / far * now;
  contact.gap = far - edge.radius - dot(contact.normal, moved);
  return contact;
}

// The solver leaves the normal of a round end as it is: follow_edges() turns it.
void put_edge(const EdgeContact& contact, StaticLanes& c, std::uint32_t at) {
  constexpr float kTurnedElsewhere = 1e29f;
  const bool round = contact.kind == EdgeContact::round, nothing = contact.kind == EdgeContact::nothing;
  c.gap[at] = nothing ? kNoGap : static_cast<float>(contact.gap);
  c.refresh[at] = round ? kTurnedElsewhere : std::numeric_limits<float>::infinity();
  c.base_x[at] = static_cast<float>(contact.base.x);
  c.base_y[at] = static_cast<float>(contact.base.y);
  if (nothing) return;
  c.nx[at] = static_cast<float>(contact.normal.x);
  c.ny[at] = static_cast<float>(contact.normal.y);
}

}  // namespace psim
