// Time-of-impact sweeps (impact_kernel.h) against collisions in closed form.
#include "kernel_oracle.h"

namespace psim::test {
namespace {

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
      b.vel[2 * j + axis] = b.vel[2 * i + axis] + static_cast<float>(random.uniform(-12, -9) * (axis == 0 ? n.x : n.y) +
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
        double virial = 0;
        const BodyView view = s.b.view(false, model == Model::rough, true);
        const std::size_t m = index_of(model);
        const bool any = pair ? scalar().sweep[m][0](view, s.c.pairs(model, true), p, 0, 1, &virial)
                              : scalar().sweep_static[m][0](view, s.c.static_contacts(model, true), p, 0, 1, &virial);
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
          EXPECT_NEAR(s.b.rim_speed[j], double{old.rim_speed[j]} - x.q_b * jt, 1e-3);
          EXPECT_NEAR(s.b.rim_speed0[j], double{old.rim_speed0[j]} - x.q_b * jt, 1e-3);
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
    const bool any = scalar().sweep_static[0][0](h.b.view(false, false, true), h.c.static_contacts(Model::plain, true),
                                                 p, 0, 1, &virial);
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
    p.least_e = last ? 1.0f : 0.0f;
    double virial = 0;
    EXPECT_FALSE(scalar().sweep[0][0](s.b.view(false, false, true), s.c.pairs(Model::plain, true), p, 0, 1, &virial));
    EXPECT_EQ(before.vel, s.b.vel);
    EXPECT_EQ(before.disp, s.b.disp);
    EXPECT_EQ(virial, 0);
    return std::bit_cast<std::uint32_t>(s.c.impact[0]);
  };
  const std::uint32_t settled = 0x80000000u, pending = 0, not_for_sweeps = 0x3F800000u;
  EXPECT_EQ(mark_of([](Heading& s) {
              for (float& v : s.b.vel) v = -v;
            }),
            settled);
  EXPECT_EQ(mark_of([](Heading& s) { s.c.e[0] = 0.001f; }), pending);  // below the floor
  EXPECT_EQ(mark_of([](Heading&) {}, true), pending);                  // last sweep, not elastic
  EXPECT_EQ(mark_of([](Heading& s) { s.c.impact[0] = 1; }), not_for_sweeps);
  EXPECT_EQ(mark_of([](Heading& s) {  // overlapping and parting
              s.c.rsum[0] = 1.1f;
              for (float& v : s.b.vel) v = -v;
            }),
            pending);
}

}  // namespace
}  // namespace psim::test
