// The scalar kernels against the equations of their comments, written anew in double precision and
// one body or contact at a time. (kernel_exact_test.cpp extends what holds here to every variant.)
#include <set>

#include "kernel_support.h"

namespace psim::test {
namespace {

const KernelTable& scalar() { return kernels_of(Isa::scalar); }

struct Vec {
  double x = 0, y = 0;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
Vec operator*(double s, Vec a) { return {s * a.x, s * a.y}; }
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
double length(Vec a) { return std::hypot(a.x, a.y); }
Vec left_of(Vec n) { return {-n.y, n.x}; }

template <class T>
Vec record(const std::vector<T>& column, std::size_t i) {
  return {double(column[2 * i]), double(column[2 * i + 1])};
}
Vec place(const Bodies& b, std::size_t i) {
  return double{kPitch} * record(b.pos, i) + record(b.disp, i);
}

void expect_near(Vec got, Vec want, double tolerance) {
  EXPECT_NEAR(got.x, want.x, tolerance);
  EXPECT_NEAR(got.y, want.y, tolerance);
}

// ---- streams ------------------------------------------------------------------------------------

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
  p.damp_rest = 0;
  const Bodies old = b;
  BodyView view = b.view(true);
  view.vel_rest = b.vel_rest.data();
  for (int step = 0; step < 10000; ++step) scalar().kick_first(view, p, 0, 1);
  for (std::size_t i = 0; i < b.count; ++i) {
    const Vec sum = 10000 * double{p.coast} * record(old.acc, i);
    expect_near(record(b.vel, i) + record(b.vel_rest, i),
                record(old.vel, i) + record(old.vel_rest, i) + sum, 1e-8);
  }
}

TEST(KernelOracle, KickInAFieldDampsByMoreThanAFloatHolds) {
  Random random(44);
  Bodies b(random, 8);
  std::fill(b.linked.begin(), b.linked.end(), std::uint8_t{0xFF});
  std::fill(b.acc.begin(), b.acc.end(), 0.0f);
  StreamParams p = stream_params(random);
  p.damp = 0.998f;
  p.damp_rest = 2.5e-8f;  // 2,000 kicks: 5e-5 of the velocity
  const double damp = double{p.damp} + double{p.damp_rest};
  const Bodies old = b;
  BodyView view = b.view(true);
  view.vel_rest = b.vel_rest.data();
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

// ---- smooth forces ------------------------------------------------------------------------------

/// Gravity and wells at a place, by std::pow.
Vec pull(const FieldSet& fields, double scale, Vec at) {
  Vec sum = scale * Vec{fields.p.gravity_x, fields.p.gravity_y};
  const double exponents[] = {0, 1, 2, 4.7};
  for (std::size_t n = 0; n < fields.wells.size(); ++n) {
    const kernels::WellTerms& w = fields.wells[n];
    const Vec d = Vec{w.x, w.y} - at;
    if (dot(d, d) > w.range2) continue;
    sum = sum + (scale * w.strength / std::pow(dot(d, d) + w.softening2, (exponents[n] + 1) / 2)) * d;
  }
  return sum;
}

struct Motion {
  Vec x, v;
};

Vec drag_of(const FieldSet& fields, Vec v) {
  return -(fields.p.linear + fields.p.quadratic * length(v)) * v;
}

/// The differential equation, by a thousand steps of the midpoint rule.
Motion flown(const FieldSet& fields, double scale, Motion m, double h) {
  const auto rate = [&](Motion at) {
    return Motion{at.v, pull(fields, scale, at.x) + drag_of(fields, at.v)};
  };
  const int steps = 1000;
  const double t = h / steps;
  for (int k = 0; k < steps; ++k) {
    const Motion r = rate(m), mid = rate({m.x + t / 2 * r.x, m.v + t / 2 * r.v});
    m = {m.x + t * mid.x, m.v + t * mid.v};
  }
  return m;
}

Motion motion(const Bodies& b, std::size_t i) {
  return {place(b, i) + record(b.disp_rest, i), record(b.vel, i) + record(b.vel_rest, i)};
}

/// Largest errors of place and velocity after one substep of the method, far from the wells.
Motion substep_error(std::size_t method, double h, std::size_t drag) {
  Random random(31);
  Bodies b(random, 40);
  FieldSet fields(random, drag ? 0.3 : 0, drag ? 0.02 : 0, h);
  for (kernels::WellTerms& w : fields.wells) {
    w.x += 10;
    w.range2 = std::numeric_limits<double>::infinity();
  }
  fields.p.smooth = method == 0 ? -1 : 4 * h * h;  // Euler
  const Bodies old = b;
  scalar().advance[method][drag](b.field_view(true), fields.p, 0, 5);
  scalar().drift_bent(b.field_view(true), fields.p, 0, 5);
  Motion worst;
  for (std::size_t i = 0; i < b.count; ++i) {
    const Motion before = motion(old, i), after = motion(b, i);
    if (old.linked[i] == 0) {
      EXPECT_EQ(length(after.x - before.x) + length(after.v - before.v), 0);
      continue;
    }
    const Motion want = flown(fields, double{old.pull[i]}, before, h);
    worst.x.x = std::fmax(worst.x.x, length(after.x - want.x));
    worst.v.x = std::fmax(worst.v.x, length(after.v - want.v));
    expect_near(record(b.vel0, i), record(old.vel, i), 0);
  }
  return worst;
}

TEST(KernelOracle, AdvanceFollowsTheEquationOfMotionToItsOrder) {
  struct Want {
    std::size_t method;
    double power;      // of h, in the error of one substep's velocity
    double at, place;  // errors at h = 0.04, m/s and m
  };
  for (const Want& want : {Want{0, 2, 0.05, 0.08}, Want{1, 5, 2e-6, 1e-6}, Want{2, 5, 2e-6, 3e-7}}) {
    for (const std::size_t drag : {std::size_t{0}, std::size_t{1}}) {
      const Motion coarse = substep_error(want.method, 0.04, drag);
      const Motion fine = substep_error(want.method, 0.02, drag);
      EXPECT_LT(coarse.v.x, want.at) << want.method << drag;
      EXPECT_LT(coarse.x.x, want.place) << want.method << drag;
      EXPECT_NEAR(std::log2(coarse.v.x / fine.v.x), want.power, 0.5) << want.method << drag;
    }
  }
}

TEST(KernelOracle, AdvanceWithDragTooStrongForAMethodTakesItsExactDecay) {
  Random random(32);
  for (const std::size_t method : {std::size_t{1}, std::size_t{2}}) {
    Bodies b(random, 40);
    std::fill(b.linked.begin(), b.linked.end(), std::uint8_t{0xFF});
    FieldSet fields(random, 200, 50);  // h c = 0.8
    fields.p.well_count = 0;
    fields.p.gravity_x = fields.p.gravity_y = 0;
    const Bodies old = b;
    scalar().advance[method][1](b.field_view(false), fields.p, 0, 5);
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = motion(old, i).v;
      const double fade = std::exp(-200 * fields.p.h);
      const double left = fade / (1 + 50 * length(v) * (1 - fade) / 200);
      expect_near(motion(b, i).v, left * v, 1e-12);
    }
  }
}

TEST(KernelOracle, AccelerateIsTheMeanOverTheSubstep) {
  for (const std::size_t drag : {std::size_t{0}, std::size_t{1}}) {
    Random random(33);
    Bodies b(random, 40);
    const FieldSet fields(random, 0.3, drag ? 0.1 : 0);
    scalar().accelerate[drag](b.field_view(true), fields.p, 0, 5);
    const double h = fields.p.h;
    for (std::size_t i = 0; i < b.count; ++i) {
      if (b.linked[i] == 0) {
        expect_near(record(b.acc, i), {}, 0);
        continue;
      }
      const Vec v = record(b.vel, i), at = place(b, i) + h / 2 * v;
      Vec want = pull(fields, double{b.pull[i]}, at);
      const Vec u = std::exp(-0.3 * h / 2) * v + h / 2 * want;
      want = want - (fields.p.quadratic / (1 + fields.p.quadratic * length(u) * h) * length(u)) * u;
      expect_near(record(b.acc, i), want, 1e-6 * (1 + length(want)));
    }
  }
}

TEST(KernelOracle, DriftBentGoesTheMethodsWayOnlyWhereTheChangeIsSmooth) {
  Random random(34);
  for (const double smooth : {4 * double{kSubstep} * double{kSubstep}, -1.0}) {
    Bodies b(random, 40);
    FieldSet fields(random);
    fields.p.smooth = smooth;
    const Bodies old = b;
    scalar().drift_bent(b.field_view(false), fields.p, 0, 5);
    const double h = fields.p.h;
    int smooth_ones = 0;
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = record(old.vel, i), v0 = record(old.vel0, i), a = record(old.acc, i);
      const bool is_smooth = dot(v - v0, v - v0) <= smooth * dot(a, a);
      smooth_ones += is_smooth;
      Vec way = is_smooth ? h / 2 * (v0 + v) + record(old.bend, i) : h * v;
      if (old.linked[i] == 0) way = {};
      expect_near(motion(b, i).x, motion(old, i).x + way, 1e-14);
    }
    EXPECT_EQ(smooth_ones > 0, smooth > 0);
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
  EXPECT_NEAR(double{scalar().list_age(b.view(), b.built.data(), b.radius.data(), b.reach.data(), p,
                                       0.02f, 1, 4)}, age, 1e-6);
  EXPECT_NEAR(double{scalar().reaches(b.view(), b.radius.data(), {0.1f, 0.02f}, b.reach.data(), 1, 4)},
              most, 1e-6);
  scalar().look_ahead(b.view(), p, 0.02f, b.built.data(), 1, 4);
  for (std::size_t i = 16; i < 64; ++i) {
    const double steps = std::nearbyint(double{b.vel[i]} * time / double{kPitch});
    EXPECT_NEAR(double(b.built[i]) - double(b.pos[i]), steps, 1 + 1e-6 * std::fabs(steps));
  }
  for (std::size_t i = 8; i < 32; ++i) {
    EXPECT_NEAR(double{b.reach[i]},
                double{b.radius[i]} + skin + length(record(b.vel, i)) * time, 1e-6);
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
      const std::uint32_t count[] = {static_cast<std::uint32_t>(g.cols),
                                     static_cast<std::uint32_t>(g.rows)};
      ASSERT_LT(cell[axis], count[axis]);
      ASSERT_EQ(cell[1 - axis], axis == 0 ? 4u : 5u);
      ASSERT_LE(key[i == 0 ? 0 : i - 1], key[i]);
      const double mid = axis == 0 ? g.mid_x : g.mid_y;
      const double at = (xs[i] - mid) * double{axis == 0 ? g.scale_x : g.scale_y} +
                        double{axis == 0 ? g.offset_x : g.offset_y};
      if (std::fabs(at - std::round(at)) < 1e-5) continue;  // on an edge either cell is right
      const double want = std::floor(std::clamp(at, 0.0, count[axis] - 1.0));
      ASSERT_EQ(double(cell[axis]), want) << xs[i];
    }
  }
}

// ---- pair search --------------------------------------------------------------------------------

using PairSet = std::multiset<std::pair<std::uint32_t, std::uint32_t>>;

PairSet close_pairs(const Grid& g) {
  PairSet pairs;
  for (std::uint32_t i = 0; i < g.size(); ++i) {
    for (std::uint32_t j = i + 1; j < g.size(); ++j) {
      double d2 = 0;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        double d = double(g.pos[2 * j + axis]) - double(g.pos[2 * i + axis]);
        if (g.periodic) d -= std::round(d * 0x1p-32) * 0x1p32;
        d2 += d * d * double{g.pitch} * double{g.pitch};
      }
      const double sum = double{g.reach[i]} + double{g.reach[j]};
      if (d2 < sum * sum) pairs.insert({i, j});
    }
  }
  return pairs;
}

