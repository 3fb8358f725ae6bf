// Scenes of all shapes give the same bits from every instruction set and number of threads, wherever
// they lie on the lattice; and warm steps allocate nothing.
#include "allocation_counter.h"
#include "rigid_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

BodyDesc any_shape(Random& random, Vec2 at, Material m) {
  const double size = random.uniform(0.4, 1);
  BodyDesc body;
  switch (random.below(5)) {
    case 0:
      body = box(at, size, random.uniform(0.4, 1), m);
      break;
    case 1:
      body = capsule(at, 0.6 * size, random.uniform(0.1, 0.25), m);
      break;
    case 2:
      body = polygon(regular(3 + static_cast<int>(random.below(6)), 0.6 * size), at, m);
      break;
    case 3:
      body = polygon({{0, 0}, {size, 0.1}, {0.3, 0.8 * size}}, at, m);
      break;
    default:
      body = disc(at, {}, 0.5 * size, m);
      break;
  }
  body.bullet = random.chance(0.1);
  body.angle = random.uniform(-3, 3);
  return moving(body, {random.uniform(-3, 3), random.uniform(-3, 3)}, random.uniform(-4, 4));
}

void pour(World& world, std::size_t n, Bounds region, Material m, std::uint64_t seed = 4) {
  Random random(seed);
  const auto columns = static_cast<std::size_t>((region.xmax - region.xmin) / 1.4);
  for (std::size_t k = 0; k < n; ++k) {
    const double x = region.xmin + 1.4 * (static_cast<double>(k % columns) + 0.5);
    const double y = region.ymin + 1.4 * (static_cast<double>(k / columns) + 0.5);
    add(world, any_shape(random, {x, y}, m));
  }
}

void furnish(World& world, Vec2 at, Material m) {
  const auto put = [&](BodyDesc body) {
    body.position.x += at.x;
    body.position.y += at.y;
    add(world, body);
  };
  put(fixed(turned(box({-6, -3}, 4, 0.5, m), 0.3)));
  put(fixed(polygon({{0, 0}, {3, 0.5}, {1, 2}}, {2, -5}, m)));
  put(fixed(turned(capsule({7, -2}, 3, 0.3, m), -0.4)));
  put(moving(kinematic(box({0, -1}, 5, 0.3, m)), {0, 0}, 1.5));
  put(moving(kinematic(polygon({{0, -0.2}, {3, -0.2}, {3, 0.2}, {0, 0.2}}, {-8, 0}, m)), {0.2, 0}, -2));
  put(chain({{-10, -8}, {-5, -9}, {0, -8.5}, {6, -9}, {10, -8}}, false, m));
}

struct Case {
  const char* name;
  std::unique_ptr<World> (*build)(Isa isa, int threads);
};

const Case kCases[] = {
    {"Heap",
     [](Isa isa, int threads) {
       const Material m = material(0, 0.4);
       auto world = make(walled({-12, -12, 12, 60}, {0, -kG}, m), isa, threads);
       furnish(*world, {0, 0}, m);
       pour(*world, 300, {-11, 2, 11, 60}, m);
       return world;
     }},
    {"BouncingHeap",
     [](Isa isa, int threads) {
       const Material m = material(0.5, 0.3);
       auto world = make(walled({-12, -12, 12, 60}, {0, -kG}, m), isa, threads);
       furnish(*world, {0, 0}, m);
       pour(*world, 300, {-11, 2, 11, 60}, m);
       return world;
     }},
    {"Smooth",
     [](Isa isa, int threads) {
       auto world = make(walled({-12, -12, 12, 60}), isa, threads);
       pour(*world, 300, {-11, -11, 11, 60}, {});
       return world;
     }},
    {"Open",
     [](Isa isa, int threads) {
       const Material m = material(0.2, 0.4);
       auto world = make(unbounded(30), isa, threads);
       furnish(*world, {0, 0}, m);
       pour(*world, 250, {-11, 2, 11, 30}, m);
       return world;
     }},
    {"Periodic",
     [](Isa isa, int threads) {
       const Material m = material(0.6, 0.3);
       WorldDesc desc = periodic(30, 30);
       desc.gravity = {0.5, -1};
       auto world = make(desc, isa, threads);
       furnish(*world, {15, 15}, m);
       pour(*world, 300, {0, 0, 30, 30}, m);
       return world;
     }},
    {"Columns",
     [](Isa isa, int threads) {
       auto world = make(unbounded(100), isa, threads);
       add(*world, ground(kGrip));
       for (int tower = 0; tower < 12; ++tower) {
         for (int k = 0; k < 15; ++k) {
           add(*world, box({3.0 * tower - 18, k + 0.5}, 1, 1, kGrip, k == 14 ? 50 : 1));
         }
       }
       pour(*world, 20, {-20, 16, 20, 30}, kGrip);
       return world;
     }},
};

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class RigidDeterminism : public testing::TestWithParam<Case> {};

