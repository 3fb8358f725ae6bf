// World::diagnostics and the virial of a step, against sums over what the world publishes: states of bodies, contacts.
#include <array>
#include <map>
#include <string>
#include <variant>

#include "body_outlines.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

/// Of a body of 1 kg: its centre of mass, m, and its moment of inertia about it, m^2.
struct Unit {
  Vec2 centre;
  double inertia = 0;
};

Unit unit_of(const std::vector<Vec2>& v) {
  double area = 0, inertia = 0;
  Vec2 sum;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const Vec2 p = v[k], q = v[(k + 1) % v.size()];
    const double c = p.x * q.y - p.y * q.x;
    area += c / 2;
    sum = {sum.x + c * (p.x + q.x) / 6, sum.y + c * (p.y + q.y) / 6};
    inertia += c * (p.x * p.x + p.y * p.y + p.x * q.x + p.y * q.y + q.x * q.x + q.y * q.y) / 12;
  }
  const Vec2 centre{sum.x / area, sum.y / area};
  return {centre, inertia / area - (centre.x * centre.x + centre.y * centre.y)};
}

Unit unit_of(const Shape& shape) {
  if (const auto* d = std::get_if<DiscShape>(&shape)) return {{}, d->radius * d->radius / 2};
  if (const auto* b = std::get_if<BoxShape>(&shape)) {
    return {{}, (b->width * b->width + b->height * b->height) / 12};
  }
  if (const auto* p = std::get_if<PolygonShape>(&shape)) return unit_of(p->vertices);
  const auto& c = std::get<CapsuleShape>(shape);  // level, about (0, 0)
  const double r = c.radius, l = c.p2.x - c.p1.x, middle = 2 * r * l, ends = kPi * r * r;
  const double of_ends = ends * (r * r / 2 + l * l / 4 + 2 * l / 2 * (4 * r / (3 * kPi)));
  return {{}, (middle * (l * l + 4 * r * r) / 12 + of_ends) / (middle + ends)};
}

enum class Space { pen, ground, torus };

struct Setting {
  const char* name;
  Space space = Space::pen;
  double e = 0, friction = 0;
  bool discs = true, shapes = true, joints = false, kinematics = false, sleeping = false;
};

/// Bodies of every kind in a heap, and their descriptions by id.
struct Mixture {
  std::unique_ptr<World> world;
  std::map<std::uint32_t, BodyDesc> desc;
  Setting setting;
  double side = 14;

  Mixture(const Setting& s, std::uint64_t seed, int threads = 1) : setting(s) {
    Random r(seed);
    const Material m = material(s.e, s.friction);
    WorldDesc d = s.space == Space::pen      ? walled({0, 0, side, 3 * side}, {0, -kG}, m)
                  : s.space == Space::ground ? unbounded(100)
                                             : periodic(side, side);
    d.sleeping = s.sleeping;
    world = make(d, best_isa(), threads);
    if (s.space == Space::ground) {
      put(fixed(box({side / 2 - 2, -0.5}, 4, 1, m)));
      put(fixed(box({side / 2 + 2, -0.5}, 4, 1, m)));
      put(segment({side / 2 - 4, 0}, {-10, 4}, m));
      put(chain({{side + 20, 10}, {side + 2, 1}, {side / 2 + 4, 0}}, false, m));
      put(static_disc({side / 2, 2}, 0.7, m));
    }
    if (s.kinematics) {
      put(moving(kinematic(box({0.3 * side, 3}, 3, 0.4, m)), {0.2, 0.3}, 0.4));
      put(moving(kinematic(disc({0.7 * side, 2}, {}, 0.6, m)), {0, 0.3}));
    }
    for (int k = 0; k < 60; ++k) add_one(r, k, m);
    if (s.joints) tie();
  }

  BodyId put(const BodyDesc& body) {
    const BodyId id = add(*world, body);
    desc[id.index] = body;
    return id;
  }

