// The scalar passes over manifolds against sums written down separately, in double.
#include "manifold_scene.h"

namespace psim::test::manifold_scene {
namespace {

struct LaneOf {
  const Scene& s;
  const ManifoldBlock& c;
  std::uint32_t l;
  std::size_t a, b;
  double nx, ny, wa, wb, ga, gb;

  LaneOf(const Scene& scene, std::size_t block, std::uint32_t lane)
      : s(scene),
        c(scene.blocks[block]),
        l(lane),
        a(c.body[2 * l]),
        b(c.body[2 * l + 1]),
        nx(c.nx[l]),
        ny(c.ny[l]),
        wa(c.wa[l]),
        wb(c.wb[l]),
        ga(c.ga[l]),
        gb(c.gb[l]) {}
};

/// Velocities of a lane's two bodies.
struct Motion {
  double vax, vay, ua, vbx, vby, ub;
  Motion(const LaneOf& x, const std::vector<float>& vel, const std::vector<float>& rim_speed)
      : vax(vel[2 * x.a]),
        vay(vel[2 * x.a + 1]),
        ua(rim_speed[x.a]),
        vbx(vel[2 * x.b]),
        vby(vel[2 * x.b + 1]),
        ub(rim_speed[x.b]) {}
  double normal(const LaneOf& x, int k) const {
    return x.nx * (vbx - vax) + x.ny * (vby - vay) + ub * double{x.c.point[k].bt[x.l]} -
           ua * double{x.c.point[k].at[x.l]};
  }
  double tangent(const LaneOf& x, int k) const {
    return x.nx * (vby - vay) - x.ny * (vbx - vax) + ub * double{x.c.point[k].bn[x.l]} -
           ua * double{x.c.point[k].an[x.l]};
  }
  /// Impulses p along the normal and q along the tangent at a point.
  void push(const LaneOf& x, int k, double p, double q, double share_a, double share_b) {
    const double px = p * x.nx - q * x.ny, py = p * x.ny + q * x.nx;
    vax -= share_a * x.wa * px;
    vay -= share_a * x.wa * py;
    vbx += share_b * x.wb * px;
    vby += share_b * x.wb * py;
    ua -= share_a * x.ga * (p * double{x.c.point[k].at[x.l]} + q * double{x.c.point[k].an[x.l]});
    ub += share_b * x.gb * (p * double{x.c.point[k].bt[x.l]} + q * double{x.c.point[k].bn[x.l]});
  }
};

double separation(const LaneOf& x, int k) {
  const auto& p = x.c.point[k];
  const auto at = [](const std::vector<float>& v, std::size_t i) { return double{v[i]}; };
  double s = p.gap[x.l];
  s += x.nx * (at(x.s.bodies.disp, 2 * x.b) - at(x.s.bodies.disp, 2 * x.a)) +
       x.ny * (at(x.s.bodies.disp, 2 * x.b + 1) - at(x.s.bodies.disp, 2 * x.a + 1));
  const auto turned_back = [&](std::size_t body, float lead) {
    return at(x.s.arm_change, 2 * body) + double{lead} * at(x.s.arm_change, 2 * body + 1);
  };
  s += turned_back(x.b, x.c.lead_b[x.l]) * (double{p.bn[x.l]} + double{x.c.round_b[x.l]}) +
       at(x.s.arm_change, 2 * x.b + 1) * double{p.bt[x.l]};
  s -= turned_back(x.a, x.c.lead_a[x.l]) * (double{p.an[x.l]} - double{x.c.round_a[x.l]}) +
       at(x.s.arm_change, 2 * x.a + 1) * double{p.at[x.l]};
  return s;
}

double coupling(const LaneOf& x, int i, int k) {
  const auto &p = x.c.point[i], &q = x.c.point[k];
  return x.wa + x.wb + x.ga * double{p.at[x.l]} * double{q.at[x.l]} + x.gb * double{p.bt[x.l]} * double{q.bt[x.l]};
}

double stored(const LaneOf& x, int k) { return std::max(0.0f, x.c.point[k].impulse[x.l]); }

TEST(ManifoldOracle, WarmAddsTheScaledImpulses) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const bool fixed_a : {false, true}) {
      Taste taste;
      taste.fixed_a = fixed_a;
      const Scene before = make_scene(seed, 1, taste);
      Scene after = before;
      ContactParams p = contact_params();
      kPasses[0].run(kernels_of(Isa::scalar), after, taste, p);
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        const LaneOf x(before, 0, l);
        if (x.b >= 64) continue;
        Motion m(x, before.bodies.vel, before.bodies.rim_speed);
        for (int k = 0; k < 2; ++k) {
          m.push(x, k, double{p.warm} * double{x.c.point[k].impulse[l]},
                 double{p.warm} * double{x.c.point[k].friction[l]}, fixed_a ? 0 : 1, 1);
        }
        const Motion is(x, after.bodies.vel, after.bodies.rim_speed);
        ASSERT_NEAR(is.vbx, m.vbx, 3e-6 * (1 + std::abs(m.vbx)));
        ASSERT_NEAR(is.vby, m.vby, 3e-6 * (1 + std::abs(m.vby)));
        ASSERT_NEAR(is.ub, m.ub, 3e-6 * (1 + std::abs(m.ub)));
        ASSERT_NEAR(is.vax, m.vax, 3e-6 * (1 + std::abs(m.vax)));
        ASSERT_NEAR(is.ua, m.ua, 3e-6 * (1 + std::abs(m.ua)));
      }
    }
  }
}

