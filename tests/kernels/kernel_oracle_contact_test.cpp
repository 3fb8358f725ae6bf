// Passes over contacts of discs (contact_kernel.h, single_kernel.h) against their equations.
#include <array>

#include "kernel_oracle.h"

namespace psim::test {
namespace {

/// Adds a normal and a tangent impulse.
void push(Contact& x, double normal, double tangent) {
  const Vec p = normal * x.n + tangent * left_of(x.n);
  x.va = x.va - x.w_a * p;
  x.vb = x.vb + x.w_b * p;
  x.u_a -= x.q_a * tangent;
  x.u_b -= x.q_b * tangent;
}

double approach_before(const Contact& x) { return dot(x.n, x.vb0 - x.va0); }

// m/s: what an impact adds to vn. Bodies that parted may come together again as fast.
double rebound(const Contact& x) {
  const double vn0 = approach_before(x);
  return vn0 > 0 ? vn0 : x.e * vn0;
}

double separation(const Contact& x) { return x.gap + dot(x.n, x.db - x.da); }

void warm(Contact& x, const ContactParams& p) {
  x.l *= double{p.warm};
  x.t *= double{p.warm};
  push(x, x.l, x.t);
}

void solve(Contact& x, const ContactParams& p, bool bounce) {
  const double s = separation(x), vn = dot(x.n, x.vb - x.va), vn0 = approach_before(x);
  double dl = -x.m * (vn + s / double{p.h});
  const bool fast = x.e > 0 && vn0<-double{p.impact_floor}, parts = vn0> double{p.impact_floor};
  const double soft = s > 0 ? s / double{p.h} : std::fmax(double{p.soft_rate} * s, -double{p.push});
  if (bounce && parts) {
    dl = -x.m * (vn + std::fmax(rebound(x), soft));
  } else if (bounce && fast && s + vn0 * double{p.h} < 0) {
    dl = -x.m * (vn + std::fmin(rebound(x), soft));
  } else if (s <= 0) {
    dl = -x.m * (double{p.soft_mass} * vn + soft) - double{p.soft_impulse} * x.l;
  }
  double next = std::fmax(x.l + dl, 0.0);
  const Vec u = x.vb - x.va;
  const double offset = std::fabs((s + x.radius) * dot(left_of(x.n), u)) / length(u);
  if (s > 0 && offset > x.radius) next = 0;  // they pass each other
  push(x, next - x.l, 0);
  x.start = std::copysign(std::fmax(x.l, 0.0), fast || parts ? 1 : -1);
  x.l = s > 0 && next <= 0 ? -0.0 : next;
}

void relax(Contact& x, bool bounce) {
  const bool hit = bounce && !std::signbit(x.start) && x.l > 0;
  const Vec u = x.vb - x.va;
  const double vn = dot(x.n, u) + (hit ? rebound(x) : 0);
  const double next = std::signbit(x.l) ? x.l : std::fmax(x.l - x.m * vn, 0.0);
  const double vt = dot(left_of(x.n), u) - x.u_b - x.u_a;
  const double cap = x.mu * std::fmax(next, 0.0);
  const double t = std::clamp(x.t - x.mt * vt, -cap, cap);
  push(x, next - x.l, t - x.t);
  x.t = t;
  x.l = hit ? std::fmin(next, std::fabs(x.start)) : next;
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
      if (pass == Pass::relax) relax(x, bounce);
      want.push_back(x);
    }
    const std::size_t m = index_of(model);
    const BodyView view = b.view(false, model == Model::rough);
    const KernelTable& t = scalar();
    if (pairs) {
      const ContactView v = c.pairs(model, bounce);
      const auto run = pass == Pass::warm ? t.warm[m] : pass == Pass::solve ? t.solve[m][bounce] : t.relax[m][bounce];
      run(view, v, p, 0, 1);
    } else {
      const StaticContactView v = c.static_contacts(model, bounce);
      const auto run = pass == Pass::warm    ? t.warm_static[m]
                       : pass == Pass::solve ? t.solve_static[m][bounce]
                                             : t.relax_static[m][bounce];
      run(view, v, p, 0, 1);
    }
    for (std::size_t k = 0; k < 7; ++k) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " lane " + std::to_string(k));
      const Contact got = contact_of(b, c, k, model);
      expect_same(got, want[k], 1e-4);
      if (bounce) {
        EXPECT_NEAR(got.start, want[k].start, 1e-4);
        EXPECT_EQ(std::signbit(got.start), std::signbit(want[k].start));
      }
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
        SCOPED_TRACE(std::string(pairs ? "pairs" : "singles") + ", model " + std::to_string(index_of(model)) +
                     (bounce ? ", bounce" : ""));
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
  scalar().solve_static[0][0](b.view(), s.static_contacts(Model::plain, false), p, 0, 1);
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

// What an impact added goes into v0. Where the bodies overlap deeply and still approach, it stays in the impulse.
void check_spending(bool pairs, std::uint64_t seed, std::array<int, 3>& seen) {
  Random random(seed);
  Bodies b(random, 40);
  Contacts c(random, b, pairs, 1, 8);
  for (float& gap : c.gap) gap = uniform(random, -1, 0.5);
  const Bodies old = b;
  const Contacts was = c;
  const std::size_t m = index_of(Model::rough);
  ContactParams p = contact_params();
  p.refresh = 0.02f;
  if (pairs) {
    scalar().spend[m](b.view(false, true), c.pairs(Model::rough, true), p, 0, 1);
  } else {
    scalar().spend_static[m](b.view(false, true), c.static_contacts(Model::rough, true), p, 0, 1);
  }
  for (std::size_t k = 0; k < kBlock; ++k) {
    const Contact x = contact_of(old, was, k, Model::rough);
    const bool parts = dot(x.n, x.vb - x.va) > 0 || separation(x) > -double{p.refresh};
    const bool struck = x.start > 0, hit = struck && parts;
    ++seen[hit ? 0 : struck ? 1 : 2];
    const double cap = x.mu * std::fmax(x.l, 0.0);
    const double held = hit ? std::clamp(x.t, -cap, cap) : x.t;
    const Vec impulse = (hit ? x.start : 0) * x.n + (x.t - held) * left_of(x.n);
    const std::size_t i = c.body[c.step * k], j = c.body[c.step * k + c.step - 1];
    expect_near(record(b.vel0, j), record(old.vel0, j) + x.w_b * impulse, 1e-5);
    EXPECT_NEAR(b.rim_speed0[j], double{old.rim_speed0[j]} - x.q_b * (x.t - held), 1e-5);
    if (pairs) {
      expect_near(record(b.vel0, i), record(old.vel0, i) - x.w_a * impulse, 1e-5);
      EXPECT_NEAR(b.rim_speed0[i], double{old.rim_speed0[i]} - x.q_a * (x.t - held), 1e-5);
    }
    EXPECT_NEAR(c.friction[k], held, 1e-6);
    EXPECT_NEAR(c.impulse[k], struck && !parts ? x.l + x.start : x.l, 1e-6);
  }
}

TEST(KernelOracle, SpendMovesImpactsIntoV0UnlessTheyCarry) {
  for (const bool pairs : {true, false}) {
    std::array<int, 3> seen{};  // impacts, loads, neither
    for (std::uint64_t seed = 12; seed < 60; ++seed) check_spending(pairs, seed, seen);
    for (const int lanes : seen) EXPECT_GT(lanes, 20);
  }
}

}  // namespace
}  // namespace psim::test
