// Terrain and moving ground: whichever way it is listed and whatever it is made of, bodies move over it alike.
#include "rigid_support.h"

namespace psim::test {
namespace {

const Material kIce = material(0, 0);

std::vector<Vec2> hill(int pieces, double mirror, bool backwards) {
  std::vector<Vec2> v{{-20 * mirror, 0}};
  for (int k = 0; k <= pieces; ++k) {
    const double x = -6 + 12.0 * k / pieces;
    v.push_back({mirror * x, 0.75 * (1 + std::cos(kPi * x / 6))});
  }
  v.push_back({20 * mirror, 0});
  if (backwards) std::reverse(v.begin(), v.end());
  return v;
}

void add_ground(World& world, const std::vector<Vec2>& line, bool in_one, bool held) {
  const auto ground = [&](BodyDesc body) { add(world, held ? kinematic(body) : body); };
  if (in_one) return ground(chain(line, false, kIce));
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    BodyDesc piece = segment(line[k], line[k + 1]);
    piece.material = kIce;
    ground(piece);
  }
}

TEST(Terrain, KeepsTheSpeedOverAHillWhicheverWayItIsListed) {
  const std::pair<const char*, BodyDesc> movers[] = {{"small disc", disc({-12, 0.2}, {}, 0.2, kIce)},
                                                     {"disc", disc({-12, 0.6}, {}, 0.6, kIce)},
                                                     {"capsule", capsule({-12, 0.2}, 0.8, 0.2, kIce)},
                                                     {"box", box({-12, 0.2}, 0.5, 0.4, kIce)}};
  for (const auto& [name, mover] : movers) {
    for (const double mirror : {1.0, -1.0}) {
      for (const bool backwards : {false, true}) {
        for (const int made : {0, 1, 2, 3}) {  // a chain or segments, static or kinematic
          auto world = make(unbounded(100, {0, -kG}));
          add_ground(*world, hill(160, mirror, backwards), made % 2 == 0, made / 2 == 1);
          BodyDesc body = moving(mover, {7 * mirror, 0});
          body.position.x *= mirror;
          const BodyId id = add(*world, body);
          run_seconds(*world, 4);
          const double kept = mirror * state(*world, id).vx / 7;
          EXPECT_GT(kept, 0.985) << name << " mirror " << mirror << " backwards " << backwards << " made " << made;
          EXPECT_LT(kept, 1.005) << name << " mirror " << mirror << " backwards " << backwards << " made " << made;
        }
      }
    }
  }
}

// A concave vertex that turns the way by d takes sin^2 d of the kinetic energy, and nothing else does.
TEST(Terrain, ValleyTakesWhatItsVerticesTake) {
  constexpr int kPieces = 100;
  constexpr double kHalf = 1, kRadius = 3, kR = 0.2, kUp = 3;
  const Vec2 slope{std::cos(kHalf), std::sin(kHalf)};
  std::vector<Vec2> line;
  for (int k = 0; k <= kPieces; ++k) {
    const double a = -kHalf + 2 * kHalf * k / kPieces;
    line.push_back({kRadius * std::sin(a), -kRadius * std::cos(a)});
  }
  const Vec2 rim = line.back();
  line.insert(line.begin(), {-rim.x - 6 * slope.x, rim.y + 6 * slope.y});
  line.push_back({rim.x + 6 * slope.x, rim.y + 6 * slope.y});
  const double start = kG * kUp * slope.y;
  double energy = start;
  for (int k = 0; k <= kPieces; ++k) {
    const double a = -kHalf + 2 * kHalf * k / kPieces, turn = 2 * kHalf / kPieces / (k == 0 || k == kPieces ? 2 : 1);
    const double height = (kRadius - kR) * (std::cos(kHalf) - std::cos(a)), sine = std::sin(turn);
    energy -= (energy - kG * height) * sine * sine;
  }
  for (const double side : {-1.0, 1.0}) {
    for (const int substeps : {4, 16}) {
      WorldDesc desc = unbounded(100, {0, -kG});
      desc.substeps = substeps;
      auto world = make(desc);
      add(*world, chain(line, false, kIce));
      const Vec2 at{side * (rim.x + kUp * slope.x - kR * slope.y), rim.y + kUp * slope.y + kR * slope.x};
      const BodyId id = add(*world, disc(at, {}, kR, kIce));
      for (int k = 0; k < 240 && -side * state(*world, id).x < rim.x + 0.3; ++k) world->step();
      const BodyState s = state(*world, id);
      const double now = speed_of(s) * speed_of(s) / 2 + kG * (s.y - at.y) + start;
      EXPECT_NEAR(std::sqrt(now / energy), 1, 1e-3) << "from " << side << " with " << substeps;
    }
  }
}

TEST(Terrain, PushesOutWhoIsInsideTheShortestWay) {
  for (const double rounded : {0.0, 0.3}) {
    for (const bool held : {false, true}) {
      auto world = make(unbounded(100, {0, 0}));
      BodyDesc block = box({0, 0}, 6, 4);
      std::get<BoxShape>(block.shape).radius = rounded;
      add(*world, held ? kinematic(block) : fixed(block));
      const BodyId id = add(*world, disc({1, 1.2}, {}, 0.3));
      double fastest = 0;
      for (int k = 0; k < 120; ++k) {
        const double before = state(*world, id).y;
        world->step();
        fastest = std::max(fastest, 60 * (state(*world, id).y - before));
      }
      EXPECT_NEAR(state(*world, id).y, 2.3 + rounded, 1e-3);
      EXPECT_NEAR(state(*world, id).x, 1, 1e-3);
      EXPECT_LT(fastest, 3.1);
    }
  }
}

TEST(Terrain, IsSolidAcrossASeam) {
  WorldDesc desc;
  desc.bounds = {-10, -8, 10, 8};
  desc.boundary = Boundary::periodic;
  desc.gravity = {0, -kG};
  const BodyDesc floors[] = {fixed(box({0, -4}, 20, 1)), fixed(box({0, -4}, 12, 1)), fixed(capsule({0, -4}, 15, 0.5)),
                             segment({-10, -3.5}, {10, -3.5})};
  for (const BodyDesc& floor : floors) {
    for (const double shift : {0.0, 3.3, 9.0}) {
      auto world = make(desc);
      BodyDesc moved = floor;
      moved.position.x += shift;
      add(*world, moved);
      std::vector<BodyId> ids;
      for (const double x : {-5.0, -2.0, 1.0, 4.0}) {
        const double at = x + shift > 10 ? x + shift - 20 : x + shift;
        ids.push_back(add(*world, disc({at, 0}, {}, 0.4, kGrip)));
        ids.push_back(add(*world, box({at, 1.5}, 0.6, 0.6, kGrip)));
      }
      run_seconds(*world, 2);
      for (const BodyId id : ids) EXPECT_GT(state(*world, id).y, -3.5) << "shift " << shift;
    }
  }
}

TEST(Terrain, WellPullsAcrossASeam) {
  WorldDesc desc;
  desc.bounds = {-10, -10, 10, 10};
  desc.boundary = Boundary::periodic;
  desc.gravity = {0, 0};
  desc.fields.push_back(WellField{{9, 0}, 20, 1, 2, 0});
  auto world = make(desc);
  const BodyId id = add(*world, disc({-9, 0}, {}, 0.2));
  run(*world, 6);
  EXPECT_LT(state(*world, id).vx, -0.1);
}

TEST(MovingGround, WakesWhomItMeetsWhenItIsPlacedOrAdded) {
  for (const bool placed : {false, true}) {
    auto world = make(unbounded(100, {0, -kG}));
    add(*world, fixed(box({0, -0.5}, 40, 1, kGrip)));
    const BodyId far = placed ? add(*world, kinematic(box({15, 5}, 1, 1))) : kNoBody;
    const BodyId id = add(*world, box({0, 0.5}, 1, 1, kGrip));
    run_seconds(*world, 5);
    ASSERT_FALSE(world->is_awake(id));
    if (placed) {
      world->set_transform(far, {0.8, 0.5}, 0);
    } else {
      add(*world, kinematic(box({0.8, 0.5}, 1, 1)));
    }
    run_seconds(*world, 3);
    EXPECT_NEAR(state(*world, id).x, -0.2, 5e-3);
  }
}

TEST(MovingGround, ThatTurnsCarriesWhatLiesOnIt) {
  for (const double omega : {5.0, 10.0, 30.0}) {
    WorldDesc desc = unbounded(500, {0, 0});
    desc.substeps = 16;
    auto world = make(desc);
    BodyDesc arm = kinematic(box({0, 0}, 80, 0.2, kIce));
    arm.angular_velocity = omega;
    add(*world, arm);
    const BodyId id = add(*world, disc({1, 0.2}, {-0.2 * omega, omega}, 0.1, kIce));
    for (int k = 1; std::cosh(omega * k / 60) < 20; ++k) {
      world->step();
      const BodyState s = state(*world, id);
      const double along = std::sqrt(s.x * s.x + s.y * s.y - 0.04), exact = std::cosh(omega * k / 60);
      EXPECT_NEAR(along / exact, 1, 0.02) << "omega " << omega << " frame " << k;
    }
  }
}

}  // namespace
}  // namespace psim::test