// The complementarity conditions themselves, not the way to them.
TEST(ManifoldOracle, SolveMeetsTheComplementarityConditions) {
  int pressed = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const bool fixed_a : {false, true}) {
      Taste taste;
      taste.fixed_a = fixed_a;
      const Scene before = make_scene(seed, 1, taste);
      Scene after = before;
      const ContactParams p = contact_params();
      kPasses[1].run(kernels_of(Isa::scalar), after, taste, p);
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        const LaneOf x(before, 0, l), y(after, 0, l);
        if (x.b >= 64) continue;
        const Motion start(x, before.bodies.vel, before.bodies.rim_speed);
        const double d[2] = {double{y.c.point[0].impulse[l]} - double{x.c.point[0].impulse[l]},
                             double{y.c.point[1].impulse[l]} - double{x.c.point[1].impulse[l]}};
        const double k11 = coupling(x, 0, 0), k12 = coupling(x, 0, 1), k22 = coupling(x, 1, 1);
        if (k11 * k22 - k12 * k12 < 2e-3 * k11 * k22) continue;  // nearly one point
        for (int k = 0; k < 2; ++k) {
          const double s = separation(x, k), l_new = stored(y, k);
          double bias = s * double{p.inv_h}, soft = 0;
          if (s <= 0) {
            bias = std::max(s * double{x.c.rate[l]}, -double{p.push});
            soft = double{x.c.soft[l]} * coupling(x, k, k);
          }
          // vn' + bias + soft l' >= 0, l' >= 0, one of them 0.
          const double vn = start.normal(x, k) + coupling(x, k, 0) * d[0] + coupling(x, k, 1) * d[1];
          const double rest = vn + bias + soft * l_new;
          const double scale = 1 + std::abs(start.normal(x, k)) + std::abs(bias);
          ASSERT_GE(l_new, 0);
          ASSERT_GT(rest, -1e-3 * scale) << "seed " << seed << " lane " << l;
          if (l_new > 1e-6) {
            ASSERT_NEAR(rest, 0, 1e-3 * scale) << "seed " << seed << " lane " << l;
            ++pressed;
          }
          if (std::signbit(y.c.point[k].impulse[l])) {
            ASSERT_GT(s, 0);
            ++open;
          }
        }
        // Bodies got what the impulses say, times their shares.
        Motion m = start;
        for (int k = 0; k < 2; ++k) {
          m.push(x, k, d[k], 0, fixed_a ? 0 : double{x.c.share_a[l]}, double{x.c.share_b[l]});
        }
        const Motion is(x, after.bodies.vel, after.bodies.rim_speed);
        ASSERT_NEAR(is.vbx, m.vbx, 1e-5 * (1 + std::abs(m.vbx)));
        ASSERT_NEAR(is.vay, m.vay, 1e-5 * (1 + std::abs(m.vay)));
        ASSERT_NEAR(is.ua, m.ua, 1e-5 * (1 + std::abs(m.ua)));
        ASSERT_NEAR(is.ub, m.ub, 1e-5 * (1 + std::abs(m.ub)));
      }
    }
  }
  EXPECT_GT(pressed, 200);
  EXPECT_GT(open, 20);
}

TEST(ManifoldOracle, BounceLeavesWithItsShareOfTheApproach) {
  int bounced = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Taste taste;
    taste.bounce = taste.fixed_a = true;
    taste.lone = 1;  // one point: the condition is an equation
    Scene before = make_scene(seed, 1, taste);
    before.bodies.vel = before.bodies.vel0;
    before.bodies.rim_speed = before.bodies.rim_speed0;
    Scene after = before;
    const ContactParams p = contact_params();
    kPasses[1].run(kernels_of(Isa::scalar), after, taste, p);
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const LaneOf x(before, 0, l), y(after, 0, l);
      if (x.b >= 64 || !(x.c.e[l] > 0)) continue;
      const Motion start(x, before.bodies.vel0, before.bodies.rim_speed0);
      const double vn0 = start.normal(x, 0), s = separation(x, 0);
      if (!(vn0 < -double{p.impact_floor}) || !(s + vn0 * double{p.h} < -1e-6)) continue;
      const double wanted = -double{x.c.e[l]} * vn0;
      const Motion is(y, after.bodies.vel, after.bodies.rim_speed);
      ASSERT_GT(is.normal(x, 0), wanted - 1e-3 * (1 + std::abs(vn0))) << seed << " lane " << l;
      if (stored(y, 0) > 0 && s > 0) {
        ASSERT_NEAR(is.normal(x, 0), wanted, 1e-3 * (1 + std::abs(vn0))) << seed << " lane " << l;
        ++bounced;
      }
    }
  }
  EXPECT_GT(bounced, 10);
}

