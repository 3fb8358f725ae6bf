// A world with joints, and what they are held against.
#pragma once

#include <array>

#include "support.h"

namespace psim::test {

struct JointScene {
  explicit JointScene(Vec2 gravity = {0, -kG}) {
    WorldDesc d;
    d.gravity = gravity;
    make(d);
  }
  explicit JointScene(const WorldDesc& d) { make(d); }
  void make(const WorldDesc& d) {
    std::string error;
    world = World::create(d, {}, error);
    EXPECT_NE(world, nullptr) << error;
  }

  BodyId add(const BodyDesc& d) {
    std::string error;
    const BodyId id = world->add_body(d, error);
    EXPECT_NE(id, kNoBody) << error;
    return id;
  }
  BodyId disc(Vec2 at, double radius, double mass = 1, bool fixed_rotation = false) {
    BodyDesc d;
    d.shape = DiscShape{radius};
    d.position = at;
    d.mass = mass;
    d.fixed_rotation = fixed_rotation;
    return add(d);
  }
  BodyId peg(Vec2 at) {
    BodyDesc d;
    d.type = BodyType::static_body;
    d.shape = DiscShape{0.01};
    d.position = at;
    return add(d);
  }
  JointId join(const JointDesc& d) {
    std::string error;
    const JointId id = world->add_joint(d, error);
    EXPECT_NE(id, kNoJoint) << error;
    return id;
  }
  BodyState at(BodyId id) const { return world->body(id).value(); }
  JointState joint(JointId id) const { return world->joint(id).value(); }
  void run(int frames) {
    for (int i = 0; i < frames; ++i) world->step();
  }

  std::unique_ptr<World> world;
};

/// A world that does not sleep.
inline JointScene free_scene(int substeps, Vec2 gravity) {
  WorldDesc desc;
  desc.gravity = gravity;
  desc.substeps = substeps;
  desc.sleeping = false;
  return JointScene(desc);
}

/// A disc that meets nobody.
inline BodyId ghost(JointScene& s, Vec2 at, double mass, double radius = 0.1) {
  BodyDesc d;
  d.shape = DiscShape{radius};
  d.position = at;
  d.mass = mass;
  d.filter.mask = 0;
  return s.add(d);
}

/// A box that meets nobody.
inline BodyId board(JointScene& s, Vec2 at, double width, double height, double mass) {
  BodyDesc d;
  d.shape = BoxShape{width, height, 0};
  d.position = at;
  d.mass = mass;
  d.filter.mask = 0;
  return s.add(d);
}

inline JointDesc between(JointType type, BodyId a, BodyId b, Vec2 anchor_a = {}, Vec2 anchor_b = {}) {
  JointDesc d;
  d.type = type;
  d.a = a;
  d.b = b;
  d.anchor_a = anchor_a;
  d.anchor_b = anchor_b;
  return d;
}

template <std::size_t N, class Slope>
void runge_kutta(std::array<double, N>& y, double time, int steps, const Slope& slope) {
  const double h = time / steps;
  const auto ahead = [&](const std::array<double, N>& k, double s) {
    std::array<double, N> z = y;
    for (std::size_t i = 0; i < N; ++i) z[i] += s * k[i];
    return z;
  };
  for (int n = 0; n < steps; ++n) {
    const auto k1 = slope(y), k2 = slope(ahead(k1, h / 2)), k3 = slope(ahead(k2, h / 2)), k4 = slope(ahead(k3, h));
    for (std::size_t i = 0; i < N; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
}

}  // namespace psim::test
