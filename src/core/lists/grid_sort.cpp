#include "lists/grid_sort.h"

#include <algorithm>
#include <array>
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

void GridSort::find_keys(const Grid& grid, float large, bool special, Chunk& chunk) {
  const std::uint32_t blocks_end = (chunk.end + kBlock - 1) / kBlock;
  k_.cell_keys(b_.built.data(), grid.view, key_.data(), chunk.begin / kBlock, blocks_end);
  std::uint32_t low = 0xFFFFFFFFu, high = 0;
  const auto widen = [&](std::uint32_t key) {
    low = std::min(low, key);
    high = std::max(high, key);
  };
  chunk.large = chunk.dead = 0;
  if (!special) {
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
  const bool special = b_.dead != 0 || large < 1e30f;
  pool_.run(chunks_.size(), [&](std::size_t c) {
    chunks_[c].begin = static_cast<std::uint32_t>(c) * kSortTaskBodies;
    chunks_[c].end = std::min(n, chunks_[c].begin + kSortTaskBodies);
    find_keys(grid, large, special, chunks_[c]);
  });
  std::size_t windows = 0;
  for (Chunk& c : chunks_) {
    c.counts = windows;
    windows += c.high - c.low;
  }
  if (windows <= 4 * std::size_t{grid.keys} + 65536) return windows;
  Chunk all;  // bodies are shuffled: one chunk sorts all of them
  all.end = n;
  for (const Chunk& c : chunks_) {
    all.large += c.large;
    all.dead += c.dead;
    if (c.high == c.low) continue;
    all.low = all.high == all.low ? c.low : std::min(all.low, c.low);
    all.high = std::max(all.high, c.high);
  }
  chunks_.assign(1, all);
  return all.high - all.low;
}

void GridSort::count_chunk(const Chunk& chunk) {
  std::uint32_t* counts = counts_.data() + chunk.counts;
  std::fill(counts, counts + (chunk.high - chunk.low), 0u);
  for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
    if (key_[i] < kLargeKey) ++counts[key_[i] - chunk.low];
  }
}

