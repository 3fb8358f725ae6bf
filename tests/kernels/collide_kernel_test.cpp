// The kernels that find manifolds of eight pairs of hulls at once: on every instruction set the bits that
// collide() gives each pair alone, wherever a pair lies in a block and whatever lies beside it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "collide/collide_batch.h"
#include "kernel_support.h"

namespace psim::test {
namespace {

using kernels::HullPairs;

/// Two hulls and how they lie.
struct HullPair {
  Hull a, b;
  Rotor qa, qb;
  float dx = 0, dy = 0, margin = 0;
};

Rotor rotor(double angle) { return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))}; }

Hull box(double width, double height, double radius) {
  Hull h;
  h.count = 4;
  for (int k = 0; k < 4; ++k) {
    h.x[k] = static_cast<float>((k == 1 || k == 2 ? 0.5 : -0.5) * width);
    h.y[k] = static_cast<float>((k < 2 ? -0.5 : 0.5) * height);
  }
  h.radius = static_cast<float>(radius);
  finish_hull(h);
  return h;
}

Hull segment(double length, double angle, double radius) {
  Hull h;
  h.count = 2;
  h.x[1] = static_cast<float>(0.5 * length * std::cos(angle));
  h.y[1] = static_cast<float>(0.5 * length * std::sin(angle));
  h.x[0] = -h.x[1];
  h.y[0] = -h.y[1];
  h.radius = static_cast<float>(radius);
  finish_hull(h);
  return h;
}

/// A hull of 1 to 8 vertices: discs beside their body's centre, capsules, triangles, boxes, any polygons.
Hull random_hull(Random& random, int count, double size) {
  const double radius = random.chance(0.5) ? 0 : size * random.uniform(0.01, 0.4);
  if (count == 1) {
    Hull h = disc_hull(static_cast<float>(size * random.uniform(0.2, 0.7)));
    if (random.chance(0.3)) {
      h.x[0] = uniform(random, -size, size);
      h.y[0] = uniform(random, -size, size);
      h.reach = h.radius + std::sqrt(h.x[0] * h.x[0] + h.y[0] * h.y[0]);
    }
    return h;
  }
  if (count == 2) {
    const double turn = random.uniform(0, 7);
    return segment(size * random.uniform(0.2, 2), turn, radius);
  }
  if (count == 4 && random.chance(0.6)) {
    return box(size, random.chance(0.5) ? size : size * random.uniform(0.02, 1), radius);
  }
  Hull h;
  h.count = count;
  const double start = random.uniform(0, 7), flat = random.uniform(0.1, 1);
  for (int k = 0; k < count; ++k) {
    const double at = start + 6.2831853 / count * (k + random.uniform(-0.35, 0.35));
    h.x[k] = static_cast<float>(0.6 * size * std::cos(at));
    h.y[k] = static_cast<float>(0.6 * size * flat * std::sin(at));
  }
  h.radius = static_cast<float>(radius);
  finish_hull(h);
  return h;
}

/// As they come in piles: boxes of one size, side against side or nearly so, a little apart or sunk.
HullPair pile_pair(Random& random, int of_a, int of_b) {
  HullPair p;
  p.a = of_a == 2 ? segment(random.chance(0.5) ? 20 : 1, 0, 0) : random_hull(random, of_a, 1);
  p.b = of_b == 4 ? box(1, 1, 0) : random_hull(random, of_b, 1);
  if (of_a == 4 && random.chance(0.8)) p.a = box(1, 1, 0);
  const double tilt = random.chance(0.3) ? 0 : random.uniform(-0.01, 0.01);
  const double quarter = random.chance(0.5) ? 0 : 1.5707963267948966;
  p.qa = of_a == 2 || random.chance(0.5) ? Rotor{} : rotor(random.uniform(-0.01, 0.01));
  p.qb = rotor(tilt + quarter);
  const double half_a = of_a == 2 ? 0 : 0.5;
  p.dx = random.chance(0.2) ? 0.5f * static_cast<float>(random.below(3)) : uniform(random, -1, 1);
  p.dy = static_cast<float>(half_a + 0.5 + random.uniform(-0.01, 0.02));
  p.margin = uniform(random, 0, 0.05);
  return p;
}

