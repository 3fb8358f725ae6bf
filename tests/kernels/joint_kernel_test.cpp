// The passes over joints: the same bits on every instruction set, over whole blocks; and scalar against
// the laws they stand for, in double precision.
#include "joint_views.h"
#include "kernel_support.h"

namespace psim::test {
namespace {

using kernels::DrivenBlock;
using kernels::JointBodies;
using kernels::JointKind;
using kernels::JointParams;
using kernels::JointShare;
using kernels::LineBlock;
using kernels::PinBlock;
using kernels::SlideBlock;
using kernels::WeldBlock;

constexpr std::uint32_t kCount = 64, kRecords = kCount + 2;  // and two resting ones
constexpr std::uint32_t kBlocks = 4;

/// Bodies that have moved and turned since the frame's start.
struct Crowd {
  explicit Crowd(Random& random) {
    const auto fill = [&](std::vector<float>& v, std::size_t n, double most) {
      v.assign(n + 16, 0.0f);
      for (std::size_t i = 0; i < n; ++i) v[i] = uniform(random, -most, most);
    };
    fill(vel, 2 * kCount, 3);
    fill(vel0, 2 * kCount, 3);
    fill(disp, 2 * kCount, 0.02);
    fill(rim_speed, kCount, 2);
    fill(rim_speed0, kCount, 2);
    fill(angle_change, kCount, 0.2);
    fill(share, 2 * kCount, 0.1);
    fill(share_spin, kCount, 0.1);
    fill(push, 2 * kCount, 0.1);
    fill(push_spin, kCount, 0.1);
    arm_change.assign(2 * kRecords + 16, 0.0f);
    radius.assign(kRecords + 16, 1.0f);
    for (std::size_t i = 0; i < kCount; ++i) {
      radius[i] = uniform(random, 0.1, 1);
      const double r = static_cast<double>(radius[i]), d = static_cast<double>(angle_change[i]);
      arm_change[2 * i] = static_cast<float>(r * (std::cos(d) - 1));
      arm_change[2 * i + 1] = static_cast<float>(r * std::sin(d));
    }
    for (auto* v : {&vel, &vel0, &disp, &share, &push}) v->resize(2 * kRecords + 16);
    push0.assign(2 * kRecords + 16, 0.0f);
    push0_spin.assign(kRecords + 16, 0.0f);
    for (auto* v : {&rim_speed, &rim_speed0, &angle_change, &share_spin, &push_spin}) v->resize(kRecords + 16);
  }
  BodyView view() {
    BodyView v;
    v.vel = vel.data();
    v.vel0 = vel0.data();
    v.disp = disp.data();
    v.rim_speed = rim_speed.data();
    v.rim_speed0 = rim_speed0.data();
    v.arm_change = arm_change.data();
    v.angle_change = angle_change.data();
    return v;
  }
  JointShare shares() {
    return {share.data(), share_spin.data(), push.data(), push_spin.data(), push0.data(), push0_spin.data()};
  }
  bool operator==(const Crowd& o) const {
    const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
      return std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
    };
    return same(vel, o.vel) && same(vel0, o.vel0) && same(disp, o.disp) && same(rim_speed, o.rim_speed) &&
           same(rim_speed0, o.rim_speed0) && same(share, o.share) && same(share_spin, o.share_spin) &&
           same(push, o.push) && same(push_spin, o.push_spin) && same(push0, o.push0) &&
           same(push0_spin, o.push0_spin) && same(arm_change, o.arm_change) && same(angle_change, o.angle_change);
  }
  std::vector<float> vel, vel0, disp, rim_speed, rim_speed0, angle_change, arm_change, radius, share, share_spin, push,
      push_spin, push0, push0_spin;
};

// Blocks whose lanes share no body; some lanes are empty.
template <class Block>
std::vector<Block> make_blocks(Random& random, const Crowd& crowd, bool fixed) {
  std::vector<Block> blocks(kBlocks);
  for (Block& b : blocks) {
    std::vector<std::uint32_t> order(kCount);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = kCount; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    auto* floats = reinterpret_cast<float*>(reinterpret_cast<char*>(&b) + sizeof b.body);
    for (std::size_t i = 0; i < (sizeof b - sizeof b.body) / sizeof(float); ++i) {
      floats[i] = uniform(random, -1, 1);
    }
    const auto each = [&](float* column, double low, double high) {
      for (std::size_t k = 0; k < kBlock; ++k) column[k] = uniform(random, low, high);
    };
    for (float* column : {b.wa, b.wb, b.ga0, b.gb0}) each(column, 0.1, 2);
    std::copy(b.ga0, b.ga0 + kBlock, b.ga);
    std::copy(b.gb0, b.gb0 + kBlock, b.gb);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      b.body[2 * k] = order[2 * k];
      b.body[2 * k + 1] = order[2 * k + 1];
      b.ra[k] = 1 / crowd.radius[order[2 * k]];
      b.rb[k] = 1 / crowd.radius[order[2 * k + 1]];
      if (fixed) {
        b.wa[k] = b.ga[k] = b.ga0[k] = 0;
        if (random.chance(0.5)) {
          b.body[2 * k] = kCount;
          b.ra[k] = 1;
        }
      }
    }
    const auto along_unit = [&](float* x, float* y) {
      for (std::size_t k = 0; k < kBlock; ++k) {
        const double a = random.uniform(0, 2 * kPi);
        x[k] = static_cast<float>(std::cos(a));
        y[k] = static_cast<float>(std::sin(a));
      }
    };
    if constexpr (std::is_same_v<Block, LineBlock>) {
      along_unit(b.nx, b.ny);
      b.central = random.chance(0.5) ? 1 : 0;
      if (b.central != 0) {
        for (float* column : {b.ax0, b.ay0, b.bx0, b.by0, b.ax, b.ay, b.bx, b.by, b.ea, b.eb}) each(column, 0, 0);
      }
      each(b.mass, 0.1, 1);
      for (float* column : {b.far0, b.curvature, b.push, b.drag, b.lag}) each(column, 0.5, 2);
      for (std::size_t k = 0; k < kBlock; ++k) {
        const double x = static_cast<double>(b.dx0[k]), y = static_cast<double>(b.dy0[k]);
        b.far0[k] = static_cast<float>(std::sqrt(x * x + y * y));
        b.top[k] = random.chance(0.5) ? 1e30f : 0.0f;
        if (b.top[k] == 0) b.l[k] = random.chance(0.3) ? 0.0f : -std::fabs(b.l[k]);
      }
    } else if constexpr (std::is_same_v<Block, SlideBlock>) {
      along_unit(b.ux0, b.uy0);
      along_unit(b.ux, b.uy);
      each(b.mass, 0.1, 1);
    } else if constexpr (!std::is_same_v<Block, PinBlock>) {
      each(b.mass, 0.1, 1);
      if constexpr (std::is_same_v<Block, WeldBlock>) {
        for (std::size_t k = 0; k < kBlock; ++k) {
          b.push[k] = random.chance(0.5) ? 0.0f : 1.5f;
          b.drag[k] = b.push[k] / 2;
          b.lag[k] = b.push[k] / 4;
        }
      }
    }
    if constexpr (requires { b.drive; }) {
      each(b.drive.lower, -0.5, 0);
      each(b.drive.upper, 0, 0.5);
      each(b.drive.most, 0, 1);
      for (std::size_t k = 0; k < kBlock; ++k) {
        if (random.chance(0.5)) b.drive.limit_l[k] = 0;
        if (random.chance(0.3)) b.drive.upper[k] = b.drive.lower[k];
      }
    }
    for (std::uint32_t k = 0; k < kBlock; ++k) {  // empty lanes
      if (!random.chance(0.15)) continue;
      auto* column = reinterpret_cast<float*>(&b);
      for (std::size_t i = 2; i < sizeof b / sizeof(float) / kBlock; ++i) column[i * kBlock + k] = 0;
      b.body[2 * k] = b.body[2 * k + 1] = kCount + 1;
    }
  }
  return blocks;
}

