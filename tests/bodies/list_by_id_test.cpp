// ListById against a map, by random additions and removals.
#include "bodies/list_by_id.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace psim::test {
namespace {

struct Entry {
  std::uint32_t id = 0;
  int value = 0;
};

TEST(ListById, HoldsWhatAMapHolds) {
  std::mt19937 random(1);
  ListById<Entry> list;
  std::map<std::uint32_t, int> map;
  for (int k = 0; k < 50'000; ++k) {
    const std::uint32_t most = k / 10'000 % 2 == 0 ? 2000 : 20;  // it grows and shrinks
    const auto id = static_cast<std::uint32_t>(random() % 2000);
    if (map.contains(id)) {
      ASSERT_EQ(list.at(id).value, map[id]);
      list.remove(id);
      map.erase(id);
    } else if (map.size() < most) {
      list.add({id, k});
      map[id] = k;
    }
    ASSERT_EQ(list.size(), map.size());
    if (k % 1000 != 0) continue;
    ASSERT_TRUE(list.index());
    for (const auto& [key, value] : list) ASSERT_EQ(map.at(key), value);
  }
  for (const auto& [id, value] : map) ASSERT_EQ(list.at(id).value, value);
}

TEST(ListById, FindsThatAnIdStandsTwice) {
  ListById<Entry> list;
  for (const std::uint32_t id : {3u, 8u, 5u}) list.add({id, 0});
  EXPECT_TRUE(list.index());
  list.entries().push_back({8, 1});
  EXPECT_FALSE(list.index());
}

}  // namespace
}  // namespace psim::test