TEST(KernelOracle, PairSearchFindsEveryClosePairOnce) {
  for (const bool periodic : {false, true}) {
    for (const std::size_t bodies : {2u, 30u, 150u, 400u}) {
      Random random(bodies);
      const Grid g(random, 6, 6, bodies, periodic);
      Found f(50000, g.size());
      kernels::PairList list = f.list();
      PairSet found;
      for (std::uint32_t r = 0; r < g.rows; ++r) {
        ASSERT_TRUE(scalar().find_pairs(g.row(r), g.row_begin[r], g.row_begin[r + 1], list));
      }
      for (std::uint32_t p = 0; p < list.count; ++p) {
        const std::uint32_t i = f.owner[p], j = f.other[p];
        found.insert({std::min(i, j), std::max(i, j)});
        ASSERT_LE(f.first[i], p);
        ASSERT_GT(i + 1 < g.size() ? f.first[i + 1] : list.count, p);
      }
      EXPECT_EQ(found, close_pairs(g)) << bodies << (periodic ? " periodic" : "");
      EXPECT_TRUE(bodies < 150 || found.size() > 20);
    }
  }
}

TEST(KernelOracle, FindNearSearchesARun) {
  Random random(8);
  const Grid g(random, 2, 2, 40, false);
  const PairSet close = close_pairs(g);
  for (std::uint32_t i = 0; i < 10; ++i) {
    Found f(100, g.size());
    kernels::PairList list = f.list();
    EXPECT_TRUE(scalar().find_near(g.row(0), i, 10, 37, list));
    std::uint32_t at = 0;
    for (std::uint32_t j = 10; j < 37; ++j) {
      if (!close.contains({i, j})) continue;
      ASSERT_LT(at, list.count);
      EXPECT_EQ(f.owner[at], i);
      EXPECT_EQ(f.other[at++], j);
    }
    EXPECT_EQ(at, list.count);
  }
}

