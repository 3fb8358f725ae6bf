// The broad phase of sparse worlds costs what is there: no pair is lost, whatever lies between the bodies, and it takes
// no more cells than bodies. Against brute force.
#include <set>

#include "base/machine.h"
#include "lists/broad_phase.h"
#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

constexpr double kHalf = 60e3;  // m: of most worlds here

struct Place {
  double x, y, radius;
};
using Places = std::vector<Place>;

/// The broad phase of a world, without the rest.
struct Broad {
  Broad(Bounds b, bool is_periodic, int threads = 1)
      : bounds(b), wraps(is_periodic), lattice(b, is_periodic), pool(threads) {}

  void add(const Places& places) {
    bodies.reserve_slots(places.size());
    for (const Place& p : places) {
      const LatticePoint at = lattice.to_lattice({p.x, p.y});
      const std::size_t slot = bodies.count++;
      bodies.pos[2 * slot] = at.x;
      bodies.pos[2 * slot + 1] = at.y;
      bodies.radius[slot] = static_cast<float>(p.radius);
      bodies.id[slot] = next_id++;
      mixed = mixed || p.radius != places[0].radius;
    }
  }

  void build(Isa isa = best_isa()) {
    BroadPhaseParams p;
    p.margin.skin = 0.05f;
    p.periodic = wraps;
    p.mixed_radii = true;
    p.walls = walls;
    p.bounds = {bounds.xmin - lattice.centre().x, bounds.ymin - lattice.centre().y, bounds.xmax - lattice.centre().x,
                bounds.ymax - lattice.centre().y};
    bodies.pad_tail();
    broad.build(bodies, shapes, p, kernels_of(isa), pool, table);
  }

  double distance(std::uint32_t i, std::uint32_t j) const {
    const double dx = wrap_sub(bodies.pos[2 * j], bodies.pos[2 * i]) * lattice.pitch_x();
    const double dy = wrap_sub(bodies.pos[2 * j + 1], bodies.pos[2 * i + 1]) * lattice.pitch_y();
    return std::hypot(dx, dy);
  }

  /// Every pair within reach is there once, and no other; strips and phases are
  /// as they must be.
  void expect_right() const {
    std::set<std::pair<std::uint32_t, std::uint32_t>> found;
    const std::size_t strips = table.strips.size();
    std::uint32_t next = 0;
    for (std::size_t s = 0; s < strips; ++s) {
      const Strip& strip = table.strips[s];
      ASSERT_EQ(strip.body_begin, next);
      next = strip.body_end;
      for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) {
        const std::uint32_t i = table.owner[p], j = table.other[p];
        ASSERT_EQ(table.strip_of(i), s);
        ASSERT_TRUE(found.insert({std::min(i, j), std::max(i, j)}).second) << i << " " << j;
        if (s + 1 == strips) continue;  // large ones go alone
        const std::size_t other = table.strip_of(j), last = strips - 2;
        ASSERT_TRUE(other == s || other == s + 1 || (wraps && s == last && other == 0))
            << s << " " << other << " of " << strips;
        ASSERT_TRUE(other == s || (other + s) % 2 == 1 || last == 0);
        ASSERT_LT(j, table.large_begin);
      }
    }
    ASSERT_EQ(next, bodies.count);
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      for (std::uint32_t j = i + 1; j < bodies.count; ++j) {
        const double sum = double{bodies.reach[i]} + double{bodies.reach[j]};
        const double d = distance(i, j);
        if (std::fabs(d - sum) < 1e-5 * sum) continue;
        ASSERT_EQ(found.contains({i, j}), d < sum) << i << " " << j << " " << d << " of " << sum;
      }
    }
  }

  Bounds bounds;
  bool wraps;
  bool walls = false;
  bool mixed = false;
  Lattice lattice;
  MemoryMeter memory;
  BodyStore bodies{memory};
  StaticShapes shapes{memory, lattice};
  BroadPhase broad{memory, lattice};
  PairTable table{memory};
  WorkerPool pool;
  std::uint32_t next_id = 0;
};

