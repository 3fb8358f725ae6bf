// Machines and impacts. Figures of E. Catto's benchmarks of Box2D 3 and Solver2D where a scene says
// so.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/rotor.h"
#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

constexpr double kDrumSpeed = 25 * std::numbers::pi / 180;  // rad/s
constexpr Vec2 kDrumCentre{0, 10};

void add_drum(Scene& scene, CompoundShape drum) {
  BodyDesc body = rigid(std::move(drum), kDrumCentre);
  body.type = BodyType::kinematic_body;
  body.angular_velocity = kDrumSpeed;
  add(scene, body);
  scene.body_names.back() = "drum";
}

// A piece of a ring between two radii and two angles. In whole micrometres: a cosine that is 0 but for rounding would make
// for products too small for floats.
PolygonShape ring_stone(double inner, double outer, double from, double to) {
  const auto corner = [](double radius, double angle) {
    const SineCosine at = sine_cosine(angle);
    return Vec2{std::nearbyint(1e6 * radius * at.cosine) / 1e6, std::nearbyint(1e6 * radius * at.sine) / 1e6};
  };
  return {{corner(inner, from), corner(outer, from), corner(outer, to), corner(inner, to)}, 0};
}

// n boxes in rows of at most `columns`, from the corner (x, y) up.
GroupDesc block_of_boxes(std::uint64_t n, std::uint64_t columns, double side, double pitch, Vec2 at) {
  GroupDesc boxes = list_of(BoxShape{side, side, 0});
  for (std::uint64_t k = 0; k < n; ++k) {
    put(boxes, at.x + pitch * static_cast<double>(k % columns), at.y + pitch * static_cast<double>(k / columns));
  }
  return boxes;
}

// The largest square of boxes that begins in the drum.
constexpr std::uint64_t drum_columns(std::uint64_t n, std::uint64_t most) {
  std::uint64_t columns = 1;
  while (columns < most && columns * columns < n) ++columns;
  return columns;
}

}  // namespace

// Box2D's benchmark: a square drum of 20 m, turning at 25 degrees/s, and 45 x 45 boxes of 0.25 m.
Scene tumbler(std::uint64_t n, std::uint64_t) {
  Scene scene = open_scene({-40, -30, 40, 50});
  CompoundShape drum;
  for (const double side : {10.0, -10.0}) {
    drum.parts.push_back(part_of(BoxShape{1, 20, 0}, {side, 0}));
    drum.parts.push_back(part_of(BoxShape{20, 1, 0}, {0, side}));
  }
  add_drum(scene, std::move(drum));
  const std::uint64_t columns = drum_columns(n, 45);
  const double corner = -0.2 * static_cast<double>(columns);
  scene.groups.push_back(block_of_boxes(n, columns, 0.25, 0.4, {corner, corner + 10}));
  return scene;
}

// Box2D's benchmark: a round drum of 36 stones between 16 and 18 m, which overlap their neighbours by
// 2 degrees, with four paddles, turning at 25 degrees/s, and 90 x 90 boxes of 0.2 m.
Scene washer(std::uint64_t n, std::uint64_t) {
  constexpr int kStones = 36;
  constexpr double kPaddle = 14, kInner = 16, kOuter = 18;
  constexpr double kPitch = 2 * std::numbers::pi / kStones;
  Scene scene = open_scene({-60, -50, 60, 70});
  CompoundShape drum;
  for (int k = 0; k < kStones; ++k) {
    const double from = k * kPitch, to = (k + 1) * kPitch;
    drum.parts.push_back(part_of(ring_stone(kInner, kOuter, from - 0.1 * kPitch, to + 0.1 * kPitch)));
    if (k % 9 == 0) drum.parts.push_back(part_of(ring_stone(kPaddle, kInner, from, to)));
  }
  add_drum(scene, std::move(drum));
  const std::uint64_t columns = drum_columns(n, 90);
  const double corner = -0.11 * static_cast<double>(columns);
  scene.groups.push_back(block_of_boxes(n, columns, 0.2, 0.21, {corner, corner + 10}));
  return scene;
}