JointParams params(bool again) {
  JointParams p;
  p.h = kSubstep;
  p.inv_h = 1 / kSubstep;
  p.rate = 0.5f / kSubstep;
  p.warm = 0.75f;
  p.again = again;
  return p;
}

// All passes one after the other, several times over.
template <class Block>
void run_all(const KernelTable& k, JointKind kind, bool fixed, Crowd& crowd, std::vector<Block>& blocks) {
  const auto at = static_cast<std::size_t>(kind);
  const BodyView view = crowd.view();
  BodyView pushed = view;
  pushed.vel = crowd.push.data();
  pushed.rim_speed = crowd.push_spin.data();
  const std::uint32_t body_blocks = kCount / kBlock;
  for (int round = 0; round < 2; ++round) {
    k.part_joints(view, crowd.shares(), 0, body_blocks);
    k.warm_joints[at][fixed](view, blocks.data(), params(false), 0, kBlocks);
    for (const bool again : {false, true}) {
      k.solve_joints[at][fixed](view, blocks.data(), params(again), 0, kBlocks);
    }
    k.part_joints(view, crowd.shares(), 0, body_blocks);
    k.push_joints[at][fixed](pushed, blocks.data(), params(false), 0, kBlocks);
    StreamParams drift;
    drift.h = kSubstep;
    drift.smooth_limit2 = 1;
    k.hold_joints(view, crowd.shares(), drift, 0, body_blocks);
    k.let_go_joints(view, crowd.shares(), 1, body_blocks);
    for (const bool again : {false, true}) {
      k.relax_joints[at][fixed](view, blocks.data(), params(again), 0, kBlocks);
    }
  }
}

