// Scenes whose bodies fall asleep and wake all the time give the same bits everywhere.
#include "rigid_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

/// Bodies that fall asleep and are woken all the time.
std::vector<std::uint64_t> restless(Isa isa, int threads, bool seam, bool shapes, bool mixed) {
  WorldDesc desc = walled({0, 0, 16, 40}, {0, -kG}, kGrip);
  if (seam) {
    desc = periodic(16, 40);
    desc.gravity = {0, -kG};
  }
  auto world = make(desc, isa, threads);
  add(*world, segment({0, 0.5}, {8, 0.5}, kGrip));
  add(*world, segment({8, 0.5}, {16, 0.5}, kGrip));
  Random random(5);
  std::vector<BodyId> ids;
  const auto put = [&](double y) {
    const Vec2 at{random.uniform(1, 15), y};
    const double r = mixed && random.chance(0.7) ? random.uniform(0.02, 0.1) : random.uniform(0.2, mixed ? 1 : 0.4);
    BodyDesc body = disc(at, {}, r, kGrip);
    body.fixed_rotation = true;  // nothing rolls for long
    if (shapes && random.chance(0.5)) body = turned(box(at, 2 * r, 1.4 * r, kGrip), random.uniform(0, 3));
    ids.push_back(add(*world, body));
  };
  for (int k = 0; k < 120; ++k) put(1.5 + 0.2 * k);
  world->set_event_options({true, false, 1, false});
  std::vector<std::uint64_t> all;
  std::uint64_t slept = 0;
  for (int frame = 0; frame < (kSanitized ? 600 : 900); ++frame) {
    if (frame > 300 && frame % 40 == 0) {
      put(12);
      const std::size_t k = random.below(ids.size());
      if (frame % 120 == 0) {
        world->remove_body(ids[k]);
        ids[k] = ids.back();
        ids.pop_back();
      } else {
        world->apply_impulse(ids[k], {random.uniform(-1, 1), 1});
      }
    }
    const StepReport report = world->step();
    slept += report.asleep;
    all.push_back(world->state_hash() * 31 + report.asleep + 7 * world->events().begin.size() +
                  13 * world->events().end.size());
  }
  EXPECT_GT(slept, 30u);
  return all;
}

TEST(SleepDeterminism, TheSameBitsForEveryIsaAndThreadCount) {
  struct Kind {
    bool seam, shapes, mixed;
  };
  for (const Kind k : {Kind{false, true, false}, {false, false, true}, {true, false, false}, {true, true, true}}) {
    const auto first = restless(Isa::scalar, 1, k.seam, k.shapes, k.mixed);
    for (const Isa isa : available_isas()) {
      for (const int threads : thread_counts()) {
        if (isa == Isa::scalar && threads == 1) continue;
        EXPECT_EQ(restless(isa, threads, k.seam, k.shapes, k.mixed), first)
            << k.seam << k.shapes << k.mixed << ' ' << static_cast<int>(isa) << ' ' << threads;
      }
    }
  }
}

}  // namespace
}  // namespace psim::test
