// Manifolds that last: every instruction set against the scalar one, bit by bit, and gaps and choices against the same
// formulas in double precision.
#include "kernel_support.h"
#include "lasting_views.h"
#include "manifold_views.h"

namespace psim::test::lasting {
namespace {

using kernels::kBlock;
using kernels::LastingBlock;
using kernels::ManifoldBlock;

constexpr std::uint32_t kCount = 64;

/// Contacts of bodies that have moved and turned a little since their hulls were looked at.
struct Contacts {
  Bodies bodies;
  std::vector<float> rotor, inner;
  std::vector<ManifoldBlock> blocks;
  std::vector<LastingBlock> then;

  kernels::LastingColumns columns() const { return {rotor.data(), inner.data(), bodies.radius.data()}; }
};

kernels::LastingParams params() {
  kernels::LastingParams p;
  p.pitch_x = p.pitch_y = static_cast<float>(kPitch);
  p.dt = 1.0f / 60;
  p.ahead = 1.25f * p.dt;
  p.fall = 9.81f * p.dt;
  p.sinks = p.fall * p.dt;
  p.nearby = p.lasting = 0.02f;
  p.rocking = 1e-3f;
  p.apart = 0.0005f;
  p.fallen = 0.1f;
  p.slow = 0.99f;
  return p;
}

/// fast: how fast bodies are, 0 to 1.
Contacts make_contacts(std::uint64_t seed, std::size_t blocks, double fast) {
  Random random(seed);
  Contacts c;
  c.bodies = Bodies(random, kCount);
  c.rotor.resize(c.bodies.vel.size());
  c.inner.resize(c.bodies.radius.size());
  std::vector<double> angle(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    angle[i] = random.uniform(-3, 3);
    c.rotor[2 * i] = static_cast<float>(std::cos(angle[i]));
    c.rotor[2 * i + 1] = static_cast<float>(std::sin(angle[i]));
    c.inner[i] = 0.7f * c.bodies.radius[i];
    for (float* v : {&c.bodies.vel[2 * i], &c.bodies.vel[2 * i + 1], &c.bodies.rim_speed[i]}) {
      *v *= static_cast<float>(fast * 0.01);
    }
  }
  c.blocks.resize(blocks);
  c.then.resize(blocks);
  for (std::size_t n = 0; n < blocks; ++n) {
    LastingBlock& t = c.then[n];
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const auto a = static_cast<std::uint32_t>(random.below(kCount)), b = (a + 1 + l) % kCount;
      t.body[2 * l] = a;
      t.body[2 * l + 1] = b;
      const auto back = [&](std::int32_t to, std::int32_t from) {
        return to - from + static_cast<std::int32_t>(random.uniform(-1, 1) * fast * 0.006 / kPitch);
      };
      t.x[l] = back(c.bodies.pos[2 * b], c.bodies.pos[2 * a]);
      t.y[l] = back(c.bodies.pos[2 * b + 1], c.bodies.pos[2 * a + 1]);
      t.dx[l] = c.bodies.disp[2 * b] - c.bodies.disp[2 * a];
      t.dy[l] = c.bodies.disp[2 * b + 1] - c.bodies.disp[2 * a + 1];
      const double was_a = angle[a] + fast * random.uniform(-0.01, 0.01);
      const double was_b = angle[b] + fast * random.uniform(-0.01, 0.01), normal = random.uniform(-3, 3);
      t.ac[l] = static_cast<float>(std::cos(was_a)), t.as[l] = static_cast<float>(std::sin(was_a));
      t.bc[l] = static_cast<float>(std::cos(was_b)), t.bs[l] = static_cast<float>(std::sin(was_b));
      t.nx[l] = static_cast<float>(std::cos(normal)), t.ny[l] = static_cast<float>(std::sin(normal));
      t.margin[l] = random.chance(0.1) ? -1 : uniform(random, 0.01, 0.05);
      t.deepest[l] = -0.01f;
      for (int p = 0; p < 2; ++p) {
        for (float* arm : {&t.ax[p][l], &t.ay[p][l], &t.bx[p][l], &t.by[p][l]}) *arm = uniform(random, -0.4, 0.4);
        t.gap[p][l] = p == 1 && random.chance(0.3) ? 2 * kernels::kNoPoint : uniform(random, -0.004, 0.004);
        c.blocks[n].point[p].gap[l] = uniform(random, 1, 2);
      }
    }
  }
  return c;
}

/// Steady lanes of all blocks.
std::vector<std::uint8_t> last(Isa isa, Contacts& c, bool fixed) {
  std::vector<std::uint8_t> steady(c.blocks.size(), 0xA5);
  BodyView view = c.bodies.view(false, true, false);
  kernels_of(isa).last_manifolds[fixed ? 1 : 0](view, c.columns(), c.blocks.data(), c.then.data(), params(),
                                                steady.data(), 0, static_cast<std::uint32_t>(c.blocks.size()));
  return steady;
}

TEST(LastingKernel, GivesTheBitsOfTheScalarOne) {
  for (const bool fixed : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      const Contacts start = make_contacts(seed, 5, static_cast<double>(seed % 5) / 4);
      Contacts truth = start;
      const std::vector<std::uint8_t> steady = last(Isa::scalar, truth, fixed);
      for (const Isa isa : available_isas()) {
        Contacts wide = start;
        ASSERT_EQ(last(isa, wide, fixed), steady) << isa_name(isa) << ", seed " << seed;
        ASSERT_EQ(std::memcmp(wide.blocks.data(), truth.blocks.data(), 5 * sizeof(ManifoldBlock)), 0)
            << isa_name(isa) << ", seed " << seed;
      }
    }
  }
}

