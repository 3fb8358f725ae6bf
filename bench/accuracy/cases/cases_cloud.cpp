// What no contact may change: momentum and angular momentum of a cloud that falls together in open
// space.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases/case.h"

namespace psim::accuracy {
namespace {

constexpr double kSize = 0.3;

/// What lies in a circle of 0.3 m: every third a disc, a box, a triangle.
Shape part(int k) {
  if (k % 3 == 0) return DiscShape{kSize};
  if (k % 3 == 1) return BoxShape{1.6 * kSize, 1.2 * kSize};
  return PolygonShape{{{kSize, 0}, {-0.5 * kSize, 0.8 * kSize}, {-0.5 * kSize, -0.8 * kSize}}};
}

/// 100 rough bodies rush at the origin and turn about it.
Scene cloud(bool mixed) {
  Scene scene = open_scene(200, {0, 0});
  for (int k = 0; k < 100; ++k) {
    const double r = 3 + 0.12 * k, turn = 2 * std::numbers::pi * k * std::numbers::phi;
    const Vec2 at{r * std::cos(turn), r * std::sin(turn)};
    const Vec2 v{-0.8 * at.x - 0.3 * at.y, -0.8 * at.y + 0.3 * at.x};
    BodyDesc body = disc(at, v, material(0.5, 0.5), kSize);
    if (mixed) body.shape = part(k);
    scene.bodies.push_back(body);
  }
  return scene;
}

std::vector<double> measure_cloud(Run& run) {
  double linear = 0, angular = 0;
  for (std::size_t k = 0; k < run.bodies().size(); ++k) {
    const BodyState& s = run.body(k);
    const double mass = mass_of(run.model().bodies[k]);
    linear += mass * std::hypot(s.vx, s.vy);
    angular += mass * std::abs(s.x * s.vy - s.y * s.vx);
  }
  const Vec2 p = momentum(run);
  const double l = angular_momentum(run), start = kinetic_energy(run);
  double gained = 0;
  for (int k = 0; k < 300; ++k) {
    run.frame();
    gained = std::max(gained, kinetic_energy(run) / start - 1);
  }
  const Vec2 q = momentum(run);
  return {std::hypot(q.x - p.x, q.y - p.y) / linear, std::abs(angular_momentum(run) - l) / angular, gained};
}

Case cloud_case() {
  Case c;
  c.name = "cloud";
  c.shows = "100 discs, e = 0.5, mu = 0.5, fall together in open space: what contacts must not change";
  c.quantities = {{"cloud-momentum", "relative", "analytic", {{4, 1e-5}}},
                  {"cloud-angular-momentum", "relative", "analytic", {{4, 1e-3}}},
                  {"cloud-energy-gain", "relative", "analytic", {{4, 1e-5}}}};
  c.scene = [] { return cloud(false); };
  c.measure = measure_cloud;
  return c;
}

Case shape_cloud() {
  Case c = cloud_case();
  c.name = "shape-cloud";
  c.shows = "the same of discs, boxes and triangles";
  for (Quantity& q : c.quantities) q.name.insert(0, "shape-");
  c.scale = Scale::large;
  c.scene = [] { return cloud(true); };
  return c;
}

}  // namespace

std::vector<Case> cloud_cases(Effort) { return {cloud_case(), shape_cloud()}; }

}  // namespace psim::accuracy