template <class Block>
void compare_isas(JointKind kind) {
  for (int round = 0; round < 20; ++round) {
    for (const bool fixed : {false, true}) {
      Random random(static_cast<std::uint64_t>(round) * 2 + fixed);
      const Crowd start(random);
      const std::vector<Block> blocks = make_blocks<Block>(random, start, fixed);
      Crowd crowd = start;
      std::vector<Block> scalar = blocks;
      run_all(kernels_of(Isa::scalar), kind, fixed, crowd, scalar);
      for (const float v : crowd.vel) ASSERT_TRUE(std::isfinite(v));
      ASSERT_FALSE(crowd == start);
      if constexpr (std::is_same_v<Block, LineBlock>) {  // where anchors are centres, arms change nothing
        Crowd with_arms = start;
        std::vector<Block> turning = blocks;
        for (Block& b : turning) b.central = 0;
        run_all(kernels_of(Isa::scalar), kind, fixed, with_arms, turning);
        ASSERT_EQ(crowd.vel, with_arms.vel);
        ASSERT_EQ(crowd.rim_speed, with_arms.rim_speed);
      }
      for (const Isa isa : available_isas()) {
        Crowd wide_crowd = start;
        std::vector<Block> wide = blocks;
        run_all(kernels_of(isa), kind, fixed, wide_crowd, wide);
        ASSERT_TRUE(crowd == wide_crowd) << isa_name(isa) << " round " << round << " " << fixed;
        ASSERT_EQ(std::memcmp(scalar.data(), wide.data(), sizeof(Block) * kBlocks), 0)
            << isa_name(isa) << " round " << round << " " << fixed;
      }
      for (std::size_t i = 2 * kCount; i < crowd.vel.size(); ++i) ASSERT_EQ(crowd.vel[i], 0);
    }
  }
}

TEST(JointKernel, RodsAreTheSameOnEveryIsa) { compare_isas<LineBlock>(JointKind::rod); }
TEST(JointKernel, SpringsAreTheSameOnEveryIsa) { compare_isas<LineBlock>(JointKind::spring); }
TEST(JointKernel, PinsAreTheSameOnEveryIsa) { compare_isas<PinBlock>(JointKind::pin); }
TEST(JointKernel, DrivenPinsAreTheSameOnEveryIsa) { compare_isas<DrivenBlock>(JointKind::driven); }
TEST(JointKernel, SlidesAreTheSameOnEveryIsa) { compare_isas<SlideBlock>(JointKind::slide); }
TEST(JointKernel, WeldsAreTheSameOnEveryIsa) { compare_isas<WeldBlock>(JointKind::weld); }

// ---- oracles ------------------------------------------------------------------------------------------

struct P2 {
  double x = 0, y = 0;
};
double wide(float v) { return static_cast<double>(v); }