  void add_one(Random& r, int k, const Material& m) {
    const Vec2 at{1.2 + 1.45 * (k % 9), 4.6 + 1.35 * (k / 9)};
    const std::size_t kind = !setting.shapes ? 0 : r.below(setting.discs ? 4 : 3) + (setting.discs ? 0 : 1);
    // Drawn one after the other: compilers evaluate arguments in different orders.
    const double second = kind == 1 ? r.uniform(0.4, 1) : kind == 2 ? r.uniform(0.15, 0.3) : 0;
    BodyDesc body = kind == 0   ? disc(at, {}, r.uniform(0.25, 0.55), m)
                    : kind == 1 ? box(at, r.uniform(0.4, 1), second, m)
                    : kind == 2 ? capsule(at, r.uniform(0.2, 0.6), second, m)
                                : polygon({{-0.3, -0.4}, {0.6, -0.3}, {0.4, 0.5}, {-0.2, 0.4}}, at, m);
    body.angle = r.uniform(-3, 3);
    body.velocity = {r.uniform(-2, 2), r.uniform(-2, 2)};
    body.angular_velocity = r.uniform(-3, 3);
    body.mass = r.uniform(0.5, 3);
    if (k % 7 == 0) body.gravity_scale = 0.5;
    put(body);
  }

  void tie() {
    const auto last = static_cast<std::uint32_t>(world->body_count()) - 1;
    const JointType kinds[] = {JointType::distance, JointType::revolute, JointType::spring, JointType::weld};
    for (std::uint32_t k = 0; k < 7; ++k) {
      JointDesc joint;
      joint.type = kinds[k % 4];
      joint.a = world->id_of(last - 2 * k);
      joint.b = world->id_of(last - 2 * k - 1);
      joint.stiffness = joint.type == JointType::spring ? 50 : 0;
      if (joint.type == JointType::revolute || joint.type == JointType::weld) {
        const BodyState a = state(*world, joint.a), b = state(*world, joint.b);
        const Vec2 middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
        const auto within = [&](const BodyState& s) {
          const double c = std::cos(s.angle), n = std::sin(s.angle), x = middle.x - s.x, y = middle.y - s.y;
          return Vec2{c * x + n * y, c * y - n * x};
        };
        joint.anchor_a = within(a);
        joint.anchor_b = within(b);
      }
      std::string error;
      ASSERT_NE(world->add_joint(joint, error), kNoJoint) << error;
    }
  }

  bool dynamic(std::uint32_t id) const { return desc.at(id).type == BodyType::dynamic_body; }
  Vec2 near(Vec2 way) const {
    if (setting.space != Space::torus) return way;
    return {way.x - side * std::nearbyint(way.x / side), way.y - side * std::nearbyint(way.y / side)};
  }
  Vec2 centre(std::uint32_t id) const {
    const BodyState s = state(*world, world->id_of(id));
    if (desc.at(id).type != BodyType::dynamic_body) return {s.x, s.y};
    const Vec2 arm = unit_of(desc.at(id).shape).centre;
    const double c = std::cos(s.angle), n = std::sin(s.angle);
    return {s.x + c * arm.x - n * arm.y, s.y + n * arm.x + c * arm.y};
  }
};

const Setting kSettings[] = {
    {"Discs", Space::pen, 0, 0.4, true, false},
    {"ElasticDiscs", Space::torus, 1, 0, true, false},
    {"Shapes", Space::pen, 0, 0.4, false, true},
    {"Mixed", Space::ground, 0, 0.4, true, true},
    {"MixedSmooth", Space::pen, 0, 0, true, true},
    {"MixedBouncing", Space::pen, 0.6, 0.3, true, true},
    {"MixedElastic", Space::torus, 1, 0, true, true},
    {"Torus", Space::torus, 0, 0.4, true, true, true},
    {"Joints", Space::ground, 0, 0.4, true, true, true},
    {"Kinematics", Space::ground, 0, 0.4, true, true, false, true},
    {"Sleeping", Space::ground, 0, 0.6, true, true, false, false, true},
    {"SleepingDiscs", Space::pen, 0, 0.6, true, false, false, false, true},
    {"All", Space::ground, 0.3, 0.5, true, true, true, true, true},
};

std::string name_of(const testing::TestParamInfo<Setting>& info) { return info.param.name; }
void PrintTo(const Setting& s, std::ostream* out) { *out << s.name; }

class Sums : public testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Mixtures, Sums, testing::ValuesIn(kSettings), name_of);

/// A sum, and how large its terms are.
struct Sum {
  double value = 0, size = 0;
  void operator+=(double term) {
    value += term;
    size += std::fabs(term);
  }
  double rounding() const { return 1e-6 * size + 1e-12; }
};