TEST_P(RigidDeterminism, SameBitsFromEveryIsaAndThreadCount) {
  constexpr int kFrames = kSanitized ? 120 : 240;
  auto base = GetParam().build(Isa::scalar, 1);
  const auto truth = hashes(*base, kFrames);
  ASSERT_NE(truth.front(), truth.back());
  ASSERT_TRUE(all_finite(*base));
  for (const Isa isa : available_isas()) {
    for (const int threads : thread_counts()) {
      auto world = GetParam().build(isa, threads);
      for (int k = 0; k < kFrames; ++k) {
        world->step();
        ASSERT_EQ(world->state_hash(), truth[static_cast<std::size_t>(k)])
            << isa_name(isa) << " with " << threads << " threads leaves at frame " << k;
      }
    }
  }
}

TEST_P(RigidDeterminism, TwoRunsAreEqual) {
  auto a = GetParam().build(best_isa(), 3);
  auto b = GetParam().build(best_isa(), 3);
  EXPECT_EQ(hashes(*a, 60), hashes(*b, 60));
}

TEST_P(RigidDeterminism, LookingAtAWorldChangesNothing) {
  auto a = GetParam().build(best_isa(), 1);
  auto b = GetParam().build(best_isa(), 1);
  for (int k = 0; k < 60; ++k) {
    a->step();
    b->diagnostics();
    b->published();
    b->memory_bytes();
    b->step();
    ASSERT_EQ(a->state_hash(), b->state_hash()) << k;
  }
}

TEST_P(RigidDeterminism, NothingGoesOut) {
  auto world = GetParam().build(best_isa(), 1);
  for (int k = 0; k < (kSanitized ? 300 : 600); ++k) ASSERT_EQ(world->step().quarantined, 0u) << k;
  EXPECT_TRUE(all_finite(*world));
  if (world->desc().boundary != Boundary::walls) return;
  const Bounds b = world->desc().bounds;
  const PublishedState s = world->published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {  // `position` may be a corner, a little inside a wall
    EXPECT_TRUE(s.x[k] > b.xmin - 0.05 && s.x[k] < b.xmax + 0.05 && s.y[k] > b.ymin - 0.05 && s.y[k] < b.ymax + 0.05)
        << s.id[k] << " at " << s.x[k] << " " << s.y[k];
  }
}

// Where bodies fall for ever, a strip may yet get more contacts than it ever had, and its lists grow once more: of eight
// times 120 frames, some do without.
TEST_P(RigidDeterminism, WarmStepsAllocateNothing) {
  if (std::string_view(GetParam().name) == "Open") GTEST_SKIP() << "its bodies leave";
  if (kSanitized) GTEST_SKIP() << "a sanitizer changes no count of allocations";
  const bool falls = std::string_view(GetParam().name) == "Periodic";
  for (const int threads : {1, 3}) {
    auto world = GetParam().build(best_isa(), threads);
    world->set_sleeping(false);
    run(*world, 900);
    std::uint64_t growths = 0, grown = 0;
    for (int trial = 0; trial < (falls ? 8 : 1); ++trial) {
      growths = 0;
      const std::uint64_t before = allocations();
      for (int k = 0; k < 120; ++k) growths += world->step().arena_growths;
      grown = allocations() - before;
      if (growths == 0 && grown == 0) break;
    }
    EXPECT_EQ(growths, 0u) << threads;
    EXPECT_EQ(grown, 0u) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(, RigidDeterminism, testing::ValuesIn(kCases), name_of);

// ---- elsewhere on the lattice -----------------------------------------------------------------

/// Velocities and angles of all bodies after the frames.
std::vector<double> motions(World& world, int frames) {
  run(world, frames);
  const PublishedState s = world.published();
  std::vector<double> all;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    for (const double value : {s.vx[k], s.vy[k], s.omega[k], s.angle[k]}) all.push_back(value);
  }
  return all;
}

constexpr double kGrain = 0x1p-10;  // m: whole in the lattice of every world here

double on_grain(double v) { return std::nearbyint(v / kGrain) * kGrain; }

TEST(RigidTranslation, ByWholeLatticePitchesChangesNoBit) {
  std::vector<double> truth;
  for (const double move : {0.0, kGrain, 12345 * kGrain, 768.0, -700.5}) {
    const Material m = material(0.2, 0.4);
    auto world = make(unbounded(1024));
    furnish(*world, {move, 0}, m);
    Random random(4);
    for (int k = 0; k < 120; ++k) {
      add(*world, any_shape(random, {on_grain(k % 12 * 1.4 - 8) + move, 2 + k / 12 * 1.4}, m));
    }
    const auto now = motions(*world, 120);
    if (truth.empty()) {
      truth = now;
    } else {
      EXPECT_EQ(now, truth) << move;
    }
  }
}

TEST(RigidTranslation, OfAStackOfAHundred) {
  std::vector<double> truth;
  for (const double move : {0.0, 512.25}) {
    auto world = make(unbounded(1024));
    add(*world, segment({move - 5, 0}, {move + 5, 0}, kGrip));
    for (int k = 0; k < 100; ++k) add(*world, box({move, k + 0.5}, 1, 1, kGrip));
    const auto now = motions(*world, 300);
    if (truth.empty()) {
      truth = now;
    } else {
      EXPECT_EQ(now, truth);
    }
  }
}

}  // namespace
}  // namespace psim::test