/// Anything: deep, far, thin, tiny beside huge, turned by all but nothing, corner on corner.
HullPair any_pair(Random& random, int of_a, int of_b) {
  HullPair p;
  const double ratio = random.chance(0.5) ? 1 : std::pow(10, random.uniform(-4, 4));
  p.a = random_hull(random, of_a, 1);
  p.b = random.chance(0.2) && of_a == of_b ? p.a : random_hull(random, of_b, ratio);
  const double turn = random.uniform(0, 7);
  p.qa = random.chance(0.2) ? Rotor{} : rotor(turn);
  const double offsets[] = {0, 1.5707963267948966, 1e-8, 1e-6, 1e-4, random.uniform(0, 7)};
  p.qb = rotor((random.chance(0.2) ? 0 : turn) + offsets[random.below(6)]);
  const double spread = (p.a.reach + p.b.reach) * (random.chance(0.1) ? 1.5f : 1.0f);
  p.dx = uniform(random, -spread, spread);
  p.dy = random.chance(0.1) ? 0.0f : uniform(random, -spread, spread);
  if (random.chance(0.1)) {  // a vertex of one on a vertex of the other
    const auto at = [](const Hull& h, Rotor q, std::size_t k) {
      return std::pair(q.c * h.x[k] - q.s * h.y[k], q.s * h.x[k] + q.c * h.y[k]);
    };
    const auto [ax, ay] = at(p.a, p.qa, random.below(static_cast<std::size_t>(of_a)));
    const auto [bx, by] = at(p.b, p.qb, random.below(static_cast<std::size_t>(of_b)));
    p.dx = ax - bx;
    p.dy = ay - by;
  }
  p.margin = random.chance(0.1) ? 0.0f : static_cast<float>(spread * std::pow(10, random.uniform(-4, 0)));
  return p;
}

HullPairs block_of(const HullPair* pairs, std::uint32_t first, std::uint32_t count) {
  HullPairs c;
  std::memset(static_cast<void*>(&c), 0xA5, sizeof c);
  for (std::uint32_t l = 0; l < kBlock; ++l) {
    const HullPair& p = pairs[(first + l) % count];
    c.a[l] = p.a.x;
    c.b[l] = p.b.x;
    c.vertices_a[l] = static_cast<float>(p.a.count);
    c.vertices_b[l] = static_cast<float>(p.b.count);
    c.ac[l] = p.qa.c;
    c.as[l] = p.qa.s;
    c.bc[l] = p.qb.c;
    c.bs[l] = p.qb.s;
    c.dx[l] = p.dx;
    c.dy[l] = p.dy;
    c.margin[l] = p.margin;
  }
  return c;
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Where two manifolds differ, or nothing.
std::string difference(const Manifold& m, const Manifold& n) {
  if (m.count != n.count) return "count " + std::to_string(m.count) + " " + std::to_string(n.count);
  if (!same_bits(m.nx, n.nx) || !same_bits(m.ny, n.ny)) return "normal";
  if (m.count == 0 && !same_bits(m.point[0].gap, n.point[0].gap)) return "bound of the gap";
  for (int k = 0; k < m.count; ++k) {
    const ManifoldPoint &p = m.point[k], &q = n.point[k];
    if (p.feature != q.feature) {
      return "feature " + std::to_string(p.feature) + " " + std::to_string(q.feature);
    }
    if (!same_bits(p.ax, q.ax) || !same_bits(p.ay, q.ay)) return "arm of A";
    if (!same_bits(p.bx, q.bx) || !same_bits(p.by, q.by)) return "arm of B";
    if (!same_bits(p.gap, q.gap)) return "gap";
  }
  return {};
}

Manifold of_lane(const HullPairs& c, std::uint32_t l) {
  Manifold m;
  m.nx = c.nx[l];
  m.ny = c.ny[l];
  if ((c.has[0] >> l & 1) == 0) m.point[0].gap = c.apart[l];
  for (int k = 0; k < 2 && (c.has[k] >> l & 1) != 0; ++k) {
    const HullPairs::Point& p = c.point[k];
    m.point[m.count++] = {p.ax[l], p.ay[l], p.bx[l], p.by[l], p.gap[l], static_cast<std::uint16_t>(p.feature[l])};
  }
  return m;
}

struct Count {
  std::uint64_t pairs = 0, hard = 0, points[3] = {};
};

using MakePair = HullPair (*)(Random&, int, int);

/// Some number of vertices that a kernel has room for.
int vertices_of(Random& random, std::size_t size) {
  const auto more = static_cast<int>(random.below(4));
  return size == 0 ? 1 : size == 1 ? 2 : size == 2 ? (more == 0 ? 3 : 4) : 5 + more;
}

/// Every kind of pair through the kernels of one instruction set; what was found, by the sizes of A and B.
void compare(Isa isa, MakePair make, std::uint32_t blocks, Count (&count)[3][4]) {
  const KernelTable& k = kernels_of(isa);
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 4; ++b) {
      Random random(100 * a + b + 1);
      Count& seen = count[a][b];
      for (std::uint32_t n = 0; n < blocks; ++n) {
        HullPair pairs[kBlock];
        for (HullPair& p : pairs) {
          const int of_a = vertices_of(random, a + 1);
          p = make(random, of_a, vertices_of(random, b));
        }
        HullPairs block = block_of(pairs, 0, kBlock);
        k.collide[a][b](&block, 0, 1);
        for (std::uint32_t l = 0; l < kBlock; ++l) {
          const HullPair& p = pairs[l];
          ++seen.pairs;
          if ((block.hard >> l & 1) != 0) {
            ++seen.hard;
            continue;
          }
          const Manifold expected = collide(p.a, p.qa, p.b, p.qb, p.dx, p.dy, p.margin);
          ++seen.points[expected.count];
          ASSERT_EQ(difference(of_lane(block, l), expected), "")
              << isa_name(isa) << " kind " << a << b << " block " << n << " lane " << l;
        }
      }
    }
  }
}

