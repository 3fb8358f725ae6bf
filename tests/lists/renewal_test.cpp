// Lists that last are made anew for the bodies that used up their margin: nobody is missed, the same bits come out
// everywhere and after a restore, and impulses stay.
#include <psim/recording.h>

#include <random>

#include "rigid_support.h"

namespace psim::test {
namespace {

struct Case {
  const char* name;
  bool periodic, rough, mixed, fixed;
  double wide;  // m; the height follows
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

BodyId id(std::uint32_t index) {
  BodyId id;
  id.index = index;
  return id;
}

class Renewal : public testing::TestWithParam<Case> {
 protected:
  static constexpr std::uint32_t kBodies = 1000;

  // A pile that has come down.
  std::unique_ptr<World> settled(Isa isa = best_isa(), int threads = 1, bool sleeping = false) {
    std::vector<std::byte>& state = states_[sleeping];
    if (state.empty()) built(sleeping)->save(state);
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    std::string error;
    auto world = World::from_state(state, options, error);
    if (!world) throw std::runtime_error(error);
    return world;
  }

  std::unique_ptr<World> built(bool sleeping) const {
    const Case& c = GetParam();
    WorldDesc desc = walled({0, 0, c.wide, 6 * kBodies / c.wide}, {0, -kG}, c.rough ? material(0, 0.5) : Material{});
    if (c.periodic) {
      desc.boundary = Boundary::periodic;
      desc.gravity = {};
    }
    desc.sleeping = sleeping;
    auto world = make(desc);
    const double high = (c.periodic ? 5.8 : 1.2) * kBodies / c.wide;
    Discs discs =
        lattice(kBodies, {0.5, 2.5, c.wide - 0.5, 2.5 + high}, 0.5, 0.1, c.rough ? material(0.2, 0.5) : Material{});
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0.35, 0.5);
    if (c.mixed) {
      for (double& r : discs.radius) r = radius(random);
      discs.radius[0] = 0.5;
    }
    add(*world, discs);
    if (c.fixed) {
      for (double x = 1; x < c.wide; x += 3) add(*world, static_disc({x, 1}, 0.7));
      add(*world, segment({0.5, 0.3}, {c.wide - 0.5, 0.3}));
    }
    run(*world, 300);
    return world;
  }

  // Every third frame six discs get a push.
  void push(World& world, int frame) const {
    if (frame % 3 != 0) return;
    std::mt19937 random(static_cast<unsigned>(frame));
    for (int k = 0; k < 6; ++k) {
      auto index = static_cast<std::uint32_t>(random() % kBodies);
      if (GetParam().periodic) index -= index % 50;  // who flies there flies on
      if (!world.body(id(index))) continue;
      const double angle = static_cast<double>(random() % 628) / 100;
      world.set_velocity(id(index), {4 * std::cos(angle), 4 * std::sin(angle)}, 0);
    }
  }

 private:
  std::vector<std::byte> states_[2];
};

Vec2 way(const WorldDesc& desc, const PublishedState& s, std::size_t i, std::size_t j) {
  Vec2 d{s.x[j] - s.x[i], s.y[j] - s.y[i]};
  if (desc.boundary != Boundary::periodic) return d;
  const Bounds& b = desc.bounds;
  d.x -= (b.xmax - b.xmin) * std::round(d.x / (b.xmax - b.xmin));
  d.y -= (b.ymax - b.ymin) * std::round(d.y / (b.ymax - b.ymin));
  return d;
}

TEST_P(Renewal, SeesWhateverTouches) {
  auto world = settled();
  std::uint64_t renewed = 0, rebuilt = 0;
  int frames = 0;
  for (int frame = 0; frame < 120; ++frame) {
    push(*world, frame);
    const StepReport report = world->step();
    renewed += report.renewed;
    rebuilt += report.rebuilt;
    frames += report.renewed != 0;
    if (report.renewed == 0) continue;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> named;
    for (const Contact& c : world->contacts()) named.emplace_back(c.a.index, c.b.index);
    const PublishedState s = world->published();
    for (std::size_t i = 0; i < s.id.size(); ++i) {
      for (std::size_t j = i + 1; j < s.id.size(); ++j) {
        const double sum = s.radius[i] + s.radius[j];
        const Vec2 d = way(world->desc(), s, i, j);
        // Deeper than an impact within the step leaves it.
        if (std::fabs(d.x) > sum || std::hypot(d.x, d.y) > sum - 0.03) continue;
        EXPECT_TRUE(std::ranges::binary_search(named, std::pair(s.id[i], s.id[j])))
            << "frame " << frame << ": " << s.id[i] << " and " << s.id[j] << ", " << sum - std::hypot(d.x, d.y);
      }
    }
  }
  EXPECT_GT(frames, 30);
  EXPECT_GT(renewed, 200u);
  EXPECT_LT(rebuilt, 60u);
}

TEST_P(Renewal, GivesTheSameBitsEverywhere) {
  std::vector<std::uint64_t> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = settled(isa, threads);
      std::vector<std::uint64_t> mine;
      for (int frame = 0; frame < 60; ++frame) {
        push(*world, frame);
        world->step();
        mine.push_back(world->state_hash());
      }
      if (first.empty()) first = mine;
      EXPECT_EQ(mine, first) << static_cast<int>(isa) << ", " << threads << " threads";
    }
  }
}

