#include "lists/grid_sort.h"

#include <algorithm>

#include "base/invariant.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kLargeKey = 0xFFFFFFFEu;
constexpr std::uint32_t kDeadKey = 0xFFFFFFFFu;
constexpr std::uint32_t kSortTaskBodies = 4096;  // bodies a task, a multiple of the block
constexpr std::uint32_t kRangeCells = 16384;     // cells a prefix task

}  // namespace

void GridSort::find_keys(const BodyStore& bodies, const Grid& grid, float large, bool special,
                         const kernels::KernelTable& k, Chunk& chunk) {
  const std::uint32_t blocks_end = (chunk.end + kBlock - 1) / kBlock;
  k.cell_keys(bodies.built.data(), grid.view, key_.data(), chunk.begin / kBlock, blocks_end);
  std::uint32_t low = 0xFFFFFFFFu, high = 0;
  chunk.large = chunk.dead = 0;
  if (special) {
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      if (bodies.id[i] == kNoSlot) {
        key_[i] = kDeadKey;
        ++chunk.dead;
      } else if (bodies.reach[i] > large) {
        key_[i] = kLargeKey;
        ++chunk.large;
      } else {
        low = std::min(low, key_[i]);
        high = std::max(high, key_[i]);
      }
    }
  } else {
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      low = std::min(low, key_[i]);
      high = std::max(high, key_[i]);
    }
  }
  chunk.low = low <= high ? low : 0;
  chunk.high = low <= high ? high + 1 : 0;
}

void GridSort::count_chunk(const Chunk& chunk) {
  std::uint32_t* counts = counts_.data() + chunk.counts;
  std::fill(counts, counts + (chunk.high - chunk.low), 0u);
  for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
    if (key_[i] < kLargeKey) ++counts[key_[i] - chunk.low];
  }
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
    spin_[to] = b.rim_speed[i];
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

void GridSort::forget(bool radii, bool rotation) {
  if (radii) radius_.release();
  if (!rotation) return;
  spin_.release();
  angle_.release();
}

void GridSort::reserve(const BodyStore& b, bool mixed_radii) {
  const std::size_t padded = kernels::round_up_block(b.count);
  key_.reserve(padded);
  key_sorted_.reserve(padded);
  from_.reserve(padded);
  pos_.reserve(2 * padded);
  vel_.reserve(2 * padded);
  disp_.reserve(2 * padded);
  id_.reserve(padded);
  reach_.reserve(padded);
  if (mixed_radii) radius_.reserve(padded);
  if (!b.rim_speed.empty()) {
    spin_.reserve(padded);
    angle_.reserve(padded);
  }
}

void GridSort::count(const BodyStore& b, const Grid& grid, float large, const kernels::KernelTable& k,
                     WorkerPool& pool) {
  const std::uint32_t n = b.count;
  key_.reserve(kernels::round_up_block(n));
  start_.reserve_loosely(std::size_t{grid.keys} + 2);

  std::size_t chunk_count = (n + kSortTaskBodies - 1) / kSortTaskBodies;
  chunks_.resize(chunk_count);
  for (std::size_t c = 0; c < chunk_count; ++c) {
    chunks_[c].begin = static_cast<std::uint32_t>(c) * kSortTaskBodies;
    chunks_[c].end = std::min(n, chunks_[c].begin + kSortTaskBodies);
  }
  const bool special = b.dead != 0 || large < 1e30f;
  pool.run(chunk_count, [&](std::size_t c) { find_keys(b, grid, large, special, k, chunks_[c]); });
  std::size_t windows = 0;
  for (Chunk& c : chunks_) {
    c.counts = windows;
    windows += c.high - c.low;
  }
  if (windows > 4 * std::size_t{grid.keys} + 65536) {  // bodies are shuffled: one chunk sorts all of them
    Chunk all = chunks_[0];
    all.begin = 0;
    all.end = n;
    for (const Chunk& c : chunks_) {
      if (c.high == c.low) continue;
      all.low = all.high == all.low ? c.low : std::min(all.low, c.low);
      all.high = std::max(all.high, c.high);
    }
    all.large = all.dead = 0;
    for (const Chunk& c : chunks_) {
      all.large += c.large;
      all.dead += c.dead;
    }
    all.counts = 0;
    chunks_.assign(1, all);
    chunk_count = 1;
    windows = all.high - all.low;
  }
  counts_.reserve_loosely(windows);
  pool.run(chunk_count, [&](std::size_t c) { count_chunk(chunks_[c]); });

  // Counts become places: cells in order, within a cell by chunk.
  std::uint32_t* cells = start_.data() + 1;
  const std::size_t ranges = (grid.keys + kRangeCells - 1) / kRangeCells;
  range_sum_.resize(ranges);
  pool.run(ranges, [&](std::size_t r) {
    const auto low = static_cast<std::uint32_t>(r * kRangeCells);
    const auto high = static_cast<std::uint32_t>(std::min<std::size_t>(grid.keys, (r + 1) * std::size_t{kRangeCells}));
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
    std::uint32_t sum = 0;
    for (std::uint32_t cell = low; cell < high; ++cell) sum += cells[cell];
    range_sum_[r] = sum;
  });
  std::uint32_t small = 0;
  for (std::uint32_t& sum : range_sum_) {
    const std::uint32_t here = sum;
    sum = small;
    small += here;
  }
  pool.run(ranges, [&](std::size_t r) {
    const auto low = static_cast<std::uint32_t>(r * kRangeCells);
    const auto high = static_cast<std::uint32_t>(std::min<std::size_t>(grid.keys, (r + 1) * std::size_t{kRangeCells}));
    std::uint32_t run = range_sum_[r];
    for (std::uint32_t cell = low; cell < high; ++cell) {
      const std::uint32_t here = cells[cell];
      cells[cell] = run;
      run += here;
    }
  });
  start_[0] = 0;
  cells[grid.keys] = small;
}

