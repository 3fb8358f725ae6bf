#include "mover/mover_path.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr int kMostLooks = 8;       // at obstacles in one way
constexpr double kNoWay = 1e-9;     // m: a shorter way is none
constexpr double kStepFuzz = 1e-4;  // m: a step may be higher by this, for rounding
/// Ground under the round end of who falls may be this share of the radius above the foot.
constexpr double kLandingEdge = 0.3;

}  // namespace

MoverPath::MoverPath(const World& w, const MoverDesc& d, Vec2 from) : world(w), desc(d), at(from), filter(d.filter) {
  up = 1 / length_of(d.up) * d.up;
  side = along(up);
  const SineCosine limit = sine_cosine(d.slope_limit);
  least_rise_ = limit.cosine - 1e-9;
  slope_ = limit.sine / limit.cosine;
  filter.one_way = filter.enter_only = true;
  if (d.half_height > 0) {
    capsule = CapsuleShape{-d.half_height * up, d.half_height * up, d.radius};
  } else {
    capsule = DiscShape{d.radius};
  }
}

void MoverPath::touch(const ShapeCastHit& hit) {
  for (std::size_t k = 0; k < touch_count; ++k) {
    if (touches[k].body == hit.body) return;
  }
  if (touch_count < touches.size()) touches[touch_count++] = {hit.body, hit.point, hit.normal};
}

std::optional<Obstacle> MoverPath::cast(Vec2 way) const {
  const auto hit = world.shape_cast(capsule, at, 0, way, 0, filter);
  if (!hit) return {};
  return Obstacle{*hit, hit->fraction * length_of(way)};
}

// How far a way of this length along u may go, so that the skin is kept.
double MoverPath::room(const Obstacle& o, Vec2 u, double length) const {
  const double closing = -dot(u, o.hit.normal);
  if (!(closing > 0)) return length;
  return std::clamp(o.way - desc.skin / closing, 0.0, length);
}

// Goes along the way up to what is in it. `share`: how much of it was gone.
std::optional<ShapeCastHit> MoverPath::advance(Vec2 way, double& share) {
  share = 1;
  const double length = length_of(way);
  if (!(length > kNoWay)) return {};
  const Vec2 u = 1 / length * way;
  const auto met = cast((length + desc.skin) * u);
  const double free = met ? room(*met, u, length) : length;
  at = at + free * u;
  if (free >= length) return {};
  share = free / length;
  return met->hit;
}

// Whether one can stand on what was hit: on a face by its slope, and on an edge by the face behind the edge, which must
// not be higher above the foot than `height`. `face`: the normal of that face.
bool MoverPath::is_walkable(const ShapeCastHit& hit, Vec2 foot, double height, Vec2& face) const {
  face = hit.normal;
  if (is_ground(hit.normal)) return true;
  if (dot(hit.normal, up) < 1e-3 || dot(hit.point - foot, up) > height) return false;
  const double inwards = dot(hit.normal, side) > 0 ? -desc.skin : desc.skin;
  const Vec2 above = (1 + slope_) * desc.skin * up, look = hit.point + inwards * side;
  const auto ray = world.ray_cast(look + above, look - above, filter);
  if (!ray || !is_ground(ray->normal)) return false;
  face = ray->normal;
  return true;
}

bool MoverPath::walk(double run, Vec2 normal) {
  for (int looks = 0; looks < kMostLooks && std::fabs(run) > kNoWay; ++looks) {
    double share = 1;
    const auto hit = advance(run * along(normal), share);
    if (!hit) return true;
    run *= 1 - share;
    touch(*hit);
    if (is_ground(hit->normal)) {
      normal = hit->normal;
    } else if (step_up(run)) {
      normal = up;
    } else {
      return false;
    }
  }
  return std::fabs(run) <= kNoWay;
}

// Up by a step, forward, and down onto what is there; `run` becomes what is left of it.
bool MoverPath::step_up(double& run) {
  const Vec2 start = at, first_foot = foot();
  double share = 1;
  advance(desc.step_height * up, share);
  const double climbed = dot(at - start, up);
  advance(run * side, share);
  Vec2 face;
  const auto below = cast((climbed + desc.skin) * (-1 * up));
  const double height = desc.step_height - desc.skin + kStepFuzz;  // the foot is above the ground by the skin
  if (climbed > desc.skin && std::fabs(share * run) > kNoWay && below &&
      is_walkable(below->hit, first_foot, height, face)) {
    const double drop = below->way - desc.skin / greater(dot(below->hit.normal, up), 0.5);
    at = at - std::clamp(drop, 0.0, climbed) * up;
    run *= 1 - share;
    return true;
  }
  at = start;
  return false;
}

void MoverPath::fly(Vec2 way, Vec2& velocity) {
  std::array<Vec2, kMostLooks> planes;
  int count = 0;
  for (int looks = 0; looks < kMostLooks; ++looks) {
    double share = 1;
    const auto hit = advance(way, share);
    if (!hit) return;
    touch(*hit);
    way = (1 - share) * way;
    const Vec2 n = hit->normal;
    if (is_ground(n) && dot(velocity, up) <= 0) {  // what falls on ground does not slide down on it
      way = dot(way, side) * along(n);
      velocity = dot(velocity, side) * side;
    } else {
      way = way - lesser(dot(way, n), 0.0) * n;
      velocity = velocity - lesser(dot(velocity, n), 0.0) * n;
    }
    for (int k = 0; k < count; ++k) {
      if (dot(way, planes[static_cast<std::size_t>(k)]) > -kNoWay) continue;
      // Between two surfaces there is no way on in the plane.
      const Vec2 sum = planes[static_cast<std::size_t>(k)] + n;
      velocity = {};
      wedged_ = dot(n, up) > 0 && dot(planes[static_cast<std::size_t>(k)], up) > 0;
      wedge_ = *hit;
      wedge_.normal = 1 / greater(length_of(sum), 1e-9) * sum;
      return;
    }
    planes[static_cast<std::size_t>(count++)] = n;
  }
}

std::optional<MoverGround> MoverPath::settle(bool walked) {
  const double deep = walked ? desc.step_height : 0;
  const auto below = cast((deep + 2 * desc.skin) * (-1 * up));
  Vec2 face;
  const double height = (walked ? desc.step_height : kLandingEdge * desc.radius) + kStepFuzz;
  if (!below || !is_walkable(below->hit, foot() - below->way * up, height, face)) {
    if (wedged_ && is_ground(wedge_.normal)) return MoverGround{wedge_.body, wedge_.point, wedge_.normal, {}};
    return {};
  }
  const double drop = below->way - desc.skin / greater(dot(below->hit.normal, up), 0.5);
  double share = 1;
  if (drop > 0) {
    at = at - drop * up;
  } else if (drop < -0.01 * desc.skin) {
    advance(-drop * up, share);
  }
  touch(below->hit);
  return MoverGround{below->hit.body, below->hit.point, face, {}};
}

}  // namespace psim
