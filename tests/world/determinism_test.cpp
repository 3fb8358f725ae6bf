// The same bits, every frame, from every instruction set, any number of threads, any job system,
// and again.
#include <atomic>
#include <thread>

#include "support.h"

namespace psim::test {
namespace {

struct Case {
  const char* name;
  std::unique_ptr<World> (*build)(std::size_t n, Isa isa, int threads);
};

std::unique_ptr<World> mixed(std::size_t n, Isa isa, int threads) {
  const double side = std::ceil(3 * std::sqrt(static_cast<double>(n)));
  auto world = make(walled({0, 0, side, side}, {0, -kG}, material(0.2, 0.3)), isa, threads);
  Discs discs = lattice(n, {0, 0, side, side}, 1.2, 5, material(0.2, 0.3));
  Random random(17);
  for (double& r : discs.radius) r = 1.2 * std::pow(50, -random.uniform(0, 1));
  add(*world, discs);
  return world;
}

template <Integrator kIntegrator>
std::unique_ptr<World> with_fields(std::size_t n, Isa isa, int threads) {
  const double side = std::ceil(2.5 * std::sqrt(static_cast<double>(n)));
  WorldDesc desc = walled({0, 0, side, side}, {1, -2}, material(0.5));
  desc.linear_damping = 0.1;
  desc.integrator = kIntegrator;
  desc.fields.push_back(WellField{{0.5 * side, 0.5 * side}, 300, 0.5, 2, 0});
  desc.fields.push_back(WellField{{0.2 * side, 0.7 * side}, -100, 0.5, 1, 0.3 * side});
  desc.fields.push_back(DragField{0.05, 0.01});
  auto world = make(desc, isa, threads);
  add(*world, lattice(n, desc.bounds, 0.5, 5, material(0.5)));
  return world;
}

std::unique_ptr<World> with_statics(std::size_t n, Isa isa, int threads) {
  const double side = std::ceil(2 * std::sqrt(static_cast<double>(n)));
  auto world = make(walled({0, -side, side, side}, {0, -kG}, material(0.3, 0.4)), isa, threads);
  const Material m = material(0.3, 0.4);
  for (double x = 2; x < side; x += 4) {
    add(*world, static_disc({x, -0.3 * side}, 0.7, m));
    add(*world, segment({x, -0.5 * side}, {x + 3, -0.55 * side}, m));
    add(*world, chain({{x, -0.7 * side}, {x + 1, -0.75 * side}, {x + 2, -0.7 * side}}, false, m));
  }
  BodyDesc paddle = disc({0.5 * side, 0}, {0, -1}, 2, m);
  paddle.type = BodyType::kinematic_body;
  paddle.angular_velocity = 3;
  add(*world, paddle);
  add(*world, lattice(n, {0, 0.05 * side, side, side}, 0.5, 3, m));
  return world;
}

const Case kCases[] = {
    {"Gas", [](std::size_t n, Isa isa, int threads) { return gas_in_walls(n, 0.1, material(0.5), 10, isa, threads); }},
    {"ElasticGas",
     [](std::size_t n, Isa isa, int threads) { return gas_in_walls(n, 0.3, material(1), 10, isa, threads); }},
    {"Pile", [](std::size_t n, Isa isa, int threads) { return pile(n, {}, isa, threads); }},
    {"RoughPile", [](std::size_t n, Isa isa, int threads) { return pile(n, material(0.3, 0.5), isa, threads); }},
    {"Periodic",
     [](std::size_t n, Isa isa, int threads) { return gas_in_period(n, 0.4, material(0.9, 0.2), 10, isa, threads); }},
    {"MixedRadii", mixed},
    {"Fields", with_fields<Integrator::verlet>},
    {"FieldsByEuler", with_fields<Integrator::euler>},
    {"FieldsByRk4", with_fields<Integrator::rk4>},
    {"FieldsBySymplectic4", with_fields<Integrator::symplectic4>},
    {"Statics", with_statics},
};

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// Every frame's hash over ISA x threads against scalar on one thread.
void expect_same_bits(const Case& c, std::size_t n, int frames, const std::vector<int>& threads) {
  auto base = c.build(n, Isa::scalar, 1);
  const auto truth = hashes(*base, frames);
  ASSERT_NE(truth.front(), truth.back());
  ASSERT_TRUE(all_finite(*base));
  for (const Isa isa : available_isas()) {
    for (const int t : threads) {
      auto world = c.build(n, isa, t);
      ASSERT_EQ(world->isa(), isa);
      for (int k = 0; k < frames; ++k) {
        world->step();
        ASSERT_EQ(world->state_hash(), truth[static_cast<std::size_t>(k)])
            << c.name << ": " << isa_name(isa) << " with " << t << " threads leaves at frame " << k;
      }
    }
  }
}

class Determinism : public testing::TestWithParam<Case> {};
class SlowDeterminism : public testing::TestWithParam<Case> {};

TEST_P(Determinism, SameBitsFromEveryIsaAndThreadCount) { expect_same_bits(GetParam(), 600, 60, {1, 2, 3, 8}); }

TEST_P(Determinism, TwoRunsAreEqual) {
  auto a = GetParam().build(500, best_isa(), 3);
  auto b = GetParam().build(500, best_isa(), 3);
  EXPECT_EQ(hashes(*a, 60), hashes(*b, 60));
}

TEST_P(SlowDeterminism, SameBitsFromEveryIsaAndThreadCount) {
  expect_same_bits(GetParam(), 6000, 90, {1, 2, 3, 8, 16});
}

INSTANTIATE_TEST_SUITE_P(, Determinism, testing::ValuesIn(kCases), name_of);
INSTANTIATE_TEST_SUITE_P(, SlowDeterminism, testing::ValuesIn(kCases), name_of);

TEST(Isas, ForcedIsaIsTheOneThatRan) {
  ASSERT_FALSE(available_isas().empty());
  EXPECT_TRUE(isa_available(Isa::scalar));
  for (const Isa isa : available_isas()) {
    auto world = pile(64, {}, isa);
    run(*world, 30);
    EXPECT_EQ(world->isa(), isa);
    EXPECT_EQ(parse_isa(isa_name(isa)), isa);
    const LaneCounts lanes = world->lane_counts();
    EXPECT_GT(lanes.vector + lanes.scalar, 0u);
    if (isa == Isa::scalar) {
      EXPECT_EQ(lanes.vector, 0u);
    } else {
      EXPECT_GT(lanes.vector, 0u);
    }
  }
  EXPECT_TRUE(isa_available(best_isa()));
  EXPECT_FALSE(parse_isa("mmx").has_value());
  EXPECT_EQ(isa_lanes(Isa::scalar), 1);
  constexpr int kLanes[] = {1, 4, 8, 4, 4};
  static_assert(std::size(kLanes) == std::size(kAllIsas));
  for (const Isa isa : kAllIsas) {
    if (isa_lanes(isa) == 0) continue;  // of another processor
    EXPECT_EQ(isa_lanes(isa), kLanes[static_cast<std::size_t>(isa)]) << isa_name(isa);
  }
}

TEST(Isas, RunSideBySide) {
  std::vector<std::unique_ptr<World>> worlds;
  for (const Isa isa : available_isas()) worlds.push_back(pile(100, material(0.3, 0.5), isa));
  for (int k = 0; k < 60; ++k) {
    for (auto& world : worlds) world->step();
    for (auto& world : worlds) ASSERT_EQ(world->state_hash(), worlds[0]->state_hash()) << k;
  }
}

TEST(Threads, AreAsManyAsAskedFor) {
  for (const int t : {1, 2, 16}) EXPECT_EQ(make(unbounded(), best_isa(), t)->threads(), t);
}

TEST(Threads, OfTheHostMayStepManyWorldsAtOnce) {
  auto truth = pile(200, material(0.3, 0.5));
  const auto expected = hashes(*truth, 60);
  std::vector<std::vector<std::uint64_t>> seen(4);
  std::vector<std::thread> hosts;
  for (auto& out : seen) {
    hosts.emplace_back([&out] {
      auto world = pile(200, material(0.3, 0.5), best_isa(), 2);
      out = hashes(*world, 60);
    });
  }
  for (auto& host : hosts) host.join();
  for (const auto& h : seen) EXPECT_EQ(h, expected);
}

TEST(Threads, BodiesAddedAndRemovedMidRunGiveTheSameBits) {
  const auto play = [](Isa isa, int threads) {
    auto world = pile(400, material(0.3, 0.5), isa, threads);
    std::vector<std::uint64_t> all;
    for (int k = 0; k < 90; ++k) {
      if (k == 20) add(*world, lattice(50, {2, 40, 18, 60}, 0.3, 5, material(0.9)));
      if (k == 35) {
        for (std::uint32_t id = 3; id < 400; id += 9) world->remove_body(world->id_of(id));
      }
      if (k == 50) add(*world, segment({2, 5}, {12, 9}, material(0, 0.1)));
      if (k == 60) add(*world, lattice(30, {2, 62, 18, 75}, 0.5, 5, {}));
      if (k == 70) world->set_velocity(world->id_of(1), {100, 50}, 7);
      world->step();
      all.push_back(world->state_hash());
    }
    return all;
  };
  const auto truth = play(Isa::scalar, 1);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 2, 8}) {
      EXPECT_EQ(play(isa, threads), truth) << isa_name(isa) << " " << threads;
    }
  }
}

