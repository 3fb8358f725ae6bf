// Random scenes against the laws that hold in all of them: finite, inside the walls, momentum,
// no energy from nothing, the same bits from every variant. A failure names its seed; the seed
// alone makes the scene.
#include "support.h"

namespace psim::test {
namespace {

struct FuzzScene {
  WorldDesc desc;
  std::vector<BodyDesc> statics;
  std::vector<BodyDesc> bodies;
  std::vector<double> dt;  ///< of every frame
  bool conserves_momentum = false;
  bool cannot_gain_energy = false;
  bool holds_everybody = false;  ///< no way out, and nobody who could push another through
};

Material random_material(Random& random) {
  const double restitutions[] = {0, 0, 0.5, 1, random.uniform(0, 1)};
  const double frictions[] = {0, 0, 0.3, random.uniform(0, 1.5)};
  return {random.uniform(0.2, 5), restitutions[random.below(5)], frictions[random.below(4)]};
}

FuzzScene make_scene(std::uint64_t seed) {
  Random random(seed);
  FuzzScene scene;
  WorldDesc& desc = scene.desc;
  const double width = random.uniform(8, 60), height = random.uniform(8, 60);
  const double x0 = random.uniform(-300, 300), y0 = random.uniform(-300, 300);
  desc.bounds = {x0, y0, x0 + width, y0 + height};
  const Boundary boundaries[] = {Boundary::walls, Boundary::periodic, Boundary::open};
  desc.boundary = boundaries[random.below(3)];
  desc.gravity = {0, 0};
  if (random.chance(0.6)) desc.gravity = {0, -kG};
  if (random.chance(0.2)) desc.gravity = {random.uniform(-20, 20), random.uniform(-20, 20)};
  if (random.chance(0.2)) desc.linear_damping = random.uniform(0, 2);
  desc.wall = random_material(random);
  const int substeps[] = {1, 2, 4, 4, 8};
  desc.substeps = substeps[random.below(5)];
  bool wells = false;
  if (random.chance(0.25)) {
    wells = true;
    desc.fields.push_back(WellField{{x0 + random.uniform(0, width), y0 + random.uniform(0, height)},
                                    random.uniform(-300, 300),
                                    random.uniform(0.2, 2),
                                    random.chance(0.7) ? 2.0 : 1.0,
                                    random.chance(0.5) ? 10.0 : 0.0});
  }
  bool drag = false;
  if (random.chance(0.2)) {
    drag = true;
    desc.fields.push_back(DragField{random.uniform(0, 1), random.uniform(0, 0.2)});
  }
  const bool constant_dt = random.chance(0.5);
  const double dt = random.uniform(1.0 / 240, 1.0 / 20);
  for (int k = 0; k < 60; ++k) {
    scene.dt.push_back(constant_dt ? dt : random.uniform(1.0 / 240, 1.0 / 20));
  }

  // Bodies that do not touch at the start: by trial, against what is there already.
  Discs placed;
  reference::Periods periods;
  if (desc.boundary == Boundary::periodic) periods = {width, height};
  const auto fits = [&](double radius) {
    const double edge = desc.boundary == Boundary::periodic ? 0 : 1.001 * radius;
    if (2 * edge >= std::min(width, height)) return false;
    for (int attempt = 0; attempt < 30; ++attempt) {
      const double up = random.uniform(edge, height - edge), along = random.uniform(edge, width - edge);
      placed.push(x0 + along, y0 + up, radius);
      const std::size_t last = placed.size() - 1;
      bool free = true;
      for (std::size_t k = 0; free && k < last; ++k) {
        free = reference::gap_between(placed.x, placed.y, placed.radius, k, last, periods) > 1e-3;
      }
      if (free) return true;
      placed.x.pop_back();
      placed.y.pop_back();
      placed.radius.pop_back();
      placed.vx.pop_back();
      placed.vy.pop_back();
    }
    return false;
  };
  const double largest = random.uniform(0.2, 1.5);
  const double spread = random.chance(0.5) ? 1 : random.uniform(1, 8);
  if (random.chance(0.5)) {
    for (std::size_t k = random.below(5); k > 0; --k) {
      const double reach = random.uniform(0.5, 3);
      if (!fits(reach)) continue;
      const Vec2 at{placed.x.back(), placed.y.back()};
      const double a = random.uniform(0, 2 * kPi);
      const Vec2 arm{reach * std::cos(a), reach * std::sin(a)};
      BodyDesc body;
      switch (random.below(3)) {
        case 0:
          body = static_disc({}, reach);
          break;
        case 1:
          body = segment({-arm.x, -arm.y}, arm);
          break;
        default:
          body = chain({{-arm.x, -arm.y}, {0.3 * arm.y, -0.3 * arm.x}, arm}, random.chance(0.5));
      }
      body.position = at;
      body.material = random_material(random);
      scene.statics.push_back(body);
    }
  }
  const double speed = random.chance(0.2) ? 0 : random.uniform(0, 15);
  const bool one_material = random.chance(0.5);
  const Material common = random_material(random);
  const std::size_t count = 1 + random.below(300);
  bool kinematics = false;
  double area = 0;
  for (std::size_t k = 0; k < count && area < 0.4 * width * height; ++k) {
    const double radius = largest * std::pow(spread, -random.uniform(0, 1));
    if (!fits(radius)) continue;
    area += kPi * radius * radius;
    const Material own = one_material ? common : random_material(random);
    BodyDesc body = disc({placed.x.back(), placed.y.back()},
                         {random.uniform(-speed, speed), random.uniform(-speed, speed)}, radius, own);
    if (random.chance(0.1)) body.angular_velocity = random.uniform(-10, 10);
    if (random.chance(0.05)) body.fixed_rotation = true;
    if (random.chance(0.05)) body.gravity_scale = random.uniform(0, 2);
    if (random.chance(0.01)) {
      body.type = BodyType::kinematic_body;
      kinematics = true;
    }
    scene.bodies.push_back(body);
  }

  const bool gravity = desc.gravity.x != 0 || desc.gravity.y != 0;
  scene.conserves_momentum = desc.boundary == Boundary::periodic && scene.statics.empty() && !kinematics && !gravity &&
                             !wells && !drag && desc.linear_damping == 0;
  // In a periodic world the potential jumps at the seam; in an open one it leaves with the body.
  scene.cannot_gain_energy = !kinematics && !wells && (desc.boundary == Boundary::walls || !gravity);
  scene.holds_everybody = desc.boundary != Boundary::open && !kinematics;
  return scene;
}

std::unique_ptr<World> build(const FuzzScene& scene, Isa isa, int threads) {
  auto world = make(scene.desc, isa, threads);
  for (const BodyDesc& body : scene.statics) add(*world, body);
  for (const BodyDesc& body : scene.bodies) add(*world, body);
  return world;
}

void expect_laws(std::uint64_t seed) {
  const FuzzScene scene = make_scene(seed);
  SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << scene.bodies.size() << " bodies");
  auto world = build(scene, best_isa(), 2);
  std::vector<std::unique_ptr<World>> twins;
  for (const Isa isa : available_isas()) twins.push_back(build(scene, isa, isa == Isa::scalar ? 1 : 3));

