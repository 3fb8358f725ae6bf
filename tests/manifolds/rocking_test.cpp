// Blocks that turn on a corner, meet the ground with another one, and rock: G. W. Housner, "The behavior of inverted
// pendulum structures during earthquakes", 1963.
#include "reference/structures.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

const Material kHolds = material(0, 5);

WorldDesc sleepless(int substeps) {
  WorldDesc desc = with_substeps(unbounded(100), substeps);
  desc.sleeping = false;
  return desc;
}

enum class Ground { box, kinematic, segment };

void add_ground(World& world, Ground ground) {
  if (ground == Ground::segment) {
    BodyDesc line = segment({-50, 0}, {50, 0});
    line.material = kHolds;
    add(world, line);
    return;
  }
  const BodyDesc floor = box({0, -1}, 100, 2, kHolds);
  add(world, ground == Ground::box ? fixed(floor) : kinematic(floor));
}

// A block of 1 kg on its lower right corner, at (0, 0), tilted by a share of the angle at which it would fall.
BodyDesc tilted(double width, double height, double share) {
  const double tilt = share * std::atan(width / height), c = std::cos(tilt), s = std::sin(tilt);
  const Vec2 centre{0.5 * (height * s - width * c), 0.5 * (height * c + width * s)};
  return turned(box(centre, width, height, kHolds, 1), -tilt);
}

double energy_of(const BodyState& s, double width, double height) {
  const double inertia = (width * width + height * height) / 12;
  return 0.5 * (s.vx * s.vx + s.vy * s.vy + inertia * s.omega * s.omega) + kG * (s.y - 0.5 * height);
}

TEST(Rocking, ABlockThatTurnsOnACornerKeepsItsEnergyAndItsPlace) {
  for (const Ground ground : {Ground::box, Ground::kinematic, Ground::segment}) {
    for (const auto& [width, height] : {std::pair{0.5, 2.0}, std::pair{1.0, 1.0}, std::pair{5.0, 20.0}}) {
      for (const int substeps : {2, 4, 16}) {
        auto world = make(sleepless(substeps));
        add_ground(*world, ground);
        const BodyId id = add(*world, tilted(width, height, 0.5));
        run(*world, 1);
        const double first = energy_of(state(*world, id), width, height);
        BodyState s = state(*world, id);
        for (; s.angle < -0.05; s = state(*world, id)) world->step();
        EXPECT_NEAR(energy_of(s, width, height) / first, 1, 4e-3) << width << ' ' << substeps;
        const double c = std::cos(s.angle), t = std::sin(s.angle);
        EXPECT_NEAR(s.x + 0.5 * (c * width + t * height), 0, 1.5e-3 * width) << width << ' ' << substeps;
      }
    }
  }
}

TEST(Rocking, ABlockSwingsAsFarAsTheClosedFormSays) {
  const reference::RockingBlock block{0.5, 2};
  const double start = 0.5 * block.slenderness();
  for (const Ground ground : {Ground::box, Ground::kinematic, Ground::segment}) {
    for (const int substeps : {4, 8, 16}) {
      auto world = make(sleepless(substeps));
      add_ground(*world, ground);
      const BodyId id = add(*world, tilted(block.width, block.height, 0.5));
      double before = -start, most = 0;
      int impacts = 0;
      for (int frame = 0; frame < 1200 && impacts < 6; ++frame) {
        world->step();
        const double angle = state(*world, id).angle;
        if (angle * before < 0) {
          if (impacts != 0) {
            EXPECT_NEAR(most / block.amplitude(start, impacts), 1, 0.02) << substeps << " swing " << impacts;
          }
          ++impacts;
          most = 0;
        }
        most = std::max(most, std::abs(angle));
        before = angle;
      }
      EXPECT_EQ(impacts, 6);
    }
  }
}

// The corner that meets the ground stays there: what turned about it before goes on turning.
TEST(Rocking, ARoughImpactKeepsTheAngularMomentumAboutItsCorner) {
  for (const int substeps : {4, 16}) {
    Random random(5);
    std::vector<double> errors;
    while (errors.size() < 40) {
      const double w = random.uniform(0.4, 1.2), h = random.uniform(0.3, 1);
      const double omega = random.uniform(1.5, 12) * (random.chance(0.5) ? 1 : -1);
      const Vec2 v{random.uniform(-3, 3), random.uniform(-8, -2)};
      double angle = random.uniform(0, 6);
      const auto corner = [&](double at) {
        Vec2 best{0, 1};
        for (const Vec2 p : {Vec2{w, h}, Vec2{-w, h}, Vec2{-w, -h}, Vec2{w, -h}}) {
          const double c = std::cos(at), s = std::sin(at);
          if (0.5 * (s * p.x + c * p.y) < best.y) best = {0.5 * (c * p.x - s * p.y), 0.5 * (s * p.x + c * p.y)};
        }
        return best;
      };
      const double y = 0.6 - corner(angle).y;
      double t = 0;
      while (y + t * v.y + corner(angle + t * omega).y > 0) t += 1e-5;
      const Vec2 r = corner(angle + t * omega);  // from the centre
      const double inertia = (w * w + h * h) / 12, square = r.x * r.x + r.y * r.y;
      const double after = (inertia * omega - r.x * v.y + r.y * v.x) / (inertia + square);
      const int frames = static_cast<int>(std::ceil(60 * t));
      const double later = frames / 60.0 - t, turned_to = angle + t * omega + later * after;
      if (std::abs(later * after) > 0.05 || corner(turned_to).x * r.x < 0) continue;  // another corner follows
      auto world = make(with_substeps(unbounded(100, {0, 0}), substeps));
      BodyDesc ground = segment({-50, 0}, {50, 0});
      ground.material = material(0, 100);
      add(*world, ground);
      const BodyId id = add(*world, moving(turned(box({0, y}, w, h, material(0, 100), 1), angle), v, omega));
      run(*world, frames);
      errors.push_back(std::abs(state(*world, id).omega - after) / std::abs(after - omega));
    }
    std::ranges::sort(errors);
    EXPECT_LT(errors[20], 0.005) << substeps;
    EXPECT_LT(errors[38], 0.03) << substeps;
  }
}

}  // namespace
}  // namespace psim::test