// Another world takes over after every step, and at every fifth one that was something else before.
TEST_P(Renewal, GoesOnAfterARestore) {
  for (const bool sleeping : {false, true}) {
    auto world = settled(best_isa(), 1, sleeping);
    auto twin = settled(best_isa(), 2, sleeping);
    std::vector<std::byte> state, again;
    std::string error;
    std::uint64_t renewed = 0;
    for (int frame = 0; frame < 60; ++frame) {
      push(*world, frame);
      push(*twin, frame);
      renewed += world->step().renewed;
      const StepReport report = twin->step();
      ASSERT_EQ(twin->state_hash(), world->state_hash()) << "frame " << frame << ", renewed " << report.renewed;
      if (frame % 5 == 4) twin = settled(best_isa(), 2, sleeping);
      world->save(state);
      ASSERT_TRUE(twin->restore(state, error)) << error;
      if (frame % 2 == 0) continue;
      twin->save(again);
      ASSERT_EQ(again, state) << "frame " << frame;
    }
    EXPECT_GT(renewed, 60u);
  }
}

// Where the host takes a body out, all lists are made again, and the others' impulses go with them.
TEST_P(Renewal, LeavesNothingBehindWhenBodiesGo) {
  if (GetParam().periodic) GTEST_SKIP() << "nobody rests on anybody";
  auto world = settled();
  auto twin = settled();
  std::vector<std::byte> state;
  std::string error;
  for (std::uint32_t frame = 0; frame < 60; ++frame) {
    push(*world, static_cast<int>(frame));
    push(*twin, static_cast<int>(frame));
    if (frame % 7 == 3) {
      ASSERT_TRUE(world->remove_body(id(11 * frame)));
      ASSERT_TRUE(twin->remove_body(id(11 * frame)));
      world->save(state);
      ASSERT_TRUE(twin->restore(state, error)) << error;
    }
    world->step();
    twin->step();
    ASSERT_EQ(twin->state_hash(), world->state_hash()) << "frame " << frame;
  }
  EXPECT_TRUE(all_finite(*world));
}

TEST_P(Renewal, KeepsThePileWhereItLies) {
  if (GetParam().periodic) GTEST_SKIP() << "no pile";
  auto world = settled();
  run(*world, 300);
  const PublishedState before = world->published();
  const double deepest_before = deepest(*world);
  // One is thrown straight up and comes down again.
  std::uint32_t top = 0;
  for (std::size_t k = 0; k < before.id.size(); ++k) {
    if (before.y[k] > before.y[top]) top = static_cast<std::uint32_t>(k);
  }
  const std::vector<double> x(before.x.begin(), before.x.end()), y(before.y.begin(), before.y.end());
  ASSERT_TRUE(world->set_velocity(id(before.id[top]), {0, 4}, 0));
  std::uint64_t renewed = 0, rebuilt = 0;
  for (int frame = 0; frame < 40; ++frame) {  // it is in the air
    const StepReport report = world->step();
    renewed += report.renewed;
    rebuilt += report.rebuilt;
  }
  EXPECT_GT(renewed, 5u);
  EXPECT_LT(rebuilt, 5u);
  const PublishedState after = world->published();
  int moved = 0;
  for (std::size_t k = 0; k < x.size(); ++k) moved += std::hypot(after.x[k] - x[k], after.y[k] - y[k]) > 0.05;
  EXPECT_LE(moved, 4);  // it, and who leant on it
  EXPECT_LT(deepest(*world), deepest_before + 0.005);
}

