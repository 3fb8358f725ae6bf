// Large bodies find one another, and others find them: exactly those that a comparison of each with each finds, in the
// same order, whatever their sizes, wherever they lie, on every ISA.
#include "lists/large_cells.h"

#include <cmath>
#include <cstring>

#include "base/machine.h"
#include "support.h"

namespace psim::test {
namespace {

struct Crowd {
  std::vector<std::int32_t> at;
  std::vector<float> reach;
  std::uint32_t size() const { return static_cast<std::uint32_t>(reach.size()); }
};

struct Kind {
  const char* name;
  double smallest, largest;  // reaches, log-uniform, m
  double width;              // of the square that they lie in, m
  bool periodic, clustered;
};

class LargeCellsOf : public testing::TestWithParam<Kind> {};

constexpr double kWorld = 2000;  // m

Lattice lattice_of(const Kind& kind) {
  return Lattice({-kWorld / 2, -kWorld / 2, kWorld / 2, kWorld / 2}, kind.periodic);
}

Crowd crowd_of(const Kind& kind, std::uint32_t bodies, Random& random) {
  const Lattice lattice = lattice_of(kind);
  Crowd crowd;
  Vec2 middle;
  for (std::uint32_t i = 0; i < bodies; ++i) {
    if (kind.clustered && i % 50 == 0) {
      middle = {random.uniform(-0.5, 0.5) * 0.9 * kWorld, random.uniform(-0.5, 0.5) * 0.9 * kWorld};
    }
    Vec2 p{random.uniform(-0.5, 0.5) * kind.width, random.uniform(-0.5, 0.5) * kind.width};
    if (kind.clustered) p = {middle.x + p.x, middle.y + p.y};
    const LatticePoint place = lattice.to_lattice(p);
    crowd.at.insert(crowd.at.end(), {place.x, place.y});
    crowd.reach.push_back(
        static_cast<float>(kind.smallest * std::exp(random.uniform(0, std::log(kind.largest / kind.smallest)))));
  }
  // Lanes may be read behind the last body.
  crowd.at.resize(crowd.at.size() + 2 * kernels::kReadPad);
  return crowd;
}

struct Pairs {
  explicit Pairs(std::size_t room) : owner(room + kernels::kReadPad), other(room + kernels::kReadPad) {
    list.owner = owner.data();
    list.other = other.data();
    list.capacity = static_cast<std::uint32_t>(room);
  }
  std::vector<std::uint32_t> owner, other;
  kernels::PairList list;
};

TEST_P(LargeCellsOf, FindWhatEachWithEachFinds) {
  const Kind& kind = GetParam();
  const Lattice lattice = lattice_of(kind);
  std::size_t found = 0;
  for (const std::uint32_t begin : {0u, 37u}) {
    Random random(begin + 5);
    Crowd crowd = crowd_of(kind, LargeCells::kLeast + 300, random);
    const std::uint32_t n = crowd.size();
    crowd.reach.resize(n + kernels::kReadPad);
    MemoryMeter meter;
    LargeCells cells(meter);
    cells.build(crowd.at.data(), crowd.reach.data(), begin, n, lattice);
    ASSERT_TRUE(cells.any());
    EXPECT_GT(cells.tests(), 0);
    kernels::PairRow row;
    row.pos = crowd.at.data();
    row.reach = crowd.reach.data();
    row.pitch_x = static_cast<float>(lattice.pitch_x());
    row.pitch_y = static_cast<float>(lattice.pitch_y());
    for (const Isa isa : available_isas()) {
      const kernels::KernelTable& k = kernels_of(isa);
      for (std::uint32_t i = begin; i < n; ++i) {
        Pairs all(n + 8), mine(3 * std::size_t{n} + 8);
        ASSERT_TRUE(k.find_near(row, i, i + 1, n, all.list));
        ASSERT_TRUE(cells.find(i, k, mine.list));
        ASSERT_EQ(mine.list.count, all.list.count) << i;
        found += all.list.count;
        for (std::uint32_t p = 0; p < all.list.count; ++p) {
          ASSERT_EQ(mine.other[p], all.other[p]) << i;
          ASSERT_EQ(mine.owner[p], i);
        }
      }
    }
  }
  EXPECT_GT(found, 500u);
}

// Who asks may be small or large and lie anywhere.
TEST_P(LargeCellsOf, AreFoundFromAnywhere) {
  const Kind& kind = GetParam();
  const Lattice lattice = lattice_of(kind);
  constexpr std::uint32_t kBegin = 37, kGuests = 300;
  Random random(11);
  Crowd crowd = crowd_of(kind, LargeCells::kLeast + 300 + kGuests, random);
  const std::uint32_t all = crowd.size(), n = all - kGuests;
  crowd.reach.resize(all + kernels::kReadPad);
  for (std::uint32_t i = n; i < all; ++i) {
    if (i % 3 != 0) crowd.reach[i] *= static_cast<float>(random.uniform(0.01, 1));
    if (i % 5 != 0) continue;
    crowd.at[2 * std::size_t{i}] = crowd.at[2 * std::size_t{i - n}];  // as one of those that are asked for
    crowd.at[2 * std::size_t{i} + 1] = crowd.at[2 * std::size_t{i - n} + 1];
  }
  MemoryMeter meter;
  LargeCells cells(meter);
  cells.build(crowd.at.data(), crowd.reach.data(), kBegin, n, lattice);
  kernels::PairRow row;
  row.pos = crowd.at.data();
  row.reach = crowd.reach.data();
  row.pitch_x = static_cast<float>(lattice.pitch_x());
  row.pitch_y = static_cast<float>(lattice.pitch_y());
  std::size_t found = 0;
  for (const Isa isa : available_isas()) {
    for (std::uint32_t i = n; i < all; ++i) {
      Pairs theirs(n + 8), mine(3 * std::size_t{n} + 8);
      mine.list.count = 2;  // it appends
      mine.other[0] = mine.other[1] = 5;
      ASSERT_TRUE(kernels_of(isa).find_near(row, i, kBegin, n, theirs.list));
      ASSERT_TRUE(cells.around(crowd.at.data() + 2 * std::size_t{i}, crowd.reach[i], mine.list));
      ASSERT_EQ(mine.list.count, theirs.list.count + 2) << i;
      ASSERT_EQ(mine.other[1], 5u);
      ASSERT_TRUE(std::equal(theirs.other.data(), theirs.other.data() + theirs.list.count, mine.other.data() + 2)) << i;
      found += theirs.list.count;
    }
  }
  EXPECT_GT(found, 100u);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, LargeCellsOf,
    testing::Values(Kind{"Alike", 1, 1.01, 80, false, false}, Kind{"OneToFifty", 0.2, 10, 300, false, false},
                    Kind{"OneToTenThousand", 0.02, 200, 1000, false, false}, Kind{"Clusters", 0.5, 2, 12, false, true},
                    Kind{"AllOverThePlane", 5, 40, kWorld, false, false},
                    Kind{"AcrossTheSeam", 5, 40, kWorld, true, false},
                    Kind{"PeriodicGiants", 1, 900, kWorld, true, false}, Kind{"OnePlace", 1, 50, 1e-6, false, false}),
    [](const auto& test) { return test.param.name; });

// As few bodies as cells are made for.
struct Least {
  Least() { crowd.reach.resize(n + kernels::kReadPad); }
  void build(LargeCells& cells, std::uint32_t begin) const {
    cells.build(crowd.at.data(), crowd.reach.data(), begin, n, lattice_of(kind));
  }
  Kind kind{"", 1, 4, 60, false, false};
  Random random{3};
  Crowd crowd = crowd_of(kind, LargeCells::kLeast, random);
  std::uint32_t n = crowd.size();
};

TEST(LargeCells, AFullListSaysSoAndTheOwnersTellHowFarItCame) {
  const Least least;
  const std::uint32_t n = least.n;
  MemoryMeter meter;
  LargeCells cells(meter);
  least.build(cells, 0);
  ASSERT_TRUE(cells.any());
  for (const Isa isa : available_isas()) {
    Pairs some(200);
    std::uint32_t i = 0;
    while (i < n && cells.find(i, kernels_of(isa), some.list)) ++i;
    ASSERT_GT(i, 0u);
    ASSERT_LT(i, n);
    EXPECT_EQ(some.owner[some.list.capacity - 1], i) << isa_name(isa);
  }
}

TEST(LargeCells, AListWithoutRoomForWhoIsAroundSaysSo) {
  const Least least;
  MemoryMeter meter;
  LargeCells cells(meter);
  least.build(cells, 0);
  const auto around = [&](std::size_t room, std::uint32_t had) {
    Pairs some(room);
    some.list.count = had;
    const bool all = cells.around(least.crowd.at.data(), 1e4f, some.list);
    EXPECT_EQ(some.list.count, all ? had + least.n : had);
    EXPECT_EQ(some.other[room], 0u);
    return all;
  };
  EXPECT_FALSE(around(200, 0));
  EXPECT_FALSE(around(200, 200));
  EXPECT_FALSE(around(least.n + 20, 30));
  EXPECT_TRUE(around(3 * std::size_t{least.n}, 30));
}

TEST(LargeCells, FewAreNotWorthIt) {
  const Least least;
  MemoryMeter meter;
  LargeCells cells(meter);
  least.build(cells, 1);
  EXPECT_FALSE(cells.any());
  EXPECT_EQ(meter.bytes, 0u);
  least.build(cells, 0);
  EXPECT_TRUE(cells.any());
  EXPECT_GT(meter.bytes, 0u);
  least.build(cells, least.n);
  EXPECT_FALSE(cells.any());
  EXPECT_EQ(meter.bytes, 0u);
}

}  // namespace
TEST(LargeCells, AreNotForSmallBodiesThatLieApartFromLargeOnes) {
  constexpr std::size_t kLarge = 1000, kSmall = 10000, kLargeColumns = 63, kSmallColumns = 141;
  const double large = 5, small = 0.1, wall = 635, height = 312;
  Discs discs;
  const auto lay = [&](std::size_t count, std::size_t columns, double from, double radius) {
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t row = k / columns, column = k % columns;
      discs.push(from + radius + 2 * radius * static_cast<double>(column) + (row % 2 != 0 ? radius : 0),
                 radius + static_cast<double>(row) * std::sqrt(3.0) * radius, radius);
    }
  };
  lay(kLarge, kLargeColumns, 0, large);
  lay(kSmall, kSmallColumns, wall + 1, small);
  WorldDesc desc = walled({0, 0, 664.3, height}, {0, -9.81});
  desc.sleeping = false;
  const auto world = make(desc, best_isa(), 1);
  BodyDesc between;
  between.type = BodyType::static_body;
  between.shape = BoxShape{0.5, height};
  between.position = {wall + 0.5, height / 2};
  add(*world, between);
  add(*world, discs);
  for (int k = 0; k < 90; ++k) {
    world->step();
    if (k % 10 != 9) continue;
    const auto strips = world->strips();
    std::uint32_t last = 0;
    for (const std::uint32_t strip : strips) {
      if (strip != kNoStrip) last = std::max(last, strip);
    }
    EXPECT_LE(std::count(strips.begin(), strips.end(), last), kLarge + kSmall / 4) << "step " << k;
  }
}

}  // namespace psim::test
