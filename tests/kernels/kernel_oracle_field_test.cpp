// Smooth forces and integrators (field_kernel.h) against the differential equation.
#include "kernel_oracle.h"

namespace psim::test {
namespace {

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

Vec drag_of(const FieldSet& fields, Vec v) { return -(fields.p.linear + fields.p.quadratic * length(v)) * v; }

/// The differential equation, by a thousand steps of the midpoint rule.
Motion flown(const FieldSet& fields, double scale, Motion m, double h) {
  const auto rate = [&](Motion at) { return Motion{at.v, pull(fields, scale, at.x) + drag_of(fields, at.v)}; };
  const int steps = 1000;
  const double t = h / steps;
  for (int k = 0; k < steps; ++k) {
    const Motion r = rate(m), mid = rate({m.x + t / 2 * r.x, m.v + t / 2 * r.v});
    m = {m.x + t * mid.x, m.v + t * mid.v};
  }
  return m;
}

Motion motion(const Bodies& b, std::size_t i) {
  return {place(b, i) + record(b.disp_remainder, i), record(b.vel, i) + record(b.vel_remainder, i)};
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
  scalar().drift_corrected(b.field_view(true), fields.p, 0, 5);
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
    scalar().drift_corrected(b.field_view(false), fields.p, 0, 5);
    const double h = fields.p.h;
    int smooth_ones = 0;
    for (std::size_t i = 0; i < b.count; ++i) {
      const Vec v = record(old.vel, i), v0 = record(old.vel0, i), a = record(old.acc, i);
      const bool is_smooth = dot(v - v0, v - v0) <= smooth * dot(a, a);
      smooth_ones += is_smooth;
      Vec way = is_smooth ? h / 2 * (v0 + v) + record(old.drift_correction, i) : h * v;
      if (old.linked[i] == 0) way = {};
      expect_near(motion(b, i).x, motion(old, i).x + way, 1e-14);
    }
    EXPECT_EQ(smooth_ones > 0, smooth > 0);
    EXPECT_LT(smooth_ones, 40);
  }
}

}  // namespace
}  // namespace psim::test
