// Scenes of bodies tied by joints. Figures of E. Catto's samples and benchmarks of Box2D 3 and
// Solver2D where a scene says so.
#include <algorithm>
#include <cmath>
#include <vector>

#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

// A row of links from x = 0 to the right at height y, each pinned to the one before and the first to
// a static anchor; returns the ids.
std::vector<std::uint64_t> add_links(Scene& scene, std::uint64_t anchor, Vec2 anchor_place, std::uint64_t n,
                                     double length, const Shape& link, double y, const Material& material) {
  std::vector<std::uint64_t> ids;
  for (std::uint64_t k = 0; k < n; ++k) {
    const double x = length * (static_cast<double>(k) + 0.5);
    ids.push_back(add(scene, rigid(link, {x, y}, material)));
    if (k == 0) {
      pin(scene, anchor, ids[0], {-anchor_place.x, y - anchor_place.y}, {-length / 2, 0});
    } else {
      pin(scene, ids[k - 1], ids[k], {length / 2, 0}, {-length / 2, 0});
    }
  }
  return ids;
}

}  // namespace

// Box2D's benchmark: 100 x 100 discs a metre apart that do not touch, each pinned to its right and
// lower neighbour half-way; seven in the middle of the top row are fixed. 19,800 joints there, less
// the six between fixed bodies here.
Scene joint_grid(std::uint64_t n, std::uint64_t) {
  const std::uint64_t columns = ceil_sqrt(n), rows = (n + columns - 1) / columns;
  const double side = static_cast<double>(columns);
  Scene scene = open_scene({-1.5 * side - 20, -3 * side - 20, 2.5 * side + 20, 1.5 * side + 20});
  const Filter apart{2, ~std::uint32_t{2}, 0};
  const auto is_fixed = [&](std::uint64_t column, std::uint64_t row) {
    return row == 0 && column + 3 >= columns / 2 && column <= columns / 2 + 3;
  };
  GroupDesc discs = list_of(DiscShape{0.4});
  discs.body.filter = apart;
  // The fixed ones have the first ids.
  std::vector<std::uint64_t> id(n);
  for (std::uint64_t k = 0; k < n; ++k) {
    if (!is_fixed(k % columns, k / columns)) continue;
    BodyDesc fixed = rigid(DiscShape{0.4}, {static_cast<double>(k), 0});
    fixed.type = BodyType::static_body;
    fixed.filter = apart;
    id[k] = add(scene, fixed);
  }
  std::uint64_t next = scene.bodies.size();
  for (std::uint64_t k = 0; k < n; ++k) {
    if (is_fixed(k % columns, k / columns)) continue;
    put(discs, static_cast<double>(k % columns), -static_cast<double>(k / columns));
    id[k] = next++;
  }
  scene.groups.push_back(std::move(discs));
  const auto moves = [&](std::uint64_t k) { return id[k] >= scene.bodies.size(); };
  for (std::uint64_t row = 0; row < rows; ++row) {
    for (std::uint64_t column = 0; column < columns; ++column) {
      const std::uint64_t k = row * columns + column;
      if (k >= n) break;
      if (row > 0) pin(scene, id[k - columns], id[k], {0, -0.5}, {0, 0.5});
      if (column > 0 && (moves(k - 1) || moves(k))) {
        pin(scene, id[k - 1], id[k], {0.5, 0}, {-0.5, 0});
      }
    }
  }
  return scene;
}

// Box2D's: planks of 1 m between two fixed points, and discs let fall on them.
Scene bridge(std::uint64_t n, std::uint64_t) {
  const double span = static_cast<double>(n);
  const Material plank{20, 0, 0.6};
  Scene scene = open_scene({-40, -span - 40, span + 40, 60});
  const std::uint64_t left = add_ground(scene, {-1, 0}, 1, 0.125);
  const auto ids = add_links(scene, left, {-1, 0}, n, 1, BoxShape{1, 0.25, 0}, 0, plank);
  const std::uint64_t right = add_ground(scene, {span + 1, 0}, 1, 0.125);
  pin(scene, ids.back(), right, {0.5, 0}, {-1, 0});
  for (int k = 0; k < 3; ++k) {
    add(scene, rigid(DiscShape{0.5}, {span * (k + 1) / 4, 5.0 + 2 * k}, plank));
  }
  return scene;
}

