// Strips and colours, as World::strips and World::contacts tell them: what is done side by side shares no body.
#include <map>
#include <set>
#include <tuple>

#include "rigid_support.h"

namespace psim::test {
namespace {

bool is_dynamic(World& world, BodyId id) { return id != kNoBody && state(world, id).type == BodyType::dynamic_body; }

/// Discs of many sizes, boxes, capsules, a lift, hinges of a chain, and a floor: about 900 bodies.
std::unique_ptr<World> mixed(Boundary boundary, Isa isa = best_isa(), int threads = 1) {
  WorldDesc desc =
      boundary == Boundary::periodic ? periodic(60, 60) : walled({0, 0, 60, 60}, {0, -kG}, material(0, 0.3));
  if (boundary == Boundary::periodic) desc.gravity = {0, -1};
  desc.sleeping = false;
  auto world = make(desc, isa, threads);
  add(*world, chain({{1, 8}, {15, 2}, {30, 1}, {45, 2}, {59, 8}}, false, material(0, 0.3)));
  add(*world, moving(kinematic(box({30, 14}, 12, 1)), {0, 0.5}));
  add(*world, lattice(700, {0.5, 16, 59.5, 56}, 0.4, 3, material(0.1, 0.3)));
  for (int k = 0; k < 60; ++k) {
    const Vec2 at{2.0 + 1.9 * (k % 30), 10.0 + 1.5 * (k / 30)};
    if (std::fabs(at.x - 30) < 7 && at.y < 16) continue;
    add(*world, k % 2 == 0 ? box(at, 1.2, 0.8, material(0, 0.3)) : capsule(at, 0.8, 0.3, material(0, 0.3)));
  }
  return world;
}

/// Contacts of one colour of one strip share no dynamic body; those of two dynamic bodies of strips that run side by
/// side neither. Counts those that have a colour.
std::size_t expect_apart(World& world) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::map<std::uint32_t, const Contact*>> seen;
  std::map<std::uint32_t, std::uint32_t> strip_of[2];
  std::size_t coloured = 0;
  std::uint32_t last = 0;  // that of large bodies, if there are any: it runs alone
  for (const std::uint32_t strip : world.strips()) last = strip == kNoStrip ? last : std::max(last, strip);
  for (const Contact& c : world.contacts()) {
    EXPECT_NE(c.strip, kNoStrip);
    const bool pair = is_dynamic(world, c.a) && is_dynamic(world, c.b);
    for (const BodyId id : {c.a, c.b}) {
      if (!is_dynamic(world, id)) continue;
      if (pair && c.strip != last) {
        const auto [at, fresh] = strip_of[c.strip % 2].try_emplace(id.index, c.strip);
        EXPECT_EQ(at->second, c.strip) << id.index;
      }
      if (c.colour == kNoColour) continue;
      const auto [at, fresh] = seen[{c.strip, c.colour}].try_emplace(id.index, &c);
      const Contact& other = *at->second;  // the other point of the same manifold
      EXPECT_TRUE(fresh || (&c == &other + 1 && c.a == other.a && c.b == other.b && c.normal.x == other.normal.x))
          << "strip " << c.strip << " colour " << c.colour << " body " << id.index;
    }
    coloured += c.colour != kNoColour ? 1 : 0;
  }
  return coloured;
}

TEST(Strips, ContactsOfAColourShareNoBody) {
  for (const Boundary boundary : {Boundary::walls, Boundary::periodic}) {
    auto world = mixed(boundary);
    std::size_t contacts = 0, coloured = 0;
    std::set<std::uint32_t> strips, colours;
    const bool walls = boundary == Boundary::walls;
    for (int k = 0; k < 200; ++k) {
      world->step();
      if (k % 10 != 9) continue;
      coloured += expect_apart(*world);
      contacts += world->contacts().size();
      for (const Contact& c : world->contacts()) {
        strips.insert(c.strip);
        colours.insert(c.colour);
      }
    }
    EXPECT_GT(contacts, walls ? 5000u : 200u);
    EXPECT_EQ(coloured, contacts);
    EXPECT_GE(strips.size(), 4u);
    EXPECT_GE(colours.size(), walls ? 6u : 3u);
    EXPECT_LE(*colours.rbegin(), 60u);  // numbered through from 0
    EXPECT_EQ(*colours.begin(), 0u);
  }
}

// More neighbours than there are colours; and heavy bodies on light ones, whose contacts have colours of their own.
TEST(Strips, ContactsThatFindNoColourAreSolvedByThemselves) {
  WorldDesc desc = walled({0, 0, 60, 60});
  desc.sleeping = false;
  auto world = make(desc);
  add(*world, lattice(500, {0.5, 0.5, 59.5, 8}, 0.25, 0, {}));
  BodyDesc heavy = disc({31, 20}, {0, -2}, 8);
  heavy.material.density = 50;
  const BodyId big = add(*world, heavy);
  std::size_t alone = 0, others = 0, coloured = 0;
  for (int k = 0; k < 240; ++k) {
    world->step();
    if (k % 2 != 0) continue;
    coloured += expect_apart(*world);
    for (const Contact& c : world->contacts()) {
      if (c.colour == kNoColour) ++(c.a == big || c.b == big ? alone : others);
    }
  }
  EXPECT_GT(alone, 10u);
  EXPECT_LE(others, coloured / 500);  // small ones that are pressed into many others
  EXPECT_GT(coloured, 1000u);
}

TEST(Strips, AreRowsFromBelowUpwards) {
  WorldDesc desc = walled({0, 0, 100, 40});
  desc.sleeping = false;
  auto world = make(desc);
  EXPECT_TRUE(world->strips().empty());
  add(*world, lattice(1500, {0.5, 0.5, 99.5, 39.5}, 0.4, 1, {}));
  const BodyId still = add(*world, static_disc({50, 39.9}, 0.05));
  const std::size_t n = world->body_count();
  ASSERT_EQ(world->strips().size(), n);
  EXPECT_TRUE(std::ranges::all_of(world->strips(), [](std::uint32_t s) { return s == kNoStrip; }));  // no step yet
  world->step();
  std::map<std::uint32_t, std::pair<double, double>> span;  // of y, by strip
  const std::span<const std::uint32_t> strips = world->strips();
  ASSERT_EQ(strips.size(), n);
  for (std::uint32_t id = 0; id < n; ++id) {
    if (id == still.index) {
      EXPECT_EQ(strips[id], kNoStrip);
      continue;
    }
    ASSERT_NE(strips[id], kNoStrip);
    const double y = state(*world, world->id_of(id)).y;
    auto& [low, high] = span.try_emplace(strips[id], y, y).first->second;
    low = std::min(low, y);
    high = std::max(high, y);
  }
  ASSERT_GE(span.size(), 5u);
  double below = -1;
  for (const auto& [strip, y] : span) {
    EXPECT_GT(y.first, below - 0.1) << strip;  // they moved since
    below = y.second;
  }
  // A contact of two bodies is found from one of them, whose strip it has.
  for (const Contact& c : world->contacts()) {
    EXPECT_TRUE(c.strip == strips[c.a.index] || (c.b != kNoBody && c.strip == strips[c.b.index]));
  }
  const BodyId gone = world->id_of(7);
  ASSERT_TRUE(world->remove_body(gone));
  const BodyId fresh = add(*world, disc({50, 39.5}, {}, 0.1));
  EXPECT_EQ(fresh.index, gone.index);
  EXPECT_EQ(world->strips()[fresh.index], kNoStrip);
  world->step();
  EXPECT_NE(world->strips()[fresh.index], kNoStrip);
}

TEST(Strips, SleepersHaveNone) {
  auto world = make(walled({-20, 0, 20, 40}));
  for (int k = 0; k < 8; ++k) add(*world, disc({-14.0 + 4 * k, 0.5}));
  world->step();
  for (const std::uint32_t strip : world->strips()) EXPECT_NE(strip, kNoStrip);
  for (const Contact& c : world->contacts()) EXPECT_NE(c.strip, kNoStrip);
  std::size_t asleep = 0;
  for (int k = 0; k < 300 && asleep < 8; ++k) asleep = world->step().asleep;
  ASSERT_EQ(asleep, 8u);
  for (const std::uint32_t strip : world->strips()) EXPECT_EQ(strip, kNoStrip);
  ASSERT_EQ(world->contacts().size(), 8u);
  for (const Contact& c : world->contacts()) {
    EXPECT_EQ(c.strip, kNoStrip);
    EXPECT_EQ(c.colour, kNoColour);
  }
}

TEST(Strips, AreTheSameOnEveryIsaAndThreadCountAndAskingChangesNothing) {
  using Group = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<std::vector<Group>> first;
  std::vector<std::vector<std::uint32_t>> first_strips;
  std::uint64_t unasked = 0;
  {
    auto world = mixed(Boundary::walls);
    run(*world, 120);
    unasked = world->state_hash();
  }
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = mixed(Boundary::walls, isa, threads);
      std::vector<std::vector<Group>> all;
      std::vector<std::vector<std::uint32_t>> strips;
      for (int k = 0; k < 120; ++k) {
        world->step();
        if (k % 20 != 19) continue;
        all.emplace_back();
        for (const Contact& c : world->contacts()) all.back().emplace_back(c.strip, c.colour);
        strips.emplace_back(world->strips().begin(), world->strips().end());
      }
      EXPECT_EQ(world->state_hash(), unasked);
      if (first.empty()) first = all, first_strips = strips;
      EXPECT_TRUE(all == first);
      EXPECT_TRUE(strips == first_strips);
    }
  }
}