TEST(KernelOracle, SelectPairsKeepsThoseThatCanMeet) {
  Random random(9);
  Bodies b(random, 40);
  std::vector<std::uint32_t> owner, other, want_i, want_j;
  const double time = 0.02, slack = 0.05;
  for (std::uint32_t i = 0; i < 40; ++i) {
    for (std::uint32_t j = i + 1; j < 40; ++j) {
      owner.push_back(i);
      other.push_back(j);
      const double far = length(double{kPitch} * (record(b.pos, j) - record(b.pos, i)));
      const double speed = length(record(b.vel, j) - record(b.vel, i));
      if (far < double{b.radius[i]} + double{b.radius[j]} + slack + speed * time) {
        want_i.push_back(i);
        want_j.push_back(j);
      }
    }
  }
  std::vector<std::uint32_t> out_i(owner.size() + kBlock), out_j(owner.size() + kBlock);
  kernels::PairSelection s;
  s.owner = owner.data();
  s.other = other.data();
  s.radius = b.radius.data();
  s.pitch_x = s.pitch_y = kPitch;
  s.time = 0.02f;
  s.slack = 0.05f;
  s.out_owner = out_i.data();
  s.out_other = out_j.data();
  const std::uint32_t n =
      scalar().select_pairs(b.view(), s, 0, static_cast<std::uint32_t>(owner.size()));
  out_i.resize(n);
  out_j.resize(n);
  EXPECT_EQ(out_i, want_i);
  EXPECT_EQ(out_j, want_j);
  EXPECT_GT(n, 50u);
  EXPECT_LT(n, owner.size() - 50);
}