  const Diagnostics start = world->diagnostics();
  const Vec2 g = scene.desc.gravity;
  const Bounds b = scene.desc.bounds;
  double mass = 0, momentum = 0;
  for (const BodyDesc& body : scene.bodies) {
    const double r = std::get<DiscShape>(body.shape).radius;
    mass += body.material.density * kPi * r * r;
    momentum += body.material.density * kPi * r * r * std::hypot(body.velocity.x, body.velocity.y);
  }
  const double scale = start.kinetic + mass * (std::abs(g.x) * (b.xmax - b.xmin) + std::abs(g.y) * (b.ymax - b.ymin));
  std::uint64_t escaped = 0, quarantined = 0;
  for (std::size_t frame = 0; frame < scene.dt.size(); ++frame) {
    const StepReport report = world->step(scene.dt[frame]);
    escaped += report.escaped;
    quarantined += report.quarantined;
    const std::uint64_t hash = world->state_hash();
    for (auto& twin : twins) {
      twin->step(scene.dt[frame]);
      ASSERT_EQ(twin->state_hash(), hash) << isa_name(twin->isa()) << " frame " << frame;
    }
    ASSERT_TRUE(all_finite(*world)) << "frame " << frame;
    ASSERT_TRUE(!scene.holds_everybody || all_inside(*world)) << "frame " << frame;
    const Diagnostics now = world->diagnostics();
    if (scene.conserves_momentum) {
      ASSERT_LE(std::hypot(now.momentum_x - start.momentum_x, now.momentum_y - start.momentum_y), 1e-5 * momentum)
          << "frame " << frame;
    }
    if (scene.cannot_gain_energy) {
      ASSERT_LE(now.kinetic + now.potential - start.kinetic - start.potential, 1e-3 * scale) << "frame " << frame;
    }
  }
  EXPECT_EQ(quarantined, 0u);
  EXPECT_EQ(world->body_count() + escaped, scene.bodies.size() + scene.statics.size());
}

TEST(LawFuzz, RandomScenesObeyTheLaws) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) expect_laws(seed);
}

TEST(SlowLawFuzz, ManyRandomScenesObeyTheLaws) {
  for (std::uint64_t seed = 1001; seed <= 2000; ++seed) expect_laws(seed);
}

}  // namespace
}  // namespace psim::test