// Lists that last come back with their colours; of lists for a step there are none before the next step.
TEST(Strips, ComeBackWithASavedState) {
  for (const double speed : {0.0, 12.0}) {
    WorldDesc desc = walled({0, 0, 60, 60});
    desc.sleeping = false;
    auto world = make(desc);
    add(*world, lattice(800, {0.5, 0.5, 59.5, 40}, 0.5, speed, material(0)));
    run(*world, speed > 0 ? 50 : 300);
    std::vector<std::byte> state;
    world->save(state);
    std::string error;
    auto other = World::from_state(state, {}, error);
    ASSERT_TRUE(other) << error;
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(std::ranges::equal(world->strips(), other->strips())) << k;
      using Key = std::tuple<std::uint32_t, std::uint32_t, long, long>;  // in a corner two of one body
      const auto key = [](const Contact& c) {
        return Key{c.a.index, c.b.index, std::lround(c.normal.x), std::lround(c.normal.y)};
      };
      std::map<Key, const Contact*> there;
      for (const Contact& c : other->contacts()) there[key(c)] = &c;
      std::size_t known = 0;
      for (const Contact& c : world->contacts()) {
        const auto at = there.find(key(c));
        if (at == there.end()) continue;  // it carries nothing
        EXPECT_EQ(at->second->strip, c.strip);
        if (at->second->colour == kNoColour) continue;
        EXPECT_EQ(at->second->colour, c.colour);
        ++known;
      }
      if (k > 0 || speed == 0) {
        EXPECT_GT(known, 10u) << k;
      }
      world->step();
      other->step();
    }
  }
}

}  // namespace
}  // namespace psim::test