// Discs that come down beside a pile get contacts with the floor: the pile's own go on with what they bear.
TEST(RenewalImpulses, StayWhereFixedShapesGetNewContacts) {
  double fastest[2] = {};
  for (const bool fall : {false, true}) {
    WorldDesc desc = walled({0, 0, 60, 60});
    desc.sleeping = false;
    auto world = make(desc);
    add(*world, segment({30, 0}, {30, 60}));
    add(*world, lattice(900, {0.5, 0.5, 29.5, 36}, 0.5, 0, {}));
    std::vector<BodyId> others;
    others.reserve(15);
    for (int k = 0; k < 15; ++k) others.push_back(add(*world, disc({32.0 + k, 50.0})));
    run(*world, 900);
    std::uint64_t renewed = 0;
    for (int frame = 0; frame < 120; ++frame) {
      for (std::size_t k = 0; fall && frame % 40 == 0 && k < others.size(); ++k) {
        world->set_velocity(others[k], {0, 2.5 + 0.1 * static_cast<double>(k)}, 0);
      }
      renewed += world->step().renewed;
      const PublishedState s = world->published();
      for (std::size_t k = 0; k < 900; ++k) fastest[fall] = std::max(fastest[fall], std::hypot(s.vx[k], s.vy[k]));
    }
    EXPECT_GE(renewed, fall ? 50u : 0u);
  }
  EXPECT_LT(fastest[1], 1.5 * fastest[0] + 0.001);
}

// A pile of discs so large beside the others that they have cells of their own, thrown about on top of it.
TEST(RenewalLarge, SeeWhateverTouches) {
  constexpr std::uint32_t kLarge = 1000, kSmall = 5000;
  constexpr double kRadius = 2, kFew = 0.1;
  WorldDesc desc = walled({0, 0, 220, 200});
  desc.sleeping = false;
  auto world = make(desc);
  for (std::uint32_t k = 0; k < kLarge; ++k) {
    const std::uint32_t row = k / 50, column = k % 50;
    add(*world, disc({kRadius * (1 + 2 * column + row % 2) - 0.05, kRadius * (1 + std::sqrt(3.0) * row)}, {}, kRadius));
  }
  for (std::uint32_t k = 0; k < kSmall; ++k) {
    add(*world, disc({202 + kFew * (1 + 2 * (k % 88)), kFew * (1 + 2 * (k / 88))}, {}, kFew));
  }
  add(*world, segment({201.9, 0}, {201.9, 200}));
  run(*world, 30);
  std::mt19937 random(5);
  std::uint64_t renewed = 0;
  for (int frame = 0; frame < 90; ++frame) {
    for (int k = 0; frame % 10 == 0 && k < 6; ++k) {
      const auto top = static_cast<std::uint32_t>(kLarge - 1 - random() % 50);
      world->set_velocity(id(top), {static_cast<double>(random() % 17) - 8, 6}, 0);
    }
    const StepReport report = world->step();
    if (report.renewed == 0) continue;
    renewed += report.renewed;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> named;
    for (const Contact& c : world->contacts()) named.emplace_back(c.a.index, c.b.index);
    const PublishedState s = world->published();
    std::vector<std::size_t> large;
    for (std::size_t i = 0; i < s.id.size(); ++i) {
      if (s.id[i] < kLarge) large.push_back(i);
    }
    ASSERT_EQ(large.size(), kLarge);
    for (const std::size_t i : large) {
      for (const std::size_t j : large) {
        if (s.id[j] <= s.id[i] || std::fabs(s.x[j] - s.x[i]) > 2 * kRadius) continue;
        const double depth = 2 * kRadius - std::hypot(s.x[j] - s.x[i], s.y[j] - s.y[i]);
        if (depth < 0.03) continue;
        EXPECT_TRUE(std::ranges::binary_search(named, std::pair(s.id[i], s.id[j])))
            << "frame " << frame << ": " << s.id[i] << " and " << s.id[j] << ", " << depth;
      }
    }
  }
  EXPECT_GT(renewed, 100u);
}