Bounds square(double half) { return {-half, -half, half, half}; }

/// n discs in a square about a place, overlapping as they may.
void cluster(Places& out, Random& random, Vec2 at, std::size_t n, double side, double radius = 0.5) {
  for (std::size_t k = 0; k < n; ++k) {
    out.push_back({at.x + random.uniform(-side / 2, side / 2), at.y + random.uniform(-side / 2, side / 2), radius});
  }
}

struct Arrangement {
  const char* name;
  bool periodic;
  bool listed;  // the box is mostly empty
  Places (*make)(Random& random);
};

const Arrangement kArrangements[] = {
    {"one cluster", false, false,
     [](Random& r) {
       Places p;
       cluster(p, r, {3e4, -2e4}, 900, 30);
       return p;
     }},
    {"side by side", false, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {-5e4, 0}, 450, 22);
       cluster(p, r, {5e4, 0}, 450, 22);
       return p;
     }},
    {"one above the other", false, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {10, -5e4}, 450, 22);
       cluster(p, r, {0, 5e4}, 450, 22);
       return p;
     }},
    {"diagonal", false, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {-5e4, -5e4}, 450, 22);
       cluster(p, r, {5e4, 5e4}, 450, 22);
       return p;
     }},
    {"seventeen clusters", false, true,
     [](Random& r) {
       Places p;
       for (int k = 0; k < 17; ++k) {
         cluster(p, r, {r.uniform(-5e4, 5e4), r.uniform(-5e4, 5e4)}, 120, 11);
       }
       return p;
     }},
    {"a stray", false, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {0, 0}, 900, 30);
       p.push_back({4e4, 3e4, 0.5});
       return p;
     }},
    {"pairs on a line", false, false,
     [](Random& r) {
       Places p;
       for (int k = 0; k < 400; ++k) {
         const double x = -5e4 + 250 * k;
         p.push_back({x, 0.1 * r.normal(), 0.5});
         p.push_back({x + r.uniform(0.9, 1.2), 0.1 * r.normal(), 0.5});
       }
       return p;
     }},
    {"three lines", false, true,
     [](Random& r) {
       Places p;
       for (int k = 0; k < 300; ++k) {
         p.push_back({-5e4 + 0.8 * k, 0.1 * r.normal(), 0.5});
         p.push_back({5e4 + 0.1 * r.normal(), 0.8 * k, 0.5});
         p.push_back({0.6 * k, 5e4 - 0.6 * k, 0.5});
       }
       return p;
     }},
    {"radii from 0.05 to 5", false, true,
     [](Random& r) {
       Places p;
       for (const double x : {-5e4, 0.0, 5e4}) {
         cluster(p, r, {x, x / 3}, 300, 12, 0.1);
         for (int k = 0; k < 12; ++k) cluster(p, r, {x, x / 3}, 1, 40, r.uniform(0.5, 5));
         for (int k = 0; k < 60; ++k) cluster(p, r, {x, x / 3}, 1, 20, r.uniform(0.05, 0.5));
       }
       return p;
     }},
    {"a giant far away", false, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {0, 0}, 600, 30, 0.3);
       cluster(p, r, {30, 0}, 1, 1, 40);
       cluster(p, r, {5e4, 1e4}, 1, 1, 60);
       return p;
     }},
    {"periodic, on both seams", true, true,
     [](Random& r) {
       Places p;
       cluster(p, r, {-kHalf, -kHalf}, 350, 20);
       cluster(p, r, {kHalf, 2e4}, 250, 16);
       cluster(p, r, {-2e4, kHalf}, 250, 16);
       cluster(p, r, {0, 0}, 50, 8);
       return p;
     }},
    {"periodic, radii from 0.1 to 8", true, true,
     [](Random& r) {
       Places p;
       for (const Vec2 at : {Vec2{-kHalf, -kHalf}, Vec2{kHalf, 2e4}, Vec2{-2e4, kHalf}}) {
         cluster(p, r, at, 250, 14, 0.2);
         for (int k = 0; k < 8; ++k) cluster(p, r, at, 1, 50, r.uniform(1, 8));
       }
       return p;
     }},
    {"periodic, a line across", true, true,
     [](Random& r) {
       Places p;
       for (int k = 0; k < 500; ++k) p.push_back({-kHalf + 0.8 * (k - 250), 10 + 0.2 * r.normal(), 0.5});
       cluster(p, r, {0, 5e4}, 300, 16);
       return p;
     }},
};