TEST_P(Sums, OfMotionAreThoseOfTheBodies) {
  Mixture m(GetParam(), 5);
  for (int frame = 0; frame < 240; ++frame) {
    m.world->step();
    if (frame % 40 != 7) continue;
    Sum kinetic, potential, px, py, spin;
    for (const auto& [id, body] : m.desc) {
      if (!m.dynamic(id)) continue;
      const BodyState s = state(*m.world, m.world->id_of(id));
      const Unit unit = unit_of(body.shape);
      const Vec2 at = m.centre(id), g = m.world->desc().gravity;
      const double inertia = body.mass * unit.inertia;
      kinetic += body.mass * (s.vx * s.vx + s.vy * s.vy) / 2 + inertia * s.omega * s.omega / 2;
      potential += -body.mass * body.gravity_scale * (g.x * at.x + g.y * at.y);
      px += body.mass * s.vx;
      py += body.mass * s.vy;
      spin += body.mass * (at.x * s.vy - at.y * s.vx) + inertia * s.omega;
    }
    const Diagnostics d = m.world->diagnostics();
    EXPECT_NEAR(d.kinetic, kinetic.value, kinetic.rounding()) << frame;
    EXPECT_NEAR(d.potential, potential.value, potential.rounding()) << frame;
    EXPECT_NEAR(d.momentum_x, px.value, px.rounding()) << frame;
    EXPECT_NEAR(d.momentum_y, py.value, py.rounding()) << frame;
    EXPECT_NEAR(d.angular_momentum, spin.value, spin.rounding()) << frame;
  }
}

using States = std::map<std::uint32_t, BodyState>;

States states_of(const Mixture& m) {
  States all;
  for (const auto& [id, body] : m.desc) all[id] = state(*m.world, m.world->id_of(id));
  return all;
}

/// Whether two bodies came together in a step faster than their velocities before it said, with a quarter to spare: lists
/// may not name who is thrown upon each other like that until the next step.
bool thrown(const Mixture& m, const States& before, std::uint32_t a, std::uint32_t b) {
  if (before.empty()) return false;
  const BodyState &a0 = before.at(a), &b0 = before.at(b);
  const BodyState a1 = state(*m.world, m.world->id_of(a)), b1 = state(*m.world, m.world->id_of(b));
  const Vec2 way = m.near({(b1.x - a1.x) - (b0.x - a0.x), (b1.y - a1.y) - (b0.y - a0.y)});
  const double dt = 1.0 / 60, speed = std::hypot(b0.vx - a0.vx, b0.vy - a0.vy);
  return std::hypot(way.x, way.y) > 1.25 * dt * (speed + kG * dt);
}

/// The deepest overlap by brute force over all outlines, walls among them.
double deepest_of_all(const Mixture& m, bool joined, const States& before) {
  std::vector<std::pair<std::uint32_t, std::vector<reference::Outline>>> bodies;
  const WorldDesc& d = m.world->desc();
  double most = 0;
  for (const auto& [id, body] : m.desc) {
    const BodyState s = state(*m.world, m.world->id_of(id));
    bodies.emplace_back(id, outlines(body.shape, {s.x, s.y}, s.angle));
    if (!m.dynamic(id) || d.boundary != Boundary::walls) continue;
    for (const reference::Outline& o : bodies.back().second) {
      for (const reference::Vec p : o.points) {
        for (const double way : {p.x - d.bounds.xmin, d.bounds.xmax - p.x, p.y - d.bounds.ymin, d.bounds.ymax - p.y}) {
          most = std::max(most, o.radius - way);
        }
      }
    }
  }
  const auto tied = [&](std::uint32_t a, std::uint32_t b) {  // as Mixture::tie pairs them
    const auto last = static_cast<std::uint32_t>(m.world->body_count()) - 1;
    return joined && last - b < 14 && (last - b) % 2 == 0 && a + 1 == b;
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const auto& [a, of_a] = bodies[i];
      const auto& [b, of_b] = bodies[j];
      if ((!m.dynamic(a) && !m.dynamic(b)) || tied(a, b) || thrown(m, before, a, b)) continue;
      const BodyState sa = state(*m.world, m.world->id_of(a)), sb = state(*m.world, m.world->id_of(b));
      const Vec2 way{sb.x - sa.x, sb.y - sa.y}, nearest = m.near(way);
      for (reference::Outline p : of_a) {
        for (reference::Vec& v : p.points) v = {v.x + way.x - nearest.x, v.y + way.y - nearest.y};
        for (const reference::Outline& q : of_b) most = std::max(most, reference::depth(p, q));
      }
    }
  }
  return most;
}