// Boxes and hexagons among discs, in a heap and alone on bumpy ground: whoever overlaps is known to, of the moving and
// the fixed.
TEST(RenewalShapes, SeeWhateverTouches) {
  constexpr std::uint32_t kHeap = 800, kCount = kHeap + 20;
  WorldDesc desc = walled({0, 0, 90, 60}, {0, -kG}, kGrip);
  desc.sleeping = false;
  auto world = make(desc);
  std::mt19937 random(3);
  std::vector<Vec2> bumps;
  for (double x = 89.8; x > 0; x -= 0.8) bumps.push_back({x, 0.3 + 0.4 * static_cast<double>(random() % 100) / 100});
  const BodyId floor = add(*world, chain(bumps, false, kGrip));
  std::vector<BodyDesc> shapes;
  std::vector<BodyId> ids;
  for (std::uint32_t k = 0; k < kCount; ++k) {
    const Vec2 at = k < kHeap ? Vec2{1.0 + 1.2 * (k % 40), 2.0 + 1.2 * (k / 40)} : Vec2{60 + 1.4 * (k - kHeap), 2};
    shapes.push_back(k % 3 == 0   ? disc(at, {}, 0.45, kGrip)
                     : k % 3 == 1 ? box(at, 0.8, 0.7, kGrip)
                                  : polygon(regular(6, 0.45), at, kGrip));
    ids.push_back(add(*world, shapes.back()));
  }
  run(*world, 400);
  const auto smaller = [&](std::size_t k) -> Shape {
    constexpr double kLess = 0.006;
    if (k % 3 == 0) return DiscShape{0.45 - kLess};
    if (k % 3 == 1) return BoxShape{0.8 - 2 * kLess, 0.7 - 2 * kLess};
    return PolygonShape{regular(6, 0.45 - 1.2 * kLess)};
  };
  std::uint64_t renewed = 0, rebuilt = 0, overlaps = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> missed, before;  // an impact may leave two so for a step
  for (int frame = 0; frame < 240; ++frame) {
    for (std::size_t k = 0; frame % 20 == 0 && k < 8; ++k) {  // some from the heap's top, and the others
      const double way = k % 2 == 0 ? 2.5 : -2.5;
      world->set_velocity(ids[kHeap - 1 - (5 * k + static_cast<std::size_t>(frame)) % 40], {1.5 * way, 3}, way);
      if (k % 4 < 2 && frame % 60 == 0) world->set_velocity(ids[kHeap + 2 * k], {way, 4}, 0.1 * way);
    }
    const StepReport report = world->step();
    renewed += report.renewed;
    rebuilt += report.rebuilt;
    before.swap(missed);
    missed.clear();
    std::vector<std::pair<std::uint32_t, std::uint32_t>> named;
    std::size_t points = 0;
    for (const Contact& c : world->contacts()) {
      const bool moving = c.a.index != floor.index && c.b.index != kNoBody.index;
      points = moving && !named.empty() && named[named.size() - 2] == std::pair(c.a.index, c.b.index) ? points + 1 : 1;
      EXPECT_LE(points, 2u) << "frame " << frame << ": " << c.a.index << " and " << c.b.index << " have two contacts";
      named.emplace_back(c.a.index, c.b.index);
      named.emplace_back(c.b.index, c.a.index);
    }
    std::ranges::sort(named);
    for (std::size_t k = 0; k < kCount; ++k) {
      const BodyState s = state(*world, ids[k]);
      for (const BodyId other : world->overlap(smaller(k), {s.x, s.y}, s.angle)) {
        const std::pair pair(ids[k].index, other.index);
        if (pair.first == pair.second) continue;
        ++overlaps;
        if (std::ranges::binary_search(named, pair)) continue;
        missed.push_back(pair);
        EXPECT_FALSE(std::ranges::count(before, pair))
            << "frame " << frame << ": " << pair.first << " and " << pair.second;
      }
    }
  }
  EXPECT_GT(renewed, 300u);
  EXPECT_LT(rebuilt, 75u);
  EXPECT_GT(overlaps, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Of, Renewal,
                         testing::Values(Case{"discs", false, false, false, false, 40},
                                         Case{"rough", false, true, false, false, 40},
                                         Case{"mixed", false, true, true, false, 25},
                                         Case{"fixed", false, true, false, true, 60},
                                         Case{"periodic", true, false, false, false, 40}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace psim::test
