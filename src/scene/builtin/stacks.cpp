// Stacks: what stands up, and for how long. Figures of E. Catto's samples and benchmarks of Box2D 3
// and Solver2D where a scene says so.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "builtin/builtin.h"

namespace psim::builtin {
namespace {

const BoxShape kUnitBox{1, 1, 0};

// The least base of a pyramid of n.
std::uint64_t base_of(std::uint64_t n) {
  const double exact = (std::sqrt(8 * static_cast<double>(n) + 1) - 1) / 2;
  auto base = static_cast<std::uint64_t>(exact);
  while (base * (base + 1) / 2 < n) ++base;
  return std::max<std::uint64_t>(base, 1);
}

// The lowest n of a pyramid of unit boxes around x, row by row, on ground at y.
void put_pyramid(GroupDesc& boxes, std::uint64_t n, double x, double y) {
  const std::uint64_t base = base_of(n);
  std::uint64_t k = 0;
  for (std::uint64_t row = 0; row < base; ++row) {
    const double width = static_cast<double>(base - row);
    for (std::uint64_t j = 0; j < base - row && k < n; ++j, ++k) {
      put(boxes, x + static_cast<double>(j) + 0.5 - width / 2, y + static_cast<double>(row) + 0.5);
    }
  }
}

Scene pyramid_at(std::uint64_t n, Vec2 origin) {
  const double base = static_cast<double>(base_of(n));
  const double half = std::max(100.0, base);
  Scene scene = open_scene({origin.x - 1.5 * half, origin.y - 20, origin.x + 1.5 * half, origin.y + 2 * base + 30});
  add_ground(scene, {origin.x, origin.y - 1}, half, 1);
  GroupDesc boxes = list_of(kUnitBox);
  put_pyramid(boxes, n, origin.x, origin.y);
  scene.groups.push_back(std::move(boxes));
  return scene;
}

// Box2D's ground of the small samples: a segment.
void add_floor(Scene& scene, double half) {
  BodyDesc floor = rigid(SegmentShape{{-half, 0}, {half, 0}}, {0, 0});
  floor.type = BodyType::static_body;
  add(scene, floor);
  scene.body_names.back() = "ground";
}

}  // namespace

// Box2D's benchmark: base 100, 5,050 boxes.
Scene large_pyramid(std::uint64_t n, std::uint64_t) { return pyramid_at(n, {0, 0}); }

Scene pyramid(std::uint64_t n, std::uint64_t) { return pyramid_at(n, {0, 0}); }

// Solver2D's: a small pyramid far from the origin, in a world that reaches from one to the other.
Scene far_pyramid(std::uint64_t n, std::uint64_t) {
  const Vec2 origin{100'000, -80'000};
  Scene scene = pyramid_at(n, origin);
  Bounds& b = scene.world.bounds;
  b = {-1000, b.ymin, b.xmax, 1000};
  return scene;
}

// Box2D's benchmark: pyramids of base 10 (55 boxes) in 20 rows of 20, every row on a segment of its
// own: 22,000 boxes.
Scene many_pyramids(std::uint64_t n, std::uint64_t) {
  constexpr std::uint64_t kBoxes = 55, kColumns = 20;
  constexpr double kPitch = 11;  // m, of columns and rows
  const std::uint64_t pyramids = (n + kBoxes - 1) / kBoxes;
  const std::uint64_t rows = std::max<std::uint64_t>((pyramids + kColumns - 1) / kColumns, 1);
  const double width = kPitch * static_cast<double>(kColumns);
  const double height = kPitch * static_cast<double>(rows);
  Scene scene = open_scene({-width - 20, -20, width + 20, height + 20});
  for (std::uint64_t row = 0; row < rows; ++row) {
    BodyDesc floor = rigid(SegmentShape{{-width, 0}, {width, 0}}, {0, kPitch * static_cast<double>(row)});
    floor.type = BodyType::static_body;
    add(scene, floor);
  }
  GroupDesc boxes = list_of(kUnitBox);
  for (std::uint64_t k = 0; k < pyramids; ++k) {
    const double x = kPitch * (static_cast<double>(k % kColumns) + 0.5) - width / 2;
    const double y = kPitch * static_cast<double>(k / kColumns);
    put_pyramid(boxes, std::min(kBoxes, n - k * kBoxes), x, y);
  }
  scene.groups.push_back(std::move(boxes));
  return scene;
}

// Solver2D's vertical stack has 15: a centimetre to the left and right in turn.
Scene stack(std::uint64_t n, std::uint64_t) {
  const double height = static_cast<double>(n);
  const double half = std::max(40.0, height);
  Scene scene = open_scene({-half - 20, -20, half + 20, 2 * height + 20});
  add_floor(scene, half);
  GroupDesc boxes = list_of(kUnitBox);
  for (std::uint64_t k = 0; k < n; ++k) {
    put(boxes, k % 2 == 0 ? -0.01 : 0.01, 0.5 + static_cast<double>(k));
  }
  scene.groups.push_back(std::move(boxes));
  return scene;
}

// Solver2D's, Box2D's: three pyramids of base 10 whose tops, let fall, weigh 100, 200 and 300 times
// as much as a box.
Scene high_mass_ratio_1(std::uint64_t, std::uint64_t) {
  constexpr double kExtent = 1;
  Scene scene = open_scene({-90, -20, 90, 60});
  add_ground(scene, {0, -2}, 50, 2);
  for (int j = 0; j < 3; ++j) {
    const double offset = -20 * kExtent + 22 * kExtent * j;
    double y = kExtent;
    for (int count = 10; count > 0; --count, y += 2 * kExtent) {
      for (int i = 0; i < count; ++i) {
        const double x = 2 * kExtent * (i - 0.5 * count) + offset;
        BodyDesc box = rigid(BoxShape{2 * kExtent, 2 * kExtent, 0}, {x, count == 1 ? y + 2 : y});
        if (count == 1) box.material.density = (j + 1) * 100;
        add(scene, box);
      }
    }
  }
  return scene;
}

// A box of 20 m let fall on two of 1 m: 400 times their mass.
Scene high_mass_ratio_2(std::uint64_t, std::uint64_t) {
  Scene scene = open_scene({-80, -20, 80, 80});
  add_ground(scene, {0, -2}, 50, 2);
  add(scene, rigid(kUnitBox, {-9, 0.5}));
  add(scene, rigid(kUnitBox, {9, 0.5}));
  add(scene, rigid(BoxShape{20, 20, 0}, {0, 10 + 16}));
  return scene;
}

// The same on two triangles.
Scene high_mass_ratio_3(std::uint64_t, std::uint64_t) {
  Scene scene = open_scene({-80, -20, 80, 60});
  add_ground(scene, {0, -2}, 50, 2);
  const PolygonShape triangle{{{-0.5, 0}, {0.5, 0}, {0, 1}}, 0};
  add(scene, rigid(triangle, {-9, 0.5}));
  add(scene, rigid(triangle, {9, 0.5}));
  add(scene, rigid(BoxShape{20, 20, 0}, {0, 10 + 4}));
  return scene;
}

// A pyramid of base 4 whose boxes overlap by a quarter of their size.
Scene overlap_recovery(std::uint64_t, std::uint64_t) {
  constexpr int kBase = 4;
  constexpr double kShare = 0.75, kExtent = 0.5;
  Scene scene = open_scene({-50, -20, 50, 40});
  add_floor(scene, 40);
  GroupDesc boxes = list_of(kUnitBox);
  double y = kExtent;
  for (int i = 0; i < kBase; ++i, y += 2 * kShare * kExtent) {
    double x = kShare * kExtent * (i - kBase);
    for (int j = i; j < kBase; ++j, x += 2 * kShare * kExtent) put(boxes, x, y);
  }
  scene.groups.push_back(std::move(boxes));
  return scene;
}

// Box2D's: five storeys of cards 40 cm high and 2 mm thick, held by friction 0.7 alone.
Scene card_house(std::uint64_t, std::uint64_t) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  constexpr double kHeight = 0.2, kThickness = 0.001;  // half of each
  const Material material{1, 0, 0.7};
  Scene scene = open_scene({-60, -10, 60, 20});
  add_ground(scene, {0, -2}, 40, 2, material);
  const auto card = [&](double x, double y, double angle) {
    BodyDesc body = rigid(BoxShape{2 * kThickness, 2 * kHeight, 0}, {x, y}, material);
    body.angle = angle;
    add(scene, body);
  };
  double left = 0, y = kHeight - 0.02;
  for (int storey = 5; storey > 0; --storey, left += 0.175, y += 2 * kHeight - 0.03) {
    double x = left;
    for (int i = 0; i < storey; ++i) {
      if (i != storey - 1) card(x + 0.25, y + kHeight - 0.015, 90 * kDegree);
      card(x, y, -25 * kDegree);
      card(x + 0.175, y, 25 * kDegree);
      x += 0.35;
    }
  }
  return scene;
}