// Also where some fell asleep or woke in the step.
TEST_P(Sums, DeepestOverlapIsThatOfTheEndOfTheStep) {
  Mixture m(GetParam(), 6);
  double most = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const States before = states_of(m);
    m.world->step();
    if (frame % 5 != 3 && frame % 16 != 15) continue;
    const double deepest = m.world->diagnostics().max_penetration,
                 most_of_listed = deepest_of_all(m, m.setting.joints, before);
    EXPECT_GT(deepest, most_of_listed - 1e-5) << frame;
    EXPECT_LT(deepest, deepest_of_all(m, m.setting.joints, {}) + 1e-5) << frame;
    most = std::max(most, deepest);
  }
  if (m.setting.e != 1) {
    EXPECT_GT(most, 1e-3);
  }
}

TEST_P(Sums, DeepestOverlapLeavesTheHostsContactsAndOutlastsItsChanges) {
  Mixture m(GetParam(), 7);
  run(*m.world, 90);
  const std::span<const Contact> contacts = m.world->contacts();
  const std::vector<Contact> before(contacts.begin(), contacts.end());
  const double deepest = m.world->diagnostics().max_penetration;
  ASSERT_EQ(contacts.size(), before.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(contacts[k].a, before[k].a);
    EXPECT_EQ(contacts[k].separation, before[k].separation);
    EXPECT_EQ(contacts[k].impulse, before[k].impulse);
  }
  std::vector<std::byte> saved;
  m.world->save(saved);
  add(*m.world, disc({1, m.side - 0.6}, {}, 0.2));
  EXPECT_EQ(m.world->diagnostics().max_penetration, deepest);
  std::string error;
  ASSERT_TRUE(m.world->restore(saved, error)) << error;
  EXPECT_EQ(m.world->diagnostics().max_penetration, deepest);
}

// The distance of two centres is one that they have within the step, or had when the manifold was found: at most 2 % of
// the smaller body's size from that.
TEST_P(Sums, VirialAndCountsAreThoseOfTheContacts) {
  if (GetParam().e > 0) GTEST_SKIP() << "impacts begin and end within a step";
  Mixture m(GetParam(), 8);
  double most = 0;
  std::uint64_t before = 0;
  for (int frame = 0; frame < 240; ++frame) {
    std::map<std::uint32_t, Vec2> start;
    std::map<std::uint32_t, bool> slept;
    for (const auto& [id, body] : m.desc) {
      start[id] = m.centre(id);
      slept[id] = !m.world->is_awake(m.world->id_of(id));
    }
    const StepReport report = m.world->step();
    if (before == 0 && report.asleep == 0) {
      EXPECT_EQ(report.contacts, m.world->contacts().size()) << frame;
    }
    before = report.asleep;
    Sum virial;
    double moved = 0;
    for (const Contact& c : m.world->contacts()) {
      if (c.b == kNoBody) continue;
      const auto round = [&](BodyId id) { return std::holds_alternative<DiscShape>(m.desc.at(id.index).shape); };
      const auto fixed = [&](BodyId id) { return m.desc.at(id.index).type == BodyType::static_body; };
      // Bodies that fall asleep do so when the step is done, and take their contacts along.
      const auto awake = [&](BodyId id) { return m.world->is_awake(id); };
      const auto fell = [&](BodyId id) { return !fixed(id) && !slept[id.index] && !awake(id); };
      const auto asleep = [&](BodyId id) { return !fixed(id) && slept[id.index]; };
      if (c.strip == kNoStrip && !fell(c.a) && !fell(c.b)) continue;
      const bool discs = round(c.a) && round(c.b);
      if ((fixed(c.a) || fixed(c.b) || asleep(c.a) || asleep(c.b)) && !discs) continue;
      const auto apart = [&](Vec2 a, Vec2 b) {
        const Vec2 way = m.near({b.x - a.x, b.y - a.y});
        return way.x * c.normal.x + way.y * c.normal.y;
      };
      const double end = apart(m.centre(c.a.index), m.centre(c.b.index));
      virial += c.impulse * (end - (discs ? c.separation : 0));
      moved += c.impulse * std::fabs(end - apart(start[c.a.index], start[c.b.index]));
    }
    EXPECT_NEAR(report.virial, virial.value, moved + 0.01 * virial.size + 1e-9) << frame;
    most = std::max(most, report.virial);
  }
  EXPECT_GT(most, 0);
}

/// Whether a part of the step was left out.
bool left_out(const StepReport& report, Skip what) { return (report.skipped >> static_cast<unsigned>(what) & 1) != 0; }

