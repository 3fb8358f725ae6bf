// A row of light bodies between a heavy one and fixed ground carries it as the ground itself would.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "joint_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr int kSubsteps[] = {1, 4, 16};

/// Light discs and boxes of one height in a row on level ground, and a plate that falls on all of them. Its weight lies
/// between the first and the last.
struct Row {
  Placed placed;                      // the plate is the last body
  double height = 0, span = 0;        // m: of the light bodies, and from the first to the last
  double plate_height = 0, mass = 0;  // m, kg
  double speed = 0;                   // m/s, at which the plate arrives
  double rounding = 0;                // m/s: to which a light body comes by an impact with a normal that is off by 1e-6
  std::ostringstream text;

  /// `mixed`: some of the row are fixed or hardly lighter than the plate, and another body lies on the plate.
  Row(Random& random, int substeps, bool mixed) {
    WorldDesc desc = unbounded(100);
    desc.substeps = substeps;
    placed.world = make(desc);
    const Material m = material(0, random.chance(0.5) ? 0.0 : 0.4);
    height = random.uniform(0.3, 0.9);
    const int n = 3 + static_cast<int>(random.below(12));
    const double ratio = std::pow(10, random.uniform(2, 5)), light = random.uniform(0.05, 2);
    const double step = height * random.uniform(1.02, 1.7), boxes = random.uniform(-0.5, 1.5);
    mass = ratio * light;
    span = (n - 1) * step;
    text << n << " bodies, mass ratio " << ratio << ", substeps " << substeps << ", friction " << m.friction;
    put_ground(m, random);
    for (int k = 0; k < n; ++k) {
      const Vec2 at{k * step - span / 2, height / 2};
      BodyDesc body = random.chance(boxes) ? box(at, height, height, m) : disc(at, {}, height / 2, m);
      body.mass = light;
      if (mixed && random.chance(0.25)) {
        body = fixed(box(at, height, height, m));
      } else if (mixed && random.chance(0.3)) {
        body = box(at, height, height, m, mass * random.uniform(0.1, 1));
      }
      placed.put(body);
    }
    plate_height = random.uniform(0.2, 1.0);
    speed = random.chance(0.2) ? 0.0 : std::pow(10, random.uniform(0, 2.3));
    const double gap = random.uniform(0, 1.5), off = random.uniform(-0.35, 0.35) * span;
    if (mixed && random.chance(0.7)) {
      const double size = random.uniform(0.3, 2), x = random.uniform(-0.4, 0.4) * span;
      const Vec2 at{x, height + gap + plate_height + size / 2};
      placed.put(moving(box(at, size, size, m, mass * random.uniform(0.1, 3)), {0, -speed}));
    }
    const Vec2 at{off, height + gap + plate_height / 2};
    placed.put(moving(box(at, 2 * span + 4 * height, plate_height, m, mass), {0, -speed}));
    speed = std::sqrt(speed * speed + 2 * kG * gap);
    rounding = 1e-6 * ratio * speed / n;
    text << ", speed " << speed;
  }

  void put_ground(Material m, Random& random) {
    World& world = *placed.world;
    const std::size_t kind = random.below(4);
    text << ", ground " << kind;
    if (kind == 0) add(world, ground(m, 50));
    if (kind == 1) {
      std::vector<Vec2> vertices{{-50, 0}};
      while (vertices.back().x < 40) vertices.push_back({vertices.back().x + random.uniform(0.4, 3), 0});
      add(world, chain(vertices, false, m));
    }
    if (kind == 2) add(world, fixed(box({0, -0.5}, 100, 1, m)));
    if (kind == 3) add(world, kinematic(box({0, -0.5}, 100, 1, m)));
  }

  /// m: how deep the plate is in the place of the row.
  double sunk() const {
    const BodyState plate = placed.top();
    return height + plate_height / 2 - plate.y + std::abs(std::sin(plate.angle)) * span / 2;
  }
};

/// What happened to the plate of a row, in 1.5 s.
struct Landing {
  int frame = 0;               // in which it came to the row; 0: never
  double sunk = 0, speed = 0;  // m; m/s, from the second frame after that one on: the largest
  explicit Landing(Row& row) {
    for (int k = 1; k <= 90; ++k) {
      if (row.placed.world->step().escaped != 0) {
        sunk = kInf;
        return;
      }
      sunk = std::max(sunk, row.sunk());
      if (frame == 0 && row.sunk() > -0.01 * row.height) frame = k;
      if (frame != 0 && k >= frame + 2) speed = std::max(speed, speed_of(row.placed.top()));
    }
  }
};

TEST(Squeezed, ARowOfLightBodiesCarriesAHeavyOneAsTheGroundDoes) {
  Random random(20261126);
  for (int k = 0; k < 30; ++k) {
    Row row(random, kSubsteps[k % 3], false);
    const Landing landing(row);
    SCOPED_TRACE(std::to_string(k) + ": " + row.text.str());
    EXPECT_NE(landing.frame, 0);
    EXPECT_LT(landing.sunk, 0.01 * row.height);
    EXPECT_LT(landing.speed, 0.005 * row.speed + 0.01);
    EXPECT_LT(row.placed.sideways(), 0.25 * row.height + 1.5 * row.rounding);
  }
}