TEST(ManifoldOracle, RelaxStopsClosedPointsAndRubsWithinTheCone) {
  int pressed = 0, stuck = 0, slid = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const bool fixed_a : {false, true}) {
      Taste taste;
      taste.fixed_a = fixed_a;
      taste.smooth = 0;
      taste.inner = true;  // what shares keep back is not settled yet
      const Scene before = make_scene(seed, 1, taste);
      Scene after = before;
      const ContactParams p = contact_params();
      kPasses[2].run(kernels_of(Isa::scalar), after, taste, p);
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        const LaneOf x(before, 0, l), y(after, 0, l);
        if (x.b >= 64) continue;
        const double k11 = coupling(x, 0, 0), k12 = coupling(x, 0, 1), k22 = coupling(x, 1, 1);
        const bool shut[2] = {!std::signbit(x.c.point[0].impulse[l]), !std::signbit(x.c.point[1].impulse[l])};
        if (shut[0] && shut[1] && k11 * k22 - k12 * k12 < 0.0101 * k11 * k22) continue;  // close: held back
        const Motion start(x, before.bodies.vel, before.bodies.rim_speed);
        double d[2];
        for (int k = 0; k < 2; ++k) {
          d[k] = double{y.c.point[k].impulse[l]} - double{x.c.point[k].impulse[l]};
          if (!shut[k]) {
            ASSERT_EQ(d[k], 0);
            ASSERT_EQ(y.c.point[k].friction[l], 0);
          }
        }
        Motion full = start, shared = start;
        for (int k = 0; k < 2; ++k) {
          full.push(x, k, d[k], 0, fixed_a ? 0 : 1, 1);
          shared.push(x, k, d[k], 0, fixed_a ? 0 : double{x.c.share_a[l]}, double{x.c.share_b[l]});
        }
        for (int k = 0; k < 2; ++k) {
          if (!shut[k]) continue;
          const double vn = full.normal(x, k), scale = 1 + std::abs(start.normal(x, k));
          ASSERT_GE(y.c.point[k].impulse[l], 0);
          ASSERT_GT(vn, -1e-3 * scale) << seed << " lane " << l;
          if (y.c.point[k].impulse[l] > 1e-6f) {
            ASSERT_NEAR(vn, 0, 1e-3 * scale) << seed << " lane " << l;
            ++pressed;
          }
        }
        // Friction of both points, where the normal impulses have their middle. It is shared as they are, and no share
        // of it is kept back.
        const auto *was = x.c.point, *is = y.c.point;
        const double n[2] = {std::max(0.0, double{is[0].impulse[l]}), std::max(0.0, double{is[1].impulse[l]})};
        const double sum = n[0] + n[1], first = sum > 0 ? n[0] / sum : 0;
        const auto middle = [&](double one, double two) { return first * one + (1 - first) * two; };
        const double an = middle(was[0].an[l], was[1].an[l]), bn = middle(was[0].bn[l], was[1].bn[l]);
        const double kt = x.wa + x.wb + x.ga * an * an + x.gb * bn * bn;
        const double cap = double{x.c.mu[l]} * sum;
        const double vt = middle(shared.tangent(x, 0), shared.tangent(x, 1));
        const double wish = double{was[0].friction[l]} + double{was[1].friction[l]} - vt / kt;
        const double wanted = std::clamp(wish, -cap, cap);
        ASSERT_NEAR(is[0].friction[l] + is[1].friction[l], wanted, 2e-4 * (1 + std::abs(wish)))
            << seed << " lane " << l;
        ASSERT_NEAR(is[0].friction[l], first * wanted, 2e-4 * (1 + std::abs(wish))) << seed << " lane " << l;
        if (sum > 0) ++(std::abs(wish) <= cap ? stuck : slid);
        for (int k = 0; k < 2; ++k) {
          shared.push(x, k, 0, double{is[k].friction[l]} - double{was[k].friction[l]}, fixed_a ? 0 : 1, 1);
        }
        const Motion now(x, after.bodies.vel, after.bodies.rim_speed);
        ASSERT_NEAR(now.vbx, shared.vbx, 2e-5 * (1 + std::abs(shared.vbx)));
        ASSERT_NEAR(now.vay, shared.vay, 2e-5 * (1 + std::abs(shared.vay)));
        ASSERT_NEAR(now.ub, shared.ub, 2e-5 * (1 + std::abs(shared.ub)));
      }
    }
  }
  EXPECT_GT(pressed, 200);
  EXPECT_GT(stuck, 20);
  EXPECT_GT(slid, 200);
}

