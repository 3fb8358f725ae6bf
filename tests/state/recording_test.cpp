// A recording replays with the same bits, and says where a run was another.
#include "forged.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

using Bytes = std::vector<std::byte>;

// A world to which a host does all that a host can.
Bytes record(std::uint64_t every, std::uint64_t* hash = nullptr, bool past = false) {
  auto world = make(walled({0, 0, 30, 40}, {0, -kG}, kGrip));
  add(*world, disc({5, 5}));
  for (int k = 0; k < 10; ++k) world->step();
  Recorder recorder(*world, every);
  std::string error;
  Random random(4);
  std::vector<BodyId> ids;
  std::vector<JointId> joints;
  const std::vector<double> x{3, 5, 7, 9, 11}, y{20, 21, 22, 21, 20}, radius{0.3};
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.radius = radius;
  std::uint32_t first = 0;
  EXPECT_EQ(recorder.add_discs(batch, first, error), 5u) << error;
  for (std::uint32_t k = 0; k < 5; ++k) ids.push_back(world->id_of(first + k));
  for (int frame = 0; frame < 150; ++frame) {
    const std::size_t k = random.below(ids.size());
    const Vec2 at{random.uniform(2, 28), random.uniform(10, 38)};
    switch (frame % 16) {
      case 0:
        ids.push_back(recorder.add_body(box(at, 1, 0.6, kGrip), error));
        break;
      case 1:
        ids.push_back(recorder.add_body(polygon(regular(5, 0.5), at, kGrip), error));
        break;
      case 2:
        ids.push_back(recorder.add_body(capsule(at, 1, 0.2, kGrip), error));
        break;
      case 3:
        recorder.add_body(segment({at.x, 2}, {at.x + 1, 3}, kGrip), error);
        break;
      case 4:
        recorder.apply_impulse(ids[k], {1, 1});
        break;
      case 5:
        recorder.apply_impulse_at(ids[k], {0, 1}, at);
        break;
      case 6:
        recorder.apply_angular_impulse(ids[k], 0.2);
        break;
      case 7:
        recorder.set_velocity(ids[k], {1, 2}, 3);
        break;
      case 8:
        recorder.set_transform(ids[k], at, 0.4);
        break;
      case 9:
        recorder.set_gravity({0.1, -kG - frame % 3});
        break;
      case 10: {
        JointDesc d;
        d.type = JointType::revolute;
        d.a = ids[k];
        d.b = ids[(k + 1) % ids.size()];
        d.motor_limit = 5;
        const JointId id = recorder.add_joint(d, error);
        if (id != kNoJoint) joints.push_back(id);
        break;
      }
      case 11:
        if (!joints.empty() && frame % 32 < 16) recorder.set_motor(joints.back(), 2, 3);
        if (!joints.empty() && frame % 32 >= 16) {
          JointDesc d = world->joint_desc(joints.back()).value_or(JointDesc{});
          d.stiffness = 3, d.break_torque = 40;
          recorder.set_joint(joints.back(), d, error);
          JointDesc mouse;
          mouse.type = JointType::target;
          mouse.b = ids[k];
          mouse.frequency = 1;
          recorder.set_target(recorder.add_joint(mouse, error), {1, 1});
        }
        break;
      case 12:
        if (frame > 100 && !joints.empty()) recorder.remove_joint(joints.back()), joints.pop_back();
        break;
      case 13:
        recorder.remove_body(ids[k]);
        break;
      case 14:
        recorder.set_sleeping(frame % 32 == 14);
        recorder.set_skin(frame % 32 == 14 ? 2 : 0.5);
        break;
      default:
        recorder.wake(ids[k]);
    }
    if (past && frame == 77) world->apply_impulse(ids.back(), {10, 10});
    if (frame % 10 == 9) {
      recorder.step(0.01);
    } else {
      recorder.step();
    }
  }
  if (hash != nullptr) *hash = world->state_hash();
  return recorder.recording();
}

TEST(Recording, ReplaysWithTheSameBits) {
  std::uint64_t hash = 0;
  const Bytes bytes = record(7, &hash);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      RunOptions options;
      options.isa = isa;
      options.threads = threads;
      std::string error;
      auto replay = Replay::open(bytes, options, error);
      ASSERT_NE(replay, nullptr) << error;
      EXPECT_EQ(replay->steps_in_all(), 150u);
      while (replay->next()) {
        ASSERT_EQ(replay->differs_at(), 0u);
        ASSERT_EQ(replay->complete(), replay->steps() == 150);
      }
      EXPECT_EQ(replay->steps(), 150u);
      EXPECT_EQ(replay->hashes(), 150u / 7 + 1);
      EXPECT_EQ(replay->world().state_hash(), hash);
    }
  }
}

