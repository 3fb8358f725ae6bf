// Bodies with corners and scenes of them, for the tests. Public API only.
#pragma once

#include "support.h"

namespace psim::test {

inline BodyDesc box(Vec2 position, double width = 1, double height = 1, Material m = {}, double mass = 0) {
  BodyDesc body;
  body.shape = BoxShape{width, height};
  body.position = position;
  body.material = m;
  body.mass = mass;
  return body;
}

inline BodyDesc polygon(std::vector<Vec2> vertices, Vec2 position, Material m = {}) {
  BodyDesc body;
  body.shape = PolygonShape{std::move(vertices)};
  body.position = position;
  body.material = m;
  return body;
}

/// Level, `length` from the centre of one end to that of the other.
inline BodyDesc capsule(Vec2 position, double length, double radius, Material m = {}) {
  BodyDesc body;
  body.shape = CapsuleShape{{-0.5 * length, 0}, {0.5 * length, 0}, radius};
  body.position = position;
  body.material = m;
  return body;
}

inline BodyDesc fixed(BodyDesc body) {
  body.type = BodyType::static_body;
  return body;
}

inline BodyDesc kinematic(BodyDesc body) {
  body.type = BodyType::kinematic_body;
  return body;
}

inline BodyDesc moving(BodyDesc body, Vec2 velocity, double angular_velocity = 0) {
  body.velocity = velocity;
  body.angular_velocity = angular_velocity;
  return body;
}

inline BodyDesc turned(BodyDesc body, double angle) {
  body.angle = angle;
  return body;
}

/// Vertices of a regular polygon about (0, 0), its lowest side level.
inline std::vector<Vec2> regular(int sides, double radius) {
  std::vector<Vec2> v;
  for (int k = 0; k < sides; ++k) {
    const double a = -0.5 * kPi + (k + 0.5) * 2 * kPi / sides;
    v.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  return v;
}

inline double speed_of(const BodyState& s) { return std::hypot(s.vx, s.vy); }

/// Bodies and the places where they were put.
struct Placed {
  std::unique_ptr<World> world;
  std::vector<BodyId> ids;
  std::vector<Vec2> at;

  BodyId put(const BodyDesc& body) {
    ids.push_back(add(*world, body));
    at.push_back(body.position);
    return ids.back();
  }
  BodyState now(std::size_t k) const { return state(*world, ids[k]); }
  BodyState top() const { return now(ids.size() - 1); }
  double sideways() const {
    double most = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      if (world->is_valid(ids[k])) most = std::max(most, std::abs(now(k).x - at[k].x));
    }
    return most;
  }
  double moved() const {
    double most = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      if (!world->is_valid(ids[k])) continue;
      most = std::max(most, std::hypot(now(k).x - at[k].x, now(k).y - at[k].y));
    }
    return most;
  }
  double fastest() const {
    double most = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      if (world->is_valid(ids[k])) most = std::max(most, speed_of(now(k)));
    }
    return most;
  }
};

inline const Material kGrip = material(0, 0.6);

/// Boxes of 1 m and 1 kg, one on the other at x = 0, on level ground.
inline Placed stack(int n, Isa isa = best_isa(), int threads = 1) {
  Placed p{make(unbounded(200), isa, threads), {}, {}};
  add(*p.world, ground(kGrip));
  for (int k = 0; k < n; ++k) p.put(box({0, k + 0.5}, 1, 1, kGrip, 1));
  return p;
}

/// Rows of n, n - 1, ... 1 boxes with gaps of 5 cm.
inline Placed pyramid(int n, double mirror = 1, Isa isa = best_isa(), int threads = 1) {
  Placed p{make(unbounded(200), isa, threads), {}, {}};
  add(*p.world, ground(kGrip));
  for (int row = 0; row < n; ++row) {
    for (int k = 0; k < n - row; ++k) {
      p.put(box({mirror * (k - 0.5 * (n - row - 1)) * 1.05, row + 0.5}, 1, 1, kGrip));
    }
  }
  return p;
}

/// A body that is drawn at random, of any shape.
inline BodyDesc body_of_any_shape(Random& r, Vec2 at) {
  const std::size_t kind = r.below(4);
  BodyDesc body = disc(at, {}, r.uniform(0.2, 0.5));
  if (kind == 1) body = box(at, r.uniform(0.3, 1), r.uniform(0.3, 1));
  if (kind == 2) body = capsule(at, r.uniform(0.2, 1), 0.2);
  if (kind == 3) body.shape = CompoundShape{{{BoxShape{1, 0.2}}, {DiscShape{0.3}, {0.5, 0}}}}, body.position = at;
  body.mass = r.uniform(0.1, 20);
  body.material = material(0, r.uniform(0, 1));
  body.angle = r.uniform(-3, 3);
  return body;
}

}  // namespace psim::test