// Counts the body itself too; rows beyond the first and the last hold nothing.
double GridSort::neighbours(const BodyStore& b, const Grid& grid) const {
  const std::uint32_t stride = std::max(1u, b.count / 128), row = grid.view.stride;
  double sum = 0, samples = 0;
  for (std::uint32_t i = stride / 2; i < b.count; i += stride) {
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

std::uint32_t GridSort::move(BodyStore& b, bool mixed_radii, WorkerPool& pool) {
  return move(b, mixed_radii, 0, moves(), pool);
}

std::uint32_t GridSort::move(BodyStore& b, bool mixed_radii, std::size_t begin, std::size_t end, WorkerPool& pool) {
  const std::size_t chunk_count = chunks_.size();
  std::uint32_t larges = 0, dead = 0;
  for (const Chunk& c : chunks_) {
    larges += c.large;
    dead += c.dead;
  }
  const std::uint32_t small = b.count - larges - dead;

  // Large and dead bodies are few: their places are found chunk by chunk.
  std::vector<std::uint32_t>& large_at = range_sum_;
  if (begin == 0) {
    reserve(b, mixed_radii);
    listed_.forget();
    large_at.resize(2 * chunk_count);
    std::uint32_t next_large = small, next_dead = small + larges;
    for (std::size_t c = 0; c < chunk_count; ++c) {
      large_at[2 * c] = next_large;
      large_at[2 * c + 1] = next_dead;
      next_large += chunks_[c].large;
      next_dead += chunks_[c].dead;
    }
    PSIM_ASSERT(next_dead == b.count);
  }
  const bool turns = !b.rim_speed.empty();
  const auto scatter = mixed_radii
                           ? (turns ? &GridSort::scatter_chunk<true, true> : &GridSort::scatter_chunk<true, false>)
                           : (turns ? &GridSort::scatter_chunk<false, true> : &GridSort::scatter_chunk<false, false>);
  pool.run(end - begin, [&](std::size_t n) {
    const std::size_t c = begin + n;
    (this->*scatter)(b, chunks_[c], large_at[2 * c], large_at[2 * c + 1]);
  });
  if (end == chunk_count) finish(b, small + larges, mixed_radii);
  return small;
}

std::uint32_t GridSort::sort(BodyStore& b, float large, bool mixed_radii, WorkerPool& pool) {
  reserve(b, mixed_radii);
  const SortCount sorted = listed_.sort(b, large, from_.data(), key_sorted_.data(), pool);
  const std::uint32_t n = b.count;
  const bool turns = !b.rim_speed.empty();
  const auto scatter = mixed_radii
                           ? (turns ? &GridSort::scatter_listed<true, true> : &GridSort::scatter_listed<true, false>)
                           : (turns ? &GridSort::scatter_listed<false, true> : &GridSort::scatter_listed<false, false>);
  pool.run((n + kSortTaskBodies - 1) / kSortTaskBodies, [&](std::size_t c) {
    (this->*scatter)(b, c * kSortTaskBodies, std::min<std::size_t>(n, (c + 1) * std::size_t{kSortTaskBodies}));
  });
  finish(b, sorted.small + sorted.large, mixed_radii);
  return sorted.small;
}

// Swaps the moved columns into the body store.
void GridSort::finish(BodyStore& b, std::uint32_t count, bool mixed_radii) {
  b.pos.swap(pos_);
  b.vel.swap(vel_);
  b.disp.swap(disp_);
  b.id.swap(id_);
  b.reach.swap(reach_);
  if (mixed_radii) b.radius.swap(radius_);
  if (!b.rim_speed.empty()) {
    b.rim_speed.swap(spin_);
    b.angle.swap(angle_);
  }
  b.count = count;
  b.dead = 0;
  b.slots_stale = true;
  // Both halves of every swapped pair must have room for what comes next.
  b.reserve_slots(0);
  if (b.count != 0) b.pad_tail();
}

}  // namespace psim
