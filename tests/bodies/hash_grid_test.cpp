// The hashed grid finds every box that a question meets, by brute force; once each; wherever they lie.
#include "bodies/hash_grid.h"

#include <algorithm>
#include <cmath>

#include "support.h"

namespace psim::test {
namespace {

struct Box {
  std::uint32_t number = 0;
  std::int32_t x = 0, y = 0;
  std::uint32_t half_x = 0, half_y = 0;
};

// Steps between two places around the lattice.
std::int64_t apart(std::int32_t a, std::int32_t b) {
  const auto d = static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
  return std::abs(std::int64_t{d});
}

bool meet(const Box& a, const Box& b) {
  return apart(a.x, b.x) <= std::int64_t{a.half_x} + b.half_x && apart(a.y, b.y) <= std::int64_t{a.half_y} + b.half_y;
}

std::int32_t anywhere(Random& random) { return static_cast<std::int32_t>(random.bits() >> 32); }

/// Log-uniform between 1 and `most`.
std::uint32_t size(Random& random, double most) {
  return static_cast<std::uint32_t>(std::exp(random.uniform(0, std::log(most))));
}

struct Model {
  explicit Model(int shift) : grid(meter, shift) {}

  void insert(const Box& box) {
    grid.insert(box.number, box.x, box.y, box.half_x, box.half_y);
    boxes.push_back(box);
  }
  void remove(std::size_t k) {
    grid.remove(boxes[k].number);
    boxes[k] = boxes.back();
    boxes.pop_back();
  }
  std::vector<std::uint32_t> found(const Box& asked) const {
    std::vector<std::uint32_t> out{4'000'000'000u};  // what is there stays
    grid.near(asked.x, asked.y, asked.half_x, asked.half_y, out);
    EXPECT_EQ(out.front(), 4'000'000'000u);
    out.erase(out.begin());
    std::sort(out.begin(), out.end());
    return out;
  }
  void check(const Box& asked) const {
    const std::vector<std::uint32_t> out = found(asked);
    EXPECT_EQ(std::adjacent_find(out.begin(), out.end()), out.end()) << "twice";
    std::vector<std::uint32_t> there;
    for (const Box& box : boxes) there.push_back(box.number);
    std::sort(there.begin(), there.end());
    EXPECT_TRUE(std::includes(there.begin(), there.end(), out.begin(), out.end())) << "one that is gone";
    for (const Box& box : boxes) {
      if (meet(box, asked)) {
        EXPECT_TRUE(std::binary_search(out.begin(), out.end(), box.number))
            << "box " << box.x << ' ' << box.y << " +- " << box.half_x << ' ' << box.half_y << ", asked " << asked.x
            << ' ' << asked.y << " +- " << asked.half_x << ' ' << asked.half_y;
      }
    }
  }

  MemoryMeter meter;
  HashGrid grid;
  std::vector<Box> boxes;
};

class HashGridOf : public testing::TestWithParam<int> {};  // the shift between the axes' pitches
INSTANTIATE_TEST_SUITE_P(Shifts, HashGridOf, testing::Values(0, 1, 5, 28, -1, -6, -28),
                         [](const testing::TestParamInfo<int>& info) {
                           return (info.param < 0 ? "Minus" : "Plus") + std::to_string(std::abs(info.param));
                         });

TEST_P(HashGridOf, FindsWhatBruteForceFindsWhileBoxesComeAndGo) {
  for (const double most : {40.0, 1e6, 1e9}) {
    Random random(static_cast<std::uint64_t>(most) + static_cast<std::uint64_t>(GetParam() + 64));
    Model model(GetParam());
    std::uint32_t next = 0;
    std::vector<std::uint32_t> free;
    for (int k = 0; k < 3000; ++k) {
      const bool crowded = random.chance(0.5);  // close together, or anywhere
      const auto place = [&] {
        return crowded ? static_cast<std::int32_t>(random.uniform(-std::min(3 * most, 2e9), std::min(3 * most, 2e9)))
                       : anywhere(random);
      };
      const Box box{0, place(), place(), size(random, most), size(random, most)};
      if (random.chance(model.boxes.size() < 200 ? 0.7 : 0.45) || model.boxes.empty()) {
        Box added = box;
        if (free.empty() || random.chance(0.3)) {
          added.number = next++;
        } else {
          added.number = free.back();
          free.pop_back();
        }
        model.insert(added);
      } else {
        const std::size_t gone = random.below(model.boxes.size());
        free.push_back(model.boxes[gone].number);
        model.remove(gone);
      }
      if (k % 10 == 0) model.check(box);
      if (k % 100 == 0) model.check({0, box.x, box.y, 0, 0});
    }
  }
}

TEST_P(HashGridOf, WrapsAtTheSeam) {
  Model model(GetParam());
  const std::int32_t end = std::numeric_limits<std::int32_t>::max(), begin = std::numeric_limits<std::int32_t>::min();
  std::uint32_t number = 0;
  for (const std::int32_t x : {end, end - 50, begin, begin + 50, 0}) {
    for (const std::int32_t y : {end, end - 50, begin, begin + 50, 0}) model.insert({number++, x, y, 40, 40});
  }
  for (const std::int32_t x : {end, begin, begin + 120, 0}) {
    for (const std::int32_t y : {end, begin, begin + 120, 0}) model.check({0, x, y, 100, 100});
  }
  EXPECT_GE(model.found({0, end, end, 100, 100}).size(), 16u);
}

TEST_P(HashGridOf, FindsAllWithAGiantQuestion) {
  Random random(3);
  Model model(GetParam());
  for (std::uint32_t k = 0; k < 500; ++k) {
    model.insert({k, anywhere(random), anywhere(random), size(random, 1e8), size(random, 1e8)});
  }
  for (const std::uint32_t half : {1u << 30, (1u << 31) - 1, 1u << 31, 0xFFFFFFFFu}) {
    model.check({0, anywhere(random), anywhere(random), half, half});
    model.check({0, anywhere(random), anywhere(random), half, 1});
    model.check({0, anywhere(random), anywhere(random), 1, half});
  }
  EXPECT_EQ(model.found({0, 5, 5, 1u << 31, 1u << 31}).size(), 500u);
}

TEST_P(HashGridOf, FindsBoxesAsLargeAsTheWorld) {
  Random random(5);
  Model model(GetParam());
  std::uint32_t number = 0;
  for (const std::uint32_t half : {1u << 28, 1u << 29, 1u << 30, 3u << 29, (1u << 31) - 1, 1u << 31}) {
    model.insert({number++, anywhere(random), anywhere(random), half, half});
    model.insert({number++, anywhere(random), anywhere(random), half, 3});
    model.insert({number++, anywhere(random), anywhere(random), 3, half});
  }
  for (int k = 0; k < 300; ++k) model.check({0, anywhere(random), anywhere(random), 10, 10});
}

TEST(HashGrid, LooksAtFewWhereAllAreApart) {
  Model model(0);
  for (std::int32_t k = 0; k < 4096; ++k) {
    model.insert({static_cast<std::uint32_t>(k), (k % 64) * 1000, (k / 64) * 1000, 400, 400});
  }
  for (std::int32_t k = 0; k < 50; ++k) EXPECT_LE(model.found({0, 1000 * k + 7, 31'000, 400, 400}).size(), 16u);
}

TEST(HashGrid, TakesNoMoreMemoryHoweverOftenBoxesMove) {
  Random random(7);
  Model model(0);
  for (std::uint32_t k = 0; k < 300; ++k) model.insert({k, anywhere(random), anywhere(random), 100, 100});
  std::uint64_t growths = 0;
  for (int round = 0; round < 200; ++round) {
    if (round == 20) growths = model.meter.growths;
    for (int k = 0; k < 100; ++k) {
      Box box = model.boxes[static_cast<std::size_t>(k)];
      model.remove(static_cast<std::size_t>(k));
      box.x = anywhere(random);
      model.insert(box);
    }
  }
  EXPECT_EQ(model.meter.growths, growths);
  model.check({0, 0, 0, 1u << 31, 1u << 31});
}

TEST(HashGrid, IsEmptyBeforeAndAfter) {
  Model model(0);
  EXPECT_TRUE(model.grid.empty());
  EXPECT_TRUE(model.found({0, 0, 0, 1u << 31, 1u << 31}).empty());
  model.insert({3, 5, 5, 1, 1});
  EXPECT_FALSE(model.grid.empty());
  model.remove(0);
  EXPECT_TRUE(model.grid.empty());
  EXPECT_TRUE(model.found({0, 5, 5, 10, 10}).empty());
}

}  // namespace
}  // namespace psim::test