// Box2D's benchmark: a bar of 40 m driven round in a ring of 40 m radius, through capsules, discs and
// boxes in turn, which overlap at the start as they do there.
Scene spinner(std::uint64_t n, std::uint64_t) {
  constexpr int kPoints = 360;
  constexpr double kRing = 40;
  const Vec2 middle{0, 32};
  Scene scene = open_scene({-60, -30, 60, 90});
  ChainShape ring;
  ring.loop = true;
  for (int k = 0; k < kPoints; ++k) {
    const SineCosine at = sine_cosine(2 * std::numbers::pi * k / kPoints);
    ring.vertices.push_back({kRing * at.cosine, kRing * at.sine});
  }
  BodyDesc ground = rigid(ring, middle, {1, 0, 0.1});
  ground.type = BodyType::static_body;
  const std::uint64_t ring_id = add(scene, ground);
  const Vec2 hub{0, 12};
  const std::uint64_t bar = add(scene, rigid(BoxShape{0.8, 40, 0.2}, hub, {1, 0, 0}));
  JointDesc& motor = pin(scene, ring_id, bar, {hub.x - middle.x, hub.y - middle.y}, {0, 0});
  motor.motor_speed = 5;
  motor.motor_limit = 40'000;

  const Material light{0.25, 0.1, 0.1};
  const Shape shapes[3] = {CapsuleShape{{-0.25, 0}, {0.25, 0}, 0.25}, DiscShape{0.35}, BoxShape{0.7, 0.7, 0}};
  double x = -23, y = 2;
  for (std::uint64_t k = 0; k < n; ++k) {
    add(scene, rigid(shapes[k % 3], {x, y}, light));
    x += 0.5;
    if (x >= 23) {
      x = -23;
      y += 0.5;
    }
  }
  scene.world.bounds.ymax = std::max(90.0, y + 20);
  return scene;
}

// Box2D's benchmark: a block of 8 m and eightfold density hits a wall of 120 x 80 boxes of 0.4 m at 40
// m/s, without gravity.
Scene smash(std::uint64_t n, std::uint64_t) {
  constexpr double kSide = 0.4;
  const std::uint64_t rows = std::clamp<std::uint64_t>(ceil_sqrt((2 * n + 2) / 3), 1, n);
  Scene scene = open_scene({-300, -300, 600, 300});
  scene.world.gravity = {0, 0};
  BodyDesc block = rigid(BoxShape{8, 8, 0}, {-20, 0}, {8, 0, 0.6});
  block.velocity = {40, 0};
  add(scene, block);
  GroupDesc boxes = list_of(BoxShape{kSide, kSide, 0});
  for (std::uint64_t k = 0; k < n; ++k) {
    put(boxes, kSide * static_cast<double>(k / rows) + 30,
        kSide * (static_cast<double>(k % rows) - static_cast<double>(rows) / 2));
  }
  scene.groups.push_back(std::move(boxes));
  return scene;
}

// After Solver2D's: discs on a spiral all drawn with the same force to a fixed one in the middle.
Scene rush(std::uint64_t n, std::uint64_t) {
  Scene scene = open_scene({-100, -100, 100, 100});
  scene.world.gravity = {0, 0};
  scene.world.fields.emplace_back(WellField{{0, 0}, 10, 0.1, 0, 0});
  BodyDesc middle = rigid(DiscShape{0.5}, {0, 0});
  middle.type = BodyType::static_body;
  add(scene, middle);
  GroupDesc discs = list_of(DiscShape{0.5});
  double distance = 5, angle = 0;
  for (std::uint64_t k = 0; k < n; ++k) {
    const SineCosine at = sine_cosine(angle);
    put(discs, distance * at.cosine, distance * at.sine);
    // Each just clear of the last, and of the turn before.
    angle += 1.05 / distance;
    distance += 1.05 * 1.05 / (2 * std::numbers::pi * distance);
  }
  const double reach = std::ceil(2 * distance + 10);
  scene.world.bounds = {-reach, -reach, reach, reach};
  scene.groups.push_back(std::move(discs));
  return scene;
}

// Fifty boxes of 4 m fall into a bed of small discs.
Scene boxes_into_discs(std::uint64_t n, std::uint64_t) {
  constexpr double kRadius = 0.25, kPitch = 0.51, kBox = 4;
  constexpr std::uint64_t kBoxes = 50, kAcross = 10;
  const std::uint64_t columns =
      std::max<std::uint64_t>(ceil_sqrt(4 * n), static_cast<std::uint64_t>(kAcross * 6 / kPitch));
  const Bounds bed = block(n, columns, kPitch, 0, 0);
  const double width = std::max(bed.xmax, 6.0 * static_cast<double>(kAcross));
  Scene scene;
  scene.world.gravity = {0, -10};
  scene.world.wall = kRigid;
  scene.world.bounds = {0, 0, width, bed.ymax + 60};
  GroupDesc boxes = list_of(BoxShape{kBox, kBox, 0});
  for (std::uint64_t k = 0; k < kBoxes; ++k) {
    put(boxes, width * (static_cast<double>(k % kAcross) + 0.5) / static_cast<double>(kAcross),
        bed.ymax + 5 + 6 * static_cast<double>(k / kAcross));
  }
  boxes.body.angle = 0.3;
  scene.groups.push_back(std::move(boxes));
  scene.groups.push_back(lattice(n, bed, kRadius, 0.5, kRigid));
  return scene;
}

}  // namespace psim::builtin
