#include "bodies/hash_grid.h"

#include <algorithm>
#include <iterator>

namespace psim {
namespace {

std::uint64_t mixed(std::uint64_t key) {  // the last step of SplitMix64
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9u;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
  return key ^ (key >> 31);
}

int along_y(int level, int shift) { return std::clamp(level + shift, 0, 31); }

// The top bit tells a cell from a free place.
std::uint64_t key_of(int level, std::uint32_t x, std::uint32_t y) {
  return 1ull << 63 | static_cast<std::uint64_t>(level) << 58 | static_cast<std::uint64_t>(x) << 29 | y;
}

constexpr int kTop = 31;  // a single cell for boxes that are larger than the cells of all other levels

std::uint64_t key_at(int level, int shift, std::int32_t x, std::int32_t y) {
  if (level == kTop) return key_of(kTop, 0, 0);
  const int ly = std::max(along_y(level, shift), 3);
  return key_of(level, static_cast<std::uint32_t>(x) >> level, static_cast<std::uint32_t>(y) >> ly);
}

}  // namespace

std::uint32_t HashGrid::find(std::uint64_t key) const {
  std::size_t at = mixed(key) & (size_ - 1);
  while (key_[at] != key && key_[at] != 0) at = (at + 1) & (size_ - 1);
  return static_cast<std::uint32_t>(at);
}

// Builds the table anew, without the cells that became empty.
void HashGrid::rehash(std::size_t size) {
  moved_.clear();
  for (std::size_t i = 0; i < size_; ++i) {
    if (key_[i] != 0 && head_[i] != kNone) moved_.emplace_back(key_[i], head_[i]);
  }
  key_.reserve(size);
  head_.reserve(size);
  size_ = size;
  std::fill_n(key_.data(), size, 0u);
  std::fill_n(head_.data(), size, kNone);
  used_ = moved_.size();
  for (const auto& [key, head] : moved_) {
    const std::uint32_t at = find(key);
    key_[at] = key;
    head_[at] = head;
    for (std::uint32_t k = head; k != kNone; k = next_[k]) cell_[k] = at;
  }
}

std::size_t HashGrid::size_for(std::size_t boxes) {
  std::size_t size = 64;
  while (size < 4 * boxes) size *= 2;
  return size;
}

void HashGrid::make_room(std::uint32_t numbers, std::size_t boxes) {
  next_.reserve(numbers);
  cell_.reserve(numbers);
  const std::size_t size = size_for(boxes / 2 + 1);  // the table is half full then
  if (size > size_) rehash(size);
}

void HashGrid::insert(std::uint32_t number, std::int32_t x, std::int32_t y, std::uint32_t half_x,
                      std::uint32_t half_y) {
  if (2 * (used_ + 1) > size_) {
    rehash(std::max(size_for(count_ + 1), size_));
  }
  next_.reserve(std::size_t{number} + 1);
  cell_.reserve(std::size_t{number} + 1);
  int level = kLeast;
  while (level < kTop && ((1ull << level) < 2ull * half_x || (1ull << along_y(level, shift_)) < 2ull * half_y)) {
    ++level;
  }
  const std::uint64_t key = key_at(level, shift_, x, y);
  const std::uint32_t at = find(key);
  if (key_[at] == 0) {
    key_[at] = key;
    head_[at] = kNone;
    ++used_;
  }
  next_[number] = head_[at];
  cell_[number] = at;
  head_[at] = number;
  ++of_level_[level];
  ++count_;
}

void HashGrid::remove(std::uint32_t number) {
  const std::uint32_t at = cell_[number];
  --of_level_[(key_[at] >> 58) & 31];
  --count_;
  std::uint32_t* link = &head_[at];
  while (*link != number) link = &next_[*link];
  *link = next_[number];
}

void HashGrid::clear() {
  std::fill_n(key_.data(), size_, 0u);
  std::fill_n(head_.data(), size_, kNone);
  std::fill(std::begin(of_level_), std::end(of_level_), 0u);
  used_ = count_ = 0;
}

void HashGrid::near(std::int32_t x, std::int32_t y, std::uint32_t half_x, std::uint32_t half_y,
                    std::vector<std::uint32_t>& out) const {
  const auto take = [&](std::size_t at) {
    for (std::uint32_t k = head_[at]; k != kNone; k = next_[k]) out.push_back(k);
  };
  if (of_level_[kTop] != 0) take(find(key_of(kTop, 0, 0)));
  for (int level = kLeast; level < kTop; ++level) {
    if (of_level_[level] == 0) continue;
    const int ly = std::max(along_y(level, shift_), kLeast);
    // First cell and number of cells along an axis; cells wrap with the lattice.
    const auto span = [](std::int32_t at, std::uint32_t half, int k, std::uint32_t& first) {
      const std::uint64_t reach = std::uint64_t{half} + (1ull << k) / 2;
      const std::uint64_t cells = 1ull << (32 - k);
      const std::uint64_t low =
          (static_cast<std::uint32_t>(at) + (1ull << 32) - std::min(reach, std::uint64_t{1} << 31));
      first = static_cast<std::uint32_t>(low) >> k;
      const std::uint64_t offset = low & ((1ull << k) - 1);
      return std::min(cells, ((offset + 2 * reach) >> k) + 1);
    };
    std::uint32_t cx = 0, cy = 0;
    const std::uint64_t nx = span(x, half_x, level, cx), ny = span(y, half_y, ly, cy);
    const std::uint32_t mask_x = static_cast<std::uint32_t>((1ull << (32 - level)) - 1);
    const std::uint32_t mask_y = static_cast<std::uint32_t>((1ull << (32 - ly)) - 1);
    if (nx * ny <= used_) {
      for (std::uint64_t j = 0; j < ny; ++j) {
        for (std::uint64_t i = 0; i < nx; ++i) {
          const std::uint64_t key = key_of(level, (cx + static_cast<std::uint32_t>(i)) & mask_x,
                                           (cy + static_cast<std::uint32_t>(j)) & mask_y);
          const std::uint32_t at = find(key);
          if (key_[at] == key) take(at);
        }
      }
      continue;
    }
    // The box covers more cells than are in use: all of these are looked at.
    for (std::size_t at = 0; at < size_; ++at) {
      if (key_[at] == 0 || static_cast<int>((key_[at] >> 58) & 31) != level) continue;
      const auto kx = static_cast<std::uint32_t>(key_[at] >> 29) & 0x1FFFFFFFu;
      const auto ky = static_cast<std::uint32_t>(key_[at]) & 0x1FFFFFFFu;
      if (((kx - cx) & mask_x) < nx && ((ky - cy) & mask_y) < ny) take(at);
    }
  }
}

}  // namespace psim