TEST(SparseWorld, NoPairIsLostWhateverLiesBetween) {
  for (const Arrangement& a : kArrangements) {
    SCOPED_TRACE(a.name);
    Random random(11);
    Broad one(square(kHalf), a.periodic);
    one.add(a.make(random));
    one.build();
    EXPECT_EQ(one.broad.listed(), a.listed);
    one.expect_right();
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(SparseWorld, BodiesThatMoveComeAndGoAreFoundEveryTime) {
  // Small steps, of which the cells stay where they are; a jump of everything;
  // some that leave; some that come.
  for (const Arrangement& a : kArrangements) {
    SCOPED_TRACE(a.name);
    Random random(5);
    Broad one(square(kHalf), a.periodic);
    one.add(a.make(random));
    for (int build = 0; build < 12; ++build) {
      SCOPED_TRACE(build);
      one.build();
      one.expect_right();
      if (testing::Test::HasFatalFailure()) return;
      const double step = build == 6 ? 300 : (build % 3) * 0.1;
      for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
        for (const std::size_t axis : {0u, 1u}) {
          const double way = random.uniform(-step, step) / one.lattice.pitch_x();
          one.bodies.pos[2 * i + axis] = wrap_add(one.bodies.pos[2 * i + axis], static_cast<std::int32_t>(way));
        }
      }
      if (build == 3) {
        for (std::uint32_t i = 0; i < one.bodies.count; i += 9) {
          one.bodies.id[i] = kNoSlot;
          ++one.bodies.dead;
        }
      }
      if (build == 8) {
        Places more;
        cluster(more, random, {-3e4, 4e4}, 200, 16);
        one.add(more);
      }
    }
  }
}

TEST(SparseWorld, TheListsAreTheSameForEveryIsaAndNumberOfThreads) {
  for (const Arrangement& a : kArrangements) {
    std::vector<std::uint32_t> first;
    for (const Isa isa : available_isas()) {
      for (const int threads : thread_counts()) {
        Random random(23);
        Broad one(square(kHalf), a.periodic, threads);
        one.add(a.make(random));
        for (int build = 0; build < 3; ++build) one.build(isa);
        std::vector<std::uint32_t> all(one.bodies.id.data(), one.bodies.id.data() + one.bodies.count);
        for (const Strip& s : one.table.strips) {
          all.push_back(s.body_begin);
          for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
            all.push_back(one.table.owner[p]);
            all.push_back(one.table.other[p]);
          }
        }
        if (first.empty()) first = all;
        EXPECT_EQ(all, first) << a.name << " " << isa_name(isa) << " " << threads;
      }
    }
  }
}