// ---- contacts -----------------------------------------------------------------------------------

/// One contact in doubles. A fixed partner has inverse mass 0, and stands still.
struct Contact {
  Vec n, va, vb, da, db, va0, vb0;
  double gap, radius, l, w_a, w_b, m, mu, t, mt, q_a, q_b, u_a, u_b, e, start;
};

Contact contact_of(const Bodies& b, const Contacts& c, std::size_t k, Model model) {
  Contact x{};
  const bool pair = c.step == 2;
  const std::size_t i = c.body[c.step * k], j = c.body[c.step * k + c.step - 1];
  x.n = {c.nx[k], c.ny[k]};
  x.gap = c.gap[k];
  x.radius = c.rsum[k];
  x.l = c.impulse[k];
  if (pair) {
    x.va = record(b.vel, i), x.da = record(b.disp, i), x.va0 = record(b.vel0, i);
    x.w_a = model == Model::plain ? 1 : c.wa[k];
  }
  x.vb = record(b.vel, j), x.db = record(b.disp, j), x.vb0 = record(b.vel0, j);
  x.w_b = model == Model::plain ? 1 : c.wb[k];
  x.m = 1 / (x.w_a + x.w_b);
  x.e = c.e[k];
  x.start = c.start[k];
  if (model == Model::rough) {
    x.mu = c.mu[k], x.t = c.friction[k], x.mt = c.tmass[k], x.q_b = c.qb[k], x.u_b = b.spin[j];
    if (pair) x.q_a = c.qa[k], x.u_a = b.spin[i];
  }
  return x;
}

/// Adds a normal and a tangent impulse.
void push(Contact& x, double normal, double tangent) {
  const Vec p = normal * x.n + tangent * left_of(x.n);
  x.va = x.va - x.w_a * p;
  x.vb = x.vb + x.w_b * p;
  x.u_a -= x.q_a * tangent;
  x.u_b -= x.q_b * tangent;
}

bool bounces(const Contact& x, const ContactParams& p, double s, double& target) {
  const double vn0 = dot(x.n, x.vb0 - x.va0);
  target = x.e * vn0;
  return x.e > 0 && vn0 < -double{p.impact_floor} && s + vn0 * double{p.h} < 0;
}

void warm(Contact& x, const ContactParams& p) {
  x.l *= double{p.warm};
  x.t *= double{p.warm};
  push(x, x.l, x.t);
}

