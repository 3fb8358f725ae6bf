// What is near walls and fixed shapes in sparse worlds, against brute force.
#include <set>

#include "sparse_support.h"

namespace psim::test {
namespace {

TEST(SparseWorld, WallsAreFoundFromListedCells) {
  Broad one(square(kHalf), false);
  one.walls = true;
  Random random(8);
  Places p;
  cluster(p, random, {-kHalf + 4.7, kHalf - 4.7}, 400, 9);
  cluster(p, random, {kHalf - 4.7, -kHalf + 4.7}, 400, 9);
  cluster(p, random, {0, 0}, 100, 9);
  one.add(p);
  one.build();
  ASSERT_TRUE(one.broad.cells().listed());
  std::set<std::pair<std::uint32_t, std::uint32_t>> found, want;
  for (std::size_t s = 0; s < one.table.strips.size(); ++s) {
    for (const StaticPair& pair : one.table.static_contacts[s]) found.insert({pair.body, pair.shape});
  }
  for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
    const double x = one.bodies.pos[2 * i] * one.lattice.pitch_x();
    const double y = one.bodies.pos[2 * i + 1] * one.lattice.pitch_y();
    const double reach = double{one.bodies.reach[i]};
    if (x - reach < -kHalf) want.insert({i, kWallLeft});
    if (x + reach > kHalf) want.insert({i, kWallRight});
    if (y - reach < -kHalf) want.insert({i, kWallBottom});
    if (y + reach > kHalf) want.insert({i, kWallTop});
  }
  EXPECT_EQ(found, want);
  EXPECT_GT(want.size(), 50u);
}

double distance_to(const Lattice& lattice, const StaticShape& s, std::int32_t x, std::int32_t y) {
  const double px = lattice.pitch_x(), py = lattice.pitch_y();
  const double ax = (s.p.x - x) * px, ay = (s.p.y - y) * py;
  double t = 0, ux = 0, uy = 0;
  if (s.segment) {
    ux = (s.q.x - s.p.x) * px;
    uy = (s.q.y - s.p.y) * py;
    t = std::clamp(-(ax * ux + ay * uy) / (ux * ux + uy * uy), 0.0, 1.0);
  }
  return std::hypot(ax + t * ux, ay + t * uy) - double{s.radius};
}

TEST(SparseWorld, FixedShapesFarApartAreFoundAndFewOthers) {
  // 2,000 pegs and edges in four places 100 km apart, two lines between them.
  MemoryMeter memory;
  const Lattice lattice(square(kHalf), false);
  StaticShapes shapes(memory, lattice);
  Random random(12);
  const Vec2 places[] = {{-5e4, -5e4}, {5e4, -4e4}, {4e4, 5e4}, {-3e4, 3e4}};
  const auto put = [&](Vec2 p, Vec2 q, double radius) {
    StaticShape s;
    s.p = lattice.to_lattice(p);
    s.q = lattice.to_lattice(q);
    s.segment = p.x != q.x || p.y != q.y;
    s.radius = static_cast<float>(radius);
    s.owner = static_cast<std::uint32_t>(shapes.size());
    shapes.add(std::vector<Piece>{Piece{s}});
  };
  for (int k = 0; k < 2000; ++k) {
    const Vec2 at = places[k % 4];
    const Vec2 p{at.x + random.uniform(0, 100), at.y + random.uniform(0, 100)};
    const bool edge = random.chance(0.5);
    put(p, edge ? Vec2{p.x + random.normal(), p.y + random.normal()} : p, edge ? 0 : 0.4);
  }
  put(places[0], places[2], 0.1);
  put(places[1], {places[1].x, 5e4}, 0);
  for (int round = 0; round < 2; ++round) {
    shapes.build_grid();
    std::vector<std::uint32_t> near;
    std::size_t all = 0;
    for (int k = 0; k < 800; ++k) {
      const Vec2 at = places[k % 4];
      const LatticePoint p = lattice.to_lattice({at.x + random.uniform(-5, 105), at.y + random.uniform(-5, 105)});
      near.clear();
      shapes.near(p.x, p.y, 2, near);
      all += near.size();
      for (std::uint32_t i = 0; i < shapes.size(); ++i) {
        if (!shapes[i].alive || distance_to(lattice, shapes[i], p.x, p.y) > 2) continue;
        ASSERT_TRUE(std::binary_search(near.begin(), near.end(), i)) << i;
      }
    }
    EXPECT_LT(all, 800u * 8);
    EXPECT_GT(all, 100u);
    for (std::uint32_t i = 0; i < shapes.size() && round == 0; i += 3) shapes.remove(i, i);
  }
}

}  // namespace
}  // namespace psim::test
