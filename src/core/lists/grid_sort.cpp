#include "lists/grid_sort.h"

#include <algorithm>
#include <numeric>

#include "base/invariant.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kLargeKey = 0xFFFFFFFEu;
constexpr std::uint32_t kDeadKey = 0xFFFFFFFFu;
constexpr std::uint32_t kSortTaskBodies = 4096;  // bodies a task, a multiple of the block
constexpr std::uint32_t kRangeCells = 16384;     // cells a prefix task

}  // namespace

void GridSort::find_keys(const Grid& grid, float large, Chunk& chunk) {
  const std::uint32_t blocks_end = (chunk.end + kBlock - 1) / kBlock;
  s_.kernels.cell_keys(b_.built.data(), grid.view, key_.data(), chunk.begin / kBlock, blocks_end);
  std::uint32_t low = 0xFFFFFFFFu, high = 0;
  const auto widen = [&](std::uint32_t key) {
    low = std::min(low, key);
    high = std::max(high, key);
  };
  chunk.large = chunk.dead = 0;
  if (b_.dead == 0 && !(large < 1e30f)) {
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) widen(key_[i]);
  } else {
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      if (b_.id[i] == kNoSlot) {
        key_[i] = kDeadKey;
        ++chunk.dead;
      } else if (b_.reach[i] > large) {
        key_[i] = kLargeKey;
        ++chunk.large;
      } else {
        widen(key_[i]);
      }
    }
  }
  chunk.low = low <= high ? low : 0;
  chunk.high = low <= high ? high + 1 : 0;
}

// Cuts the bodies into chunks and finds the keys of each. Returns the room for the windows of all chunks.
std::size_t GridSort::find_windows(const Grid& grid, float large) {
  const std::uint32_t n = b_.count;
  chunks_.resize((n + kSortTaskBodies - 1) / kSortTaskBodies);
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    chunks_[c].begin = static_cast<std::uint32_t>(c) * kSortTaskBodies;
    chunks_[c].end = std::min(n, chunks_[c].begin + kSortTaskBodies);
    find_keys(grid, large, chunks_[c]);
  });
  std::size_t windows = 0;
  for (Chunk& c : chunks_) {
    c.counts = windows;
    windows += c.high - c.low;
  }
  if (windows <= 4 * std::size_t{grid.keys} + 65536) return windows;
  Chunk all{.end = n, .high = grid.keys};  // bodies are shuffled: one chunk sorts all of them
  for (const Chunk& c : chunks_) {
    all.large += c.large;
    all.dead += c.dead;
  }
  chunks_.assign(1, all);
  return grid.keys;
}

// Counts become places: cells in order, within a cell by chunk; then large bodies and dead ones, chunk by chunk.
void GridSort::place_cells(std::uint32_t keys) {
  std::uint32_t* const cells = start_.data() + 1;
  const std::size_t ranges = (keys + kRangeCells - 1) / kRangeCells;
  range_sum_.resize(ranges);
  const auto run = [&](const auto& each) {  // each(range, its cells)
    s_.pool.run(ranges, [&](std::size_t r) {
      const auto low = static_cast<std::uint32_t>(r * kRangeCells);
      each(r, low, std::min(keys - low, kRangeCells) + low);
    });
  };
  run([&](std::size_t r, std::uint32_t low, std::uint32_t high) {
    std::fill(cells + low, cells + high, 0u);
    for (const Chunk& c : chunks_) {
      const std::uint32_t from = std::max(low, c.low), to = std::min(high, c.high);
      std::uint32_t* counts = counts_.data() + c.counts;
      for (std::uint32_t cell = from; cell < to; ++cell) {
        const std::uint32_t before = cells[cell];
        cells[cell] = before + counts[cell - c.low];
        counts[cell - c.low] = before;
      }
    }
    range_sum_[r] = std::accumulate(cells + low, cells + high, 0u);
  });
  const std::uint32_t last = range_sum_.empty() ? 0 : range_sum_.back();
  std::exclusive_scan(range_sum_.begin(), range_sum_.end(), range_sum_.begin(), 0u);
  const std::uint32_t small = range_sum_.empty() ? 0 : range_sum_.back() + last;
  run([&](std::size_t r, std::uint32_t low, std::uint32_t high) {
    std::exclusive_scan(cells + low, cells + high, cells + low, range_sum_[r]);
  });
  start_[0] = 0;
  cells[keys] = small;
  std::uint32_t place = b_.count;
  for (const auto kind : {&Chunk::dead, &Chunk::large}) {
    for (auto c = chunks_.rbegin(); c != chunks_.rend(); ++c) place = (*c).*kind = place - (*c).*kind;
  }
  PSIM_ASSERT(place == small);
}

void GridSort::count(const Grid& grid, float large) {
  key_.reserve(kernels::round_up_block(b_.count));
  start_.reserve_loosely(std::size_t{grid.keys} + 2);
  counts_.reserve_loosely(find_windows(grid, large));
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    const Chunk chunk = chunks_[c];
    std::uint32_t* const counts = counts_.data() + chunk.counts;
    std::fill_n(counts, chunk.high - chunk.low, 0u);
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      if (key_[i] < kLargeKey) ++counts[key_[i] - chunk.low];
    }
  });
  place_cells(grid.keys);
}

// Counts the body itself too; rows beyond the first and the last hold nothing.
double GridSort::neighbours(const Grid& grid) const {
  const std::uint32_t stride = std::max(1u, b_.count / 128), row = grid.view.stride;
  double sum = 0, samples = 0;
  for (std::uint32_t i = stride / 2; i < b_.count; i += stride) {
    const std::uint32_t key = key_[i];
    if (key >= kLargeKey) continue;
    sum += in_three(key) + (key >= row ? in_three(key - row) : 0) + in_three(key + row);
    samples += 1;
  }
  return samples > 0 ? sum / samples : 0;
}

SortCount GridSort::order(std::uint32_t* from, std::uint32_t* keys) {
  if (chunks_.empty()) return {};
  const std::uint32_t small = chunks_.front().large, living = chunks_.front().dead;
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    Chunk chunk = chunks_[c];
    std::uint32_t* const counts = counts_.data() + chunk.counts;
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      const std::uint32_t key = key_[i];
      const std::uint32_t to = key < kLargeKey    ? start()[key] + counts[key - chunk.low]++
                               : key == kLargeKey ? chunk.large++
                                                  : chunk.dead++;
      from[to] = i;
      keys[to] = key;
    }
  });
  return {small, living - small, b_.count - living};
}

}  // namespace psim
