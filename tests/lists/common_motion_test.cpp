// Lists that last by what bodies have in common: who has used up no margin does not touch who is not listed, however far
// both went; heaps that move as a whole keep their lists, with the same bits everywhere and after a restore.
#include "lists/common_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "base/machine.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// ---- alone: random motions

// Bodies in a box of 100 x 60 m, about a metre apart, whose lists know them at `places`.
class CommonMotionTest : public testing::Test {
 protected:
  static constexpr double kEdge = 8, kSkin = 0.15, kBeside = 1.5;
  static constexpr float kRadius = 0.5f;

  // Bodies anywhere: some overlap. Nobody is in the first column of regions beyond x = 0 if that is to be empty.
  void fill(std::mt19937& random, bool gap) {
    const double low = -std::floor((periodic ? 50 : 49.9) / edge()) * edge();
    std::uniform_real_distribution<double> x(low, 49.9), y(-29.9, 29.9);
    add({low, 0});
    while (bodies.count < 6000) {
      const Vec2 at{x(random), y(random)};
      if (!gap || at.x < 0 || at.x > edge()) add(at);
    }
    know();
  }
  void know() {
    places.assign(bodies.pos.data(), bodies.pos.data() + 2 * std::size_t{bodies.count});
    reach.assign(bodies.count, kRadius + static_cast<float>(kSkin));
  }
  // m: of the regions, which are cut from the lowest body on: fill() puts that where x = 0 is the border of two.
  double edge() const {
    return std::ldexp(lattice.pitch_x(), static_cast<int>(std::ceil(std::log2(kEdge / lattice.pitch_x()))));
  }
  void add(Vec2 at) {
    const std::uint32_t slot = bodies.count;
    if (slot % 1024 == 0) {
      bodies.reserve_slots(1024 + 8);
      bodies.info.reserve(bodies.id_count + 1024 + 8);
    }
    bodies.id[slot] = bodies.take_id();
    ++bodies.count;
    bodies.radius[slot] = kRadius;
    bodies.pos[2 * slot] = steps(at.x, lattice.pitch_x());
    bodies.pos[2 * slot + 1] = steps(at.y, lattice.pitch_y());
    bodies.vel[2 * slot] = bodies.vel[2 * slot + 1] = 0;
  }
  static std::int32_t steps(double way, double pitch) { return static_cast<std::int32_t>(std::lround(way / pitch)); }

  // Everybody goes the way of a field, m, and a little by itself; `flying` of them fly some metres. `rate`, 1/s: the speeds
  // over the ways.
  template <class Field>
  void move(std::mt19937& random, const Field& field, double own, int flying, double rate) {
    std::uniform_real_distribution<double> around(-own, own), far(-3, 3);
    const auto go = [&](std::size_t i, Vec2 way) {
      bodies.pos[2 * i] = wrap_add(bodies.pos[2 * i], steps(way.x, lattice.pitch_x()));
      bodies.pos[2 * i + 1] = wrap_add(bodies.pos[2 * i + 1], steps(way.y, lattice.pitch_y()));
    };
    for (std::size_t i = 0; i < bodies.count; ++i) {
      const Vec2 way = field(lattice.metres(places[2 * i], places[2 * i + 1])) + Vec2{around(random), around(random)};
      go(i, way);
      bodies.vel[2 * i] = static_cast<float>(way.x * rate);
      bodies.vel[2 * i + 1] = static_cast<float>(way.y * rate);
    }
    for (int k = 0; k < flying; ++k) {
      go(random() % bodies.count, {far(random), far(random)});
    }
  }
  template <class Field>
  void move(const Field& field) {
    std::mt19937 unused;
    move(unused, field, 0, 0, 60);
  }
  bool update() { return common.update(places.data(), fixed, kBeside); }
  float use(std::uint32_t slot, float time) const {
    return common.use(slot, places.data() + 2 * std::size_t{slot}, time);
  }
  bool spent(std::uint32_t slot, float time) const { return use(slot, time) > reach[slot] - kRadius; }
  void renew(std::uint32_t slot) {
    std::int32_t at[2] = {places[2 * std::size_t{slot}], places[2 * std::size_t{slot} + 1]};
    common.find_place(slot, at);
    common.move_member(places.data() + 2 * std::size_t{slot}, at);
    std::copy_n(at, 2, places.data() + 2 * std::size_t{slot});
    reach[slot] = kRadius + static_cast<float>(kSkin) + std::max(use(slot, 0.03f), 0.0f);
  }

