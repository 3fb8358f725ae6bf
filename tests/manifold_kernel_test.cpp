// The passes over manifolds: every instruction set against the scalar one, bit by bit over whole blocks
// and body columns; and the scalar one against sums written down separately, in double.
#include "kernel_support.h"
#include "manifold_views.h"

namespace psim::test {
namespace {

using kernels::ManifoldBlock;

/// Blocks over distinct bodies of a world of 64, and everything that a pass can read or write.
struct Scene {
  Bodies bodies;
  std::vector<float> turn, swing, radius;
  std::vector<ManifoldBlock> blocks;

  BodyView view() {
    BodyView v = bodies.view(false, true, false);
    v.turn = turn.data();
    v.swing = swing.data();
    return v;
  }
};

struct Taste {
  bool fixed_a = false;
  bool bounce = false;
  double lone = 0.3;      // chance of one point
  double padding = 0.15;  // of an empty lane
  double zero = 0.1;      // of a signed zero in an impulse
  double smooth = 0.3;    // of a lane without friction
};

float signed_zero(Random& random) { return random.chance(0.5) ? 0.0f : -0.0f; }

void no_point(ManifoldBlock::Point& p, std::uint32_t l) {
  p.an[l] = p.at[l] = p.bn[l] = p.bt[l] = 0;
  p.gap[l] = 1e6f;
  p.impulse[l] = -0.0f;
  p.friction[l] = p.start[l] = 0;
}

Scene make_scene(std::uint64_t seed, std::size_t blocks, const Taste& taste) {
  Random random(seed);
  Scene s;
  constexpr std::size_t kCount = 64;
  s.bodies = Bodies(random, kCount);
  for (auto* c : {&s.bodies.vel, &s.bodies.vel0}) {
    for (std::size_t i = 0; i < 2 * kCount; ++i) {
      if (random.chance(0.7)) (*c)[i] *= 0.05f;
      if (random.chance(0.03)) (*c)[i] = signed_zero(random);
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {  // resting dummies
    const std::size_t d = kCount + i;
    for (auto* c : {&s.bodies.vel, &s.bodies.vel0, &s.bodies.disp})
      (*c)[2 * d] = (*c)[2 * d + 1] = 0;
  }
  s.turn.assign(s.bodies.vel.size(), 0);
  s.swing.assign(s.bodies.spin.size(), 0);
  s.radius.assign(s.bodies.spin.size(), 0);
  for (std::size_t i = 0; i < kCount; ++i) {
    s.radius[i] = uniform(random, 0.3, 2);
    s.swing[i] = uniform(random, -0.3, 0.3);
    s.turn[2 * i] = s.radius[i] * (std::cos(s.swing[i]) - 1);
    s.turn[2 * i + 1] = s.radius[i] * std::sin(s.swing[i]);
  }
  s.blocks.resize(blocks);
  for (ManifoldBlock& c : s.blocks) {
    std::vector<std::uint32_t> free(kCount);
    std::iota(free.begin(), free.end(), 0u);
    for (std::size_t k = free.size(); k > 1; --k) std::swap(free[k - 1], free[random.below(k)]);
    const std::uint32_t shared = free.back();  // a fixed body may be in many lanes
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const bool pad = random.chance(taste.padding);
      c.body[2 * l] = pad || (taste.fixed_a && random.chance(0.3)) ? kCount
                      : taste.fixed_a                              ? shared
                                                                   : free[2 * l];
      c.body[2 * l + 1] = pad ? kCount + 1 : free[2 * l + 1];
      const double angle = random.chance(0.2) ? 0.5 * kPi * static_cast<double>(random.below(4))
                                              : random.uniform(0, 2 * kPi);
      c.nx[l] = pad ? 0 : static_cast<float>(std::cos(angle));
      c.ny[l] = pad ? 1 : static_cast<float>(std::sin(angle));
      for (int k = 0; k < 2; ++k) {
        ManifoldBlock::Point& p = c.point[k];
        if (pad || (k == 1 && random.chance(taste.lone))) {
          no_point(p, l);
          continue;
        }
        p.an[l] = taste.fixed_a ? 0 : uniform(random, -1, 1);
        p.at[l] = taste.fixed_a ? 0 : uniform(random, -1, 1);
        p.bn[l] = uniform(random, -1, 1);
        p.bt[l] = uniform(random, -1, 1);
        if (k == 1 && random.chance(0.1)) {  // all but the same point
          p.bt[l] = c.point[0].bt[l];
          p.at[l] = c.point[0].at[l];
        }
        p.gap[l] = random.chance(0.1) ? signed_zero(random) : uniform(random, -0.01, 0.02);
        p.impulse[l] = random.chance(taste.zero) ? signed_zero(random)
                       : random.chance(0.2)      ? -0.0f
                                                 : uniform(random, 0, 0.3);
        p.friction[l] =
            random.chance(taste.zero) ? signed_zero(random) : uniform(random, -0.1, 0.1);
        p.start[l] = random.chance(0.5) ? 0 : uniform(random, 0, 0.2);
      }
      c.wa[l] = pad ? 1 : taste.fixed_a ? 0 : uniform(random, 0.1, 2);
      c.wb[l] = pad ? 1 : uniform(random, 0.1, 2);
      c.ga[l] = pad || taste.fixed_a ? 0 : uniform(random, 0, 4);
      c.gb[l] = pad ? 0 : uniform(random, 0, 4);
      c.share_a[l] = !pad && !taste.fixed_a && random.chance(0.3) ? 0.5f : 1;
      c.share_b[l] = !pad && !taste.fixed_a && random.chance(0.3) ? 0.5f : 1;
      c.round_a[l] = random.chance(0.5) || pad ? 0 : uniform(random, 0, 0.5);
      c.round_b[l] = random.chance(0.5) || pad ? 0 : uniform(random, 0, 0.5);
      const bool smooth = pad || random.chance(taste.smooth);
      c.mu[l] = smooth ? 0 : uniform(random, 0, 1);
      if (smooth) c.point[0].friction[l] = c.point[1].friction[l] = 0;
      c.e[l] = !pad && taste.bounce && random.chance(0.7) ? uniform(random, 0, 1) : 0;
      c.soft[l] = pad ? 0 : uniform(random, 0, 0.2);
      c.rate[l] = pad ? 0 : uniform(random, 0, 60);
    }
  }
  return s;
}

bool same_bits(const Scene& a, const Scene& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  // There is no NaN in these scenes, and signed zeros of velocities are alike, as in state_hash.
  return same(a.blocks, b.blocks) && a.bodies.vel == b.bodies.vel &&
         a.bodies.vel0 == b.bodies.vel0 && a.bodies.spin == b.bodies.spin &&
         a.bodies.spin0 == b.bodies.spin0 && same(a.bodies.disp, b.bodies.disp) &&
         same(a.turn, b.turn) && same(a.swing, b.swing);
}

struct Pass {
  const char* name;
  void (*run)(const KernelTable&, Scene&, const Taste&, const ContactParams&);
};

const Pass kPasses[] = {
    {"warm",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.warm_manifolds[t.fixed_a](s.view(), s.blocks.data(), p.warm, 0,
                                   static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"solve",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.solve_manifolds[t.fixed_a][t.bounce](s.view(), s.blocks.data(), p, 0,
                                              static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"relax",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams& p) {
       k.relax_manifolds[t.fixed_a][t.bounce](s.view(), s.blocks.data(), p, 0,
                                              static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"spend",
     [](const KernelTable& k, Scene& s, const Taste& t, const ContactParams&) {
       k.spend_manifolds[t.fixed_a](s.view(), s.blocks.data(), 0,
                                    static_cast<std::uint32_t>(s.blocks.size()));
     }},
    {"swing", [](const KernelTable& k, Scene& s, const Taste&,
                 const ContactParams& p) { k.swing_bodies(s.view(), s.radius.data(), p.h, 0, 9); }},
};

std::vector<Taste> tastes() {
  std::vector<Taste> all;
  for (const bool fixed_a : {false, true}) {
    for (const bool bounce : {false, true}) {
      for (const double padding : {0.0, 0.3}) {
        for (const double smooth : {0.0, 0.5, 1.0}) {
          Taste t;
          t.fixed_a = fixed_a;
          t.bounce = bounce;
          t.padding = padding;
          t.smooth = smooth;
          all.push_back(t);
        }
      }
    }
  }
  return all;
}

std::string describe(const Taste& t) {
  return std::string(t.fixed_a ? "fixed A" : "moving A") + (t.bounce ? ", bounce" : "") +
         ", padding " + std::to_string(t.padding) + ", smooth " + std::to_string(t.smooth);
}

TEST(ManifoldExact, EveryPassAloneGivesTheBitsOfTheScalarOne) {
  for (const Taste& taste : tastes()) {
    for (const bool more : {false, true}) {
      for (const bool again : {false, true}) {
        ContactParams p = contact_params();
        p.more = more;
        p.again = again;
        for (std::uint64_t seed = 1; seed <= 20; ++seed) {
          const Scene scene = make_scene(seed, 3, taste);
          for (const Pass& pass : kPasses) {
            Scene truth = scene;
            pass.run(kernels_of(Isa::scalar), truth, taste, p);
            for (const Isa isa : available_isas()) {
              Scene wide = scene;
              pass.run(kernels_of(isa), wide, taste, p);
              ASSERT_TRUE(same_bits(truth, wide))
                  << pass.name << " on " << isa_name(isa) << ", seed " << seed << ", "
                  << describe(taste) << (more ? ", more" : "") << (again ? ", again" : "");
            }
          }
        }
      }
    }
  }
}

TEST(ManifoldExact, ManySubstepsGiveTheBitsOfTheScalarOne) {
  for (const Taste& taste : tastes()) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto play = [&](Isa isa) {
        Scene s = make_scene(seed, 4, taste);
        const KernelTable& k = kernels_of(isa);
        ContactParams p = contact_params();
        for (int substep = 0; substep < 6; ++substep) {
          for (const int pass : {0, 1, 4, 2, 3}) {
            p.warm = substep == 0 ? 0.8f : 1;
            kPasses[pass].run(k, s, taste, p);
          }
        }
        return s;
      };
      const Scene truth = play(Isa::scalar);
      for (const Isa isa : available_isas()) {
        ASSERT_TRUE(same_bits(truth, play(isa)))
            << isa_name(isa) << ", seed " << seed << ", " << describe(taste);
      }
    }
  }
}

TEST(ManifoldExact, FixedBodiesAndPaddingAreNeverWritten) {
  Taste taste;
  taste.fixed_a = true;
  taste.padding = 0.4;
  for (const bool bounce : {false, true}) {
    taste.bounce = bounce;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      for (const Isa isa : available_isas()) {
        const Scene before = make_scene(seed, 2, taste);
        Scene after = before;
        for (int pass = 0; pass < 4; ++pass) {
          kPasses[pass].run(kernels_of(isa), after, taste, contact_params());
        }
        std::vector<bool> is_b(66);
        for (const ManifoldBlock& c : before.blocks) {
          for (std::uint32_t l = 0; l < kBlock; ++l) is_b[c.body[2 * l + 1]] = true;
        }
        for (std::size_t i = 0; i < 66; ++i) {
          if (is_b[i] && i < 64) continue;
          ASSERT_EQ(after.bodies.vel[2 * i], before.bodies.vel[2 * i]) << i;
          ASSERT_EQ(after.bodies.vel[2 * i + 1], before.bodies.vel[2 * i + 1]) << i;
          ASSERT_EQ(after.bodies.spin[i], before.bodies.spin[i]) << i;
        }
      }
    }
  }
}

// ---- against sums in double -------------------------------------------------------------------

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
  Motion(const LaneOf& x, const std::vector<float>& vel, const std::vector<float>& spin)
      : vax(vel[2 * x.a]),
        vay(vel[2 * x.a + 1]),
        ua(spin[x.a]),
        vbx(vel[2 * x.b]),
        vby(vel[2 * x.b + 1]),
        ub(spin[x.b]) {}
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
  s += at(x.s.turn, 2 * x.b) * (double{p.bn[x.l]} + double{x.c.round_b[x.l]}) +
       at(x.s.turn, 2 * x.b + 1) * double{p.bt[x.l]};
  s -= at(x.s.turn, 2 * x.a) * (double{p.an[x.l]} - double{x.c.round_a[x.l]}) +
       at(x.s.turn, 2 * x.a + 1) * double{p.at[x.l]};
  return s;
}

double coupling(const LaneOf& x, int i, int k) {
  const auto &p = x.c.point[i], &q = x.c.point[k];
  return x.wa + x.wb + x.ga * double{p.at[x.l]} * double{q.at[x.l]} +
         x.gb * double{p.bt[x.l]} * double{q.bt[x.l]};
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
        Motion m(x, before.bodies.vel, before.bodies.spin);
        for (int k = 0; k < 2; ++k) {
          m.push(x, k, double{p.warm} * double{x.c.point[k].impulse[l]},
                 double{p.warm} * double{x.c.point[k].friction[l]}, fixed_a ? 0 : 1, 1);
        }
        const Motion is(x, after.bodies.vel, after.bodies.spin);
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
        const Motion start(x, before.bodies.vel, before.bodies.spin);
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
          const double vn =
              start.normal(x, k) + coupling(x, k, 0) * d[0] + coupling(x, k, 1) * d[1];
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
        const Motion is(x, after.bodies.vel, after.bodies.spin);
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
    before.bodies.spin = before.bodies.spin0;
    Scene after = before;
    const ContactParams p = contact_params();
    kPasses[1].run(kernels_of(Isa::scalar), after, taste, p);
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const LaneOf x(before, 0, l), y(after, 0, l);
      if (x.b >= 64 || !(x.c.e[l] > 0)) continue;
      const Motion start(x, before.bodies.vel0, before.bodies.spin0);
      const double vn0 = start.normal(x, 0), s = separation(x, 0);
      if (!(vn0 < -double{p.impact_floor}) || !(s + vn0 * double{p.h} < -1e-6)) continue;
      const double wanted = -double{x.c.e[l]} * vn0;
      const Motion is(y, after.bodies.vel, after.bodies.spin);
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
      const Scene before = make_scene(seed, 1, taste);
      Scene after = before;
      ContactParams p = contact_params();
      p.more = true;  // what shares keep back is not settled yet
      kPasses[2].run(kernels_of(Isa::scalar), after, taste, p);
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        const LaneOf x(before, 0, l), y(after, 0, l);
        if (x.b >= 64) continue;
        const double k11 = coupling(x, 0, 0), k12 = coupling(x, 0, 1), k22 = coupling(x, 1, 1);
        const bool shut[2] = {!std::signbit(x.c.point[0].impulse[l]),
                              !std::signbit(x.c.point[1].impulse[l])};
        if (shut[0] && shut[1] && k11 * k22 - k12 * k12 < 0.0101 * k11 * k22) continue;  // close: held back
        const Motion start(x, before.bodies.vel, before.bodies.spin);
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
        // Friction, one point after the other.
        for (int k = 0; k < 2; ++k) {
          const auto &was = x.c.point[k], &is = y.c.point[k];
          if (shut[k]) {
            const double kt = x.wa + x.wb + x.ga * double{was.an[l]} * double{was.an[l]} +
                              x.gb * double{was.bn[l]} * double{was.bn[l]};
            const double cap = double{x.c.mu[l]} * double{is.impulse[l]};
            const double wish = double{was.friction[l]} - shared.tangent(x, k) / kt;
            const double wanted = std::clamp(wish, -cap, cap);
            ASSERT_NEAR(is.friction[l], wanted, 2e-4 * (1 + std::abs(wish)))
                << seed << " lane " << l;
            std::abs(wish) <= cap ? ++stuck : ++slid;
          }
          shared.push(x, k, 0, double{is.friction[l]} - double{was.friction[l]},
                      fixed_a ? 0 : double{x.c.share_a[l]}, double{x.c.share_b[l]});
        }
        const Motion now(x, after.bodies.vel, after.bodies.spin);
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

TEST(ManifoldOracle, SwingFollowsSineAndCosine) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    Taste taste;
    Scene s = make_scene(static_cast<std::uint64_t>(round) + 1, 1, taste);
    std::fill(s.bodies.linked.begin(), s.bodies.linked.end(), std::uint8_t{0xFF});
    const double reach = round % 2 ? 3 : 300;
    for (std::size_t i = 0; i < 64; ++i) {
      s.swing[i] = uniform(random, -reach, reach);
      s.bodies.spin[i] = uniform(random, -20, 20);
    }
    const Scene before = s;
    kPasses[4].run(kernels_of(Isa::scalar), s, taste, contact_params());
    for (std::size_t i = 0; i < 64; ++i) {
      const double d = s.swing[i], r = s.radius[i];
      const double wanted =
          double{before.swing[i]} + double{kSubstep} * double{before.bodies.spin[i]} / r;
      ASSERT_NEAR(d, wanted, 1e-6 * (1 + std::abs(wanted)));
      ASSERT_NEAR(s.turn[2 * i], r * (std::cos(d) - 1), (2e-6 + 1e-7 * std::abs(d)) * r) << d;
      ASSERT_NEAR(s.turn[2 * i + 1], r * std::sin(d), (2e-6 + 1e-7 * std::abs(d)) * r) << d;
    }
  }
}

}  // namespace
}  // namespace psim::test
