// Scenes whose discs are listed one by one. No libm beyond sqrt: the same lists everywhere.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "builtin/builtin.h"
#include "place/random.h"

namespace psim::builtin {
namespace {

// To so many steps a unit: short numbers in a scene file, far below what matters.
double rounded(double value, double steps) { return std::nearbyint(value * steps) / steps; }

GroupDesc list(double radius, const Material& material) {
  GroupDesc group;
  group.layout = Layout::explicit_list;
  group.radius_min = group.radius_max = radius;
  group.radius = {radius};
  group.body.material = material;
  return group;
}

void put_moving(GroupDesc& group, double x, double y, double vx, double vy) {
  group.x.push_back(x);
  group.y.push_back(y);
  group.vx.push_back(vx);
  group.vy.push_back(vy);
  group.count = group.x.size();
}

}  // namespace

// Pool balls on a 9-foot table, SI units; the table grows with the rack. The rack has gaps of 1 % of
// a ball, moved about in them by the seed, so that no two breaks are alike.
Scene billiard(std::uint64_t n, std::uint64_t seed) {
  constexpr double kRadius = 0.0286, kPitch = 2.02 * kRadius, kHalfSqrt3 = 0.8660254037844386;
  const Material ball{66, 1, 0};
  std::uint64_t rows = 0;
  while (rows * (rows + 1) / 2 < n - 1) ++rows;
  const double table_y = std::max(1.27, rounded(2.5 * kPitch * static_cast<double>(rows), 100));
  const double table_x = 2 * table_y;

  Scene scene;
  scene.world.bounds = {0, 0, table_x, table_y};
  scene.world.wall = ball;
  scene.world.gravity = {0, 0};
  GroupDesc balls = list(kRadius, ball);
  put_moving(balls, rounded(table_x / 4, 1e6), rounded(table_y / 2, 1e6), 1.5, 0);
  const RandomStream random_x(seed, 0), random_y(seed, 1);
  std::uint64_t k = 1;
  for (std::uint64_t row = 0; row < rows; ++row) {
    const double x = table_x / 2 + static_cast<double>(row) * kPitch * kHalfSqrt3;
    for (std::uint64_t place = 0; place <= row && k < n; ++place, ++k) {
      const double off_axis = static_cast<double>(place) - static_cast<double>(row) / 2;
      const double y = table_y / 2 + off_axis * kPitch;
      const double shake = 0.006 * kRadius;
      put_moving(balls, rounded(x + shake * random_x.plus_minus_one(k), 1e6),
                 rounded(y + shake * random_y.plus_minus_one(k), 1e6), 0, 0);
    }
  }
  scene.groups.push_back(std::move(balls));
  return scene;
}

// Discs on a sunflower spiral (one in every m^2, each turned by the golden angle from the last), at
// the speed of a circular orbit there and up to 1 % off it. From the field's formula
//   v^2 / d = strength d / (d^2 + softening^2)^(3/2).
Scene orbits(std::uint64_t n, std::uint64_t seed) {
  constexpr double kGoldenCos = -0.7373688780783197, kGoldenSin = 0.6754902942615238;
  constexpr double kInner = 10;     // m
  constexpr double kRadius = 0.05;  // m
  const WellField well{{0, 0}, 80, 1, 2, 0};

  Scene scene;
  GroupDesc discs = list(kRadius, {1, 0.9, 0});
  const RandomStream random_x(seed, 0), random_y(seed, 1);
  double c = 1, s = 0, outer = kInner;
  for (std::uint64_t k = 0; k < n; ++k) {
    const double d2 = kInner * kInner + static_cast<double>(k) / std::numbers::pi;
    const double d = std::sqrt(d2);
    const double to_centre2 = d2 + well.softening * well.softening;
    const double speed = std::sqrt(well.strength * d2 / (to_centre2 * std::sqrt(to_centre2)));
    put_moving(discs, rounded(d * c, 1e4), rounded(d * s, 1e4),
               rounded(speed * (-s + 0.01 * random_x.plus_minus_one(k)), 1e5),
               rounded(speed * (c + 0.01 * random_y.plus_minus_one(k)), 1e5));
    outer = d;
    const double turned = c * kGoldenCos - s * kGoldenSin;
    s = s * kGoldenCos + c * kGoldenSin;
    c = turned;
    const double length = std::sqrt(c * c + s * s);
    c /= length;
    s /= length;
  }
  const double reach = std::ceil(2 * outer);
  scene.world.bounds = {-reach, -reach, reach, reach};
  scene.world.boundary = Boundary::open;
  scene.world.gravity = {0, 0};
  scene.world.fields.emplace_back(well);
  scene.groups.push_back(std::move(discs));
  return scene;
}

}  // namespace psim::builtin