void solve(Contact& x, const ContactParams& p, bool bounce) {
  const double s = x.gap + dot(x.n, x.db - x.da), vn = dot(x.n, x.vb - x.va);
  double dl = -x.m * (vn + s / double{p.h});
  double target = 0;
  const double soft = s > 0 ? s / double{p.h} : std::fmax(double{p.soft_rate} * s, -double{p.push});
  if (bounce && bounces(x, p, s, target)) {
    dl = -x.m * (vn + std::fmin(target, soft));
  } else if (s <= 0) {
    dl = -x.m * (double{p.soft_mass} * vn + soft) - double{p.soft_impulse} * x.l;
  }
  double next = std::fmax(x.l + dl, 0.0);
  const Vec u = x.vb - x.va;
  const double offset = std::fabs((s + x.radius) * dot(left_of(x.n), u)) / length(u);
  if (s > 0 && offset > x.radius) next = 0;  // they pass each other
  push(x, next - x.l, 0);
  x.start = x.l;
  x.l = s > 0 && next <= 0 ? -0.0 : next;
}

void relax(Contact& x, const ContactParams& p, bool bounce) {
  double target = 0;
  const bool hit = bounce && bounces(x, p, -1e30, target) && x.l > 0;
  const Vec u = x.vb - x.va;
  const double vn = dot(x.n, u) + (hit ? target : 0);
  const double next = std::signbit(x.l) ? x.l : std::fmax(x.l - x.m * vn, 0.0);
  const double vt = dot(left_of(x.n), u) - x.u_b - x.u_a;
  const double cap = x.mu * std::fmax(next, 0.0);
  const double t = std::clamp(x.t - x.mt * vt, -cap, cap);
  push(x, next - x.l, t - x.t);
  x.t = t;
  x.l = hit ? std::fmin(next, std::fmax(x.start, 0.0)) : next;
  x.start = hit ? next - x.l : 0;
}

void expect_same(const Contact& got, const Contact& want, double tolerance) {
  expect_near(got.va, want.va, tolerance);
  expect_near(got.vb, want.vb, tolerance);
  EXPECT_NEAR(got.l, want.l, tolerance);
  EXPECT_EQ(std::signbit(got.l), std::signbit(want.l));
  EXPECT_NEAR(got.t, want.t, tolerance);
  EXPECT_NEAR(got.u_a, want.u_a, tolerance);
  EXPECT_NEAR(got.u_b, want.u_b, tolerance);
}

enum class Pass { warm, solve, relax };

void check_pass(Pass pass, bool pairs, Model model, bool bounce) {
  int opened = 0, closed = 0;
  for (std::uint64_t seed = 0; seed < 20 && !::testing::Test::HasFailure(); ++seed) {
    Random random(seed);
    Bodies b(random, 40);
    for (std::size_t i = 0; i < 2 * b.count; ++i) {  // slower: touching, not only colliding
      b.vel[i] *= 0.1f;
      b.vel0[i] *= 0.1f;
    }
    Contacts c(random, b, pairs, 1, 7);
    for (std::size_t k = 0; k < kBlock; ++k) c.impact[k] = 1;
    ContactParams p = contact_params();
    p.refresh = 1e30f;  // fixed normals; KernelOracle.NormalsAreRefreshed has the others
    std::fill(c.refresh.begin(), c.refresh.end(), 1e30f);
    std::vector<Contact> want;
    for (std::size_t k = 0; k < 7; ++k) {
      Contact x = contact_of(b, c, k, model);
      if (pass == Pass::warm) warm(x, p);
      if (pass == Pass::solve) solve(x, p, bounce);
      if (pass == Pass::relax) relax(x, p, bounce);
      want.push_back(x);
    }
    const std::size_t m = index_of(model);
    const BodyView view = b.view(false, model == Model::rough);
    const KernelTable& t = scalar();
    if (pairs) {
      const ContactView v = c.pairs(model, bounce);
      const auto run = pass == Pass::warm    ? t.warm[m]
                       : pass == Pass::solve ? t.solve[m][bounce]
                                             : t.relax[m][bounce];
      run(view, v, p, 0, 1);
    } else {
      const SingleView v = c.singles(model, bounce);
      const auto run = pass == Pass::warm    ? t.warm_single[m]
                       : pass == Pass::solve ? t.solve_single[m][bounce]
                                             : t.relax_single[m][bounce];
      run(view, v, p, 0, 1);
    }
    for (std::size_t k = 0; k < 7; ++k) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " lane " + std::to_string(k));
      const Contact got = contact_of(b, c, k, model);
      expect_same(got, want[k], 1e-4);
      EXPECT_NEAR(got.start, bounce ? want[k].start : got.start, 1e-4);
      (std::signbit(got.l) ? opened : closed)++;
    }
  }
  EXPECT_GT(opened, 5);
  EXPECT_GT(closed, 5);
}

