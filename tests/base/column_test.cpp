// Columns: small ones and those whose pages come straight from the system.
#include "base/column.h"

#include <gtest/gtest.h>
#if defined(__linux__)
#include <sys/resource.h>
#endif

#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <utility>

#include "sanitized.h"

namespace psim::test {
namespace {

constexpr std::size_t kSmall = 1000, kLarge = 3 * os::kLargePage / sizeof(std::uint32_t);

bool aligned(const void* p) { return reinterpret_cast<std::uintptr_t>(p) % kernels::kAlign == 0; }

TEST(Column, NewValuesAreZeroAndOldOnesStay) {
  for (const std::size_t first : {kSmall, kLarge}) {
    MemoryMeter meter;
    Column<std::uint32_t> column(meter);
    column.reserve(first);
    ASSERT_TRUE(aligned(column.data()));
    for (std::size_t i = 0; i < first; ++i) {
      ASSERT_EQ(column[i], 0u);
      column[i] = static_cast<std::uint32_t>(i + 1);
    }
    const std::size_t before = column.capacity();
    column.reserve(first + kLarge);
    ASSERT_TRUE(aligned(column.data()));
    for (std::size_t i = 0; i < first; ++i) ASSERT_EQ(column[i], i + 1);
    for (std::size_t i = before; i < column.capacity(); ++i) ASSERT_EQ(column[i], 0u);
    EXPECT_EQ(meter.growths, 2u);
  }
}

// Kernels read a little past the end.
TEST(Column, TheEndCanBeRead) {
  MemoryMeter meter;
  Column<std::uint8_t> column(meter);
  for (const std::size_t n : {os::kLargePage - 64, os::kLargePage, os::kLargePage + 1}) {
    column.reserve(n);
    unsigned sum = 0;
    for (std::size_t k = 0; k < kernels::kReadPad; ++k) sum += column.data()[column.capacity() + k];
    EXPECT_EQ(sum, 0u);
  }
}

TEST(Column, TheMeterCountsWhatThereIs) {
  MemoryMeter meter;
  Column<float> small(meter), large(meter);
  small.reserve(kSmall);
  large.reserve(kLarge);
  EXPECT_EQ(meter.bytes, small.bytes() + large.bytes());
  small.swap(large);
  EXPECT_GE(small.bytes(), kLarge * sizeof(float));
  small.release_if_short(kSmall);
  EXPECT_FALSE(small.empty());
  small.release_if_short(2 * kLarge);
  EXPECT_TRUE(small.empty());
  Column<float> moved = std::move(large);
  EXPECT_EQ(meter.bytes, moved.bytes());
  moved.release();
  EXPECT_EQ(meter.bytes, 0u);
}

TEST(Column, BeyondTheMostIsNoMemoryAndLosesNothing) {
  MemoryMeter meter;
  meter.most = 4 * os::kLargePage;
  Column<std::uint32_t> column(meter);
  column.reserve(kLarge);
  column[kLarge - 1] = 7;
  EXPECT_THROW(column.reserve(2 * kLarge), std::bad_alloc);
  EXPECT_EQ(column[kLarge - 1], 7u);
  EXPECT_EQ(meter.bytes, column.bytes());
}

#if defined(__linux__) && defined(__x86_64__)
// Pages that the system gives while the column is filled.
long faults_of_filling(bool touched) {
  MemoryMeter meter;
  Column<std::uint32_t> column(meter);
  constexpr std::size_t kMany = 24 * kLarge;  // 144 MiB
  {
    column.reserve(kSmall);
    column[7] = 7;
    std::optional<TouchedRoom> room;
    if (touched) room.emplace(meter);
    column.reserve(kMany);
  }
  const auto faults = [] {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return used.ru_minflt;
  };
  const long before = faults();
  for (std::size_t i = 0; i < kMany; i += 1024) column[i] = static_cast<std::uint32_t>(i);
  EXPECT_EQ(column[7], 7u);
  EXPECT_FALSE(meter.touches);
  return faults() - before;
}

TEST(Column, TouchedRoomIsThereBeforeItIsUsed) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer has pages of its own";
  EXPECT_LE(faults_of_filling(true), 16);
  EXPECT_GE(faults_of_filling(false), 40);  // with pages of 2 MiB, too
}
#endif

TEST(Pages, MoreThanThereIsIsNoMemory) {
  EXPECT_THROW(os::take_pages(std::size_t{1} << 60), std::bad_alloc);
  void* const pages = os::take_pages(os::kLargePage + 1);
  EXPECT_EQ(static_cast<char*>(pages)[os::kLargePage], 0);
  os::give_pages_back(pages, os::kLargePage + 1);
}

}  // namespace
}  // namespace psim::test
