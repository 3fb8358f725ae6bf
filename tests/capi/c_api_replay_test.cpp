// The C API: saved worlds, replays and recordings.
#include <cmath>
#include <cstring>

#include "c_api_support.h"

namespace psim::test {
namespace {

TEST(CApi, AGovernedRunReplaysFromItsReports) {
  const auto fill = [](CWorld& c) {
    for (int k = 0; k < 40; ++k) c.add(psim_disc(0.5), {k % 8 * 1.0, -499 + k / 8 * 1.0});
  };
  CWorld cut, again;
  fill(cut);
  fill(again);
  psim_cost_model costs;
  psim_cost_model_init(&costs);
  costs.pass = 1e5;  // so that nothing fits
  psim_governor_desc governor;
  psim_governor_desc_init(&governor);
  governor.on = 1;
  governor.costs = &costs;
  ASSERT_EQ(psim_world_set_governor(cut.world, &governor), PSIM_OK) << cut.last();
  bool less = false;
  for (int k = 0; k < 30; ++k) {
    psim_step_report report;
    psim_step_report_init(&report);
    ASSERT_EQ(psim_world_step(cut.world, &report), PSIM_OK);
    less |= report.detail.substeps < 4;
    ASSERT_EQ(psim_world_replay(again.world, report.detail, nullptr), PSIM_OK) << again.last();
  }
  EXPECT_TRUE(less);
  EXPECT_EQ(psim_world_state_hash(cut.world), psim_world_state_hash(again.world));
  EXPECT_EQ(psim_world_replay(again.world, {4, PSIM_STEP_WAKES, 1, 1, 0}, nullptr), PSIM_ERROR_ARGUMENT);
  psim_step_report limited;
  psim_step_report_init(&limited);
  constexpr std::uint8_t kFlags = 3 * PSIM_STEP_SWEEP + 2 * PSIM_STEP_FLUID_PART;
  ASSERT_EQ(psim_world_replay(again.world, {4, kFlags, 1, 1, 0}, &limited), PSIM_OK);
  EXPECT_EQ(limited.detail.flags, kFlags);
}

TEST(CApi, ASavedWorldGoesOnWithTheSameBits) {
  psim_world_desc desc = CWorld::defaults();
  const psim_field drag = psim_drag(0.1, 0);
  desc.fields = &drag;
  desc.field_count = 1;
  CWorld c(desc);
  for (int k = 0; k < 30; ++k) c.add(psim_box(1, 1), {k % 5 * 1.1, -498 + k / 5 * 1.1});
  const auto run_on = [](psim_world* world) {
    for (int k = 0; k < 20; ++k) psim_world_step(world, nullptr);
    return psim_world_state_hash(world);
  };
  run_on(c.world);
  const void* state = nullptr;
  std::size_t size = 0;
  ASSERT_EQ(psim_world_save(c.world, &state, &size), PSIM_OK) << c.last();
  const std::uint64_t expected = run_on(c.world);
  ASSERT_EQ(psim_world_restore(c.world, state, size), PSIM_OK) << c.last();
  EXPECT_EQ(run_on(c.world), expected);

  // Through a buffer, and into a new world.
  std::size_t packed_size = 0;
  ASSERT_EQ(psim_pack_state(state, size, nullptr, 0, &packed_size), PSIM_OK);
  EXPECT_EQ(packed_size, size + 32);
  std::vector<unsigned char> packed(packed_size), unpacked(size);
  EXPECT_EQ(psim_pack_state(state, size, packed.data(), 10, &packed_size), PSIM_ERROR_ARGUMENT);
  ASSERT_EQ(psim_pack_state(state, size, packed.data(), packed.size(), &packed_size), PSIM_OK);
  char error[256];
  std::size_t unpacked_size = 0;
  ASSERT_EQ(psim_unpack_state(packed.data(), packed.size(), unpacked.data(), unpacked.size(), &unpacked_size, error,
                              sizeof error),
            PSIM_OK)
      << error;
  psim_world* again = nullptr;
  ASSERT_EQ(psim_world_from_state(unpacked.data(), unpacked_size, nullptr, &again, error, sizeof error), PSIM_OK)
      << error;
  EXPECT_EQ(run_on(again), expected);
  psim_world_desc now = CWorld::defaults();
  ASSERT_EQ(psim_world_get_desc(again, &now), PSIM_OK);
  ASSERT_EQ(now.field_count, 1u);
  EXPECT_EQ(now.fields[0].linear, 0.1);
  psim_world_destroy(again);

  packed[packed.size() / 2] ^= 1;
  EXPECT_EQ(psim_unpack_state(packed.data(), packed.size(), nullptr, 0, &unpacked_size, error, sizeof error),
            PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(std::string(error).rfind("psim_unpack_state: ", 0), 0u) << error;
  CWorld other;
  EXPECT_EQ(psim_world_restore(other.world, "no state", 8), PSIM_ERROR_ARGUMENT);
  EXPECT_NE(other.last(), "");

  const std::string path = testing::TempDir() + "c_api_state";
  ASSERT_EQ(psim_write_state(path.c_str(), state, size, error, sizeof error), PSIM_OK) << error;
  ASSERT_EQ(psim_read_state(path.c_str(), unpacked.data(), size, &unpacked_size, error, sizeof error), PSIM_OK)
      << error;
  EXPECT_EQ(std::memcmp(unpacked.data(), state, size), 0);
  std::remove(path.c_str());
  EXPECT_EQ(psim_read_state(path.c_str(), nullptr, 0, &unpacked_size, error, sizeof error), PSIM_ERROR_ARGUMENT);
}

TEST(CApi, AReplayStepsByAnotherDt) {
  CWorld a, b;
  for (CWorld* c : {&a, &b}) {
    for (int k = 0; k < 5; ++k) c->add(psim_disc(0.5), {0.1 * k, -499.5 + k});
  }
  for (int k = 0; k < 20; ++k) {
    psim_step_report report;
    psim_step_report_init(&report);
    ASSERT_EQ(psim_world_step_by(a.world, 0.01, &report), PSIM_OK);
    ASSERT_EQ(psim_world_replay_by(b.world, report.detail, 0.01, nullptr), PSIM_OK) << b.last();
  }
  EXPECT_EQ(psim_world_state_hash(a.world), psim_world_state_hash(b.world));
  for (const double dt : {0.0, -1.0, 11.0, kNaN}) {
    EXPECT_EQ(psim_world_replay_by(b.world, {0, 0, 1, 1, 0}, dt, nullptr), PSIM_ERROR_ARGUMENT) << dt;
    EXPECT_EQ(psim_world_step_by(b.world, dt, nullptr), PSIM_ERROR_ARGUMENT) << dt;
  }
  for (const psim_step_detail wrong :
       {psim_step_detail{65, 0, 1, 1, 0}, psim_step_detail{0, 2, 1, 1, 0}, psim_step_detail{0, 6, 1, 1, 0},
        psim_step_detail{0, 0, 0, 1, 0}, psim_step_detail{0, 0, 9, 1, 0}, psim_step_detail{0, 0, 1, 0, 0}}) {
    EXPECT_EQ(psim_world_replay(b.world, wrong, nullptr), PSIM_ERROR_ARGUMENT);
  }
  EXPECT_EQ(psim_world_frame(b.world), 20u);
}

TEST(CApi, ARecordingHoldsAllThatWasDoneAndRunsAgain) {
  CWorld c;
  std::vector<psim_body_id> ids;
  for (int k = 0; k < 12; ++k) ids.push_back(c.add(psim_box(1, 0.8), {k % 4 * 1.2, -498 + k / 4 * 1.1}));
  const void* bytes = nullptr;
  std::size_t size = 1;
  EXPECT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_NOTHING);
  EXPECT_EQ(size, 0u);
  EXPECT_EQ(psim_world_stop_recording(c.world), PSIM_NOTHING);
  EXPECT_EQ(psim_world_record(c.world, 0), PSIM_ERROR_ARGUMENT);
  for (int k = 0; k < 10; ++k) psim_world_step(c.world, nullptr);

  ASSERT_EQ(psim_world_record(c.world, 5), PSIM_OK);
  const auto steps = [&](int n) {
    for (int k = 0; k < n; ++k) ASSERT_EQ(psim_world_step(c.world, nullptr), PSIM_OK);
  };
  // All that changes a world, each with an effect.
  steps(3);
  ids.push_back(c.add(psim_disc(0.4), {2, -480}));
  const double x[] = {-3, -5}, y[] = {-490, -490};
  psim_disc_batch batch;
  psim_disc_batch_init(&batch);
  batch.count = 2;
  batch.x = {x, 0};
  batch.y = {y, 0};
  ASSERT_EQ(psim_world_add_discs(c.world, &batch, nullptr), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_set_velocity(c.world, ids[0], {1, 3}, 2), PSIM_OK);
  ASSERT_EQ(psim_world_set_transform(c.world, ids[1], {8, -490}, 0.3), PSIM_OK);
  ASSERT_EQ(psim_world_apply_impulse(c.world, ids[2], {1, 1}), PSIM_OK);
  ASSERT_EQ(psim_world_apply_impulse_at(c.world, ids[3], {1, 1}, {5, -498}), PSIM_OK);
  ASSERT_EQ(psim_world_apply_angular_impulse(c.world, ids[4], 0.5), PSIM_OK);
  steps(4);
  psim_joint_desc joint;
  psim_joint_desc_init(&joint);
  joint.type = PSIM_JOINT_REVOLUTE;
  joint.a = ids[5];
  joint.b = ids[6];
  psim_joint_id pin{}, second{};
  ASSERT_EQ(psim_world_add_joint(c.world, &joint, &pin), PSIM_OK) << c.last();
  joint.a = ids[7];
  ASSERT_EQ(psim_world_add_joint(c.world, &joint, &second), PSIM_OK) << c.last();
  ASSERT_EQ(psim_world_set_motor(c.world, pin, 1, 5), PSIM_OK);
  std::size_t crossed = 0;
  psim_joint_id across[1] = {};
  EXPECT_EQ(psim_world_joints_across(c.world, {-500, -500}, {500, 500}, nullptr, 1, &crossed), PSIM_ERROR_ARGUMENT);
  ASSERT_EQ(psim_world_joints_across(c.world, {-500, -500}, {-400, -500}, across, 1, &crossed), PSIM_OK) << c.last();
  EXPECT_EQ(crossed, 0u);
  ASSERT_EQ(psim_world_step_by(c.world, 0.01, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_remove_joint(c.world, second), PSIM_OK);
  ASSERT_EQ(psim_world_remove_body(c.world, ids[8]), PSIM_OK);
  ASSERT_EQ(psim_world_set_gravity(c.world, {1, -9}), PSIM_OK);
  ASSERT_EQ(psim_world_set_skin(c.world, 0.5), PSIM_OK);
  ASSERT_EQ(psim_world_replay_by(c.world, {2, 0, 1, 1, 0}, 0.02, nullptr), PSIM_OK);
  ASSERT_EQ(psim_world_replay(c.world, {3, 0, 2, 2, 0}, nullptr), PSIM_OK);
  steps(90);
  ASSERT_EQ(psim_world_set_sleeping(c.world, 0), PSIM_OK);
  ASSERT_EQ(psim_world_wake(c.world, ids[9]), PSIM_OK);
  steps(5);
  const std::uint64_t hash = psim_world_state_hash(c.world), frame = psim_world_frame(c.world);
  ASSERT_EQ(psim_world_recording(c.world, &bytes, &size), PSIM_OK);
  std::vector<unsigned char> recording(static_cast<const unsigned char*>(bytes),
                                       static_cast<const unsigned char*>(bytes) + size);
  // A restore is none of what a recording can hold.
  const void* state = nullptr;
  std::size_t state_size = 0;
  ASSERT_EQ(psim_world_save(c.world, &state, &state_size), PSIM_OK);
  EXPECT_EQ(psim_world_restore(c.world, state, state_size), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_world_stop_recording(c.world), PSIM_OK);
  EXPECT_EQ(psim_world_restore(c.world, state, state_size), PSIM_OK);

  psim_run_options options;
  psim_run_options_init(&options);
  options.isa = PSIM_ISA_SCALAR;
  options.threads = 2;
  char error[256];
  psim_replay* replay = nullptr;
  ASSERT_EQ(psim_replay_open(recording.data(), recording.size(), &options, &replay, error, sizeof error), PSIM_OK)
      << error;
  EXPECT_EQ(psim_replay_steps_in_all(replay), frame - 10);
  EXPECT_EQ(psim_replay_complete(replay), 0);
  psim_result result = PSIM_OK;
  while ((result = psim_replay_next(replay)) == PSIM_OK) {
  }
  EXPECT_EQ(result, PSIM_NOTHING);
  EXPECT_EQ(psim_replay_steps(replay), frame - 10);
  EXPECT_EQ(psim_replay_differs_at(replay), 0u);
  EXPECT_EQ(psim_replay_complete(replay), 1);
  EXPECT_GE(psim_replay_hashes(replay), (frame - 10) / 5);
  EXPECT_EQ(psim_world_state_hash(psim_replay_world(replay)), hash);
  EXPECT_EQ(psim_world_threads(psim_replay_world(replay)), 2);
  psim_replay_close(replay);

  recording[recording.size() - 9] ^= 1;
  EXPECT_EQ(psim_replay_open(recording.data(), recording.size(), nullptr, &replay, error, sizeof error),
            PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(std::string(error).rfind("psim_replay_open: ", 0), 0u) << error;
  EXPECT_EQ(replay, nullptr);
  EXPECT_EQ(psim_replay_open(nullptr, 0, nullptr, &replay, error, sizeof error), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_replay_open(recording.data(), 5, nullptr, nullptr, error, sizeof error), PSIM_ERROR_ARGUMENT);
  psim_replay_close(nullptr);
  EXPECT_EQ(psim_replay_next(nullptr), PSIM_ERROR_ARGUMENT);
  EXPECT_EQ(psim_replay_world(nullptr), nullptr);
  EXPECT_EQ(psim_replay_steps(nullptr) + psim_replay_steps_in_all(nullptr) + psim_replay_hashes(nullptr) +
                psim_replay_differs_at(nullptr),
            0u);
  EXPECT_EQ(psim_replay_complete(nullptr), 0);
}

}  // namespace
}  // namespace psim::test