  // Checks all pairs that are not listed at their places, of bodies that have margin left, `time` seconds ahead.
  void expect_unlisted_apart(float time, const char* when) {
    std::map<std::pair<int, int>, std::vector<std::uint32_t>> near;
    const auto ahead = [&](std::size_t i) {
      return lattice.metres(bodies.pos[2 * i], bodies.pos[2 * i + 1]) +
             double{time} * Vec2{static_cast<double>(bodies.vel[2 * i]), static_cast<double>(bodies.vel[2 * i + 1])};
    };
    const auto cell = [this](Vec2 at) {
      const auto x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
      return periodic ? std::pair((x + 1000) % 100, (y + 600) % 60) : std::pair(x, y);
    };
    for (std::uint32_t i = 0; i < bodies.count; ++i) near[cell(ahead(i))].push_back(i);
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      if (spent(i, time)) continue;
      const Vec2 at = ahead(i), known = lattice.metres(places[2 * std::size_t{i}], places[2 * std::size_t{i} + 1]);
      EXPECT_TRUE(wall_is_listed(at, known, reach[i])) << when;
      for (int k = 0; k < 9; ++k) {
        const auto found = near.find(cell(at + Vec2{k % 3 - 1.0, k / 3 - 1.0}));
        if (found == near.end()) continue;
        for (const std::uint32_t j : found->second) {
          if (j <= i || spent(j, time) || length_of(across(ahead(j) - at)) >= 2 * double{kRadius} - 1e-4) continue;
          const Vec2 was = across(lattice.metres(places[2 * std::size_t{j}], places[2 * std::size_t{j} + 1]) - known);
          EXPECT_LT(length_of(was), double{reach[i]} + double{reach[j]}) << when << ": " << i << " meets " << j;
        }
      }
    }
  }
  Vec2 across(Vec2 d) const { return periodic ? Vec2{std::remainder(d.x, 100), std::remainder(d.y, 60)} : d; }
  bool wall_is_listed(Vec2 at, Vec2 known, float of) const {
    if (!fixed.walls) return true;
    const Bounds& b = fixed.bounds;
    const double r = double{kRadius} - 1e-4, far = double{of} + kBeside;
    return !((at.x - r < b.xmin && known.x - far >= b.xmin) || (at.x + r > b.xmax && known.x + far <= b.xmax) ||
             (at.y - r < b.ymin && known.y - far >= b.ymin) || (at.y + r > b.ymax && known.y + far <= b.ymax));
  }

  MemoryMeter memory;
  WorkerPool pool{1};
  KinematicBodies kinematics;
  MixingRules mixing;
  Material wall;
  BodyStore bodies{memory};
  Lattice lattice{{-50, -30, 50, 30}, false};
  StaticShapes shapes{memory, lattice};
  const kernels::KernelTable kernels = kernels_of(best_isa());
  CommonMotion common{{memory, lattice, bodies, shapes, kernels, pool, kinematics, mixing, wall}};
  CommonMotion::Fixed fixed{true, {-50, -30, 50, 30}};
  bool periodic = false;
  std::vector<std::int32_t> places;
  std::vector<float> reach;
};