TEST(Threads, StepLengthMayChangeEachFrame) {
  const auto play = [](Isa isa, int threads) {
    auto world = pile(300, material(0.3, 0.5), isa, threads);
    Random random(3);
    std::vector<std::uint64_t> all;
    for (int k = 0; k < 60; ++k) {
      world->step(random.uniform(1e-4, 1.0 / 20));
      all.push_back(world->state_hash());
    }
    return all;
  };
  const auto truth = play(Isa::scalar, 1);
  for (const Isa isa : available_isas()) EXPECT_EQ(play(isa, 3), truth) << isa_name(isa);
}

// ---- the host's own job systems ---------------------------------------------------------------

/// All jobs on the calling thread, last first.
JobSystem backwards(std::atomic<std::uint64_t>& calls) {
  JobSystem jobs;
  jobs.workers = 1;
  jobs.parallel_for = [&calls](std::size_t count, const std::function<void(std::size_t)>& job) {
    ++calls;
    for (std::size_t k = count; k > 0; --k) job(k - 1);
  };
  return jobs;
}

/// New threads for every call, jobs claimed by a counter.
JobSystem threads_each_time(std::atomic<std::uint64_t>& calls, int workers) {
  JobSystem jobs;
  jobs.workers = workers;
  jobs.parallel_for = [&calls, workers](std::size_t count, const std::function<void(std::size_t)>& job) {
    ++calls;
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> crew;
    for (int w = 0; w < workers; ++w) {
      crew.emplace_back([&] {
        for (std::size_t k = next++; k < count; k = next++) job(k);
      });
    }
    for (auto& worker : crew) worker.join();
  };
  return jobs;
}