void check_pass(Pass pass) {
  for (const bool pairs : {true, false}) {
    for (const Model model : kAllModels) {
      for (const bool bounce : {false, true}) {
        if (pass == Pass::warm && bounce) continue;
        SCOPED_TRACE(std::string(pairs ? "pairs" : "singles") + ", model " +
                     std::to_string(index_of(model)) + (bounce ? ", bounce" : ""));
        check_pass(pass, pairs, model, bounce);
      }
    }
  }
}

TEST(KernelOracle, WarmStartRepeatsTheImpulses) { check_pass(Pass::warm); }
TEST(KernelOracle, SolveFollowsTheSoftContactEquations) { check_pass(Pass::solve); }
TEST(KernelOracle, RelaxStopsTheApproachAndRubs) { check_pass(Pass::relax); }

TEST(KernelOracle, PrepareMakesNormalAndGap) {
  Random random(10);
  Bodies b(random, 40);
  std::copy_n(&b.pos[0], 2, &b.pos[2]);
  Contacts c(random, b, true, 3, 8);
  c.body[0] = 0;  // coincident centres in lane 0; slots need not differ to be read
  c.body[1] = 1;
  scalar().prepare(b.view(), c.pairs(Model::plain, false), contact_params(), 0, 3);
  EXPECT_EQ(c.nx[0], 0);
  EXPECT_EQ(c.ny[0], 1);
  EXPECT_EQ(c.gap[0], -c.rsum[0]);
  for (std::size_t k = 1; k < c.lanes(); ++k) {
    const Vec d = double{kPitch} * (record(b.pos, c.body[2 * k + 1]) - record(b.pos, c.body[2 * k]));
    const double far = length(d);
    if (far == 0) continue;
    expect_near({c.nx[k], c.ny[k]}, (1 / far) * d, 3e-7);
    EXPECT_NEAR(c.gap[k], far - double{c.rsum[k]}, 1e-6);
  }
}

// Beyond p.refresh the normal is that of the present displacement, and gap + n.dd the true gap.
TEST(KernelOracle, NormalsAreRefreshed) {
  Random random(11);
  Bodies b(random, 40);
  Contacts c(random, b, true, 1, 8);
  Contacts s(random, b, false, 1, 8);
  ContactParams p = contact_params();
  p.refresh = 0;
  std::fill(s.refresh.begin(), s.refresh.end(), 0.0f);
  scalar().solve[0][0](b.view(), c.pairs(Model::plain, false), p, 0, 1);
  scalar().solve_single[0][0](b.view(), s.singles(Model::plain, false), p, 0, 1);
  for (std::size_t k = 0; k < kBlock; ++k) {
    const std::size_t i = c.body[2 * k], j = c.body[2 * k + 1];
    const Vec d = place(b, j) - place(b, i), dd = record(b.disp, j) - record(b.disp, i);
    const Vec n{c.nx[k], c.ny[k]};
    expect_near(n, (1 / length(d)) * d, 1e-6);
    EXPECT_NEAR(double{c.gap[k]} + dot(n, dd), length(d) - double{c.rsum[k]}, 1e-6);
    const Vec ds = record(b.disp, s.body[k]), ns{s.nx[k], s.ny[k]};
    const Vec x = Vec{s.base_x[k], s.base_y[k]} + ds;
    expect_near(ns, (1 / length(x)) * x, 1e-6);
    EXPECT_NEAR(double{s.gap[k]} + dot(ns, ds), length(x) - double{s.rsum[k]}, 1e-6);
  }
}

TEST(KernelOracle, SpendMovesImpactsIntoV0) {
  for (const bool pairs : {true, false}) {
    Random random(12);
    Bodies b(random, 40);
    Contacts c(random, b, pairs, 1, 8);
    const Bodies old = b;
    const Contacts was = c;
    const std::size_t m = index_of(Model::rough);
    if (pairs) {
      scalar().spend[m](b.view(false, true), c.pairs(Model::rough, true), {}, 0, 1);
    } else {
      scalar().spend_single[m](b.view(false, true), c.singles(Model::rough, true), {}, 0, 1);
    }
    for (std::size_t k = 0; k < kBlock; ++k) {
      const Contact x = contact_of(old, was, k, Model::rough);
      const bool hit = x.start > 0;
      const double cap = x.mu * std::fmax(x.l, 0.0);
      const double held = hit ? std::clamp(x.t, -cap, cap) : x.t;
      const Vec impulse = (hit ? x.start : 0) * x.n + (x.t - held) * left_of(x.n);
      const std::size_t i = c.body[c.step * k], j = c.body[c.step * k + c.step - 1];
      expect_near(record(b.vel0, j), record(old.vel0, j) + x.w_b * impulse, 1e-5);
      EXPECT_NEAR(b.spin0[j], double{old.spin0[j]} - x.q_b * (x.t - held), 1e-5);
      if (pairs) {
        expect_near(record(b.vel0, i), record(old.vel0, i) - x.w_a * impulse, 1e-5);
        EXPECT_NEAR(b.spin0[i], double{old.spin0[i]} - x.q_a * (x.t - held), 1e-5);
      }
      EXPECT_NEAR(c.friction[k], held, 1e-6);
    }
  }
}