TEST_F(CommonMotionTest, WhoIsNotListedIsNotMet) {
  int served = 0, renewed = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(-1, 1);
    bodies.count = 0;
    const unsigned kind = seed % 5;
    const bool tight = kind == 1 || kind == 4;
    periodic = kind == 4;
    lattice = Lattice({-50, -30, 50, 30}, periodic);
    fixed.walls = kind != 2 && !periodic;
    fill(random, kind == 2);
    ASSERT_TRUE(common.cut(kEdge)) << seed;
    const double shear = 0.05 * part(random), length = 10 + 40 * std::fabs(part(random));
    const Vec2 all{kind == 3 ? 1.4 : 0.3 * part(random), 0.3 * part(random)};
    const auto field = [&](Vec2 at) {
      if (kind == 4) return Vec2{at.x < 0 ? -0.02 : 0.02, 0};  // two halves press against each other at the seam
      if (kind == 1) return Vec2{at.x < 0 ? 0.02 : -0.02, 0};  // two halves press against each other
      if (kind == 2) return Vec2{at.x < 0 ? 0.7 : -0.7, 0};    // a gap closes
      return all + shear * Vec2{std::sin(at.y / length), std::sin(at.x / length)};
    };
    for (int step = 0; step < 16; ++step) {
      move(random, field, tight ? 0.001 : 0.02, 60, tight ? 600 : 60);
      if (!update()) break;
      ++served;
      expect_unlisted_apart(0, "now");
      expect_unlisted_apart(0.01f, "soon");
      for (std::uint32_t i = 0; i < bodies.count; ++i) {
        if (!spent(i, 0.02f) || renewed++ % 2 != 0) continue;
        renew(i);
      }
      expect_unlisted_apart(0, "renewed");
    }
  }
  EXPECT_GT(served, 30);
  EXPECT_GT(renewed, 1000);
}

TEST_F(CommonMotionTest, AHeapThatMovesAsAWholeUsesNothing) {
  std::mt19937 random(1);
  fill(random, false);
  ASSERT_TRUE(common.cut(kEdge));
  move([](Vec2) { return Vec2{0.7, -0.4}; });
  EXPECT_TRUE(update());
  std::uint32_t middle = 0;
  while (length_of(lattice.metres(places[2 * std::size_t{middle}], places[2 * std::size_t{middle} + 1])) > 1) ++middle;
  EXPECT_LT(use(middle, 0.02f), 1e-4f);
  move([](Vec2) { return Vec2{9, 0}; });
  EXPECT_FALSE(update());  // so far that walls may be near
}

// Who flies into an empty region is met by bodies that did not know of it: it bears alone what they differ by.
TEST_F(CommonMotionTest, WhoEntersAnEmptyRegionAllowsForAllThatItsNeighboursDo) {
  std::mt19937 random(2);
  fixed.walls = false;
  fill(random, true);
  ASSERT_TRUE(common.cut(kEdge));
  move([](Vec2 at) { return Vec2{at.x < 0 ? 0.7 : -0.7, 0}; });
  ASSERT_TRUE(update());
  const std::int32_t between[2] = {steps(edge() / 2, lattice.pitch_x()), 0};
  std::copy_n(between, 2, bodies.pos.data());
  bodies.vel[0] = bodies.vel[1] = 0;
  EXPECT_GT(common.use(0, between, 0), 0.69f);
}

TEST_F(CommonMotionTest, LooseBodiesHaveNothingInCommon) {
  for (int k = 0; k < 600; ++k) add({-48 + k % 30 * 3.2, -28 + k / 30 * 2.8});
  know();
  ASSERT_TRUE(common.cut(kEdge));
  move([](Vec2) { return Vec2{0.3, 0}; });
  update();
  EXPECT_NEAR(use(300, 0), 0.3f, 1e-3f);
}

TEST_F(CommonMotionTest, AWorldThatIsMostlyEmptyIsNotCut) {
  add({-45, -25});
  add({45, 25});
  EXPECT_TRUE(common.cut(20));
  EXPECT_FALSE(common.cut(1));
  EXPECT_FALSE(common.on());
}

// ---- in a world