TEST(JobSystems, OfTheHostGiveTheSameBits) {
  auto truth = pile(3000, material(0.3, 0.5), best_isa(), 1);
  const auto expected = hashes(*truth, 30);
  std::atomic<std::uint64_t> calls{0};
  for (const int kind : {0, 1, 2}) {
    auto world = pile(3000, material(0.3, 0.5), best_isa(), kind == 2 ? 3 : 1);
    world->set_job_system(kind == 0 ? backwards(calls) : threads_each_time(calls, 3));
    EXPECT_EQ(hashes(*world, 30), expected) << kind;
  }
  EXPECT_GT(calls.load(), 0u);
}

TEST(JobSystems, MayBeTakenAwayAgain) {
  auto truth = pile(1000, material(0.3, 0.5));
  const auto expected = hashes(*truth, 30);
  std::atomic<std::uint64_t> calls{0};
  auto world = pile(1000, material(0.3, 0.5), best_isa(), 2);
  auto got = hashes(*world, 10);
  world->set_job_system(threads_each_time(calls, 2));
  for (const auto h : hashes(*world, 10)) got.push_back(h);
  world->set_job_system({});
  const auto before = calls.load();
  for (const auto h : hashes(*world, 10)) got.push_back(h);
  EXPECT_EQ(got, expected);
  EXPECT_EQ(calls.load(), before);
}

}  // namespace
}  // namespace psim::test
