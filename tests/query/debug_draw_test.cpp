// World::debug_draw: what the host draws is what the world has.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "joint_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

struct Drawn : DebugDraw {
  struct Part {
    std::vector<Vec2> corners;  // one: a circle
    double radius = 0, angle = 0;
    DrawKind kind{};
    BodyId body;
  };
  struct Line {
    Vec2 from, to;
    DrawKind kind{};
  };
  std::vector<Part> parts;
  std::vector<Line> lines;
  std::vector<Vec2> points;

  void circle(Vec2 centre, double radius, double angle, DrawKind kind, BodyId body) override {
    parts.push_back({{centre}, radius, angle, kind, body});
  }
  void polygon(std::span<const Vec2> corners, double radius, DrawKind kind, BodyId body) override {
    parts.push_back({{corners.begin(), corners.end()}, radius, 0, kind, body});
  }
  void line(Vec2 from, Vec2 to, DrawKind kind) override { lines.push_back({from, to, kind}); }
  void point(Vec2 at, DrawKind kind) override {
    EXPECT_EQ(kind, DrawKind::contact);
    points.push_back(at);
  }
  std::size_t count(DrawKind kind) const {
    return static_cast<std::size_t>(std::ranges::count(lines, kind, &Line::kind));
  }
};

std::vector<double> numbers(const Drawn& d) {
  std::vector<double> all;
  for (const Drawn::Part& p : d.parts) {
    all.insert(all.end(), {p.radius, p.angle, static_cast<double>(p.kind), static_cast<double>(p.body.index)});
    for (const Vec2 v : p.corners) all.insert(all.end(), {v.x, v.y});
  }
  for (const Drawn::Line& l : d.lines) all.insert(all.end(), {l.from.x, l.from.y, l.to.x, l.to.y});
  for (const Vec2 p : d.points) all.insert(all.end(), {p.x, p.y});
  return all;
}

DebugDrawOptions all_of() {
  DebugDrawOptions options;
  options.contacts = options.forces = true;
  return options;
}

std::unique_ptr<World> yard(Isa isa = best_isa(), int threads = 1) {
  auto world = make(walled({-10, 0, 10, 30}, {0, -kG}, kGrip), isa, threads);
  Random r(4);
  add(*world, segment({-10, 1}, {-5, 0.2}, kGrip));
  add(*world, fixed(box({0, 2}, 3, 0.5, kGrip)));
  BodyDesc chain = segment({}, {});
  chain.shape = ChainShape{{{8, 0.5}, {6, 1}, {4, 0.5}}};
  add(*world, chain);
  BodyDesc eye = static_disc({7, 5}, 1);
  eye.sensor = true;
  add(*world, eye);
  add(*world, kinematic(moving(box({-6, 6}, 3, 0.4), {0.1, 0}, 1)));
  for (int k = 0; k < 60; ++k) {
    const Vec2 at{-8 + 1.4 * (k % 12), 4 + 1.6 * (k / 12)};
    BodyDesc body = disc(at, {}, 0.4, kGrip);
    if (k % 4 == 1) body = box(at, 0.8, 0.5, kGrip);
    if (k % 4 == 2) body = capsule(at, 0.5, 0.2, kGrip);
    if (k % 4 == 3) body.shape = CompoundShape{{{BoxShape{0.8, 0.2}}, {DiscShape{0.25}, {0.4, 0}}}};
    body.angle = r.uniform(-3, 3);
    add(*world, body);
  }
  return world;
}