// The two bodies of a lane, in doubles.
struct Pair {
  Pair(const Crowd& c, const JointBodies& b, std::uint32_t k, bool before = false) {
    const std::vector<float>& v = before ? c.vel0 : c.vel;
    const std::vector<float>& u = before ? c.rim_speed0 : c.rim_speed;
    const std::uint32_t i = b.body[2 * k], j = b.body[2 * k + 1];
    va = {wide(v[2 * i]), wide(v[2 * i + 1])};
    vb = {wide(v[2 * j]), wide(v[2 * j + 1])};
    wa = wide(u[i]) * wide(b.ra[k]);
    wb = wide(u[j]) * wide(b.rb[k]);
    ra = arm(c, i, b.ax0[k], b.ay0[k], b.ra[k]);
    rb = arm(c, j, b.bx0[k], b.by0[k], b.rb[k]);
    moved = {wide(c.disp[2 * j]) - wide(c.disp[2 * i]), wide(c.disp[2 * j + 1]) - wide(c.disp[2 * i + 1])};
    swung = wide(c.angle_change[j]) - wide(c.angle_change[i]);
    moved.x += rb.x - ra.x - wide(b.bx0[k]) / wide(b.rb[k]) + wide(b.ax0[k]) / wide(b.ra[k]);
    moved.y += rb.y - ra.y - wide(b.by0[k]) / wide(b.rb[k]) + wide(b.ay0[k]) / wide(b.ra[k]);
  }
  static P2 arm(const Crowd& c, std::uint32_t i, float x, float y, float inverse) {
    const double co = std::cos(wide(c.angle_change[i])), si = std::sin(wide(c.angle_change[i]));
    return {(co * wide(x) - si * wide(y)) / wide(inverse), (si * wide(x) + co * wide(y)) / wide(inverse)};
  }
  P2 anchors() const {  // velocity of B's against A's
    return {vb.x - wb * rb.y - va.x + wa * ra.y, vb.y + wb * rb.x - va.y - wa * ra.x};
  }
  P2 va, vb, ra, rb, moved;
  double wa = 0, wb = 0, swung = 0;
};

// Relax at the bodies' present places, then `check` every lane that is in use.
template <class Block, class Check>
void after_relax(JointKind kind, const Check& check) {
  for (int round = 0; round < 20; ++round) {
    for (const bool fixed : {false, true}) {
      Random random(100 + static_cast<std::uint64_t>(round) * 2 + fixed);
      Crowd crowd(random);
      const Crowd start = crowd;
      std::vector<Block> blocks = make_blocks<Block>(random, crowd, fixed);
      const KernelTable& k = kernels_of(Isa::scalar);
      // One block: the lanes of several may share bodies.
      k.relax_joints[static_cast<std::size_t>(kind)][fixed](crowd.view(), blocks.data(), params(false), 0, 1);
      for (int sweep = 0; sweep < 8; ++sweep) {
        k.relax_joints[static_cast<std::size_t>(kind)][fixed](crowd.view(), blocks.data(), params(true), 0, 1);
      }
      for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
        const Block& b = blocks[0];
        if (b.body[2 * lane + 1] >= kCount) continue;
        const std::uint32_t i = b.body[2 * lane], j = b.body[2 * lane + 1];
        if (fixed) {
          ASSERT_EQ(crowd.vel[2 * i], start.vel[2 * i]);
          ASSERT_EQ(crowd.rim_speed[i], start.rim_speed[i]);
        } else {  // what A lost B gained
          for (std::size_t axis = 0; axis < 2; ++axis) {
            const double lost = (wide(crowd.vel[2 * i + axis]) - wide(start.vel[2 * i + axis])) / wide(b.wa[lane]);
            const double got = (wide(crowd.vel[2 * j + axis]) - wide(start.vel[2 * j + axis])) / wide(b.wb[lane]);
            ASSERT_NEAR(lost, -got, 1e-4);
          }
        }
        check(b, lane, Pair(crowd, b, lane));
      }
    }
  }
}