// Counts become places: cells in order, within a cell by chunk.
void GridSort::place_cells(std::uint32_t keys) {
  std::uint32_t* const cells = start_.data() + 1;
  const std::size_t ranges = (keys + kRangeCells - 1) / kRangeCells;
  range_sum_.resize(ranges);
  const auto run = [&](const auto& each) {  // each(range, its cells)
    pool_.run(ranges, [&](std::size_t r) {
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
}

void GridSort::count(const Grid& grid, float large) {
  key_.reserve(kernels::round_up_block(b_.count));
  start_.reserve_loosely(std::size_t{grid.keys} + 2);
  counts_.reserve_loosely(find_windows(grid, large));
  pool_.run(chunks_.size(), [&](std::size_t c) { count_chunk(chunks_[c]); });
  place_cells(grid.keys);
}

// Counts the body itself too; rows beyond the first and the last hold nothing.
double GridSort::neighbours(const Grid& grid) const {
  const std::uint32_t stride = std::max(1u, b_.count / 128), row = grid.view.stride;
  double sum = 0, samples = 0;
  for (std::uint32_t i = stride / 2; i < b_.count; i += stride) {
    const std::uint32_t key = key_[i];
    if (key >= kLargeKey) continue;
    const std::uint32_t* const here = start() + key;
    sum += here[2] - here[-1];
    if (key >= row) sum += (here - row)[2] - (here - row)[-1];
    if (key + row + 2 < grid.keys) sum += here[row + 2] - here[row - 1];
    samples += 1;
  }
  return samples > 0 ? sum / samples : 0;
}

// Copies the columns of one body to its new slot.
template <bool kRadii, bool kTurns>
inline void GridSort::move_one(const BodyStore& b, std::size_t to, std::size_t i) {
  const auto copy2 = [&](auto* target, const auto* source) {
    target[2 * to] = source[2 * i];
    target[2 * to + 1] = source[2 * i + 1];
  };
  copy2(pos_.data(), b.pos.data());
  copy2(vel_.data(), b.vel.data());
  copy2(disp_.data(), b.disp.data());
  id_[to] = b.id[i];
  reach_[to] = b.reach[i];
  if constexpr (kRadii) radius_[to] = b.radius[i];
  if constexpr (kTurns) {
    rim_speed_[to] = b.rim_speed[i];
    angle_[to] = b.angle[i];
  }
}

template <bool kRadii, bool kTurns>
void GridSort::scatter_chunk(const BodyStore& b, const Chunk& chunk, std::uint32_t large_at, std::uint32_t dead_at) {
  std::uint32_t* counts = counts_.data() + chunk.counts;
  const std::uint32_t* cell_start = start();
  for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
    const std::uint32_t key = key_[i];
    std::uint32_t to;
    if (key < kLargeKey) {
      to = cell_start[key] + counts[key - chunk.low]++;
    } else if (key == kLargeKey) {
      to = large_at++;
    } else {
      to = dead_at++;
    }
    key_sorted_[to] = key;
    from_[to] = i;
    move_one<kRadii, kTurns>(b, to, i);
  }
}

template <bool kRadii, bool kTurns>
void GridSort::scatter_listed(const BodyStore& b, std::size_t begin, std::size_t end) {
  for (std::size_t to = begin; to < end; ++to) move_one<kRadii, kTurns>(b, to, from_[to]);
}

// The member for the columns that there are, out of those for <radii, rotation>: neither, rotation, radii, both.
template <class Scatter>
Scatter GridSort::for_columns(bool mixed_radii, const std::array<Scatter, 4>& scatters) const {
  return scatters[(mixed_radii ? 2u : 0u) + (b_.rim_speed.empty() ? 0u : 1u)];
}

void GridSort::reserve(bool mixed_radii) {
  const std::size_t padded = kernels::round_up_block(b_.count);
  key_.reserve(padded);
  key_sorted_.reserve(padded);
  from_.reserve(padded);
  pos_.reserve(2 * padded);
  vel_.reserve(2 * padded);
  disp_.reserve(2 * padded);
  id_.reserve(padded);
  reach_.reserve(padded);
  if (mixed_radii) radius_.reserve(padded);
  if (!b_.rim_speed.empty()) {
    rim_speed_.reserve(padded);
    angle_.reserve(padded);
  }
}

std::uint32_t GridSort::move(bool mixed_radii, std::size_t begin, std::size_t end) {
  std::uint32_t larges = 0, dead = 0;
  for (const Chunk& c : chunks_) {
    larges += c.large;
    dead += c.dead;
  }
  const std::uint32_t small = b_.count - larges - dead;

  // Large and dead bodies are few: their places are found chunk by chunk.
  std::vector<std::uint32_t>& large_at = range_sum_;
  if (begin == 0) {
    reserve(mixed_radii);
    listed_.forget();
    large_at.clear();
    std::uint32_t next_large = small, next_dead = small + larges;
    for (const Chunk& c : chunks_) {
      large_at.insert(large_at.end(), {next_large, next_dead});
      next_large += c.large;
      next_dead += c.dead;
    }
    PSIM_ASSERT(next_dead == b_.count);
  }
  const auto scatter = for_columns<decltype(&GridSort::scatter_chunk<true, true>)>(
      mixed_radii, {&GridSort::scatter_chunk<false, false>, &GridSort::scatter_chunk<false, true>,
                    &GridSort::scatter_chunk<true, false>, &GridSort::scatter_chunk<true, true>});
  pool_.run(end - begin, [&](std::size_t n) {
    const std::size_t c = begin + n;
    (this->*scatter)(b_, chunks_[c], large_at[2 * c], large_at[2 * c + 1]);
  });
  if (end == moves()) finish(small + larges, mixed_radii);
  return small;
}

std::uint32_t GridSort::sort(float large, bool mixed_radii) {
  reserve(mixed_radii);
  const SortCount sorted = listed_.sort(large, from_.data(), key_sorted_.data());
  const std::size_t n = b_.count;
  const auto scatter = for_columns<decltype(&GridSort::scatter_listed<true, true>)>(
      mixed_radii, {&GridSort::scatter_listed<false, false>, &GridSort::scatter_listed<false, true>,
                    &GridSort::scatter_listed<true, false>, &GridSort::scatter_listed<true, true>});
  pool_.run((n + kSortTaskBodies - 1) / kSortTaskBodies,
            [&](std::size_t c) { (this->*scatter)(b_, c * kSortTaskBodies, std::min(n, (c + 1) * kSortTaskBodies)); });
  finish(sorted.small + sorted.large, mixed_radii);
  return sorted.small;
}

// Swaps the moved columns into the body store.
void GridSort::finish(std::uint32_t count, bool mixed_radii) {
  b_.pos.swap(pos_);
  b_.vel.swap(vel_);
  b_.disp.swap(disp_);
  b_.id.swap(id_);
  b_.reach.swap(reach_);
  if (mixed_radii) b_.radius.swap(radius_);
  if (!b_.rim_speed.empty()) {
    b_.rim_speed.swap(rim_speed_);
    b_.angle.swap(angle_);
  }
  b_.count = count;
  b_.dead = 0;
  b_.slots_stale = true;
  // Both halves of every swapped pair must have room for what comes next.
  b_.reserve_slots(0);
  if (b_.count != 0) b_.pad_tail();
}

}  // namespace psim