// Each body comes in the order of ids, with as many parts as it has, of the right kind, and where it is: the middle of a
// part overlaps the body, a place beyond its border does not.
TEST(DebugDraw, ShowsEveryBody) {
  auto world = yard();
  for (int frame = 0; frame < 400; frame += 40) {
    Drawn d;
    ASSERT_TRUE(world->debug_draw(d, {}));
    std::map<std::uint32_t, int> parts;
    std::uint32_t last = 0;
    for (const Drawn::Part& p : d.parts) {
      EXPECT_GE(p.body.index, last);
      last = p.body.index;
      ++parts[p.body.index];
      const BodyState s = state(*world, p.body);
      const bool sensor = p.kind == DrawKind::sensor;
      DrawKind want = s.type == BodyType::static_body      ? DrawKind::static_body
                      : s.type == BodyType::kinematic_body ? DrawKind::kinematic_body
                      : world->is_awake(p.body)            ? DrawKind::dynamic_body
                                                           : DrawKind::asleep;
      if (world->traits(p.body)->sensor) want = DrawKind::sensor;
      EXPECT_EQ(p.kind, want);
      Vec2 middle;
      for (const Vec2 v : p.corners) middle = {middle.x + v.x, middle.y + v.y};
      const auto n = static_cast<double>(p.corners.size());
      middle = {middle.x / n, middle.y / n};
      QueryFilter filter;
      filter.sensors = sensor;
      const auto found = world->overlap(DiscShape{1e-6}, middle, 0, filter);
      EXPECT_NE(std::ranges::find(found, p.body), found.end()) << p.body.index;
      EXPECT_NEAR(p.angle, p.corners.size() == 1 ? s.angle : 0, 1e-12);
      for (std::size_t k = 0; p.corners.size() > 2 && k < p.corners.size(); ++k) {  // counter-clockwise
        const Vec2 a = p.corners[k], b = p.corners[(k + 1) % p.corners.size()];
        EXPECT_GT((b.x - a.x) * (middle.y - a.y) - (b.y - a.y) * (middle.x - a.x), 0);
      }
    }
    EXPECT_EQ(parts.size(), world->body_count());
    for (const auto& [id, count] : parts) {
      const int want = id == 2 || (id >= 5 && (id - 5) % 4 == 3) ? 2 : 1;  // the chain, and bodies of two parts
      EXPECT_EQ(count, want) << id;
    }
    EXPECT_EQ(d.count(DrawKind::bounds), 4u);
    for (int k = 0; k < 40; ++k) world->step();
  }
}

TEST(DebugDraw, ShowsContactsAndForces) {
  auto world = yard();
  for (int k = 0; k < 500; ++k) world->step();
  Drawn d;
  ASSERT_TRUE(world->debug_draw(d, all_of()));
  const auto contacts = world->contacts();
  EXPECT_EQ(d.points.size(), contacts.size());
  EXPECT_EQ(d.count(DrawKind::contact), contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) EXPECT_EQ(d.points[k].x, contacts[k].point.x);
  // A box that rests: the forces on it are its weight.
  auto rest = make(unbounded(20));
  add(*rest, ground(kGrip));
  add(*rest, box({0, 0.5}, 1, 1, kGrip, 2));
  for (int k = 0; k < 20; ++k) rest->step();
  Drawn of;
  DebugDrawOptions options = all_of();
  options.force_scale = 1;
  ASSERT_TRUE(rest->debug_draw(of, options));
  double sum = 0;
  for (const Drawn::Line& l : of.lines) {
    if (l.kind == DrawKind::force) sum += l.to.y - l.from.y;
  }
  EXPECT_NEAR(sum, 2 * kG, 0.01 * 2 * kG);
  EXPECT_EQ(of.count(DrawKind::bounds), 0u) << "the world is open";
}

TEST(DebugDraw, ShowsParticles) {
  auto world = make(walled({0, 0, 10, 10}, {0, -kG}));
  add(*world, disc({5, 5}));
  std::string error;
  const FluidId water = world->add_fluid({.spacing = 0.5}, error);
  ASSERT_EQ(water, 0u) << error;
  ASSERT_TRUE(world->add_particles(water, std::vector<Vec2>{{1, 1}, {2, 1}, {8, 9}}, {}, error)) << error;
  Drawn d;
  ASSERT_TRUE(world->debug_draw(d, {}));
  ASSERT_EQ(d.parts.size(), 4u);
  for (std::size_t k = 0; k < 3; ++k) {  // before the body
    EXPECT_EQ(d.parts[k].kind, DrawKind::particle);
    EXPECT_EQ(d.parts[k].radius, 0.25);
    EXPECT_EQ(d.parts[k].body, kNoBody);
  }
  EXPECT_EQ(d.parts[1].corners[0].x, 2);
  DebugDrawOptions options;
  options.region = Bounds{2.2, 0, 8, 8};
  Drawn some;
  ASSERT_TRUE(world->debug_draw(some, options));
  EXPECT_EQ(some.parts.size(), 2u) << "one reaches into the region";
  options.particles = false;
  Drawn none;
  ASSERT_TRUE(world->debug_draw(none, options));
  EXPECT_EQ(none.parts.size(), 1u);
}