/// One contact, in double precision.
struct Oracle {
  double gap[2], least, most, moved, wanted, closing, inner, rim;
};

Oracle oracle_of(const Contacts& c, const LastingBlock& t, std::uint32_t l, bool fixed) {
  const kernels::LastingParams p = params();
  const std::size_t a = t.body[2 * l], b = t.body[2 * l + 1];
  const Bodies& of = c.bodies;
  const auto relative = [&](const auto& column, std::size_t axis) {
    return static_cast<double>(column[2 * b + axis]) - (fixed ? 0 : static_cast<double>(column[2 * a + axis]));
  };
  const double mx = (relative(of.pos, 0) - t.x[l]) * kPitch + relative(of.disp, 0) - t.dx[l];
  const double my = (relative(of.pos, 1) - t.y[l]) * kPitch + relative(of.disp, 1) - t.dy[l];
  const auto turn = [&](std::size_t slot, float tc, float ts) {
    const double to = std::atan2(c.rotor[2 * slot + 1], c.rotor[2 * slot]), from = std::atan2(ts, tc);
    return to - from;
  };
  const double tb = turn(b, t.bc[l], t.bs[l]), ta = fixed ? 0 : turn(a, t.ac[l], t.as[l]);
  const auto swung = [&](double angle, double rx, double ry) {
    const double x = std::cos(angle) * rx - std::sin(angle) * ry - rx;
    const double y = std::sin(angle) * rx + std::cos(angle) * ry - ry;
    return t.nx[l] * x + t.ny[l] * y;
  };
  Oracle o{};
  for (int k = 0; k < 2; ++k) {
    o.gap[k] = t.gap[k][l] + t.nx[l] * mx + t.ny[l] * my + swung(tb, t.bx[k][l], t.by[k][l]) -
               (fixed ? 0 : swung(ta, t.ax[k][l], t.ay[k][l]));
  }
  o.least = std::min(o.gap[0], o.gap[1]), o.most = std::max(o.gap[0], o.gap[1]);
  o.inner = fixed ? c.inner[b] : std::min(c.inner[a], c.inner[b]);
  o.rim = std::fabs(of.rim_speed[b]) + (fixed ? 0 : std::fabs(of.rim_speed[a]));
  o.closing = std::hypot(relative(of.vel, 0), relative(of.vel, 1)) + o.rim + p.fall;
  o.wanted = p.nearby * o.inner + p.ahead * o.closing;
  o.moved = std::hypot(mx, my) + of.radius[b] * std::fabs(std::sin(tb)) +
            (fixed ? 0 : of.radius[a] * std::fabs(std::sin(ta)));
  return o;
}

TEST(LastingKernel, AgreesWithDoublePrecision) {
  const kernels::LastingParams p = params();
  int steady_lanes = 0, others = 0;
  for (const bool fixed : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      Contacts c = make_contacts(seed, 5, static_cast<double>(seed % 5) / 4);
      if (fixed) {  // places from 0, as those of fixed geometry
        for (LastingBlock& t : c.then) {
          for (std::uint32_t l = 0; l < kBlock; ++l) {
            t.x[l] += c.bodies.pos[2 * t.body[2 * l]], t.y[l] += c.bodies.pos[2 * t.body[2 * l] + 1];
            t.dx[l] = c.bodies.disp[2 * t.body[2 * l + 1]], t.dy[l] = c.bodies.disp[2 * t.body[2 * l + 1] + 1];
          }
        }
      }
      const Contacts before = c;
      const std::vector<std::uint8_t> steady = last(best_isa(), c, fixed);
      for (std::size_t n = 0; n < c.blocks.size(); ++n) {
        for (std::uint32_t l = 0; l < kBlock; ++l) {
          const LastingBlock& t = c.then[n];
          const Oracle o = oracle_of(c, t, l, fixed);
          const bool is = (steady[n] >> l & 1) != 0;
          (is ? steady_lanes : others) += 1;
          for (int k = 0; k < 2; ++k) {
            const bool there = t.gap[k][l] < kernels::kNoPoint;
            const float gap = c.blocks[n].point[k].gap[l], was = before.blocks[n].point[k].gap[l];
            if (is && there) {
              ASSERT_NEAR(gap, o.gap[k], 1e-6) << seed << ", " << n << ", " << l;
            } else {
              ASSERT_EQ(gap, was) << seed << ", " << n << ", " << l;
            }
          }
          // How far each condition is from its bound: positive where it holds.
          const double inner = o.inner, dt = p.dt;
          const double serves = std::min(t.margin[l] - o.wanted - o.moved, p.lasting * inner - o.moved);
          const double touches = std::max(p.apart * inner, std::min<double>(p.sinks, p.fallen * inner)) - o.least;
          const double rocks =
              std::min({o.rim * dt - p.rocking * inner, o.most - 10 * o.least, p.ahead * o.closing - o.most});
          double holds = std::min({serves, touches, -rocks});
          if (t.margin[l] < 0) holds = -1;
          if (fixed) holds = std::min({holds, p.slow * inner - dt * o.closing, o.least - double{t.deepest[l]}});
          if (std::fabs(holds) < 1e-5) continue;  // rounding decides
          ASSERT_EQ(is, holds > 0) << seed << ", " << n << ", " << l << ": " << holds;
        }
      }
    }
  }
  EXPECT_GT(steady_lanes, 500);
  EXPECT_GT(others, 500);
}

}  // namespace
}  // namespace psim::test::lasting