TEST(JointKernel, RelaxedRodsKeepTheirLength) {
  after_relax<LineBlock>(JointKind::rod, [](const LineBlock& b, std::uint32_t k, const Pair& p) {
    const double x = wide(b.dx0[k]) + p.moved.x, y = wide(b.dy0[k]) + p.moved.y;
    const double far = std::sqrt(x * x + y * y);
    EXPECT_NEAR(wide(b.nx[k]), x / far, 2e-6);
    EXPECT_NEAR(wide(b.ny[k]), y / far, 2e-6);
    EXPECT_NEAR(wide(b.c[k]), wide(b.c0[k]) + far - wide(b.far0[k]), 2e-6);
    const P2 v = p.anchors();
    const double speed = (x * v.x + y * v.y) / far;
    if (b.top[k] > 0) {
      EXPECT_NEAR(speed, 0, 2e-5);
    } else {
      EXPECT_LE(b.l[k], 0);
      if (b.l[k] < 0) {
        EXPECT_NEAR(speed, 0, 2e-5);
      }
    }
  });
}

TEST(JointKernel, RelaxedPinsKeepTheirAnchorsTogether) {
  after_relax<PinBlock>(JointKind::pin, [](const PinBlock& b, std::uint32_t k, const Pair& p) {
    EXPECT_NEAR(wide(b.cx[k]), wide(b.cx0[k]) + p.moved.x, 2e-6);
    EXPECT_NEAR(wide(b.cy[k]), wide(b.cy0[k]) + p.moved.y, 2e-6);
    EXPECT_NEAR(p.anchors().x, 0, 1e-4);
    EXPECT_NEAR(p.anchors().y, 0, 1e-4);
  });
}

TEST(JointKernel, RelaxedWeldsKeepAnchorsAndAngle) {
  after_relax<WeldBlock>(JointKind::weld, [](const WeldBlock& b, std::uint32_t k, const Pair& p) {
    EXPECT_NEAR(wide(b.angle[k]), wide(b.angle0[k]) + p.swung, 1e-6);
    EXPECT_NEAR(p.anchors().x, 0, 1e-4);
    EXPECT_NEAR(p.anchors().y, 0, 1e-4);
    if (b.push[k] == 0) {
      EXPECT_NEAR(p.wb - p.wa, 0, 2e-4);
    }
  });
}

TEST(JointKernel, RelaxedDrivenPinsObeyMotorOrLimit) {
  after_relax<DrivenBlock>(JointKind::driven, [](const DrivenBlock& b, std::uint32_t k, const Pair& p) {
    EXPECT_NEAR(p.anchors().x, 0, 1e-4);
    EXPECT_NEAR(p.anchors().y, 0, 1e-4);
    EXPECT_LE(std::fabs(b.drive.motor_l[k]), b.drive.most[k]);
    const double rim_speed = p.wb - p.wa;
    if (b.drive.limit_l[k] != 0) {
      EXPECT_NEAR(rim_speed, 0, 5e-4);
    } else if (std::fabs(b.drive.motor_l[k]) < b.drive.most[k]) {
      EXPECT_NEAR(rim_speed, wide(b.drive.speed[k]), 5e-4);
    }
  });
}

TEST(JointKernel, RelaxedSlidesMoveAlongTheirAxisAlone) {
  after_relax<SlideBlock>(JointKind::slide, [](const SlideBlock& b, std::uint32_t k, const Pair& p) {
    EXPECT_NEAR(p.wb - p.wa, 0, 5e-4);
    const double norm = wide(b.ux[k]) * wide(b.ux[k]) + wide(b.uy[k]) * wide(b.uy[k]);
    EXPECT_NEAR(norm, 1, 1e-5);
    // Across, seen from A, whose axis turns: n.v - wA u.d.
    const P2 v = p.anchors();
    const double across = -wide(b.uy[k]) * v.x + wide(b.ux[k]) * v.y - p.wa * wide(b.along[k]);
    EXPECT_NEAR(across, 0, 2e-4);
  });
}

