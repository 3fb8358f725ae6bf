// Moving a whole scene by whole lattice cells changes no bit of what happens in it.
#include "support.h"

namespace psim::test {
namespace {

/// Coordinates on a lattice of 2^-10 m, which is whole in the world's own.
double on_lattice(double v) { return std::round(v * 1024) / 1024; }

std::unique_ptr<World> scene_at(double x, double y, Isa isa, int threads, WorldDesc desc) {
  auto world = make(desc, isa, threads);
  BodyDesc floor = ground(material(0.2, 0.3), 30);
  floor.position = {x, y};
  add(*world, floor);
  add(*world, static_disc({x - 4, y + 1}, 1, material(0.2, 0.3)));
  for (int i = 0; i < 100; ++i) {
    add(*world, disc({x + on_lattice((i % 10) * 1.03 + 0.01 * i), y + on_lattice(0.6 + (i / 10) * 1.05)},
                     {on_lattice(0.1 * (i % 7)), 0}, 0.5, material(0.2, 0.3)));
  }
  return world;
}

void expect_same(World& a, World& b, double dx, double dy) {
  const PublishedState s = a.published(), t = b.published();
  ASSERT_EQ(s.id.size(), t.id.size());
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    ASSERT_EQ(s.x[k] + dx, t.x[k]) << k;
    ASSERT_EQ(s.y[k] + dy, t.y[k]) << k;
    ASSERT_EQ(s.vx[k], t.vx[k]) << k;
    ASSERT_EQ(s.vy[k], t.vy[k]) << k;
    ASSERT_EQ(s.omega[k], t.omega[k]) << k;
    ASSERT_EQ(s.angle[k], t.angle[k]) << k;
  }
}

TEST(Translation, MovesTheSceneBitForBit) {
  WorldDesc desc = unbounded(1024);
  for (const Isa isa : available_isas()) {
    for (const Vec2 shift : {Vec2{768, -512}, Vec2{-700.5, 900.25}, Vec2{1.0 / 1024, 0}}) {
      SCOPED_TRACE(testing::Message() << isa_name(isa) << " " << shift.x << " " << shift.y);
      auto here = scene_at(0, 0, isa, 1, desc);
      auto there = scene_at(shift.x, shift.y, isa, 2, desc);
      for (int k = 0; k < 10; ++k) {
        run(*here, 30);
        run(*there, 30);
        expect_same(*here, *there, shift.x, shift.y);
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(Translation, OfAGasToo) {
  WorldDesc desc = unbounded(1024, {0, 0});
  const auto build = [&](double x, double y) {
    auto world = make(desc);
    Random random(12);
    for (int i = 0; i < 200; ++i) {
      const Vec2 velocity{on_lattice(random.uniform(-2, 2)), on_lattice(random.uniform(-2, 2))};
      add(*world, disc({x + on_lattice((i % 15) * 1.3 + random.uniform(0, 0.2)),
                        y + on_lattice((i / 15) * 1.3 + random.uniform(0, 0.2))},
                       velocity, 0.5, material(1)));
    }
    return world;
  };
  auto here = build(0, 0);
  auto there = build(-500, 800);
  run(*here, 120);
  run(*there, 120);
  expect_same(*here, *there, -500, 800);
}

}  // namespace
}  // namespace psim::test
