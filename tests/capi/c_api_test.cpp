// The C API: structs of other versions, errors, and that nothing thrown gets out. Layouts: tests/capi/abi_v1.c.
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>

#include "c_api_support.h"

namespace psim::test {
namespace {

TEST(CApi, AnOlderCallersShorterStructTakesDefaults) {
  psim_world_desc desc = CWorld::defaults();
  desc.dt = 0.01;
  desc.substeps = 40;  // past the end of the shorter struct: not read
  desc.restitution_threshold = -5;
  desc.struct_size = offsetof(psim_world_desc, substeps);
  CWorld c(desc);
  ASSERT_EQ(c.result, PSIM_OK) << c.error;
  psim_world_desc now = CWorld::defaults();
  ASSERT_EQ(psim_world_get_desc(c.world, &now), PSIM_OK);
  EXPECT_EQ(now.dt, 0.01);
  EXPECT_EQ(now.substeps, WorldDesc{}.substeps);
  EXPECT_EQ(now.restitution_threshold, 0);
}

TEST(CApi, AnOlderCallersShorterReportIsNotWrittenPast) {
  CWorld c;
  c.add(psim_disc(0.5), {0, 0});
  psim_step_report report;
  std::memset(&report, 0xAB, sizeof report);
  report.struct_size = offsetof(psim_step_report, pairs);
  ASSERT_EQ(psim_world_step(c.world, &report), PSIM_OK);
  EXPECT_EQ(report.struct_size, offsetof(psim_step_report, pairs));
  EXPECT_GT(report.total_ms, 0);
  EXPECT_EQ(report.pairs, 0xABABABABABABABABu);
}

TEST(CApi, WrongStructSizesAreRefused) {
  psim_world_desc desc = CWorld::defaults();
  for (const std::uint32_t size : {0u, 4u, 12u, static_cast<std::uint32_t>(sizeof desc) + 8u}) {
    desc.struct_size = size;
    CWorld c(desc);
    EXPECT_EQ(c.result, PSIM_ERROR_STRUCT_SIZE) << size;
    EXPECT_EQ(c.world, nullptr);
  }
  EXPECT_STREQ(CWorld(desc).error,
               "psim_world_create: desc has struct_size 200, this library knows 192: it is older "
               "than the header");
}

TEST(CApi, InitFillsWhatANewerCallerHasWithZeros) {
  alignas(8) unsigned char newer[sizeof(psim_body_desc) + 16];
  std::memset(newer, 0xAB, sizeof newer);
  psim_init(newer, PSIM_STRUCT_BODY_DESC, sizeof newer);
  psim_body_desc known;
  std::memcpy(&known, newer, sizeof known);
  EXPECT_EQ(known.struct_size, sizeof newer);
  EXPECT_EQ(known.gravity_scale, 1);
  EXPECT_EQ(newer[sizeof newer - 1], 0);
}

TEST(CApi, BodiesAreDisabledAndChange) {
  CWorld c;
  psim_body_desc desc;
  psim_body_desc_init(&desc);
  const psim_surface surfaces[3] = {{0, 0.5, 3, 0}, {0, 0.1, 0, 0.2}, {}};
  const psim_vec2 line[3] = {{9, 0}, {0, 0}, {-9, 0}};
  desc.type = PSIM_BODY_STATIC;
  desc.shape = psim_chain(line, 3, 0);
  desc.surfaces = surfaces;
  desc.surface_count = 3;
  EXPECT_EQ(psim_world_add_body(c.world, &desc, nullptr), PSIM_ERROR_ARGUMENT);  // two segments
  desc.surface_count = 2;
  EXPECT_EQ(psim_world_add_body(c.world, &desc, nullptr), PSIM_OK) << c.last();
  psim_body_desc_init(&desc);
  desc.surfaces = surfaces;
  desc.surface_count = 1;
  EXPECT_EQ(psim_world_add_body(c.world, &desc, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_body: surfaces are those of the segments of a chain");
  psim_body_desc_init(&desc);
  desc.shape = psim_box(0.5, 0.5);
  desc.position = psim_xy(1, 0.25);
  desc.material.friction = 0.5;
  desc.user_data = 0xFEDCBA9876543210u;
  desc.disabled = 1;
  psim_body_id id;
  ASSERT_EQ(psim_world_add_body(c.world, &desc, &id), PSIM_OK) << c.last();
  EXPECT_EQ(psim_world_user_data(c.world, id), 0xFEDCBA9876543210u);
  EXPECT_EQ(psim_world_set_user_data(c.world, id, 5), PSIM_OK);
  EXPECT_EQ(psim_world_user_data(c.world, id), 5u);
  EXPECT_EQ(psim_world_is_enabled(c.world, id), 0);
  EXPECT_EQ(psim_world_dynamic_count(c.world), 0u);
  EXPECT_EQ(psim_world_set_enabled(c.world, id, 1), PSIM_OK);
  EXPECT_EQ(psim_world_is_enabled(c.world, id), 1);
  psim_body_traits traits;
  psim_body_traits_init(&traits);
  ASSERT_EQ(psim_world_traits(c.world, id, &traits), PSIM_OK) << c.last();
  EXPECT_FLOAT_EQ(static_cast<float>(traits.mass), 0.25f);
  EXPECT_EQ(traits.surface.friction, 0.5);
  traits.mass = -1;
  EXPECT_EQ(psim_world_set_traits(c.world, id, &traits), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_set_traits: body 1 cannot have these traits");
  traits.mass = 2;
  traits.lock_angle = 1;
  ASSERT_EQ(psim_world_set_traits(c.world, id, &traits), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_traits(c.world, id, &traits), PSIM_OK);
  EXPECT_EQ(traits.mass, 2);
  EXPECT_EQ(traits.lock_angle, 1);
  for (int k = 0; k < 60; ++k) psim_world_step(c.world, nullptr);
  psim_body_state state;
  ASSERT_EQ(psim_world_body(c.world, id, &state), PSIM_OK);
  EXPECT_NEAR(state.vx, 3, 1e-3);  // the belt of the first segment
  EXPECT_EQ(psim_world_remove_body(c.world, id), PSIM_OK);
  EXPECT_EQ(psim_world_set_enabled(c.world, id, 1), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_traits(c.world, id, &traits), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_set_traits(c.world, id, &traits), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_set_user_data(c.world, id, 1), PSIM_ERROR_STALE_ID);
  EXPECT_EQ(psim_world_user_data(c.world, id), 0u);
}

TEST(CApi, ErrorsSayWhatAndWhere) {
  psim_world_desc desc = CWorld::defaults();
  desc.boundary = 9;
  EXPECT_STREQ(CWorld(desc).error, "psim_world_create: boundary 9 is none of psim_boundary, 0 to 2");
  desc = CWorld::defaults();
  desc.dt = 0;
  EXPECT_STREQ(CWorld(desc).error, "psim_world_create: dt must be above 0 and up to 10, not 0");
  char shorter[8];
  psim_world* world = nullptr;
  EXPECT_EQ(psim_world_create(&desc, nullptr, &world, shorter, sizeof shorter), PSIM_ERROR_ARGUMENT);
  EXPECT_STREQ(shorter, "psim_wo");

  CWorld c;
  const psim_body_id still = c.add(psim_box(1, 1), {0, 0}, PSIM_BODY_STATIC);
  EXPECT_EQ(c.last(), "");
  EXPECT_EQ(psim_world_set_velocity(c.world, still, {1, 0}, 0), PSIM_ERROR_NOT_MOVABLE);
  EXPECT_EQ(c.last(), "psim_world_set_velocity: body 0 is static or frozen");
  psim_body_desc body;
  psim_body_desc_init(&body);
  body.shape.type = 77;
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_body: shape type 77 is none of psim_shape_type, 0 to 5");
  body.shape.type = PSIM_SHAPE_DISC;
  body.part_count = 2;
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_body: parts must not be NULL");
  psim_shape_part parts[2] = {};
  parts[0].shape = psim_disc(1);
  parts[1].shape = psim_box(1, -1);
  body.parts = parts;
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last().rfind("psim_world_add_body: part 1: height", 0), 0u) << c.last();
  parts[1].shape = psim_box(1, 1);
  body.reserved = 1;
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_body: reserved must be 0");
  EXPECT_EQ(psim_world_add_body(c.world, nullptr, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_step_by(c.world, kNaN, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_step(nullptr, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_body_count(nullptr), 0u);
  EXPECT_EQ(psim_last_error(nullptr, nullptr, 0), 0u);
  psim_world_destroy(nullptr);

  psim_joint_desc joint;
  psim_joint_desc_init(&joint);
  joint.a = joint.b = still;
  EXPECT_EQ(psim_world_add_joint(c.world, &joint, nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(c.last(), "psim_world_add_joint: a and b must differ");
}

TEST(CApi, EveryResultHasWords) {
  for (int code = PSIM_ERROR_BROKEN_WORLD; code <= PSIM_NOTHING; ++code) {
    EXPECT_STRNE(psim_result_string(code), "unknown result") << code;
  }
  EXPECT_STREQ(psim_result_string(PSIM_ERROR_BROKEN_WORLD - 1), "unknown result");
}

TEST(CApi, VersionsAndInstructionSets) {
  EXPECT_STREQ(psim_version(), PSIM_VERSION_STRING);
  EXPECT_EQ(psim_version_number(), 10000u * PSIM_VERSION_MAJOR + 100u * PSIM_VERSION_MINOR + PSIM_VERSION_PATCH);
  for (const Isa isa : kAllIsas) {
    std::int32_t parsed = -7;
    EXPECT_EQ(psim_isa_name(static_cast<std::int32_t>(isa)), isa_name(isa));
    EXPECT_EQ(psim_parse_isa(isa_name(isa).data(), &parsed), PSIM_OK);
    EXPECT_EQ(parsed, static_cast<std::int32_t>(isa));
    if (!isa_available(isa)) continue;
    psim_run_options options;
    psim_run_options_init(&options);
    options.isa = static_cast<std::int32_t>(isa);
    options.threads = 2;
    CWorld c(CWorld::defaults(), &options);
    ASSERT_EQ(c.result, PSIM_OK) << c.error;
    EXPECT_EQ(psim_world_isa(c.world), options.isa);
    EXPECT_EQ(psim_world_threads(c.world), 2);
  }
  EXPECT_EQ(psim_isa_name(5), nullptr);
  EXPECT_EQ(psim_isa_available(5), 0);
  std::int32_t integrator = -7;
  EXPECT_EQ(psim_parse_integrator("rk4", &integrator), PSIM_OK);
  EXPECT_STREQ(psim_integrator_name(integrator), "rk4");
  EXPECT_EQ(psim_parse_integrator("rk5", &integrator), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_stage_name(static_cast<int>(kStageCount)), nullptr);
  EXPECT_STREQ(psim_stage_name(0), "forces");
}

void throw_no_memory(void*, size_t, psim_job_function, void*) { throw std::bad_alloc(); }
void throw_number(void*, size_t, psim_job_function, void*) { throw 7; }
void leave_out_the_last(void*, size_t count, psim_job_function function, void* job) {
  for (std::size_t i = 0; i + 1 < count; ++i) function(job, i);
}

TEST(CApi, WhatIsThrownInsideBecomesAResultAndTheWorldIsDone) {
  for (const auto parallel_for : {throw_number, leave_out_the_last}) {
    CWorld c;
    const psim_body_id id = c.add(psim_disc(0.5), {0, 0});
    psim_job_system jobs;
    psim_job_system_init(&jobs);
    jobs.parallel_for = parallel_for;
    ASSERT_EQ(psim_world_set_job_system(c.world, &jobs), PSIM_OK);
    EXPECT_EQ(psim_world_step(c.world, nullptr), PSIM_ERROR_INTERNAL) << c.last();
    EXPECT_NE(c.last(), "");
    EXPECT_EQ(psim_world_step(c.world, nullptr), PSIM_ERROR_BROKEN_WORLD);
    EXPECT_EQ(psim_world_remove_body(c.world, id), PSIM_ERROR_BROKEN_WORLD);
    EXPECT_EQ(psim_world_body_count(c.world), 0u);
  }
}

TEST(CApi, ABudgetOfMemoryEndsWhatWouldGrowBeyondIt) {
  psim_world_desc desc = CWorld::defaults();
  desc.max_bytes = 1;
  CWorld c(desc);
  ASSERT_NE(c.world, nullptr) << c.error;
  psim_body_desc body;
  psim_body_desc_init(&body);
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(c.last().rfind("psim_world_add_body: no room for a body: the world holds ", 0), 0u) << c.last();
  ASSERT_EQ(psim_world_set_max_bytes(c.world, UINT64_MAX), PSIM_OK);
  EXPECT_EQ(psim_world_add_body(c.world, &body, nullptr), PSIM_OK) << c.last();
}

TEST(CApi, AStepThatFindsNoMemoryLeavesTheWorldAsItWas) {
  CWorld c;
  const psim_body_id id = c.add(psim_disc(0.5), {0, 0});
  psim_job_system jobs;
  psim_job_system_init(&jobs);
  jobs.parallel_for = throw_no_memory;
  ASSERT_EQ(psim_world_set_job_system(c.world, &jobs), PSIM_OK);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(psim_world_step(c.world, nullptr), PSIM_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(c.last(), "psim_world_step: no room for pairs; the world is as before");
    EXPECT_EQ(psim_world_body_count(c.world), 1u);
  }
  ASSERT_EQ(psim_world_set_job_system(c.world, nullptr), PSIM_OK);
  EXPECT_EQ(psim_world_step(c.world, nullptr), PSIM_OK) << c.last();
  EXPECT_EQ(psim_world_remove_body(c.world, id), PSIM_OK);
}

}  // namespace
}  // namespace psim::test