TEST(Squeezed, WhatElseTheHeavyBodyTouchesTakesItsShare) {
  Random random(20261126);
  for (int k = 0; k < 30; ++k) {
    Row row(random, kSubsteps[k % 3], true);
    const Landing landing(row);
    SCOPED_TRACE(std::to_string(k) + ": " + row.text.str());
    EXPECT_LT(landing.sunk, 0.02 * row.height);
    EXPECT_LT(landing.speed, 0.02 * row.speed + 0.1);
  }
}

TEST(Squeezed, HasTheSameBitsForEveryIsaAndThreadCount) {
  std::uint64_t hash = 0;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = make(unbounded(100), isa, threads);
      add(*world, ground(kGrip));
      for (int k = 0; k < 8; ++k) add(*world, disc({k - 3.5, 0.35}, {}, 0.35, kGrip));
      for (int k = 0; k < 2; ++k) add(*world, box({9.0 * k - 4.5, 0.35}, 0.7, 0.7, kGrip));
      add(*world, moving(box({0.3, 1.5}, 14, 0.8, kGrip, 3000), {0.5, -20}));
      add(*world, moving(disc({1, 5}, {}, 1, material(0.3)), {0, -5}));
      for (int k = 0; k < 60; ++k) world->step();
      if (hash == 0) hash = world->state_hash();
      EXPECT_EQ(world->state_hash(), hash) << threads;
    }
  }
}

// A light body overlaps two heavy ones and moves towards one of them. What holds it to the other one must not push the
// heavy bodies apart: they would have many times as much energy as the light one had.
TEST(Squeezed, ALightBodyThatBouncesBetweenHeavyOnesGainsNoEnergy) {
  for (const int substeps : kSubsteps) {
    for (const double e : {0.3, 0.9, 1.0}) {
      for (const double mass : {10., 100., 1e3}) {
        for (const bool boxes : {false, true}) {
          WorldDesc desc = unbounded(100, {});
          desc.substeps = substeps;
          Placed p{make(desc), {}, {}};
          const auto put = [&](double x, double speed, double m) {
            BodyDesc body = boxes ? box({x, 0}, 1, 1, material(e)) : disc({x, 0}, {}, 0.5, material(e));
            body.velocity = {speed, 0};
            body.mass = m;
            p.put(body);
          };
          put(-0.97, 0, mass);
          put(0, -5, 1);
          put(0.97, 0, mass);
          const double before = energy(*p.world);
          double most = 0;
          for (int frame = 0; frame < 60; ++frame) {
            p.world->step();
            most = std::max(most, energy(*p.world));
          }
          EXPECT_LT(most, 1.001 * before)
              << substeps << " substeps, e " << e << ", mass " << mass << ", boxes " << boxes;
        }
      }
    }
  }
}

// Bodies of which some are a hundred times as heavy fall on discs and bumps, in whose nooks the light ones are wedged.
// Rows that contradicted each other there had impulses without bounds, and the next step threw everything apart, with up to
// 170,000 times the energy. The joints of such heaps may still add some hundredths: 0.058 in one of these.
TEST(Squeezed, HeapsOfBodiesThatBounceStayTogether) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    Random random(seed);
    WorldDesc desc = walled({0, 0, 16, 200});
    desc.substeps = seed % 2 == 0 ? 1 : 4;
    Placed p{make(desc), {}, {}};
    add(*p.world, segment({0.2, 0.4}, {15.8, 0.4}));
    for (int k = 0; k < 4; ++k) add(*p.world, static_disc({1 + 4.0 * k, 1}, 0.6));
    std::vector<Vec2> bumps;
    for (double x = 15.8; x > 0; x -= 0.7) bumps.push_back({x, 0.3 + random.uniform(0, 0.3)});
    add(*p.world, chain(bumps));
    for (int k = 0; k < 140; ++k) {
      const Vec2 at{0.6 + 1.59 * (k % 9), 2.6 + 1.59 * (k / 9)};
      const Material stuff = material(0.3, 0, random.chance(0.05) ? 100 : 1);
      BodyDesc body = random.chance(0.4) ? disc(at, {}, 0.5, stuff) : box(at, 0.63, 0.63, stuff);
      if (random.chance(0.2)) body = box(at, 0.54, 0.36, stuff), body.fixed_rotation = true;
      body.velocity = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
      p.put(body);
      if (k % 9 == 0 || !random.chance(0.1)) continue;
      std::string error;
      p.world->add_joint(between(JointType::distance, p.ids[p.ids.size() - 2], p.ids.back()), error);
      ASSERT_EQ(error, "");
    }
    const double before = energy(*p.world);
    double most = 0;
    for (int frame = 0; frame < 250; ++frame) {
      p.world->step();
      most = std::max(most, energy(*p.world));
    }
    EXPECT_LT(most, 1.2 * before) << "seed " << seed;
  }
}

}  // namespace
}  // namespace psim::test
