// Scenes of discs in plain boxes, placed on lattices.
#include <algorithm>
#include <cmath>

#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

// ceil(sqrt(n)) discs a row, over a floor half a metre wider on either side; room to be thrown up.
Scene pile_of(std::uint64_t n, const Material& material) {
  const double columns = static_cast<double>(ceil_sqrt(n));
  const double width = columns * kSpacing + 1;
  Scene scene;
  scene.world.bounds = {0, 0, width, 4 * width};
  scene.world.wall = material;
  scene.groups.push_back(lattice(n, {0.5, 0.5, width - 0.5, 0.5 + columns * kSpacing}, 0.5, 0.5, material));
  return scene;
}

}  // namespace

// 10 m^2 a disc whatever their number, so that scenes of any size do the same work a disc.
Scene discs(std::uint64_t n, std::uint64_t) {
  const Material material{1, 0.5, 0};
  const double side = 1000 * std::sqrt(static_cast<double>(n) / 1e5);
  Scene scene;
  scene.world.bounds = {0, 0, side, side};
  scene.world.wall = material;
  scene.groups.push_back(lattice(n, {1, 1, side - 1, side - 1}, 0.5, 0.9, material));
  scene.groups.back().velocity_spread = 10;
  return scene;
}

Scene pile(std::uint64_t n, std::uint64_t) { return pile_of(n, {1, 0, 0}); }

Scene rough_pile(std::uint64_t n, std::uint64_t) { return pile_of(n, {1, 0.1, 0.5}); }

// The column is twice as high as wide and stands against the left wall of a tank ten times as long.
Scene dam(std::uint64_t n, std::uint64_t) {
  const Material material{1, 0.1, 0.2};
  const std::uint64_t columns = ceil_sqrt((n + 1) / 2);
  const Bounds column = block(n, columns, kSpacing, 0, 0);
  Scene scene;
  scene.world.bounds = {0, 0, 10 * column.xmax, 1.5 * column.ymax + 1};
  scene.world.wall = material;
  scene.groups.push_back(lattice(n, column, 0.5, 0.5, material));
  return scene;
}

// Radii 5, 0.8 and 0.1 m; large at the bottom, small on top, where they trickle into the gaps.
// One in 500 is large, one in 20 middling: each size covers about as much ground.
Scene mixed_sizes(std::uint64_t n, std::uint64_t) {
  struct Size {
    std::uint64_t count;
    double radius;
  };
  const std::uint64_t large = n / 500, middling = n / 20;
  const Size sizes[] = {{large, 5}, {middling, 0.8}, {n - large - middling, 0.1}};
  const Material material{1, 0.1, 0.3};
  const double width = std::max(12.0, std::ceil(0.8 * std::sqrt(static_cast<double>(n))));
  Scene scene;
  double y = 0;
  for (const Size& size : sizes) {
    if (size.count == 0) continue;
    const double cell = 2.2 * size.radius;
    const auto columns = static_cast<std::uint64_t>(width / cell);
    const Bounds region = block(size.count, columns, cell, 0, y);
    scene.groups.push_back(lattice(size.count, region, size.radius, 0.8, material));
    scene.groups.back().seed = scene.groups.size();
    y = region.ymax;
  }
  scene.world.bounds = {0, 0, width, std::max(width, 1.5 * y)};
  scene.world.wall = material;
  return scene;
}

// 6.25 m^2 a disc: discs cover an eighth of the box.
Scene gas_periodic(std::uint64_t n, std::uint64_t) {
  const double side = std::max(10.0, 2.5 * std::sqrt(static_cast<double>(n)));
  Scene scene;
  scene.world.bounds = {0, 0, side, side};
  scene.world.boundary = Boundary::periodic;
  scene.world.gravity = {0, 0};
  scene.groups.push_back(lattice(n, {0, 0, side, side}, 0.5, 0.9, {1, 1, 0}));
  scene.groups.back().velocity_spread = 5;
  return scene;
}

}  // namespace psim::builtin