TEST(SparseWorld, ManyChunksOfBodiesAreSortedAsOne) {
  // More bodies than one task of the sort takes; movers and stayers cross the
  // chunks.
  std::vector<std::uint32_t> first;
  for (const int threads : {1, 3}) {
    Random random(2);
    Broad one(square(kHalf), false, threads);
    Places p;
    for (int k = 0; k < 40; ++k) {
      cluster(p, random, {random.uniform(-5e4, 5e4), random.uniform(-5e4, 5e4)}, 1000, 50);
    }
    one.add(p);
    for (int build = 0; build < 4; ++build) {
      one.build();
      EXPECT_TRUE(one.broad.listed());
      for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
        one.bodies.pos[2 * i] += static_cast<std::int32_t>(random.bits() % 401) - 200;
      }
    }
    // Order of slots: rows, columns and slots ascend, so the order alone tells
    // of a mistake.
    std::vector<std::uint32_t> all(one.bodies.id.data(), one.bodies.id.data() + one.bodies.count);
    std::vector<std::uint32_t> sorted = all;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t k = 0; k < sorted.size(); ++k) ASSERT_EQ(sorted[k], k);
    std::size_t pairs = 0;
    for (const Strip& s : one.table.strips) pairs += s.pair_end - s.pair_begin;
    all.push_back(static_cast<std::uint32_t>(pairs));
    if (first.empty()) first = all;
    EXPECT_EQ(all, first);
    Broad fresh(square(kHalf), false);  // sorted anew
    fresh.bodies.reserve_slots(one.bodies.count);
    fresh.bodies.count = one.bodies.count;
    for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
      fresh.bodies.pos[2 * i] = one.bodies.built[2 * i];
      fresh.bodies.pos[2 * i + 1] = one.bodies.built[2 * i + 1];
      fresh.bodies.radius[i] = one.bodies.radius[i];
      fresh.bodies.id[i] = i;
    }
    fresh.build();
    std::size_t again = 0;
    for (const Strip& s : fresh.table.strips) again += s.pair_end - s.pair_begin;
    EXPECT_EQ(again, pairs);
    EXPECT_GT(pairs, 10000u);
  }
}

TEST(SparseWorld, CellsAndMemoryFollowTheBodiesNotTheSpace) {
  for (const double apart : {2e3, 2e4, 1e5, 1e6, 1e7}) {
    Random random(3);
    Places p;
    cluster(p, random, {-apart / 2, -apart / 2}, 5000, 100);
    cluster(p, random, {apart / 2, apart / 2}, 5000, 100);
    Broad one(square(apart), false);
    one.add(p);
    for (int build = 0; build < 4; ++build) one.build();
    EXPECT_TRUE(one.broad.listed()) << apart;
    EXPECT_LE(one.broad.cells(), p.size()) << apart;
    EXPECT_LT(static_cast<double>(one.memory.bytes) / static_cast<double>(p.size()), 300) << apart;
    // Half a disc a square metre, seen through cells of a metre or so.
    EXPECT_NEAR(one.broad.density(), 0.5, 0.1) << apart;
    EXPECT_NEAR(one.broad.area(), 2e4, 4e3) << apart;
  }
}

TEST(SparseWorld, DenseWorldsKeepTheirGrid) {
  Random random(4);
  Broad one(square(kHalf), false);
  Places p;
  cluster(p, random, {0, 0}, 4000, 60);
  one.add(p);
  one.build();
  EXPECT_FALSE(one.broad.listed());
  Broad gas(square(kHalf), false);
  p.clear();
  cluster(p, random, {0, 0}, 4000, 1e5);
  gas.add(p);
  gas.build();
  EXPECT_FALSE(gas.broad.listed());
}

TEST(SparseWorld, ACloudThatThinsOutGoesBackToAGrid) {
  Random random(6);
  Broad one(square(kHalf), false);
  Places p;
  cluster(p, random, {-4e4, 0}, 1500, 40);
  cluster(p, random, {4e4, 0}, 1500, 40);
  one.add(p);
  one.build();
  EXPECT_TRUE(one.broad.listed());
  for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
    const LatticePoint at = one.lattice.to_lattice({random.uniform(-4e4, 4e4), random.uniform(-4e4, 4e4)});
    one.bodies.pos[2 * i] = at.x;
    one.bodies.pos[2 * i + 1] = at.y;
  }
  for (int build = 0; build < 3; ++build) one.build();
  EXPECT_FALSE(one.broad.listed());
  one.expect_right();
}

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
  ASSERT_TRUE(one.broad.listed());
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
    shapes.add(s);
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