// A line leads from each end of a joint to the other.
TEST(DebugDraw, ShowsJoints) {
  auto world = make(unbounded(20));
  const BodyId a = add(*world, fixed(box({0, 5}))), b = add(*world, box({3, 5}));
  JointDesc rod;
  rod.a = a, rod.b = b, rod.anchor_b = {-0.5, 0};
  std::string error;
  const JointId id = world->add_joint(rod, error);
  ASSERT_NE(id, kNoJoint) << error;
  for (int k = 0; k < 10; ++k) world->step();
  Drawn d;
  ASSERT_TRUE(world->debug_draw(d, all_of()));
  EXPECT_EQ(d.count(DrawKind::joint), 2u) << "the rod, and the arm of b";
  const JointState s = world->joint(id).value();
  const bool there = std::ranges::any_of(d.lines, [&](const Drawn::Line& l) {
    return l.from.x == s.anchor_a.x && l.to.x == s.anchor_b.x && l.to.y == s.anchor_b.y;
  });
  EXPECT_TRUE(there);
  EXPECT_EQ(d.count(DrawKind::force), 1u);
  ASSERT_TRUE(world->remove_joint(id));
  Drawn without;
  ASSERT_TRUE(world->debug_draw(without, {}));
  EXPECT_EQ(without.count(DrawKind::joint), 0u);
}

// Within a region come the same calls, without those that do not reach into it; in a periodic world also of copies.
TEST(DebugDraw, KeepsToTheRegion) {
  auto world = yard();
  for (int k = 0; k < 60; ++k) world->step();
  DebugDrawOptions options;
  options.region = Bounds{-3, 1, 4, 6};
  Drawn all, some;
  ASSERT_TRUE(world->debug_draw(all, {}));
  ASSERT_TRUE(world->debug_draw(some, options));
  EXPECT_LT(some.parts.size(), all.parts.size());
  std::set<std::uint32_t> drawn;
  for (const Drawn::Part& p : some.parts) drawn.insert(p.body.index);
  QueryFilter filter;
  filter.sensors = true;
  for (const BodyId id : world->in_region(*options.region, filter)) EXPECT_TRUE(drawn.count(id.index)) << id.index;

  auto wraps = make(periodic(10, 10));
  add(*wraps, disc({0.1, 5}));
  options.region = Bounds{-1, 0, 11, 10};
  Drawn copies;
  ASSERT_TRUE(wraps->debug_draw(copies, options));
  ASSERT_EQ(copies.parts.size(), 2u);
  EXPECT_NEAR(copies.parts[0].corners[0].x, 0.1, 1e-6);
  EXPECT_NEAR(copies.parts[1].corners[0].x, 10.1, 1e-6);
}

TEST(DebugDraw, IsTheSameEverywhereAndChangesNothing) {
  std::vector<double> want;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = yard(isa, threads);
      auto unseen = yard(isa, threads);
      Drawn d;
      for (int k = 0; k < 120; ++k) {
        if (k % 10 == 0) world->debug_draw(d, all_of());
        world->step();
        unseen->step();
      }
      EXPECT_EQ(world->state_hash(), unseen->state_hash());
      if (want.empty()) want = numbers(d);
      EXPECT_EQ(numbers(d), want) << static_cast<int>(isa) << " " << threads;
    }
  }
}

TEST(DebugDraw, RefusesWhatIsNoNumber) {
  auto world = yard();
  for (const double wrong : {kNan, kInf}) {
    Drawn d;
    DebugDrawOptions options;
    options.force_scale = wrong;
    EXPECT_FALSE(world->debug_draw(d, options));
    options = {};
    options.normal_length = wrong;
    EXPECT_FALSE(world->debug_draw(d, options));
    options = {};
    options.region = Bounds{0, 0, wrong, 1};
    EXPECT_FALSE(world->debug_draw(d, options));
    options.region = Bounds{1, 0, 0, 1};
    EXPECT_FALSE(world->debug_draw(d, options));
    EXPECT_TRUE(numbers(d).empty());
  }
}

}  // namespace
}  // namespace psim::test