// Box2D's: seventeen stones along a catenary, with four beams on top.
Scene arch(std::uint64_t, std::uint64_t) {
  constexpr double kScale = 0.25;
  const std::array<Vec2, 9> inner = {{{16, 0},
                                      {14.93803712795643, 5.133601056842984},
                                      {13.79871746027416, 10.24928069555078},
                                      {12.56252963284711, 15.34107019122473},
                                      {11.20040987372525, 20.39856541571217},
                                      {9.66521217819836, 25.40369899225096},
                                      {7.87179930638133, 30.3179337000085},
                                      {5.635199558196225, 35.03820717801641},
                                      {2.405937953536585, 39.09554102558315}}};
  const std::array<Vec2, 9> outer = {{{24, 0},
                                      {22.33619528222415, 6.02299846205841},
                                      {20.54936888969905, 12.00964361211476},
                                      {18.60854610798073, 17.9470321677465},
                                      {16.46769273811807, 23.81367936585418},
                                      {14.05325025774858, 29.57079353071012},
                                      {11.23551045834022, 35.13775818285372},
                                      {7.752568160730571, 40.30450679009583},
                                      {3.016931552701656, 44.28891593799322}}};
  const auto at = [](Vec2 p, double side) { return Vec2{side * kScale * p.x, kScale * p.y}; };
  Scene scene = open_scene({-120, -20, 120, 40});
  add_floor(scene, 100);
  for (const double side : {1.0, -1.0}) {
    for (std::size_t k = 0; k + 1 < inner.size(); ++k) {
      std::vector<Vec2> stone = {at(inner[k], side), at(outer[k], side), at(outer[k + 1], side),
                                 at(inner[k + 1], side)};
      if (side < 0) std::reverse(stone.begin(), stone.end());
      add(scene, rigid(PolygonShape{stone, 0}, {0, 0}));
    }
  }
  const Vec2 low = inner.back(), high = outer.back();
  add(scene, rigid(PolygonShape{{at(low, 1), at(high, 1), at(high, -1), at(low, -1)}, 0}, {0, 0}));
  for (int k = 0; k < 4; ++k) {
    add(scene, rigid(BoxShape{4, 1, 0}, {0, 0.5 + kScale * high.y + k}));
  }
  return scene;
}

// Dominoes a metre high, 0.6 m apart; a disc rolls into the first.
Scene domino_run(std::uint64_t n, std::uint64_t) {
  constexpr double kPitch = 0.6;
  const double length = kPitch * static_cast<double>(n);
  Scene scene = open_scene({-30, -20, length + 30, 20});
  add_ground(scene, {length / 2, -0.5}, length / 2 + 20, 0.5);
  BodyDesc ball = rigid(DiscShape{0.5}, {-2, 0.5});
  ball.material.density = 2;
  ball.velocity = {4, 0};
  ball.angular_velocity = -8;
  add(scene, ball);
  GroupDesc dominoes = list_of(BoxShape{0.15, 1, 0});
  for (std::uint64_t k = 0; k < n; ++k) put(dominoes, kPitch * static_cast<double>(k), 0.5);
  scene.groups.push_back(std::move(dominoes));
  return scene;
}

}  // namespace psim::builtin
