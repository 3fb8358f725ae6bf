// Floors of several pieces are as one piece: what lands flat stays flat, and nobody is pressed through.
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr double kPiece = 0.7, kHalf = 12.6;  // m: the length of a piece, half the floor

enum class Floor { segment, segments, chain, boxes, triangles, kinematic_chain, kinematic_boxes };
constexpr std::pair<const char*, Floor> kFloors[] = {{"segment", Floor::segment},
                                                     {"segments", Floor::segments},
                                                     {"chain", Floor::chain},
                                                     {"boxes", Floor::boxes},
                                                     {"triangles", Floor::triangles},
                                                     {"kinematic_chain", Floor::kinematic_chain},
                                                     {"kinematic_boxes", Floor::kinematic_boxes}};

// A floor along y = 0.
void add_floor(World& world, Floor floor, Material m) {
  if (floor == Floor::segment) {
    add(world, segment({-kHalf, 0}, {kHalf, 0}, m));
    return;
  }
  std::vector<Vec2> vertices;
  for (double x = -kHalf; x < kHalf + 0.5 * kPiece; x += kPiece) vertices.push_back({x, 0});
  const BodyDesc line = chain(vertices, false, m);
  if (floor == Floor::chain) add(world, line);
  if (floor == Floor::kinematic_chain) add(world, kinematic(line));
  for (std::size_t k = 0; k + 1 < vertices.size(); ++k) {
    const Vec2 p = vertices[k], q = vertices[k + 1], middle{0.5 * (p.x + q.x), -0.5};
    const BodyDesc tile = box(middle, kPiece, 1, m);
    if (floor == Floor::segments) add(world, segment(p, q, m));
    if (floor == Floor::boxes) add(world, fixed(tile));
    if (floor == Floor::kinematic_boxes) add(world, kinematic(tile));
    if (floor == Floor::triangles) add(world, fixed(polygon({p, {middle.x, -1}, q}, {0, 0}, m)));
  }
}

class Floors : public testing::TestWithParam<std::pair<const char*, Floor>> {};

TEST_P(Floors, WhatLandsFlatStaysFlat) {
  for (const double speed : {1.0, 5.0, 20.0, 60.0}) {
    for (const double e : {0.0, 0.5}) {
      for (const double width : {1.0, 2.0, 8.0}) {
        const Material m = material(e, 0.3);
        std::unique_ptr<World> worlds[2] = {make(unbounded(100)), make(unbounded(100))};
        BodyId id[2];
        for (int k = 0; k < 2; ++k) {
          add_floor(*worlds[k], k == 0 ? Floor::segment : GetParam().second, m);
          BodyDesc falling = box({0.123, 0.3}, width, 0.5, m);
          falling.velocity = {0, -speed};
          id[k] = add(*worlds[k], falling);
        }
        for (int frame = 0; frame < 90; ++frame) {
          for (const auto& world : worlds) world->step();
          const BodyState one = state(*worlds[0], id[0]), many = state(*worlds[1], id[1]);
          ASSERT_NEAR(many.angle, 0, 2e-4) << speed << " m/s, e " << e << ", width " << width << ", frame " << frame;
          ASSERT_NEAR(many.y, one.y, 2e-3) << speed << " m/s, e " << e << ", width " << width << ", frame " << frame;
        }
      }
    }
  }
}

// A plate falls on a row of bodies in a box without a lid.
TEST_P(Floors, APlatePressesNobodyThrough) {
  Random random(7);
  for (int round = 0; round < 24; ++round) {
    const Material m = material(random.chance(0.5) ? 0 : random.uniform(0, 1), random.uniform(0, 0.6));
    auto world = make(unbounded(8000));
    add_floor(*world, GetParam().second, m);
    for (const double side : {-1.0, 1.0}) add(*world, segment({side * 10, -1}, {side * 10, 4000}, m));
    std::vector<BodyId> row;
    const double speed = std::exp(random.uniform(0, 7)), size = random.uniform(0.2, 0.4);
    const bool round_ones = random.chance(0.6);
    for (double x = -6; x < 6.5; x += 1) {
      const Material light = material(m.restitution, m.friction, 0.25);
      const BodyDesc small =
          round_ones ? disc({x, size + 0.01}, {}, size, light) : box({x, size + 0.01}, 2 * size, 2 * size, light);
      row.push_back(add(*world, small));
    }
    BodyDesc plate = box({0, 2.5}, 16, 0.8, m);
    plate.mass = random.chance(0.5) ? 25 : 2500;
    plate.velocity = {0, -speed};
    row.push_back(add(*world, plate));
    for (int frame = 0; frame < 120; ++frame) {
      world->step();
      for (const BodyId id : row) {
        const BodyState s = state(*world, id);
        ASSERT_GT(s.y, 0) << "round " << round << ", frame " << frame << ", " << speed << " m/s, at " << s.x;
      }
    }
  }
}

// A kinematic piston comes down on them to 0.6 of their size, and stays.
TEST_P(Floors, APistonPressesNobodyThrough) {
  for (const double speed : {0.5, 5.0, 50.0}) {
    for (const bool round_ones : {false, true}) {
      auto world = make(unbounded(400));
      const Material m = material(0, 0.3);
      add_floor(*world, GetParam().second, m);
      for (const double side : {-1.0, 1.0}) add(*world, segment({side * 10, -1}, {side * 10, 200}, m));
      std::vector<BodyId> row;
      for (double x = -6; x < 6.5; x += 1.5) {
        row.push_back(add(*world, round_ones ? disc({x, 0.41}, {}, 0.4, m) : box({x, 0.41}, 0.8, 0.8, m)));
      }
      double y = 2;
      BodyDesc piston = kinematic(box({0, y + 0.5}, 16, 1, m));
      piston.velocity = {0, -speed};
      const BodyId id = add(*world, piston);
      for (int frame = 0; frame < 200; ++frame) {
        const double step = std::fmin(speed / 60, y - 0.48);
        world->set_velocity(id, {0, -60 * step}, 0);
        y -= step;
        world->step();
        for (const BodyId body : row) {
          const BodyState s = state(*world, body);
          ASSERT_GT(s.y, 0) << "frame " << frame << ", " << speed << " m/s, at " << s.x;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Floors, testing::ValuesIn(kFloors), [](const auto& info) { return info.param.first; });

}  // namespace
}  // namespace psim::test