TEST(Recording, NamesTheFirstHashThatWasAnother) {
  const Bytes bytes = record(5, nullptr, true);  // a push in frame 77 went past the recorder
  std::string error;
  auto replay = Replay::open(bytes, {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 80u);
}

TEST(Recording, NamesTheStepIfEachHasAHash) {
  const Bytes bytes = record(1, nullptr, true);  // frame 77 is the 78th
  std::string error;
  auto replay = Replay::open(bytes, {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 78u);
}

// As the headers and docs/saved-states.md say.
TEST(Recording, TakesAsManyBytesAsItSays) {
  auto world = make(walled({0, 0, 10, 10}, {0, -kG}));
  add(*world, disc({5, 5}));
  Bytes state;
  world->save(state);
  Recorder recorder(*world, 4);
  EXPECT_EQ(recorder.recording().size(), sizeof(RecordingHeader) + state.size() + kBytesOfAHash);
  for (int k = 0; k < 10; ++k) recorder.step();
  EXPECT_EQ(recorder.recording().size(),
            sizeof(RecordingHeader) + state.size() + 10 * kBytesOfAStep + 3 * kBytesOfAHash);
}

TEST(Recording, IsCompleteOnlyAtItsEnd) {
  const Bytes bytes = record(50);
  using Log = std::vector<std::byte>;
  const auto run = [&](const Bytes& recording) {
    std::string error;
    auto replay = Replay::open(recording, {}, error);
    EXPECT_NE(replay, nullptr) << error;
    while (replay->next()) {
    }
    return replay->complete();
  };
  EXPECT_TRUE(run(bytes));
  EXPECT_TRUE(run(forged(bytes, [](Log&, std::uint64_t&) {})));
  EXPECT_FALSE(run(forged(bytes, [](Log&, std::uint64_t& steps) { ++steps; })));
  EXPECT_FALSE(run(forged(bytes, [](Log&, std::uint64_t& steps) { --steps; })));
  EXPECT_FALSE(run(forged(bytes, [](Log& log, std::uint64_t&) { log.clear(); })));
  EXPECT_FALSE(run(forged(bytes, [](Log& log, std::uint64_t&) { log.insert(log.begin(), std::byte{99}); })));
  EXPECT_FALSE(run(forged(bytes, [](Log& log, std::uint64_t&) { log.push_back(std::byte{99}); })));
  // Step 150 has a hash of its own, and then the one at the end.
  for (std::size_t cut = 1; cut < kBytesOfAStep + 2 * kBytesOfAHash; ++cut) {
    const bool is_all = cut == kBytesOfAHash;
    EXPECT_EQ(run(forged(bytes, [&](Log& log, std::uint64_t&) { log.resize(log.size() - cut); })), is_all) << cut;
  }
}

TEST(Recording, OfAGovernedRunReplaysItsCuts) {
  auto world = make(walled({0, 0, 60, 60}, {0, -kG}));
  for (int k = 0; k < 400; ++k) add(*world, disc({1.5 + k % 20 * 1.1, 1.5 + k / 20 * 1.1}));
  GovernorDesc governor;
  governor.on = true;
  governor.budget_ms = 0.02;
  world->set_governor(governor);
  Recorder recorder(*world, 10);
  bool cut = false;
  for (int k = 0; k < 60; ++k) {
    const StepDetail detail = recorder.step().detail;
    cut = cut || detail.waits() || detail.substeps < 4;
  }
  EXPECT_TRUE(cut);
  std::string error;
  auto replay = Replay::open(recorder.recording(), {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().state_hash(), world->state_hash());
}

TEST(Recording, RefusesWhatWasCutOrDamaged) {
  const Bytes bytes = record(50);
  std::string error;
  for (std::size_t cut = 0; cut < bytes.size(); cut += 97) {
    EXPECT_EQ(Replay::open(std::span(bytes).first(cut), {}, error), nullptr) << cut;
  }
  for (std::size_t at = 0; at < bytes.size(); at += at < 48 ? 1 : 53) {
    Bytes bad = bytes;
    bad[at] ^= std::byte{4};
    EXPECT_EQ(Replay::open(bad, {}, error), nullptr) << at;
  }
  EXPECT_EQ(Replay::open({}, {}, error), nullptr);
  EXPECT_EQ(error, "it is cut short");
}

}  // namespace
}  // namespace psim::test