class CollideKernel : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (!isa_available(GetParam())) GTEST_SKIP() << "this CPU lacks " << isa_name(GetParam());
  }
};

TEST_P(CollideKernel, GivesPilesTheBitsOfCollide) {
  Count count[3][4];
  compare(GetParam(), pile_pair, 15'000, count);
  if (HasFatalFailure()) return;
  for (const auto& row : count) {
    for (const Count& c : row) {
      EXPECT_GE(c.pairs, 100'000u);
      EXPECT_LT(static_cast<double>(c.hard), 0.02 * static_cast<double>(c.pairs));
      EXPECT_GT(c.points[1], c.pairs / 100);
    }
  }
  for (const std::size_t a : {0u, 1u})
    EXPECT_GT(count[a][2].points[2], count[a][2].pairs / 4);  // boxes lie on two points
  EXPECT_GT(count[2][2].points[2], count[2][2].pairs / 8);    // a polygon of many sides seldom lies on one of them
}

TEST_P(CollideKernel, GivesAnyPairTheBitsOfCollide) {
  Count count[3][4];
  compare(GetParam(), any_pair, 15'000, count);
  if (HasFatalFailure()) return;
  for (const auto& row : count) {
    for (const Count& c : row) {
      EXPECT_LT(static_cast<double>(c.hard), 0.35 * static_cast<double>(c.pairs));
      EXPECT_GT(c.points[0], c.pairs / 20);
      EXPECT_GT(c.points[1], c.pairs / 20);
    }
    EXPECT_EQ(row[0].hard, 0u);  // nothing about a disc is hard
    EXPECT_GT(row[2].hard, 0u);  // deep pairs are
  }
}

// Which lanes are hard, and all that is stored, is the same on every instruction set.
TEST_P(CollideKernel, StoresTheSameOnEveryInstructionSet) {
  const KernelTable& scalar = kernels_of(Isa::scalar);
  const KernelTable& other = kernels_of(GetParam());
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 4; ++b) {
      Random random(7 + 100 * a + b);
      for (std::uint32_t n = 0; n < 3'000; ++n) {
        HullPair pairs[kBlock];
        for (HullPair& p : pairs) {
          const int of_a = vertices_of(random, a + 1);
          p = (n % 2 ? pile_pair : any_pair)(random, of_a, vertices_of(random, b));
        }
        HullPairs mine = block_of(pairs, 0, kBlock), theirs = mine;
        scalar.collide[a][b](&mine, 0, 1);
        other.collide[a][b](&theirs, 0, 1);
        ASSERT_EQ(mine.hard, theirs.hard);
        ASSERT_EQ(mine.has[0], theirs.has[0]);
        ASSERT_EQ(mine.has[1], theirs.has[1]);
        for (std::uint32_t l = 0; l < kBlock; ++l) {
          if ((mine.hard >> l & 1) != 0) continue;
          ASSERT_EQ(difference(of_lane(mine, l), of_lane(theirs, l)), "") << "block " << n << " lane " << l;
        }
      }
    }
  }
}

TEST_P(CollideKernel, ALaneDoesNotDependOnItsNeighbours) {
  Random random(5);
  HullPair pairs[kBlock];
  for (std::uint32_t n = 0; n < 2'000; ++n) {
    for (HullPair& p : pairs) p = (n % 2 ? pile_pair : any_pair)(random, 4, 4);
    HullPairs here = block_of(pairs, 0, kBlock), there = block_of(pairs, 3, kBlock);
    kernels_of(GetParam()).collide[1][2](&here, 0, 1);
    kernels_of(GetParam()).collide[1][2](&there, 0, 1);
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const std::uint32_t moved = (l + kBlock - 3) % kBlock;
      ASSERT_EQ(here.hard >> l & 1, there.hard >> moved & 1);
      if ((here.hard >> l & 1) != 0) continue;
      ASSERT_EQ(difference(of_lane(here, l), of_lane(there, moved)), "");
    }
  }
}

