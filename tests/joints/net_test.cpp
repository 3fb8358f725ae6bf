// Nets: what hangs on few supports stretches little, no net gives energy, and loads are told although tethers carry them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "joint_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr double kMesh = 0.25;

struct Net : JointScene {
  Net(int columns, int rows, int substeps, JointType type, bool (*held)(int column, int row, int columns, int rows),
      Vec2 corner = {}, bool periodic = false, double slack = 1)
      : JointScene(desc_of(substeps, periodic)), length(kMesh * slack), columns(columns) {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        BodyDesc d;
        d.shape = DiscShape{0.1};
        const double x = corner.x + kMesh * column;
        d.position = {periodic && x >= 10 ? x - 20 : x, corner.y - kMesh * row};
        d.mass = 1;
        d.filter.mask = 0;
        if (held(column, row, columns, rows)) d.type = BodyType::static_body;
        bodies.push_back(add(d));
      }
    }
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        if (column + 1 < columns) tie(type, {column, row}, {column + 1, row}, {kMesh / 2, 0});
        if (row + 1 < rows) tie(type, {column, row}, {column, row + 1}, {0, -kMesh / 2});
        if (row + 1 < rows && column == 0) down.emplace_back();
        if (row + 1 < rows) down.back().push_back(joints.back());
      }
    }
  }
  static WorldDesc desc_of(int substeps, bool periodic) {
    WorldDesc d;
    d.gravity = {0, -kG};
    d.substeps = substeps;
    d.sleeping = false;
    if (periodic) {
      d.bounds = {-10, -10, 10, 10};
      d.boundary = Boundary::periodic;
    }
    return d;
  }
  BodyId& body(int column, int row) { return bodies[static_cast<std::size_t>(row * columns + column)]; }
  void tie(JointType type, std::array<int, 2> a, std::array<int, 2> b, Vec2 arm) {
    if (world->body(body(a[0], a[1]))->type != BodyType::dynamic_body &&
        world->body(body(b[0], b[1]))->type != BodyType::dynamic_body) {
      return;
    }
    const bool pins = type == JointType::revolute;
    JointDesc d =
        between(type, body(a[0], a[1]), body(b[0], b[1]), pins ? arm : Vec2{}, pins ? Vec2{-arm.x, -arm.y} : Vec2{});
    if (!pins && length != kMesh) d.length = length;
    joints.push_back(join(d));
  }
  double energy() const {
    const Diagnostics d = world->diagnostics();
    return d.kinetic + d.potential;
  }
  // The longest distance of anchors that should be `length` apart, in meshes beyond it.
  double stretch() const {
    double most = 0;
    for (const JointId id : joints) {
      const JointState s = joint(id);
      const double far = std::hypot(s.anchor_b.x - s.anchor_a.x, s.anchor_b.y - s.anchor_a.y);
      most = std::max(most, far / length - (s.type == JointType::revolute ? 0 : 1));
    }
    return most;
  }

  double length;  // m: of a link
  int columns;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  std::vector<std::vector<JointId>> down;  // by row
};

bool top_row(int, int row, int, int) { return row == 0; }
bool top_corners(int column, int row, int columns, int) { return row == 0 && (column == 0 || column == columns - 1); }
bool corners(int column, int row, int columns, int rows) {
  return (row == 0 || row == rows - 1) && (column == 0 || column == columns - 1);
}

class Nets : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Substeps, Nets, testing::Values(1, 4, 16));

// Without tethers the links of the first one stretched by 0.39 at 4 substeps; those of the second one, which has no slack,
// by 17, and it gained energy.
TEST_P(Nets, GiveNoEnergyAndStretchLittle) {
  const double most = GetParam() == 1 ? 0.6 : GetParam() == 4 ? 0.1 : 0.03;
  for (const auto held : {top_corners, corners}) {
    for (const JointType type : {JointType::distance, JointType::revolute}) {
      Net net(40, 40, GetParam(), type, held);
      const double start = net.energy(), scale = 1600 * kG * 40 * kMesh;
      for (int frame = 0; frame < 240; frame += 4) {
        net.run(4);
        ASSERT_LT(net.energy() - start, 1e-3 * scale) << "frame " << frame;
        ASSERT_LT(net.stretch(), (held == corners ? 2 : 1) * most) << "frame " << frame;
      }
    }
  }
}

// Without cycles, links stretched by 0.06 in the sheet and by 0.1 in one with slack.
TEST(Net, UnderALargeLoadItsLinksHardlyStretch) {
  for (const double slack : {1.0, 1.1}) {
    Net net(40, 40, 4, JointType::distance, top_corners, {}, false, slack);
    net.run(420);
    for (int quarter = 0; quarter < 4; ++quarter) {
      net.run(15);
      EXPECT_LT(net.stretch(), 0.03) << "slack " << slack;
    }
  }
}

TEST(Net, JointsTellTheWholeLoadAlthoughTethersCarryIt) {
  for (const JointType type : {JointType::distance, JointType::revolute}) {
    Net net(40, 60, 4, type, top_row);
    net.run(240);
    for (const std::size_t row : {0u, 10u, 30u}) {
      double load = 0;
      for (const JointId id : net.down[row]) load -= net.joint(id).force.y;
      EXPECT_NEAR(std::fabs(load), (59 - static_cast<double>(row)) * 40 * kG, 0.01 * 59 * 40 * kG) << "row " << row;
    }
  }
}

TEST(Net, KeepsItsTethersImpulsesWhenJointsComeAndInSavedStates) {
  Net net(40, 40, 4, JointType::distance, top_corners);
  net.run(60);
  std::string error;
  std::vector<std::byte> saved;
  net.world->save(saved);
  const auto other = World::create(Net::desc_of(4, false), {}, error);
  ASSERT_TRUE(other->restore(saved, error)) << error;
  const double before = net.stretch();
  for (World* w : {net.world.get(), other.get()}) {
    ASSERT_NE(w->add_joint(between(JointType::distance, net.body(20, 20), net.body(23, 23)), error), kNoJoint) << error;
  }
  for (int frame = 0; frame < 20; ++frame) {
    net.run(1);
    other->step();
    ASSERT_EQ(net.world->state_hash(), other->state_hash()) << "frame " << frame;
  }
  EXPECT_LT(net.stretch(), before + 0.05);
}

TEST(Net, AcrossTheSeamOfAPeriodicWorldDefaultLengthsGoTheShortWay) {
  Net net(8, 1, 4, JointType::distance, top_corners, {9.1, 0}, true);
  for (const JointId id : net.joints) EXPECT_NEAR(net.joint(id).value, kMesh, 1e-6);
  net.run(60);
  for (const JointId id : net.joints) EXPECT_NEAR(net.joint(id).value, kMesh, 1e-4);
}

}  // namespace
}  // namespace psim::test
