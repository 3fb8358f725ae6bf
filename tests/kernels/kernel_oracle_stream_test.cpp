// Streams over bodies (stream_kernel.h) against their equations.
#include "kernel_oracle.h"

namespace psim::test {
namespace {

TEST(KernelOracle, IntegrateIsTheClosedFormAndLosesNoPosition) {
  for (const bool own : {false, true}) {
    Random random(1);
    Bodies b(random, 40);
    const Bodies old = b;
    const StreamParams p = stream_params(random);
    EXPECT_TRUE(scalar().integrate(b.view(own), p, 0, 5));
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = record(old.vel, i), a = record(old.acc, i);
      const Vec kick = own ? double{p.coast} * a : Vec{p.kick_x, p.kick_y};
      const Vec fall = own ? double{p.drop} * a : Vec{p.fall_x, p.fall_y};
      const bool free = old.linked[i] == 0;
      expect_near(record(b.vel, i), free ? double{p.damp} * v + kick : v, free ? 1e-5 : 0);
      const Vec way = free ? double{p.coast} * v + fall : Vec{};
      expect_near(place(b, i), place(old, i) + way, 1e-6);
      EXPECT_LE(std::fabs(b.disp[2 * i]), kPitch / 2);
      EXPECT_LE(std::fabs(b.disp[2 * i + 1]), kPitch / 2);
    }
  }
}

TEST(KernelOracle, IntegrateCutsFarMovesAndReportsBadBodies) {
  Random random(2);
  Bodies b(random, 8);
  std::fill(b.linked.begin(), b.linked.end(), std::uint8_t{0});
  StreamParams p = stream_params(random);
  p.far_x = 0.05f;
  p.far_y = 0.03f;
  b.vel[4] = 900;
  b.vel[5] = -900;
  const Bodies old = b;
  const BodyView view = b.view();
  EXPECT_FALSE([&] {
    StreamParams slow = p;
    slow.speed_limit2 = 100;
    Bodies copy = old;
    return scalar().integrate(copy.view(), slow, 0, 1);
  }());
  EXPECT_FALSE(scalar().integrate(view, p, 0, 1));  // 900 and 900: beyond 1000 m/s
  expect_near(place(b, 2), double{kPitch} * record(old.pos, 2) + Vec{0.05, -0.03}, 1e-6);
  b = old;
  b.vel[4] = b.vel[5] = 0;
  EXPECT_TRUE(scalar().integrate(b.view(), p, 0, 1));
  b.vel[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(scalar().integrate(b.view(), p, 0, 1));
}

TEST(KernelOracle, KickDampsTakesV0AndAddsTheAcceleration) {
  for (const bool own : {false, true}) {
    Random random(3);
    Bodies b(random, 40);
    Bodies old = b;
    StreamParams p = stream_params(random);
    scalar().kick_first(b.view(own), p, 0, 5);
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = record(old.vel, i);
      if (old.linked[i] == 0) {
        expect_near(record(b.vel, i), v, 0);
        continue;
      }
      const Vec kick = own ? double{p.coast} * record(old.acc, i) : Vec{p.kick_x, p.kick_y};
      expect_near(record(b.vel0, i), double{p.damp} * v, 4e-6);
      expect_near(record(b.vel, i), double{p.damp} * v + kick, 8e-6);
    }
    old = b;
    scalar().kick_again(b.view(own), p, 0, 5);  // the same change again
    for (std::size_t i = 0; i < b.count; ++i) {
      if (old.linked[i] == 0) continue;
      const Vec v = record(old.vel, i);
      expect_near(record(b.vel0, i), double{p.damp} * v, 4e-6);
      expect_near(record(b.vel, i), double{p.damp} * v + v - record(old.vel0, i), 8e-6);
    }
  }
}

TEST(KernelOracle, KickInAFieldKeepsWhatVelocitiesCannotHold) {
  Random random(4);
  Bodies b(random, 8);
  std::fill(b.linked.begin(), b.linked.end(), std::uint8_t{0xFF});
  for (float& a : b.acc) a = 1.1e-5f;
  StreamParams p = stream_params(random);
  p.damp = 1;
  p.damp_remainder = 0;
  const Bodies old = b;
  BodyView view = b.view(true);
  view.vel_remainder = b.vel_remainder.data();
  for (int step = 0; step < 10000; ++step) scalar().kick_first(view, p, 0, 1);
  for (std::size_t i = 0; i < b.count; ++i) {
    const Vec sum = 10000 * double{p.coast} * record(old.acc, i);
    expect_near(record(b.vel, i) + record(b.vel_remainder, i), record(old.vel, i) + record(old.vel_remainder, i) + sum,
                1e-8);
  }
}

TEST(KernelOracle, KickInAFieldDampsByMoreThanAFloatHolds) {
  Random random(44);
  Bodies b(random, 8);
  std::fill(b.linked.begin(), b.linked.end(), std::uint8_t{0xFF});
  std::fill(b.acc.begin(), b.acc.end(), 0.0f);
  StreamParams p = stream_params(random);
  p.damp = 0.998f;
  p.damp_remainder = 2.5e-8f;  // 2,000 kicks: 5e-5 of the velocity
  const double damp = double{p.damp} + double{p.damp_remainder};
  const Bodies old = b;
  BodyView view = b.view(true);
  view.vel_remainder = b.vel_remainder.data();
  for (int step = 0; step < 2000; ++step) scalar().kick_first(view, p, 0, 1);
  for (std::size_t i = 0; i < b.count; ++i) {
    const Vec want = std::pow(damp, 2000) * record(old.vel, i);
    expect_near(record(b.vel, i), want, 5e-6 * (0.1 + length(want)));
  }
}

TEST(KernelOracle, DriftUsesTheMeanOnlyWhereTheChangeIsSmooth) {
  for (const bool own : {false, true}) {
    Random random(5);
    Bodies b(random, 40);
    const Bodies old = b;
    const StreamParams p = stream_params(random);
    scalar().drift(b.view(own), p, 0, 5);
    int smooth_ones = 0;
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = record(old.vel, i), dv = v - record(old.vel0, i), a = record(old.acc, i);
      const double h = p.h;
      const double bound = double{p.smooth_limit2} + (own ? 4 * h * h * dot(a, a) : 0);
      const bool smooth = dot(dv, dv) <= bound;
      smooth_ones += smooth;
      Vec way = smooth ? h * (v - 0.5 * dv) : h * v;
      if (old.linked[i] == 0) way = {};
      expect_near(record(b.disp, i), record(old.disp, i) + way, 5e-8);
    }
    EXPECT_GT(smooth_ones, 0);
    EXPECT_LT(smooth_ones, 40);
  }
}

