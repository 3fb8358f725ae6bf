// Fluids through the C API.
#include "c_api_support.h"

namespace psim::test {
namespace {

TEST(CApiFluid, ParticlesAreAddedSteppedAndTold) {
  CWorld c;
  psim_fluid_desc desc;
  psim_fluid_desc_init(&desc);
  EXPECT_EQ(desc.density, 1000);
  EXPECT_EQ(desc.viscosity, 0);
  EXPECT_EQ(psim_world_add_fluid(c.world, &desc, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_fluid: a fluid's spacing must be from 0.001 to 1000, not 0");
  desc.spacing = 0.5;
  std::uint32_t fluid = 7;
  ASSERT_EQ(psim_world_add_fluid(c.world, &desc, &fluid), PSIM_OK) << c.last();
  EXPECT_EQ(fluid, 0u);
  const psim_vec2 places[] = {{0, 0}, {0.5, 0}, {0, 0.5}}, speeds[] = {{1, 0}, {1, 0}, {1, 0}};
  ASSERT_EQ(psim_world_add_particles(c.world, fluid, places, speeds, 3), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_add_particles(c.world, fluid, places, nullptr, 1), PSIM_OK) << c.last();
  const psim_fluid_particle* particles = nullptr;
  std::size_t count = 0;
  ASSERT_EQ(psim_world_fluid_particles(c.world, &particles, &count), PSIM_OK);
  ASSERT_EQ(count, 4u);
  EXPECT_EQ(particles[2].id, 2u);
  EXPECT_EQ(particles[2].velocity.x, 1);
  EXPECT_EQ(particles[3].velocity.x, 0);
  psim_fluid_report report;
  psim_fluid_report_init(&report);
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_fluid_report(c.world, &report), PSIM_OK);
  EXPECT_EQ(report.particles, 4u);
  EXPECT_GT(report.kinetic, 0);
}

TEST(CApiFluid, ParticlesAreDrawn) {
  CWorld c;
  psim_fluid_desc desc;
  psim_fluid_desc_init(&desc);
  desc.spacing = 0.5;
  const psim_vec2 places[] = {{0, 0}, {0.5, 0}};
  ASSERT_EQ(psim_world_add_fluid(c.world, &desc, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_add_particles(c.world, 0, places, nullptr, 2), PSIM_OK) << c.last();
  psim_debug_draw draw;
  psim_debug_draw_init(&draw);
  EXPECT_EQ(draw.particles, 1);
  std::vector<double> radii;
  draw.user = &radii;
  draw.circle = [](void* user, psim_vec2, double radius, double, std::int32_t kind, psim_body_id) {
    EXPECT_EQ(kind, PSIM_DRAW_PARTICLE);
    static_cast<std::vector<double>*>(user)->push_back(radius);
  };
  ASSERT_EQ(psim_world_debug_draw(c.world, &draw), PSIM_OK) << c.last();
  EXPECT_EQ(radii, (std::vector<double>{0.25, 0.25}));
  draw.particles = 0;
  ASSERT_EQ(psim_world_debug_draw(c.world, &draw), PSIM_OK);
  EXPECT_EQ(radii.size(), 2u);
}

TEST(CApiFluid, TapsAndDrainsAndWhatIsWhere) {
  CWorld c;
  psim_fluid_desc fluid;
  psim_fluid_desc_init(&fluid);
  fluid.spacing = 0.5;
  ASSERT_EQ(psim_world_add_fluid(c.world, &fluid, nullptr), PSIM_OK);
  psim_emitter_desc desc;
  psim_emitter_desc_init(&desc);
  EXPECT_EQ(desc.fluid, 0u);
  EXPECT_EQ(desc.end, std::numeric_limits<double>::infinity());
  EXPECT_EQ(desc.limit, ~std::uint64_t{0});
  EXPECT_EQ(psim_world_add_emitter(c.world, &desc, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last().find("psim_world_add_emitter: an emitter's length"), 0u) << c.last();
  desc.from = {0, 1};
  desc.to = {0, 0};
  desc.speed = 5;
  std::uint32_t emitter = 7, drain = 7;
  ASSERT_EQ(psim_world_add_emitter(c.world, &desc, &emitter), PSIM_OK) << c.last();
  EXPECT_EQ(emitter, 0u);
  EXPECT_EQ(psim_world_add_drain(c.world, {1, 1, 0, 0}, &drain), PSIM_ERROR_ARGUMENT);
  ASSERT_EQ(psim_world_add_drain(c.world, {5, -90, 90, 90}, &drain), PSIM_OK) << c.last();
  EXPECT_EQ(drain, 0u);
  for (int k = 0; k < 120; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  psim_fluid_report report;
  psim_fluid_report_init(&report);
  ASSERT_EQ(psim_world_fluid_report(c.world, &report), PSIM_OK);
  EXPECT_EQ(report.emitted, 40u);
  EXPECT_GT(report.drained, 10u);
  EXPECT_EQ(report.particles, report.emitted - report.drained);
  EXPECT_EQ(report.withheld, 0u);
  psim_fluid_amount amount;
  ASSERT_EQ(psim_world_fluid_in(c.world, {-90, -90, 90, 90}, PSIM_NO_FLUID, &amount), PSIM_OK);
  EXPECT_EQ(amount.particles, report.particles);
  EXPECT_NEAR(amount.mean_velocity.x, 5, 0.1);
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.shape = psim_disc(50);
  body.type = PSIM_BODY_STATIC;
  body.sensor = 1;
  psim_body_id id;
  ASSERT_EQ(psim_world_add_body(c.world, &body, &id), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_fluid_in_sensor(c.world, id, 0, &amount), PSIM_OK) << c.last();
  EXPECT_EQ(amount.particles, report.particles);
  psim_event_options asked;
  psim_event_options_init(&asked);
  EXPECT_EQ(asked.fluids, 0);
  asked.fluids = 1;
  ASSERT_EQ(psim_world_set_event_options(c.world, &asked), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  psim_events events;
  psim_events_init(&events);
  ASSERT_EQ(psim_world_events(c.world, &events), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_fluid_in_sensor(c.world, id, 0, &amount), PSIM_OK) << c.last();
  ASSERT_EQ(events.fluid_begin_count, amount.particles);
  EXPECT_EQ(events.fluid_end_count, 0u);
  EXPECT_EQ(events.fluid_begin[0].sensor.index, id.index);
  EXPECT_EQ(events.fluid_begin[0].fluid, 0u);
  EXPECT_LT(events.fluid_begin[0].particle, events.fluid_begin[1].particle);
  psim_vec2 force = {1, 1};
  double torque = 1;
  ASSERT_EQ(psim_world_fluid_load(c.world, id, &force, &torque), PSIM_OK) << c.last();
  EXPECT_EQ(force.x, 0);
  EXPECT_EQ(torque, 0);
  EXPECT_EQ(psim_world_set_emitter_speed(c.world, emitter, 1e9), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_set_emitter_speed(c.world, emitter, 0), PSIM_OK);
  EXPECT_EQ(psim_world_remove_emitter(c.world, emitter), PSIM_OK);
  EXPECT_EQ(psim_world_remove_emitter(c.world, emitter), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(c.last(), "psim_world_remove_emitter: there is no emitter 0");
  EXPECT_EQ(psim_world_set_emitter_speed(c.world, emitter, 0), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_remove_drain(c.world, drain), PSIM_OK);
  EXPECT_EQ(psim_world_remove_drain(c.world, drain), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_fluid_in(c.world, {0, 0, 1, 1}, 0, nullptr), PSIM_ERROR_ARGUMENT);
  id.generation += 7;
  EXPECT_EQ(psim_world_fluid_in_sensor(c.world, id, 0, &amount), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_fluid_load(c.world, id, &force, &torque), PSIM_ERROR_STALE_ID);
}

TEST(CApiFluid, WhatIsWrongIsRefused) {
  CWorld c;
  psim_fluid_desc desc;
  psim_fluid_desc_init(&desc);
  desc.spacing = 0.5;
  const psim_vec2 place = {0, 0};
  EXPECT_EQ(psim_world_add_particles(c.world, 0, &place, nullptr, 1), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_particles: there is no such fluid");
  ASSERT_EQ(psim_world_add_fluid(c.world, &desc, nullptr), PSIM_OK);
  EXPECT_EQ(psim_world_add_particles(c.world, 0, nullptr, nullptr, 1), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_add_particles(c.world, 0, &place, nullptr, 10'000'001), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_add_particles(c.world, 0, nullptr, nullptr, 0), PSIM_OK);
  const psim_vec2 nowhere = {kNaN, 0};
  EXPECT_EQ(psim_world_add_particles(c.world, 0, &nowhere, nullptr, 1), PSIM_ERROR_ARGUMENT);
  std::size_t count = 0;
  EXPECT_EQ(psim_world_fluid_particles(c.world, nullptr, &count), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_fluid_report(c.world, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_add_fluid(nullptr, &desc, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_add_fluid(c.world, nullptr, nullptr), PSIM_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace psim::test