// What an impact added goes into the velocities before the kick. Where a point overlaps deeply and the bodies still
// approach there, it stays in the impulse.
TEST(ManifoldOracle, SpendMovesImpactsIntoV0UnlessTheyCarry) {
  int spent = 0, carried = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const bool fixed_a : {false, true}) {
      Taste taste;
      taste.fixed_a = fixed_a;
      taste.bounce = true;
      const Scene before = make_scene(seed, 1, taste);
      Scene after = before;
      ContactParams p = contact_params();
      p.refresh = 0.001f;
      kPasses[3].run(kernels_of(Isa::scalar), after, taste, p);
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        const LaneOf x(before, 0, l), y(after, 0, l);
        if (x.b >= 64) continue;
        const Motion now(x, before.bodies.vel, before.bodies.rim_speed);
        Motion wanted(x, before.bodies.vel0, before.bodies.rim_speed0);
        const double mu = x.c.mu[l];
        for (int k = 0; k < 2; ++k) {
          const auto& point = x.c.point[k];
          const double start = point.start[l], impulse = point.impulse[l], friction = point.friction[l];
          const bool struck = start > 0, parts = now.normal(x, k) > 0 || separation(x, k) > -double{p.refresh};
          const double cap = mu * std::fmax(impulse, 0.0);
          const double held = struck && parts ? std::clamp(friction, -cap, cap) : friction;
          if (struck && parts) wanted.push(x, k, start, friction - held, 1, 1);
          (parts ? spent : carried) += struck;
          ASSERT_NEAR(y.c.point[k].impulse[l], struck && !parts ? impulse + start : impulse, 1e-6) << seed;
          ASSERT_NEAR(y.c.point[k].friction[l], held, 1e-6) << seed;
        }
        const Motion is(y, after.bodies.vel0, after.bodies.rim_speed0);
        ASSERT_NEAR(is.vbx, wanted.vbx, 1e-5) << seed;
        ASSERT_NEAR(is.vby, wanted.vby, 1e-5) << seed;
        ASSERT_NEAR(is.ub, wanted.ub, 1e-5) << seed;
        ASSERT_NEAR(is.vax, wanted.vax, 1e-5) << seed;
        ASSERT_NEAR(is.vay, wanted.vay, 1e-5) << seed;
        ASSERT_NEAR(is.ua, wanted.ua, 1e-5) << seed;
      }
    }
  }
  EXPECT_GT(spent, 20);
  EXPECT_GT(carried, 20);
}

TEST(ManifoldOracle, SwingFollowsSineAndCosine) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    Taste taste;
    Scene s = make_scene(static_cast<std::uint64_t>(round) + 1, 1, taste);
    std::fill(s.bodies.linked.begin(), s.bodies.linked.end(), std::uint8_t{0xFF});
    const double reach = round % 2 ? 3 : 300;
    for (std::size_t i = 0; i < 64; ++i) {
      s.angle_change[i] = uniform(random, -reach, reach);
      s.bodies.rim_speed[i] = uniform(random, -20, 20);
    }
    const Scene before = s;
    kPasses[4].run(kernels_of(Isa::scalar), s, taste, contact_params());
    for (std::size_t i = 0; i < 64; ++i) {
      const double d = s.angle_change[i], r = s.radius[i];
      // By the mean speed of the substep, where the change is smooth and small.
      const float last = before.bodies.rim_speed[i], first = before.bodies.rim_speed0[i], change = last - first;
      const float most = std::min(turning(contact_params()).smooth_limit2, first * first);
      const double u = change * change <= most ? 0.5 * (double{last} + double{first}) : double{last};
      const double wanted = double{before.angle_change[i]} + double{kSubstep} * u / r;
      ASSERT_NEAR(d, wanted, 1e-6 * (1 + std::abs(wanted)));
      ASSERT_NEAR(s.arm_change[2 * i], r * (std::cos(d) - 1), (2e-6 + 1e-7 * std::abs(d)) * r) << d;
      ASSERT_NEAR(s.arm_change[2 * i + 1], r * std::sin(d), (2e-6 + 1e-7 * std::abs(d)) * r) << d;
    }
  }
}

}  // namespace
}  // namespace psim::test::manifold_scene
