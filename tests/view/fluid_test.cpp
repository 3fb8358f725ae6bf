// Fluids in the viewer without its window: what is told of them, kept, carried over and drawn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "model/fluid_drawing.h"
#include "model/history.h"
#include "small_scene.h"

namespace psim::view {
namespace {

using cli::FluidColouring;
using cli::FluidStyle;

// Two pools, of 200 and of 50 particles.
Scene wet_scene() {
  Scene scene = small_scene();
  scene.fluids.resize(2);
  scene.fluids[0] = {{0.5}, Bounds{-20, -10, -15, 0}, {}};
  scene.fluids[1] = {{0.5}, Bounds{0, 5, 2.5, 10}, {3, 0}};
  return scene;
}

TEST(ViewFluid, IsToldWhereThereIsSome) {
  Simulation dry = make_simulation();
  EXPECT_EQ(told(dry).fluids, nullptr);
  Simulation simulation(wet_scene(), best_isa(), 1);
  const Status before = told(simulation);
  ASSERT_NE(before.fluids, nullptr);
  EXPECT_EQ(before.fluids->particles, 250u);
  ASSERT_EQ(before.fluids->fluids.size(), 2u);
  EXPECT_EQ(before.fluids->fluids[1].place.size(), 50u);
  EXPECT_EQ(before.fluids->fluids[1].velocity[7].x, 3);
  EXPECT_EQ(told(simulation).fluids, before.fluids) << "the same until a step";
  simulation.step();
  const Status after = told(simulation);
  EXPECT_NE(after.fluids, before.fluids);
  EXPECT_GT(after.fluids->fluids[1].place[0].x, before.fluids->fluids[1].place[0].x);
}

TEST(ViewFluid, GoesOnInANewWorld) {
  Simulation simulation(wet_scene(), best_isa(), 1);
  for (int k = 0; k < 10; ++k) simulation.step();
  const FluidPlaces before = told(simulation).fluids;
  Settings settings = told(simulation).settings;
  settings.substeps = 8;
  simulation.set_settings(settings);
  const FluidPlaces after = told(simulation).fluids;
  ASSERT_EQ(after->particles, before->particles);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t row = 0; row < before->fluids[k].place.size(); ++row) {
      EXPECT_NEAR(after->fluids[k].place[row].y, before->fluids[k].place[row].y, 1e-5);
      EXPECT_NEAR(after->fluids[k].velocity[row].y, before->fluids[k].velocity[row].y, 1e-5);
    }
  }
  simulation.restart();
  EXPECT_NEAR(told(simulation).fluids->fluids[1].place[0].y, 5.25, 1e-5);
}

TEST(ViewFluid, FramesToLookBackAtHaveThem) {
  History history;
  const auto look = std::make_shared<FluidLook>();
  look->particles = 500'000;  // 20 MB
  for (int k = 0; k < 40; ++k) history.record({}, {}, look);
  EXPECT_EQ(history.fluids(3), look);
  EXPECT_LT(history.size(), 14u);
  EXPECT_GE(history.size(), 8u);
}

class FluidDrawn : public ::testing::Test {
 protected:
  FluidDrawn() {
    world_.bounds = {0, 0, 40, 30};
    camera_.fit({0, 0, 40, 30}, 800, 600);
    look_.fluids.resize(2);
    look_.fluids[0].spacing = look_.fluids[1].spacing = 0.5;
    for (int k = 0; k < 400; ++k) add(0, {5.25 + 0.5 * (k % 20), 5.25 + 0.5 * (k / 20)}, {1.0 * (k % 20), 0});
    add(1, {30, 20}, {60, 0});
  }
  void add(std::size_t fluid, Vec2 at, Vec2 velocity) {
    FluidRows& rows = look_.fluids[fluid];
    rows.place.push_back(at);
    rows.velocity.push_back(velocity);
    rows.pressure.push_back(1000 * (20 - at.y));
    ++look_.particles;
  }
  WorldDesc world_;
  Camera camera_;
  FluidLook look_;
  FluidDrawing drawing_;
};

TEST_F(FluidDrawn, SurfacesAreGridsAndParticlesDiscs) {
  drawing_.build(&look_, world_, camera_, 1, {});
  ASSERT_EQ(drawing_.parts().size(), 2u);
  const FluidDrawing::Part& pool = drawing_.parts()[0];
  EXPECT_TRUE(pool.discs.empty());
  EXPECT_GT(std::ranges::count_if(pool.field.fullness, [](float f) { return f > cli::kFluidEdge; }), 1500);
  EXPECT_TRUE(pool.field.value.empty());
  EXPECT_NE(pool.rgb, drawing_.parts()[1].rgb);

  drawing_.build(&look_, world_, camera_, 1, {FluidStyle::particles, FluidColouring::fluid});
  EXPECT_TRUE(drawing_.parts()[0].field.is_empty());
  ASSERT_EQ(drawing_.parts()[0].discs.size(), 400u);
  const FluidDrawing::Disc first = drawing_.parts()[0].discs[0];
  EXPECT_NEAR(first.x + camera_.centre().x, 5.25, 1e-4);
  EXPECT_NEAR(first.y + camera_.centre().y, 5.25, 1e-4);
  EXPECT_LT(first.share, 0);
  drawing_.build(nullptr, world_, camera_, 1, {});
  EXPECT_TRUE(drawing_.parts().empty());
}

TEST_F(FluidDrawn, BetweenFramesParticlesAreOnTheirWay) {
  drawing_.build(&look_, world_, camera_, 0.25f, {FluidStyle::particles, FluidColouring::fluid});
  const double x = drawing_.parts()[1].discs[0].x + camera_.centre().x;
  EXPECT_NEAR(x, 30 - 0.75 * 60 * world_.dt, 1e-4);
}

TEST_F(FluidDrawn, NumbersAreSharesOfNearlyTheMost) {
  for (const FluidColouring colouring : {FluidColouring::speed, FluidColouring::pressure}) {
    drawing_.build(&look_, world_, camera_, 1, {FluidStyle::particles, colouring});
    float most = 0;
    for (const FluidDrawing::Disc& disc : drawing_.parts()[0].discs) most = std::max(most, disc.share);
    EXPECT_NEAR(most, 1, 0.1);
    drawing_.build(&look_, world_, camera_, 1, {FluidStyle::surface, colouring});
    const cli::FluidField& field = drawing_.parts()[0].field;
    EXPECT_EQ(field.value.size(), field.fullness.size());
  }
}

}  // namespace
}  // namespace psim::view