// Batches of any length, with discs on either side: what collide() says of every pair, hard ones too.
TEST_P(CollideKernel, BatchesOfAnyLengthSayWhatCollideSays) {
  Random random(11);
  for (std::uint32_t n = 0; n < 20'000; ++n) {
    const std::size_t size_a = random.below(4), size_b = size_a == 0 ? 1 + random.below(3) : random.below(4);
    const auto count = static_cast<std::uint32_t>(1 + random.below(kBlock));
    HullPair pairs[kBlock];
    CollideBatch batch;
    for (std::uint32_t k = 0; k < count; ++k) {
      HullPair& p = pairs[k];
      const int of_a = vertices_of(random, size_a);
      p = any_pair(random, of_a, vertices_of(random, size_b));
      batch.add(p.a, p.qa, p.b, p.qb, p.dx, p.dy, p.margin);
    }
    ASSERT_EQ(batch.full(), count == kBlock);
    const std::uint32_t kind = CollideBatch::kind_of(pairs[0].a, pairs[0].b);
    ASSERT_LT(kind, CollideBatch::kKinds);
    batch.solve(kernels_of(GetParam()), kind);
    for (std::uint32_t k = 0; k < count; ++k) {
      const HullPair& p = pairs[k];
      ASSERT_EQ(difference(batch.manifold(k), collide(p.a, p.qa, p.b, p.qb, p.dx, p.dy, p.margin)), "")
          << size_a << " " << size_b << " " << k << " of " << count;
    }
  }
}

TEST(CollideBatch, KnowsAllPairsButThoseOfTwoDiscs) {
  const Hull disc = disc_hull(1), quad = box(1, 1, 0);
  Random random(3);
  EXPECT_EQ(CollideBatch::kind_of(disc, disc), CollideBatch::kKinds);
  EXPECT_EQ(CollideBatch::kind_of(disc, quad), CollideBatch::kind_of(quad, disc));
  for (int of_a = 2; of_a <= 8; ++of_a) {
    for (int of_b = 1; of_b <= 8; ++of_b) {
      EXPECT_LT(CollideBatch::kind_of(random_hull(random, of_a, 1), random_hull(random, of_b, 1)),
                CollideBatch::kKinds);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, CollideKernel, testing::ValuesIn(kAllIsas),
                         [](const auto& isa) { return std::string(isa_name(isa.param)); });

}  // namespace
}  // namespace psim::test
