// Random worlds of discs, and of other shapes, filters and joints among them, in which hosts push, add, remove and
// change things: one goes straight on, the other is saved and restored now and then, into a fresh world, too; with a
// governor the other replays what the first one chose.
#include <random>

#include "joint_support.h"
#include "rigid_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

class RandomWorld {
 public:
  enum class Kind { discs, any };

  RandomWorld(unsigned seed, Kind kind) : seed_(seed), random_(seed) {
    bodies_ = 512 + below(1200);
    wide_ = uniform(15, 60);
    spacing_ = uniform(1.05, 1.6);
    desc_ = walled({0, 0, wide_, 8.0 * bodies_ / wide_}, {0, -kG}, chance(2) ? material(0.3, 0.5) : Material{});
    const unsigned boundary = below(6);
    if (boundary == 0) {
      desc_.boundary = Boundary::periodic;
      desc_.gravity = {};
    } else if (boundary == 1) {
      desc_.boundary = Boundary::open;
    }
    desc_.sleeping = chance(2);
    desc_.substeps = 1 + static_cast<int>(below(5));
    if (chance(4)) desc_.skin = uniform(0.3, 3);
    if (chance(8)) desc_.fields.push_back(WellField{{wide_ / 2, 10}, 5, 1, 2, 0});
    mixed_ = chance(2);
    heavy_ = chance(4);
    fixed_ = chance(2);
    kinematics_ = chance(4);
    governed_ = chance(4);
    budget_ms_ = uniform(0.05, 0.6);
    settling_ = static_cast<int>(below(200));
    shaped_ = kind == Kind::any;
    filtered_ = shaped_ && chance(3);
    joined_ = shaped_ && chance(3);
  }

  /// Frames whose bits, pieces and renewed bodies were compared; stops at the first that differs.
  void go(int frames) {
    auto world = build(1), twin = build(3);
    for (int k = 0; k < settling_; ++k) {
      world->step();
      twin->step();
    }
    if (governed_) govern(*world), govern(*twin);
    std::vector<std::byte> state, again;
    std::string error;
    for (int frame = 0; frame < frames; ++frame) {
      disturb(*world, *twin, frame);
      const double dt = chance(10) ? uniform(0.004, 0.03) : 1.0 / 60;
      const StepReport one = world->step(dt);
      const StepReport other = governed_ ? twin->replay(one.detail, dt) : twin->step(dt);
      renewed += one.renewed;
      waits += one.detail.waits();
      ASSERT_EQ(twin->state_hash(), world->state_hash()) << "seed " << seed_ << ", frame " << frame;
      ASSERT_EQ(other.renewed, one.renewed) << "seed " << seed_ << ", frame " << frame;
      ASSERT_EQ(other.rebuilt, one.rebuilt) << "seed " << seed_ << ", frame " << frame;
      if (!chance(3)) continue;
      if (chance(4)) twin = build(2);
      world->save(state);
      ASSERT_TRUE(twin->restore(state, error)) << error;
      if (governed_) continue;  // who has a governor counts what the other does not
      twin->save(again);
      ASSERT_EQ(again, state) << "seed " << seed_ << ", frame " << frame;
    }
  }

  std::uint64_t renewed = 0, waits = 0;