// Box2D's: thirty planks of 1.2 m overlapping by 0.2 m, let swing from one end.
Scene chain(std::uint64_t n, std::uint64_t) {
  const double length = static_cast<double>(n);
  Scene scene = open_scene({-1.5 * length - 20, -1.5 * length - 20, 1.5 * length + 20, length + 20});
  const std::uint64_t anchor = add_ground(scene, {-0.5, 0}, 0.5, 0.5);
  add_links(scene, anchor, {-0.5, 0}, n, 1, BoxShape{1.2, 0.25, 0}, 0, {20, 0, 0.2});
  // Links overlap their neighbours' neighbours when the chain folds.
  for (BodyDesc& body : scene.bodies) body.filter.group = -1;
  return scene;
}

// Solver2D's: a disc of 8 m, 168 times as heavy as a link, at the end of thirty links of 1 m.
Scene ball_and_chain(std::uint64_t n, std::uint64_t) {
  constexpr double kRadius = 4;
  const double length = static_cast<double>(n), y = 0;
  const Material material{20, 0, 0.6};
  Scene scene = open_scene({-2 * length - 20, -2 * length - 20, 2 * length + 20, 1.5 * length + 20});
  const std::uint64_t anchor = add_ground(scene, {-0.5, 0}, 0.5, 0.5);
  const auto ids = add_links(scene, anchor, {-0.5, 0}, n, 1, CapsuleShape{{-0.5, 0}, {0.5, 0}, 0.125}, y, material);
  const std::uint64_t ball = add(scene, rigid(DiscShape{kRadius}, {length + kRadius, y}, material));
  pin(scene, ids.back(), ball, {0.5, 0}, {-kRadius, 0});
  for (BodyDesc& body : scene.bodies) body.filter.group = -1;
  return scene;
}

// Discs in a row, each on a rod; the first let fall. No losses.
Scene newtons_cradle(std::uint64_t n, std::uint64_t) {
  constexpr double kRadius = 0.5, kRod = 5;
  const Material ball{1, 1, 0};
  const double width = static_cast<double>(n);
  Scene scene = open_scene({-10, -10, width + 10, 10});
  const std::uint64_t beam = add_ground(scene, {width / 2, 0.25}, width / 2 + 1, 0.25);
  for (std::uint64_t k = 0; k < n; ++k) {
    // 1 um apart, so that the impacts are one after the other.
    const double x = (2 * kRadius + 1e-6) * static_cast<double>(k) + kRadius;
    Vec2 at{x, -kRod};
    if (k == 0) at = {x - 3, -4};  // on the same circle
    BodyDesc disc = rigid(DiscShape{kRadius}, at, ball);
    disc.fixed_rotation = true;
    const std::uint64_t id = add(scene, disc);
    SceneJoint rod;
    rod.a = beam;
    rod.b = id;
    rod.joint.type = JointType::distance;
    rod.joint.anchor_a = {x - width / 2, -0.25};
    rod.joint.length = kRod;
    scene.joints.push_back(rod);
  }
  return scene;
}

// One row of discs, the first of them fixed, let fall.
Scene rope(std::uint64_t n, std::uint64_t) {
  constexpr double kPitch = 0.5;
  const double length = kPitch * static_cast<double>(n);
  Scene scene = open_scene({-length - 10, -1.5 * length - 10, length + 10, 0.5 * length + 10});
  GroupDesc discs = lattice(n, {0, 0, length, kPitch}, 0.2, 0, kRigid);
  discs.links = LinkDesc{};
  discs.links->pin = Pin::left;
  scene.groups.push_back(std::move(discs));
  return scene;
}

// A square of discs, tied to their neighbours by rods, hung by its upper corners; a ball is thrown
// through the slack.
Scene cloth(std::uint64_t n, std::uint64_t) {
  constexpr double kPitch = 0.5;
  const std::uint64_t columns = ceil_sqrt(n);
  const Bounds region = block(n, columns, kPitch, 0, 0);
  const double side = region.xmax;
  Scene scene = open_scene({-side - 10, -2 * side - 20, 2 * side + 10, 2 * side + 20});
  BodyDesc ball = rigid(DiscShape{std::max(0.5, side / 15)}, {side / 2, 1.3 * side});
  ball.velocity = {0, -5};
  add(scene, ball);
  GroupDesc discs = lattice(n, region, 0.2, 0, kRigid);
  discs.links = LinkDesc{};
  discs.links->pin = Pin::corners;
  scene.groups.push_back(std::move(discs));
  return scene;
}

}  // namespace psim::builtin
