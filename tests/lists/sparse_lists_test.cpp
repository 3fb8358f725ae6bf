// The broad phase of sparse worlds costs what is there: no pair is lost, whatever lies between the bodies, and it takes
// no more cells than bodies. Against brute force.
#include <set>

#include "sanitized.h"
#include "sparse_support.h"

namespace psim::test {
namespace {

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
    EXPECT_EQ(one.broad.cells().listed(), a.listed);
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
      EXPECT_TRUE(one.broad.cells().listed());
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
    EXPECT_TRUE(one.broad.cells().listed()) << apart;
    EXPECT_LE(one.broad.cells().list().size(), p.size()) << apart;
    EXPECT_LT(static_cast<double>(one.memory.bytes) / static_cast<double>(p.size()), 300) << apart;
    // Half a disc a square metre, seen through cells of a metre or so.
    EXPECT_NEAR(one.broad.cells().density(), 0.5, 0.1) << apart;
    EXPECT_NEAR(one.broad.cells().area_about(0.5, 0), 2e4, 4e3) << apart;
  }
}

TEST(SparseWorld, DenseWorldsKeepTheirGrid) {
  Random random(4);
  Broad one(square(kHalf), false);
  Places p;
  cluster(p, random, {0, 0}, 4000, 60);
  one.add(p);
  one.build();
  EXPECT_FALSE(one.broad.cells().listed());
  Broad gas(square(kHalf), false);
  p.clear();
  cluster(p, random, {0, 0}, 4000, 1e5);
  gas.add(p);
  gas.build();
  EXPECT_FALSE(gas.broad.cells().listed());
}

TEST(SparseWorld, ACloudThatThinsOutGoesBackToAGrid) {
  Random random(6);
  Broad one(square(kHalf), false);
  Places p;
  cluster(p, random, {-4e4, 0}, 1500, 40);
  cluster(p, random, {4e4, 0}, 1500, 40);
  one.add(p);
  one.build();
  EXPECT_TRUE(one.broad.cells().listed());
  for (std::uint32_t i = 0; i < one.bodies.count; ++i) {
    const LatticePoint at = one.lattice.to_lattice({random.uniform(-4e4, 4e4), random.uniform(-4e4, 4e4)});
    one.bodies.pos[2 * i] = at.x;
    one.bodies.pos[2 * i + 1] = at.y;
  }
  for (int build = 0; build < 3; ++build) one.build();
  EXPECT_FALSE(one.broad.cells().listed());
  one.expect_right();
}

}  // namespace
}  // namespace psim::test