TEST(KernelOracle, ListAgeReachesAndExtentAreTheExtremes) {
  Random random(6);
  Bodies b(random, 40);
  const StreamParams p = stream_params(random);
  const double time = 0.02, skin = 0.1;
  double age = -1e30, most = 0;
  std::int32_t want[] = {INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
  for (std::size_t i = 8; i < 32; ++i) {
    const double moved = length(double{kPitch} * (record(b.pos, i) - record(b.built, i)));
    const double next = length(record(b.vel, i)) * time;
    age = std::fmax(age, moved + next - (double{b.reach[i]} - double{b.radius[i]}));
    most = std::fmax(most, double{b.radius[i]} + skin + next);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      want[axis] = std::min(want[axis], b.pos[2 * i + axis]);
      want[2 + axis] = std::max(want[2 + axis], b.pos[2 * i + axis]);
    }
  }
  EXPECT_NEAR(double{scalar().list_age(b.view(), b.built.data(), b.radius.data(), b.reach.data(), p, 0.02f, 1, 4)}, age,
              1e-6);
  EXPECT_NEAR(double{scalar().reaches(b.view(), b.radius.data(), {.skin = 0.1f, .time = 0.02f}, b.reach.data(), 1, 4)},
              most, 1e-6);
  scalar().look_ahead(b.view(), p, 0.02f, b.built.data(), 1, 4);
  for (std::size_t i = 16; i < 64; ++i) {
    const double steps = std::nearbyint(double{b.vel[i]} * time / double{kPitch});
    EXPECT_NEAR(double(b.built[i]) - double(b.pos[i]), steps, 1 + 1e-6 * std::fabs(steps));
  }
  for (std::size_t i = 8; i < 32; ++i) {
    EXPECT_NEAR(double{b.reach[i]}, double{b.radius[i]} + skin + length(record(b.vel, i)) * time, 1e-6);
  }
  std::int32_t got[] = {INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
  scalar().extent(b.pos.data(), got, 1, 4);
  EXPECT_TRUE(std::equal(got, got + 4, want));
  std::int32_t wider[] = {INT32_MIN, -3, INT32_MAX, INT32_MIN};
  scalar().extent(b.pos.data(), wider, 1, 4);
  EXPECT_EQ(wider[0], INT32_MIN);
  EXPECT_EQ(wider[1], std::min(-3, want[1]));
  EXPECT_EQ(wider[2], INT32_MAX);
  EXPECT_EQ(wider[3], want[3]);
}

TEST(KernelOracle, CellKeysAreInRangeAndMonotonic) {
  kernels::GridView g;
  g.mid_x = 1000;
  g.mid_y = -2000;
  g.scale_x = 0x1p-18f;
  g.scale_y = 0x1p-19f;
  g.offset_x = 5.5f;
  g.offset_y = 4;
  g.cols = 11;
  g.rows = 9;
  g.stride = 13;
  std::vector<std::int32_t> xs;
  Random random(7);
  for (int i = 0; i < 4000; ++i) xs.push_back(static_cast<std::int32_t>(random.uniform(-3e6, 3e6)));
  std::sort(xs.begin(), xs.end());
  std::vector<std::int32_t> pos(2 * xs.size() + 2 * kernels::kReadPad);
  std::vector<std::uint32_t> key(xs.size());
  for (const std::size_t axis : {0u, 1u}) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      pos[2 * i + axis] = xs[i];
      pos[2 * i + 1 - axis] = axis == 0 ? g.mid_y : g.mid_x;
    }
    scalar().cell_keys(pos.data(), g, key.data(), 0, static_cast<std::uint32_t>(xs.size() / kBlock));
    for (std::size_t i = 0; i < xs.size(); ++i) {
      const std::uint32_t cell[] = {key[i] % g.stride, key[i] / g.stride};
      const std::uint32_t count[] = {static_cast<std::uint32_t>(g.cols), static_cast<std::uint32_t>(g.rows)};
      ASSERT_LT(cell[axis], count[axis]);
      ASSERT_EQ(cell[1 - axis], axis == 0 ? 4u : 5u);
      ASSERT_LE(key[i == 0 ? 0 : i - 1], key[i]);
      const double mid = axis == 0 ? g.mid_x : g.mid_y;
      const double at =
          (xs[i] - mid) * double{axis == 0 ? g.scale_x : g.scale_y} + double{axis == 0 ? g.offset_x : g.offset_y};
      if (std::fabs(at - std::round(at)) < 1e-5) continue;  // on an edge either cell is right
      const double want = std::floor(std::clamp(at, 0.0, count[axis] - 1.0));
      ASSERT_EQ(double(cell[axis]), want) << xs[i];
    }
  }
}

}  // namespace
}  // namespace psim::test