TEST(JointKernel, SpringImpulsesFulfilTheirEquation) {
  for (int round = 0; round < 20; ++round) {
    Random random(500 + static_cast<std::uint64_t>(round));
    Crowd crowd(random);
    std::fill(crowd.angle_change.begin(), crowd.angle_change.end(), 0.0f);
    std::fill(crowd.arm_change.begin(), crowd.arm_change.end(), 0.0f);
    std::fill(crowd.rim_speed.begin(), crowd.rim_speed.end(), 0.0f);  // no centripetal terms
    std::fill(crowd.rim_speed0.begin(), crowd.rim_speed0.end(), 0.0f);
    std::vector<LineBlock> blocks = make_blocks<LineBlock>(random, crowd, false);
    const KernelTable& k = kernels_of(Isa::scalar);
    const auto at = static_cast<std::size_t>(JointKind::spring);
    for (float* column : {blocks[0].ax0, blocks[0].ay0, blocks[0].bx0, blocks[0].by0}) {
      std::fill(column, column + kBlock, 0.0f);  // hung by their centres
    }
    k.warm_joints[at][0](crowd.view(), blocks.data(), params(false), 0, 1);
    const Crowd warm = crowd;
    k.solve_joints[at][0](crowd.view(), blocks.data(), params(false), 0, 1);
    for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
      const LineBlock& b = blocks[0];
      if (b.body[2 * lane + 1] >= kCount) continue;
      const double nx = wide(b.nx[lane]), ny = wide(b.ny[lane]), h = wide(kSubstep);
      const auto along = [&](const P2& v) { return nx * v.x + ny * v.y; };
      const Pair then(warm, b, lane), now(crowd, b, lane), before(crowd, b, lane, true);
      const P2 v = then.anchors();
      const double sideways = std::fabs(nx * v.y - ny * v.x);
      const double curve = sideways * std::fmin(sideways * wide(b.curvature[lane]) * h, 1.0);
      const double l = -wide(b.push[lane]) * (wide(b.c[lane]) + h / 4 * curve) -
                       wide(b.drag[lane]) * (along(before.anchors()) + along(now.anchors())) -
                       wide(b.lag[lane]) * along(before.anchors());
      EXPECT_NEAR(wide(b.l[lane]), l, 2e-5);
    }
  }
}

TEST(JointKernel, PushTakesAShareOfTheErrorBack) {
  Random random(900);
  Crowd crowd(random);
  std::fill(crowd.push.begin(), crowd.push.end(), 0.0f);
  std::fill(crowd.push_spin.begin(), crowd.push_spin.end(), 0.0f);
  std::vector<PinBlock> blocks = make_blocks<PinBlock>(random, crowd, false);
  const KernelTable& k = kernels_of(Isa::scalar);
  const auto at = static_cast<std::size_t>(JointKind::pin);
  k.warm_joints[at][0](crowd.view(), blocks.data(), params(false), 0, 1);
  BodyView pushed = crowd.view();
  pushed.vel = crowd.push.data();
  pushed.rim_speed = crowd.push_spin.data();
  k.push_joints[at][0](pushed, blocks.data(), params(false), 0, 1);
  std::swap(crowd.vel, crowd.push);
  std::swap(crowd.rim_speed, crowd.push_spin);
  for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
    const PinBlock& b = blocks[0];
    if (b.body[2 * lane + 1] >= kCount) continue;
    const P2 v = Pair(crowd, b, lane).anchors();
    EXPECT_NEAR(v.x * wide(kSubstep), -0.5 * wide(b.cx[lane]), 1e-5);
    EXPECT_NEAR(v.y * wide(kSubstep), -0.5 * wide(b.cy[lane]), 1e-5);
  }
}

TEST(JointKernel, PartingTwiceAddsWhatHappenedInBetween) {
  Random random(1000);
  Crowd crowd(random);
  const Crowd start = crowd;
  const KernelTable& k = kernels_of(Isa::scalar);
  k.part_joints(crowd.view(), crowd.shares(), 0, kCount / kBlock);
  for (std::size_t i = 0; i < 2 * kCount; ++i) crowd.vel[i] += 0.25f;
  for (std::size_t i = 0; i < kCount; ++i) crowd.rim_speed[i] -= 0.5f;
  k.part_joints(crowd.view(), crowd.shares(), 0, kCount / kBlock);
  for (std::size_t i = 0; i < 2 * kCount; ++i) EXPECT_NEAR(crowd.share[i], start.share[i] + 0.25f, 1e-6);
  for (std::size_t i = 0; i < kCount; ++i) EXPECT_NEAR(crowd.share_spin[i], start.share_spin[i] - 0.5f, 1e-6);
}

}  // namespace
}  // namespace psim::test
