// Scenes in vessels made of chains and segments.
#include <algorithm>
#include <cmath>

#include "builtin/builtin.h"
#include "place/placement.h"

namespace psim::builtin {

// Two bulbs joined by a neck at the origin; the floor is the world's. Slopes are 45 degrees; the neck
// is 2 m high and 8 % of the width, but no less than 5 m.
//
//    |  o o o  |  filling
//    |  o o o  |
//     \       /   slope
//      \     /
//       |   |     neck
//      /     \    slope
//     /       \   .
//    |         |
Scene hourglass(std::uint64_t n, std::uint64_t) {
  const Material material{1, 0.1, 0.2};
  const std::uint64_t columns = ceil_sqrt(n);
  const double half = std::max(6.0, std::ceil(static_cast<double>(columns) * kSpacing / 2 + 1));
  const double neck = std::max(2.5, std::ceil(0.16 * half) / 2);
  const double slope = 1 + half - neck;  // where a bulb's straight sides begin, above the neck
  const Bounds filling = block(n, columns, kSpacing, 0, slope);
  const double top = std::ceil(filling.ymax + 1);

  Scene scene;
  scene.world.bounds = {-half - 1, -top, half + 1, top + 1};
  scene.world.wall = material;
  add_static(scene, "left", {0, 0},
             ChainShape{{{-half, top}, {-half, slope}, {-neck, 1}, {-neck, -1}, {-half, -slope}, {-half, -top}}, false},
             material);
  add_static(scene, "right", {0, 0},
             ChainShape{{{half, top}, {half, slope}, {neck, 1}, {neck, -1}, {half, -slope}, {half, -top}}, false},
             material);
  const double shift = filling.xmax / 2;
  scene.groups.push_back(lattice(n, {-shift, filling.ymin, shift, filling.ymax}, 0.5, 0.5, material));
  return scene;
}

// From the top: a hopper full of discs, `rows` staggered rows of pegs (static discs), and a bin below
// every gap of the lowest row. With n discs in rows + 4 bins the fullest holds about 0.8 n /
// sqrt(rows): the pitch of the pegs is such that the bins are about as high as the pegs.
Scene galton(std::uint64_t n, std::uint64_t) {
  const Material material{1, 0.3, 0.1};
  const std::uint64_t rows = std::clamp<std::uint64_t>(ceil_sqrt(n), 4, 200);
  const std::uint64_t columns = rows + 4;
  const double r = static_cast<double>(rows);
  const double pitch = std::max(3.0, std::ceil(std::sqrt(0.9 * static_cast<double>(n) / (r * std::sqrt(r)))));
  const double width = static_cast<double>(columns) * pitch, half = width / 2;
  const double bins = std::ceil(0.9 * static_cast<double>(n) / (std::sqrt(r) * pitch)) + pitch;

  GroupDesc pegs = lattice(columns * rows, {-half, bins, half, bins + r * pitch}, 0.15 * pitch, 0, material);
  pegs.layout = Layout::hex;
  pegs.body.type = BodyType::static_body;
  const LatticePlan plan = plan_lattice(pegs.count, pegs.region, true);

  const double mouth = std::max(4.0, pitch) / 2;
  const double mouth_y = pegs.region.ymax + 1;
  const std::uint64_t across = ceil_sqrt(n);
  const double hopper = std::max(mouth + 2, std::ceil(static_cast<double>(across) * kSpacing / 2 + 1));
  const double slope_y = mouth_y + hopper - mouth;
  const Bounds filling = block(n, across, kSpacing, 0, slope_y);
  const double top = std::ceil(filling.ymax + 1);
  const double shift = filling.xmax / 2;

  Scene scene;
  scene.world.bounds = {-half, 0, half, top};
  scene.world.wall = material;
  add_static(scene, "hopper left", {0, mouth_y},
             ChainShape{{{-hopper, top - mouth_y}, {-hopper, slope_y - mouth_y}, {-mouth, 0}}, false}, material);
  add_static(scene, "hopper right", {0, mouth_y},
             ChainShape{{{hopper, top - mouth_y}, {hopper, slope_y - mouth_y}, {mouth, 0}}, false}, material);
  for (std::uint64_t k = 0; k < columns; ++k) {
    const double x = -half + (static_cast<double>(k) + 0.5) * plan.cell_x;
    add_static(scene, "", {x, 0}, SegmentShape{{0, 0}, {0, bins}}, material);
  }
  scene.groups.push_back(pegs);
  scene.groups.push_back(lattice(n, {-shift, filling.ymin, shift, filling.ymax}, 0.5, 0.5, material));
  return scene;
}

}  // namespace psim::builtin
