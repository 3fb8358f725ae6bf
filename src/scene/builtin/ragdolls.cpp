// Ragdolls raining on shelves: Box2D's benchmark `rain`, with its figures of a person. There they come
// group by group while it runs; here all hang in the air at the start.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

struct Bone {
  std::size_t parent;
  double y;         // of its origin, when the person stands at y = 0
  double from, to;  // of the capsule's line, upright, about the origin
  double radius;
  double pivot;  // y of the joint with the parent
  double lower, upper;
};

// Parents come first.
constexpr std::array<Bone, 11> kBones = {{
    {0, 0.95, -0.02, 0.02, 0.095, 0, 0, 0},                                                      // hip
    {0, 1.2, -0.135, 0.135, 0.09, 1, -0.25 * std::numbers::pi, 0},                               // torso
    {1, 1.475, -0.038, 0.039, 0.08, 1.4, -0.3 * std::numbers::pi, 0.1 * std::numbers::pi},       // head
    {0, 0.775, -0.125, 0.125, 0.06, 0.9, -0.05 * std::numbers::pi, 0.4 * std::numbers::pi},      // upper left leg
    {3, 0.475, -0.155, 0.125, 0.045, 0.625, -0.5 * std::numbers::pi, -0.02 * std::numbers::pi},  // lower left leg
    {0, 0.775, -0.125, 0.125, 0.06, 0.9, -0.05 * std::numbers::pi, 0.4 * std::numbers::pi},      // upper right leg
    {5, 0.475, -0.155, 0.125, 0.045, 0.625, -0.5 * std::numbers::pi, -0.02 * std::numbers::pi},  // lower right leg
    {1, 1.225, -0.125, 0.125, 0.035, 1.35, -0.1 * std::numbers::pi, 0.8 * std::numbers::pi},     // upper left arm
    {7, 0.975, -0.125, 0.125, 0.03, 1.1, -0.2 * std::numbers::pi, 0.3 * std::numbers::pi},       // lower left arm
    {1, 1.225, -0.125, 0.125, 0.035, 1.35, -0.1 * std::numbers::pi, 0.8 * std::numbers::pi},     // upper right arm
    {9, 0.975, -0.125, 0.125, 0.03, 1.1, -0.2 * std::numbers::pi, 0.3 * std::numbers::pi},       // lower right arm
}};

// The first `bones` of a person; the parts of one do not meet.
void add_person(Scene& scene, Vec2 at, std::size_t bones, std::int32_t number) {
  constexpr double kTorque = 0.03;  // N m, of friction in a joint
  const std::uint64_t first = scene.bodies.size();
  for (std::size_t k = 0; k < bones; ++k) {
    const Bone& bone = kBones[k];
    BodyDesc body = rigid(CapsuleShape{{0, bone.from}, {0, bone.to}, bone.radius}, {at.x, at.y + bone.y}, {1, 0, 0.2});
    body.filter.group = -number;
    add(scene, body);
    if (k == 0) continue;
    JointDesc& joint =
        pin(scene, first + bone.parent, first + k, {0, bone.pivot - kBones[bone.parent].y}, {0, bone.pivot - bone.y});
    joint.lower = bone.lower;
    joint.upper = bone.upper;
    joint.motor_limit = kTorque;
  }
}

}  // namespace

// Shelves of 501 boxes of 0.5 m, 45 m above each other; over each 40 groups of five persons.
Scene rain(std::uint64_t n, std::uint64_t) {
  constexpr std::uint64_t kParts = kBones.size(), kGroup = 5, kColumns = 40, kTiles = 501;
  constexpr double kShelf = 45, kTile = 0.5;
  const std::uint64_t persons = (n + kParts - 1) / kParts;
  const std::uint64_t a_row = kGroup * kColumns;
  const std::uint64_t rows = std::max<std::uint64_t>((persons + a_row - 1) / a_row, 1);
  const double width = kTile * static_cast<double>(kTiles - 1);
  Scene scene = open_scene({-width, -30, width, kShelf * static_cast<double>(rows) + 30});
  const double pitch = width / static_cast<double>(kColumns);
  for (std::uint64_t k = 0; k < persons; ++k) {
    const std::uint64_t row = k / a_row, column = k / kGroup % kColumns, place = k % kGroup;
    const double x = pitch * (static_cast<double>(column) + 0.5) - width / 2 + 0.75 * (static_cast<double>(place) - 2);
    const double y = kShelf * static_cast<double>(row) + 10 + 2 * static_cast<double>(place);
    const std::uint64_t bones = std::min(kParts, n - k * kParts);
    add_person(scene, {x, y}, static_cast<std::size_t>(bones), static_cast<std::int32_t>(k + 1));
  }
  GroupDesc tiles = list_of(BoxShape{kTile, kTile, 0});
  tiles.body.type = BodyType::static_body;
  for (std::uint64_t row = 0; row < rows; ++row) {
    for (std::uint64_t k = 0; k < kTiles; ++k) {
      put(tiles, kTile * static_cast<double>(k) - width / 2, kShelf * static_cast<double>(row));
    }
  }
  scene.groups.push_back(std::move(tiles));
  return scene;
}

}  // namespace psim::builtin