// ---- impacts ------------------------------------------------------------------------------------

/// Two discs (or one against a fixed point) heading for each other with an offset; all else rests.
struct Heading {
  Bodies b;
  Contacts c;
  double t = 0;  // analytic time of impact
  Vec d, u;      // relative place and velocity at 0

  Heading(Random& random, bool pair) : b(random, 16), c(random, b, pair, 1, 1) {
    for (auto* column : {&b.vel, &b.disp}) std::fill(column->begin(), column->end(), 0.0f);
    std::fill(b.event_time.begin(), b.event_time.end(), 0.0f);
    const std::size_t i = c.body[0], j = c.body[c.step - 1];
    const double angle = random.uniform(0, 6);
    const Vec n{std::cos(angle), std::sin(angle)};
    c.rsum[0] = 1;
    const double far = 1 + random.uniform(0.005, 0.02);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double along = far * (axis == 0 ? n.x : n.y);
      b.pos[2 * j + axis] = b.pos[2 * i + axis] + static_cast<int>(along / double{kPitch});
      if (pair) b.vel[2 * i + axis] = uniform(random, -3, 3);
      const double side = axis == 0 ? -n.y : n.x;
      b.vel[2 * j + axis] = b.vel[2 * i + axis] +
                            static_cast<float>(random.uniform(-12, -9) * (axis == 0 ? n.x : n.y) +
                                               random.uniform(-2, 2) * side);
    }
    if (pair) {
      d = place(b, j) - place(b, i);
      u = record(b.vel, j) - record(b.vel, i);
    } else {
      c.base_x[0] = static_cast<float>(far * n.x);
      c.base_y[0] = static_cast<float>(far * n.y);
      c.refresh[0] = 0.01f;
      d = {c.base_x[0], c.base_y[0]};
      b.vel[2 * j] = static_cast<float>(-10 * n.x - n.y);
      b.vel[2 * j + 1] = static_cast<float>(-10 * n.y + n.x);
      u = record(b.vel, j);
    }
    const double a = dot(u, u), q = dot(d, u), gap2 = dot(d, d) - 1;
    t = (-q - std::sqrt(q * q - a * gap2)) / a;
    c.e[0] = 0.8f;
    c.impact[0] = 0;
  }
};

TEST(KernelOracle, SweepHitsAtTheAnalyticTime) {
  for (const bool pair : {true, false}) {
    for (const Model model : kAllModels) {
      for (std::uint64_t seed = 0; seed < 30 && !HasFailure(); ++seed) {
        SCOPED_TRACE((pair ? "pair, seed " : "single, seed ") + std::to_string(seed));
        Random random(seed);
        Heading s(random, pair);
        ASSERT_LT(s.t, double{kSubstep});
        const Bodies old = s.b;
        ContactParams p = contact_params();
        p.gravity_y = 0;
        p.last_sweep = false;
        double virial = 0;
        const BodyView view = s.b.view(false, model == Model::rough, true);
        const std::size_t m = index_of(model);
        const bool any =
            pair ? scalar().sweep[m](view, s.c.pairs(model, true), p, 0, 1, &virial)
                 : scalar().sweep_single[m](view, s.c.singles(model, true), p, 0, 1, &virial);
        ASSERT_TRUE(any);
        EXPECT_TRUE(std::signbit(s.c.impact[0]));
        const std::size_t i = s.c.body[0], j = s.c.body[s.c.step - 1];
        EXPECT_NEAR(double{s.b.event_time[j]}, s.t, 2e-6);
        const Vec met = s.d + s.t * s.u;
        const Vec n = (1 / length(met)) * met;
        const Contact x = contact_of(old, s.c, 0, model), now = contact_of(s.b, s.c, 0, model);
        const double vn = dot(n, s.u), jn = -(1 + double{0.8f}) * vn * x.m;
        EXPECT_NEAR(dot(n, now.vb - now.va), -0.8 * vn, 1e-3);
        EXPECT_NEAR(virial, jn, 1e-3);
        double jt = 0;
        if (model == Model::rough) {
          const double vt = dot(left_of(n), s.u) - x.u_a - x.u_b;
          jt = std::clamp(-x.mt * vt, -x.mu * jn, x.mu * jn);
          EXPECT_NEAR(s.b.spin[j], double{old.spin[j]} - x.q_b * jt, 1e-3);
          EXPECT_NEAR(s.b.spin0[j], double{old.spin0[j]} - x.q_b * jt, 1e-3);
        }
        const Vec impulse = jn * n + jt * left_of(n);
        expect_near(now.vb, x.vb + x.w_b * impulse, 1e-3);
        expect_near(now.vb0, x.vb0 + x.w_b * impulse, 1e-3);
        // The old and the new path cross at the time of the impact.
        expect_near(now.db + s.t * now.vb, x.db + s.t * x.vb, 1e-5);
        if (!pair) continue;
        EXPECT_EQ(s.b.event_time[i], s.b.event_time[j]);
        expect_near(now.va, x.va - x.w_a * impulse, 1e-3);
        expect_near(now.da + s.t * now.va, x.da + s.t * x.va, 1e-5);
      }
    }
  }
}