 private:
  unsigned below(unsigned n) { return static_cast<unsigned>(random_()) % n; }
  bool chance(unsigned of) { return below(of) == 0; }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }

  void govern(World& world) const {
    GovernorDesc desc;
    desc.on = true;
    desc.budget_ms = budget_ms_;
    world.set_governor(desc);
  }

  std::unique_ptr<World> build(int threads) const {
    std::mt19937 random(seed_ + 1);
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    auto world = make(desc_, best_isa(), threads);
    std::vector<BodyId> bodies;
    const auto columns = static_cast<unsigned>((wide_ - 1) / spacing_);
    for (unsigned k = 0; k < bodies_; ++k) {
      const Vec2 at{0.6 + spacing_ * (k % columns) + uniform(-0.02, 0.02),
                    2.6 + spacing_ * (k / columns) + uniform(-0.02, 0.02)};
      const double radius = mixed_ && random() % 300 != 0 ? uniform(0.2, 0.5) : 0.5;
      const double density = heavy_ && random() % 20 == 0 ? 100 : 1;
      const Vec2 velocity{uniform(-0.1, 0.1), uniform(-0.1, 0.1)};
      const Material stuff = material(seed_ % 3 == 0 ? 0 : 0.3, seed_ % 2 == 0 ? 0 : 0.5, density);
      BodyDesc body = disc(at, velocity, radius, stuff);
      if (shaped_ && random() % 3 != 0) body = moving(shape(random, at, 0.9 * radius, stuff), velocity, uniform(-1, 1));
      if (filtered_ && random() % 4 == 0) body.filter = {2, random() % 2 == 0 ? 1u : ~0u, 0};
      bodies.push_back(add(*world, body));
      if (!joined_ || k % columns == 0 || random() % 10 != 0) continue;
      JointDesc joint = between(JointType::distance, bodies[k - 1], bodies[k]);
      joint.collide = random() % 3 == 0;
      std::string error;
      world->add_joint(joint, error);
      EXPECT_EQ(error, "");
    }
    if (shaped_ && fixed_) {
      std::vector<Vec2> bumps;
      for (double x = wide_ - 0.2; x > 0; x -= 0.7) bumps.push_back({x, 0.3 + uniform(0, 0.3)});
      add(*world, chain(bumps));
    }
    for (double x = 1; fixed_ && x < wide_ - 1; x += 4) add(*world, static_disc({x, 1}, 0.6));
    if (fixed_) add(*world, segment({0.2, 0.4}, {wide_ - 0.2, 0.4}));
    if (desc_.boundary == Boundary::open) add(*world, segment({-5, 0.1}, {wide_ + 5, 0.1}));
    if (kinematics_) add(*world, kinematic(disc({wide_ / 2, 3}, {0.5, 0}, 0.4)));
    return world;
  }

  // Within `radius` of its place.
  static BodyDesc shape(std::mt19937& random, Vec2 at, double radius, const Material& stuff) {
    switch (random() % 5) {
      case 0:
        return polygon(regular(3 + static_cast<int>(random() % 6), radius), at, stuff);
      case 1:
        return capsule(at, radius, 0.5 * radius, stuff);
      case 2:
        return fixed_turn(box(at, 1.2 * radius, 0.8 * radius, stuff));
      default:
        return box(at, 1.4 * radius, 1.4 * radius, stuff);
    }
  }

  static BodyDesc fixed_turn(BodyDesc body) {
    body.fixed_rotation = true;
    return body;
  }

  // What a host does between two frames, to both.
  void disturb(World& world, World& twin, int frame) {
    const unsigned what = below(12);
    for (int k = 0; what < 4 && k < 3; ++k) {
      const BodyId id = world.id_of(below(bodies_));
      const double angle = uniform(0, 6.28), speed = uniform(0.2, 8);
      for (World* w : {&world, &twin}) {
        if (w->body(id)) w->set_velocity(id, {speed * std::cos(angle), speed * std::sin(angle)}, 0);
      }
    }
    const double x = uniform(1, wide_ - 1), g = uniform(-12, -6);
    const BodyId gone = world.id_of(below(bodies_));
    const bool rarely = chance(4);
    for (World* w : {&world, &twin}) {
      if (what == 4 && rarely && w->body(gone)) w->remove_body(gone);
      if (what == 5 && rarely) add(*w, disc({x, 7.0 * bodies_ / wide_}, {0, -3}, 0.4));
      if (what == 6 && rarely) w->set_gravity({0, g});
      if (what == 7 && rarely) w->set_skin(1 + 0.1 * (frame % 5));
    }
  }

  unsigned seed_;
  std::mt19937 random_;
  WorldDesc desc_;
  unsigned bodies_ = 0;
  double wide_ = 0, spacing_ = 0, budget_ms_ = 0;
  bool mixed_ = false, heavy_ = false, fixed_ = false, kinematics_ = false, governed_ = false, shaped_ = false,
       filtered_ = false, joined_ = false;
  int settling_ = 0;
};

void go(RandomWorld::Kind kind, unsigned from, unsigned to) {
  std::uint64_t renewed = 0, waits = 0;
  for (unsigned seed = from; seed < to && !testing::Test::HasFatalFailure(); ++seed) {
    RandomWorld world(seed, kind);
    world.go(60);
    renewed += world.renewed;
    waits += world.waits;
  }
  EXPECT_GT(renewed, 30 * (to - from));
  EXPECT_GT(waits, (to - from) / 2);
}

TEST(RenewalRandom, WorldsGoOnAfterRestores) { go(RandomWorld::Kind::discs, 0, 12); }
TEST(RenewalRandom, WorldsOfAllShapesGoOnAfterRestores) { go(RandomWorld::Kind::any, 0, 12); }

TEST(SlowRenewalRandom, WorldsGoOnAfterRestores) { go(RandomWorld::Kind::discs, 100, all_seeds() ? 1100 : 350); }
TEST(SlowRenewalRandom, WorldsOfAllShapesGoOnAfterRestores) {
  go(RandomWorld::Kind::any, 2000, all_seeds() ? 2500 : 2120);
}

}  // namespace
}  // namespace psim::test