void expect_overlaps_are_listed(World& world, double deeper) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> named;
  for (const Contact& c : world.contacts()) named.emplace_back(c.a.index, c.b.index);
  const PublishedState s = world.published();
  std::vector<std::size_t> by_x(s.id.size());
  std::iota(by_x.begin(), by_x.end(), std::size_t{0});
  std::ranges::sort(by_x, {}, [&](std::size_t k) { return s.x[k]; });
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    for (std::size_t j = i + 1; j < by_x.size() && s.x[by_x[j]] - s.x[by_x[i]] < 1; ++j) {
      const std::size_t a = std::min(by_x[i], by_x[j]), b = std::max(by_x[i], by_x[j]);
      if (std::hypot(s.x[b] - s.x[a], s.y[b] - s.y[a]) > s.radius[a] + s.radius[b] - deeper) continue;
      EXPECT_TRUE(std::ranges::binary_search(named, std::pair(s.id[a], s.id[b]))) << s.id[a] << " and " << s.id[b];
    }
  }
}

// A block of packed discs that falls, far above anything.
std::unique_ptr<World> falling(Isa isa = best_isa(), int threads = 1) {
  WorldDesc desc = walled({-100, -3000, 100, 1000}, {0, -kG});
  auto world = make(desc, isa, threads);
  for (int k = 0; k < 5000; ++k) {  // in triangles
    const int column = k % 70, row = k / 70;
    add(*world, disc({1.01 * column + 0.505 * (row % 2) - 35, 0.88 * row}));
  }
  return world;
}

TEST(CommonLists, LastWhileABlockFalls) {
  auto world = falling();
  run(*world, 60);  // 10 m/s
  int rebuilt = 0;
  for (int frame = 0; frame < 60; ++frame) rebuilt += world->step().rebuilt;
  EXPECT_LE(rebuilt, 12);
}

// A heap that was let fall and sways.
TEST(CommonLists, SeeWhateverTouchesInAHeapThatSways) {
  auto world = make(walled({0, 0, 90, 200}, {0, -kG}), best_isa(), 2);
  add(*world, lattice(5000, {0.5, 0.5, 60, 87}, 0.5, 0.01, Material{}));
  run(*world, 400);
  int kept = 0;
  for (int frame = 0; frame < 60; ++frame) {
    kept += !world->step().rebuilt;
    if (frame % 10 == 0) expect_overlaps_are_listed(*world, 0.05);
  }
  EXPECT_GE(kept, 20);
}

TEST(CommonLists, AreTheSameEverywhereAndAfterARestore) {
  const auto play = [](World& world, int frames) {
    std::vector<std::uint64_t> all;
    for (int k = 0; k < frames; ++k) {
      world.step();
      all.push_back(world.state_hash());
    }
    return all;
  };
  auto world = falling();
  run(*world, 50);
  std::vector<std::byte> state;
  world->save(state);
  const auto expected = play(*world, 40);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      RunOptions options;
      options.isa = isa;
      options.threads = threads;
      std::string error;
      auto again = World::from_state(state, options, error);
      ASSERT_TRUE(again) << error;
      EXPECT_EQ(play(*again, 40), expected) << static_cast<int>(isa) << ", " << threads << " threads";
    }
  }
}

TEST(CommonLists, AreTheSameWhereverABlockFalls) {
  const auto speeds_at = [](double far) {
    WorldDesc desc;
    desc.boundary = Boundary::open;
    desc.bounds = kOpenBounds;
    auto world = make(desc);
    Discs discs = lattice(5000, {-35, 0, 35, 77}, 0.5, 0.01, Material{});
    for (double& x : discs.x) x += far;
    add(*world, discs);
    run(*world, 80);
    const PublishedState s = world->published();
    return std::vector(s.vy.begin(), s.vy.end());
  };
  EXPECT_EQ(speeds_at(0), speeds_at(4096));
}

}  // namespace
}  // namespace psim::test