TEST(KernelOracle, SweepHitsFlatFacesOnTheParabola) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Random random(seed);
    Heading h(random, false);
    const std::size_t j = h.c.body[0];
    h.c.refresh[0] = std::numeric_limits<float>::infinity();
    h.c.nx[0] = 0.6f;
    h.c.ny[0] = 0.8f;
    h.c.gap[0] = uniform(random, 0.001, 0.02);
    h.b.vel[2 * j] = uniform(random, -3, 3);
    h.b.vel[2 * j + 1] = -10;
    ContactParams p = contact_params();
    p.gravity_y = -500;  // so that the parabola matters within a substep
    const double un = 0.6 * double{h.b.vel[2 * j]} - 8, gn = -400, s = h.c.gap[0];
    const double t = (-un - std::sqrt(un * un - 2 * gn * s)) / gn;
    const Bodies old = h.b;
    double virial = 0;
    const bool any = scalar().sweep_single[0](h.b.view(false, false, true),
                                              h.c.singles(Model::plain, true), p, 0, 1, &virial);
    ASSERT_EQ(any, t < double{kSubstep}) << seed;
    if (!any) continue;
    EXPECT_NEAR(double{h.b.event_time[j]}, t, 1e-6);
    const double vn = un + gn * t;
    const Vec n{0.6, 0.8};
    expect_near(record(h.b.vel, j), record(old.vel, j) - 1.8 * vn * n, 1e-3);
    EXPECT_EQ(virial, 0);  // flat faces have no radius to the point
  }
}

TEST(KernelOracle, SweepSettlesMissesAndLeavesTheRest) {
  Random random(13);
  Heading h(random, true);
  const auto mark_of = [&](auto change, bool last = false) {
    Heading s = h;
    change(s);
    const Bodies before = s.b;
    ContactParams p = contact_params();
    p.last_sweep = last;
    double virial = 0;
    EXPECT_FALSE(scalar().sweep[0](s.b.view(false, false, true), s.c.pairs(Model::plain, true), p,
                                   0, 1, &virial));
    EXPECT_EQ(before.vel, s.b.vel);
    EXPECT_EQ(before.disp, s.b.disp);
    EXPECT_EQ(virial, 0);
    return std::bit_cast<std::uint32_t>(s.c.impact[0]);
  };
  const std::uint32_t settled = 0x80000000u, pending = 0, not_for_sweeps = 0x3F800000u;
  EXPECT_EQ(mark_of([](Heading& s) { for (float& v : s.b.vel) v = -v; }), settled);
  EXPECT_EQ(mark_of([](Heading& s) { s.c.e[0] = 0.001f; }), pending);   // below the floor
  EXPECT_EQ(mark_of([](Heading&) {}, true), pending);                   // last sweep, not elastic
  EXPECT_EQ(mark_of([](Heading& s) { s.c.impact[0] = 1; }), not_for_sweeps);
  EXPECT_EQ(mark_of([](Heading& s) {                                    // overlapping and parting
              s.c.rsum[0] = 1.1f;
              for (float& v : s.b.vel) v = -v;
            }), pending);
}

}  // namespace
}  // namespace psim::test