TEST_P(Sums, LedgerOfAStepAddsUp) {
  Mixture m(GetParam(), 9);
  World& world = *m.world;
  std::array<std::uint64_t, kSkipNames.size()> sums{};
  std::uint64_t slept = 0;
  for (int frame = 0; frame < 900; ++frame) {
    const StepReport r = world.step();
    SCOPED_TRACE(frame);
    std::uint64_t asleep = 0;
    for (const auto& [id, body] : m.desc) asleep += m.dynamic(id) && !world.is_awake(world.id_of(id));
    EXPECT_EQ(r.asleep, asleep);
    EXPECT_EQ(r.awake + r.asleep, world.dynamic_count());
    EXPECT_EQ(r.detail.substeps, world.desc().substeps);
    EXPECT_TRUE(r.pairs_reused == 0 || r.pairs_reused == r.pairs);
    EXPECT_FALSE(r.rebuilt && r.pairs_reused != 0);
    EXPECT_FALSE(r.rebuilt && (r.renewed != 0 || left_out(r, Skip::broad_phase)));
    EXPECT_LE(r.contacts, 2 * r.pairs);
    EXPECT_LE(r.touching, r.pairs);
    EXPECT_LE(r.touching, r.contacts);
    EXPECT_LE(r.stopped, r.fast);
    double stages = 0;
    for (const double ms : r.stage_ms) stages += ms;
    EXPECT_LE(stages, r.total_ms * (1 + 1e-12));  // the sum rounds
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += r.skipped >> k & 1;
    slept += r.asleep;
    if (r.awake == 0) continue;
    // What pressed was not left out.
    std::uint64_t shapes = 0, rubs = 0, solved = 0;
    for (const Contact& c : world.contacts()) {
      if (c.strip == kNoStrip) continue;
      ++solved;
      const auto cornered = [&](BodyId id) {
        return id != kNoBody && m.dynamic(id.index) && !std::holds_alternative<DiscShape>(m.desc.at(id.index).shape);
      };
      shapes += c.impulse > 0 && (cornered(c.a) || cornered(c.b));
      rubs += c.friction != 0;
    }
    EXPECT_TRUE(solved == 0 || !left_out(r, Skip::solver));
    EXPECT_TRUE(solved == 0 || !left_out(r, Skip::narrow_phase));
    EXPECT_TRUE(shapes == 0 || !left_out(r, Skip::manifolds));
    EXPECT_TRUE(rubs == 0 || !left_out(r, Skip::friction));
    EXPECT_EQ(m.setting.joints && r.asleep == 0, m.setting.joints && r.asleep == 0 && !left_out(r, Skip::joints));
    for (const PlanEntry& entry : world.plan()) {
      const auto name = std::find(kSkipNames.begin(), kSkipNames.end(), entry.stage);
      if (name == kSkipNames.end() || entry.needed) continue;
      EXPECT_TRUE(r.skipped >> (name - kSkipNames.begin()) & 1) << entry.stage;
    }
  }
  for (const auto& [stage, frames] : world.skipped()) {
    const auto name = std::find(kSkipNames.begin(), kSkipNames.end(), stage);
    EXPECT_EQ(frames, sums[static_cast<std::size_t>(name - kSkipNames.begin())]) << stage;
  }
  EXPECT_EQ(slept > 0, m.setting.sleeping);
}

// What bounces counts in every impact. What does not counts in one of four substeps, fourfold.
TEST(Virial, OfImpactsIsTheirImpulseTimesTheDistance) {
  constexpr int kImpacts = 16;
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const int boxes : {0, 1, 2}) {
      double mean = 0;
      for (int impact = 0; impact < kImpacts; ++impact) {
        const double gap = 0.3 + 0.05 * (impact + 0.4) / kImpacts;  // spread over a frame
        auto world = make(unbounded(100, {0, 0}));
        const Material m = material(e);
        BodyDesc a = boxes > 0 ? box({-1 - gap, 0}, 1, 1, m) : disc({-1 - gap, 0}, {}, 0.5, m);
        BodyDesc b = boxes > 1 ? box({0, 0}, 1, 1, m) : disc({0, 0}, {}, 0.5, m);
        a.velocity = {3, 0};
        a.mass = b.mass = 2;
        add(*world, a);
        add(*world, b);
        double virial = 0;
        for (int k = 0; k < 30; ++k) virial += world->step().virial;
        if (e > 0) {
          EXPECT_NEAR(virial, (1 + e) * 3, 0.02 * 3) << e << ", boxes " << boxes << ", gap " << gap;
        }
        mean += virial / kImpacts;
      }
      EXPECT_NEAR(mean, (1 + e) * 3, 0.02 * 3) << e << ", boxes " << boxes;
    }
  }
}

}  // namespace
}  // namespace psim::test
