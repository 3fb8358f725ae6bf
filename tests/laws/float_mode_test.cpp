// A step computes by IEEE 754 whatever the host has set, and nothing decays into denormals.
#include <gtest/gtest.h>
#include <psim/scene.h>

#include <cfenv>

#include "support/support.h"

#if defined(__x86_64__)
#include <immintrin.h>

namespace psim::test {
namespace {

constexpr unsigned kUsual = 0x1F80;          // MXCSR: no exception raised, all of them masked
constexpr unsigned kDenormalOperand = 0x02;  // its flag DE
constexpr unsigned kFlushUpwards = 0xDFC0;   // denormals are flushed and read as zero, results rounded upwards
constexpr unsigned kControl = 0xFFC0;        // what is no flag

// Steps in which a calculation read a denormal.
int steps_with_denormals(World& world, int frames) {
  int found = 0;
  for (int frame = 0; frame < frames; ++frame) {
    _mm_setcsr(kUsual);
    world.step();
    found += (_mm_getcsr() & kDenormalOperand) != 0 ? 1 : 0;
  }
  _mm_setcsr(kUsual);
  return found;
}

std::unique_ptr<World> built_in(std::string_view name, std::uint64_t count, const RunOptions& options) {
  std::string error;
  const auto scene = make_builtin(name, count, 1, error);
  if (!scene) throw std::runtime_error(error);
  auto world = build_world(*scene, options, error);
  if (!world) throw std::runtime_error(error);
  return world;
}

TEST(FloatMode, NoBuiltInSceneComputesWithDenormals) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name == "million") continue;  // the scene discs
    const std::uint64_t few = scene.sized ? std::min<std::uint64_t>(scene.default_particles, 500) : 0;
    for (const Isa isa : available_isas()) {
      auto world = built_in(scene.name, scene.sized ? few : scene.default_particles, {.isa = isa, .threads = 1});
      const int frames = isa == best_isa() ? 300 : 60;
      // The square of a number below 1e-19 is one. That is chance: in 1,000 steps of five starts of each scene, one or
      // two steps of one start in thirty. What decays would meet denormals in every step from then on.
      EXPECT_LE(steps_with_denormals(*world, frames), frames / 60) << scene.name << ' ' << isa_name(isa);
    }
  }
}

// Discs, boxes and a joint; the speeds, gravity and friction that the host gives are denormal.
TEST(FloatMode, DenormalsThatTheHostGivesDoNotLiveOn) {
  for (const Isa isa : available_isas()) {
    for (const Vec2 gravity : {Vec2{0, -1e-42}, Vec2{0, -kG}}) {
      auto world = make(walled({-50, 0, 50, 50}, gravity, material(0, 1e-40)), isa);
      Random random(2);
      BodyId last = kNoBody;
      for (int k = 0; k < 60; ++k) {
        BodyDesc body =
            disc({-20 + 0.99 * (k % 10), 0.5 + 0.99 * (k / 10)}, {random.uniform(-1e-40, 1e-40), 1e-310}, 0.5);
        if (k % 2 == 1) body.shape = BoxShape{1, 1};
        body.material = material(1e-41, 1e-39);
        body.angular_velocity = random.uniform(-1e-40, 1e-40);
        body.angle = 1e-41;
        const BodyId id = add(*world, body);
        if (k % 10 == 9) {
          std::string error;
          JointDesc spring;
          spring.type = JointType::spring;
          spring.a = last, spring.b = id;
          spring.length = 1;
          spring.stiffness = 1e-40;
          EXPECT_NE(world->add_joint(spring, error), JointId{}) << error;
        }
        last = id;
      }
      EXPECT_EQ(steps_with_denormals(*world, 60), 0) << isa_name(isa) << ' ' << gravity.y;
    }
  }
}

TEST(FloatMode, TheHostsSettingsChangeNoBitAndComeBack) {
  const auto hash_under = [](unsigned settings, int threads) {
    _mm_setcsr(settings);
    auto world = built_in("tumbler", 300, {.isa = best_isa(), .threads = threads});
    std::uint64_t hash = 0;
    for (int frame = 0; frame < 60; ++frame) {
      world->step();
      hash = world->state_hash();
    }
    const BodyState first = *world->body(world->id_of(0));
    const unsigned after = _mm_getcsr();
    _mm_setcsr(kUsual);
    EXPECT_EQ(after & kControl, settings & kControl);
    return std::pair{hash, std::pair{first.x, first.angle}};
  };
  const auto expected = hash_under(kUsual, 1);
  EXPECT_EQ(hash_under(kFlushUpwards, 1), expected);
  EXPECT_EQ(hash_under(kFlushUpwards, 3), expected);
}

}  // namespace
}  // namespace psim::test
#endif
