#include "bodies/hash_grid.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

#include "base/sort_keys.h"

namespace psim {
namespace {

std::uint64_t cell_of(int level, std::uint64_t x, std::uint64_t y) {
  return static_cast<std::uint64_t>(level) << 58 | x << 29 | y;
}

int level_of(std::uint64_t cell) { return static_cast<int>(cell >> 58); }

// The cells of a level that a box may meet along an axis. Cells wrap with the lattice.
class Span {
 public:
  Span(std::int32_t middle, std::uint32_t half, int level) : mask_((1ull << (32 - level)) - 1) {
    constexpr std::uint64_t kHalf = 1ull << 31;  // of the lattice
    const std::uint64_t reach = std::uint64_t{half} + (1ull << level) / 2;
    const std::uint64_t low = static_cast<std::uint32_t>(middle) + (1ull << 32) - std::min(reach, kHalf);
    const std::uint64_t offset = low & ((1ull << level) - 1);
    first_ = (low >> level) & mask_;
    count = std::min(mask_ + 1, ((offset + 2 * reach) >> level) + 1);
  }
  std::uint64_t operator[](std::uint64_t k) const { return (first_ + k) & mask_; }
  bool has(std::uint64_t cell) const { return ((cell - first_) & mask_) < count; }

  std::uint64_t count;

 private:
  std::uint64_t mask_, first_;
};

}  // namespace

int HashGrid::level_y(int level) const { return level == kTop ? kTop : std::clamp(level + shift_, kLeast, kTop); }

std::uint32_t& HashGrid::first_of(std::uint64_t cell) { return first_[mixed(cell) & (size_ - 1)]; }

// Makes a table of so many places or more, and puts the boxes into it.
void HashGrid::grow(std::size_t places) {
  std::vector<std::uint32_t> boxes;
  for (std::size_t at = 0; at < size_; ++at) {
    for (std::uint32_t k = first_[at]; k != kNone; k = next_[k]) boxes.push_back(k);
  }
  const std::size_t size = std::bit_ceil(std::max<std::size_t>(places, 64));
  first_.reserve(size);
  size_ = size;
  std::fill_n(first_.data(), size_, kNone);
  for (const std::uint32_t k : boxes) next_[k] = std::exchange(first_of(cell_[k]), k);
}

void HashGrid::make_room(std::uint32_t numbers, std::size_t boxes) {
  next_.reserve(numbers);
  cell_.reserve(numbers);
  const std::size_t all = count_ + boxes;
  if (2 * all > size_) grow(count_ == 0 ? 2 * all : 4 * all);
}

void HashGrid::insert(std::uint32_t number, std::int32_t x, std::int32_t y, std::uint32_t half_x,
                      std::uint32_t half_y) {
  if (2 * (count_ + 1) > size_) grow(4 * (count_ + 1));
  next_.reserve(std::size_t{number} + 1);
  cell_.reserve(std::size_t{number} + 1);
  int level = kLeast;
  while (level < kTop && ((1ull << level) < 2ull * half_x || (1ull << level_y(level)) < 2ull * half_y)) ++level;
  const auto along = [](std::int32_t at, int k) { return std::uint64_t{static_cast<std::uint32_t>(at)} >> k; };
  cell_[number] = cell_of(level, along(x, level), along(y, level_y(level)));
  next_[number] = std::exchange(first_of(cell_[number]), number);
  ++of_level_[level];
  ++count_;
}

void HashGrid::remove(std::uint32_t number) {
  --of_level_[level_of(cell_[number])];
  --count_;
  std::uint32_t* link = &first_of(cell_[number]);
  while (*link != number) link = &next_[*link];
  *link = next_[number];
}

void HashGrid::clear() {
  std::fill_n(first_.data(), size_, kNone);
  std::fill(std::begin(of_level_), std::end(of_level_), 0u);
  count_ = 0;
}

void HashGrid::near(std::int32_t x, std::int32_t y, std::uint32_t half_x, std::uint32_t half_y,
                    std::vector<std::uint32_t>& out) const {
  const auto take = [&](std::size_t at, const auto& wanted) {
    for (std::uint32_t k = first_[at]; k != kNone; k = next_[k]) {
      if (wanted(cell_[k])) out.push_back(k);
    }
  };
  for (int level = kLeast; level <= kTop; ++level) {
    if (of_level_[level] == 0) continue;
    const Span along_x(x, half_x, level), along_y(y, half_y, level_y(level));
    if (along_x.count * along_y.count <= size_) {
      for (std::uint64_t j = 0; j < along_y.count; ++j) {
        for (std::uint64_t i = 0; i < along_x.count; ++i) {
          const std::uint64_t cell = cell_of(level, along_x[i], along_y[j]);
          take(mixed(cell) & (size_ - 1), [cell](std::uint64_t other) { return other == cell; });
        }
      }
      continue;
    }
    // The box covers more cells than the table has places: all boxes are looked at.
    const auto covered = [&](std::uint64_t cell) {
      constexpr std::uint64_t kAxis = (1ull << 29) - 1;
      return level_of(cell) == level && along_x.has((cell >> 29) & kAxis) && along_y.has(cell & kAxis);
    };
    for (std::size_t at = 0; at < size_; ++at) take(at, covered);
  }
}

}  // namespace psim
