#include "lists/cell_list.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/elementary.h"
#include "base/invariant.h"
#include "base/sort_keys.h"

namespace psim {
namespace {

constexpr std::uint32_t kCellTaskBodies = 16384;  // bodies a task
constexpr std::uint32_t kMostChunks = 32;         // bounds the memory of counts by chunk and digit
constexpr std::uint32_t kTaskCells = 4096;
constexpr int kDigitBits = 12;
constexpr double kOtherAxis = 1.5;  // rows change their direction when the other axis is longer by this factor
// Cells keep their places while they are not much too wide, and the box has some
// room to grow.
constexpr double kFirstEdge = 1.04, kLeastEdge = 0.8, kRoom = 0.03;
constexpr std::uint32_t kMoved = 8;  // if more than one body in kMoved changed its cell, all are sorted
constexpr int kPatience = 7;
constexpr std::uint64_t kNoName = 0xFFFFFFFFFFFFFFFFu;
constexpr std::uint32_t kSentinels = 4;  // names behind the last cell that belong to no cell

}  // namespace

// Whether the cells of an axis can keep their places.
bool CellList::serves(int axis, const std::int32_t box[4], double edge, bool periodic) const {
  const CellAxis& a = axis_[axis];
  if (!stays_ || !(edge <= a.width && edge >= kLeastEdge * a.width)) return false;
  const std::uint64_t last = a.at(box[2 + axis]);
  return periodic || (box[axis] >= a.low && last < a.cells && 4 * (last - a.at(box[axis])) + 64 >= a.cells);
}

bool CellList::lay(const std::int32_t box[4], const double edge[2], bool periodic, std::uint32_t bodies) {
  const int slot_bits = 32 - std::countl_zero(bodies);
  // A name and a slot share 64 bits. If a box would have more cells than fit,
  // they are made wider.
  double cells = 1;
  for (int k = 0; k < 2; ++k) {
    const double steps = periodic ? 0x1p32 : static_cast<double>(box[2 + k]) - box[k];
    cells *= steps / edge[k] + 64;
  }
  const double wider = std::sqrt(greater(cells / std::ldexp(0.5, 64 - slot_bits), 1.0));
  const double least[2] = {wider * edge[0], wider * edge[1]};
  if (periodic == periodic_ && slot_bits == slot_bits_ && serves(0, box, least[0], periodic) &&
      serves(1, box, least[1], periodic)) {
    return true;
  }
  forget();
  periodic_ = periodic;
  slot_bits_ = slot_bits;
  for (int k = 0; k < 2; ++k) {
    CellAxis& a = axis_[k];
    const double width = kFirstEdge * least[k];
    if (periodic) {
      a.low = std::numeric_limits<std::int32_t>::min();
      a.per = a.cells = static_cast<std::uint64_t>(0x1p32 / width);
    } else {
      const double room = kRoom * (static_cast<double>(box[2 + k]) - box[k]) + 8 * width;
      const auto steps = [](double at) { return static_cast<std::int32_t>(std::clamp(at, -0x1p31, 0x1p31 - 1)); };
      a.low = steps(box[k] - room);
      a.per = static_cast<std::uint64_t>(0x1p32 / std::ceil(width));
      a.cells = a.at(steps(box[2 + k] + room)) + 1;
    }
    if (a.per == 0) return false;
    a.width = 0x1p32 / static_cast<double>(a.per);
  }
  const auto longer = [&](int k) {
    return static_cast<double>(axis_[k].cells) > kOtherAxis * static_cast<double>(axis_[1 - k].cells);
  };
  if (longer(1 - row_axis_)) row_axis_ = 1 - row_axis_;
  rows_ = axis_[row_axis_].cells;
  stride_ = axis_[1 - row_axis_].cells + 1;
  return !periodic || (axis_[0].cells >= 3 && axis_[1].cells >= 3);
}

void CellList::cut_chunks(std::uint32_t n) {
  const std::uint32_t each = std::max(kCellTaskBodies, (n + kMostChunks - 1) / kMostChunks);
  chunks_.resize((n + each - 1) / each);
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    chunks_[c].begin = static_cast<std::uint32_t>(c) * each;
    chunks_[c].end = std::min(n, chunks_[c].begin + each);
  }
  moved_room_ = std::max(64u, std::min(n, each) / kMoved);
  moved_.reserve(chunks_.size() * moved_room_);
}

void CellList::name_bodies(float large, Chunk& chunk) {
  const CellAxis ra = axis_[row_axis_], ca = axis_[1 - row_axis_];
  const std::int32_t* const row_at = b_.built.data() + row_axis_;
  const std::int32_t* const column_at = b_.built.data() + (1 - row_axis_);
  std::uint64_t* const out = spare_name_.data();
  for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
    const std::uint64_t name = ra.at(row_at[2 * i]) * stride_ + ca.at(column_at[2 * i]);
    out[i] = name << slot_bits_ | i;
  }
  chunk.large = chunk.dead = 0;
  if (b_.dead == 0 && !(large < 1e30f)) return;
  for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
    if (b_.id[i] == kNoSlot) {
      out[i] = (rows_ * stride_ + 1) << slot_bits_ | i;
      ++chunk.dead;
    } else if (b_.reach[i] > large) {
      out[i] = (rows_ * stride_) << slot_bits_ | i;
      ++chunk.large;
    }
  }
}

// A stable counting sort of names by some of their bits: each chunk counts,
// counts become places (by digit, then by chunk), each chunk moves its own.
void CellList::sort_by_digit(int shift, int bits) {
  const std::size_t digits = std::size_t{1} << bits;
  const auto each_name = [&](const Chunk& chunk, const auto& each) {  // each(digit, name)
    const std::uint64_t mask = digits - 1;
    const int low = shift;
    const std::uint64_t* const end = spare_name_.data() + chunk.end;
    for (const std::uint64_t* p = spare_name_.data() + chunk.begin; p != end; ++p) each((*p >> low) & mask, *p);
  };
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    std::uint32_t* const count = counts_.data() + c * digits;
    std::fill(count, count + digits, 0u);
    each_name(chunks_[c], [=](std::uint64_t digit, std::uint64_t) { ++count[digit]; });
  });
  std::uint32_t place = 0;
  for (std::size_t d = 0; d < digits; ++d) {
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
      place += std::exchange(counts_[c * digits + d], place);
    }
  }
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    std::uint32_t* const next = counts_.data() + c * digits;
    std::uint64_t* const out = name_.data();
    each_name(chunks_[c], [=](std::uint64_t digit, std::uint64_t name) { out[next[digit]++] = name; });
  });
  name_.swap(spare_name_);
}

// Splits the names of a chunk: bodies that are in the same cell as at the last
// sort come first, in order; the others go to moved_, as far as there is room.
void CellList::find_moved(const std::uint32_t* keys, std::size_t index) {
  Chunk& chunk = chunks_[index];
  const std::uint64_t* const cell = name_.data();
  std::uint64_t* const name = spare_name_.data();
  const std::uint32_t room = moved_room_;
  std::uint64_t* const moved = moved_.data() + index * room;
  const int shift = slot_bits_;
  std::size_t stay = chunk.begin;
  std::uint32_t go = 0;
  for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
    const std::uint64_t mine = name[i];
    const bool same = i < sorted_ && mine >> shift == cell[keys[i] / 4];
    name[stay] = mine;
    moved[std::min(go, room - 1)] = mine;
    stay += same ? 1u : 0u;
    go += same ? 0u : 1u;
  }
  chunk.stayed = static_cast<std::uint32_t>(stay) - chunk.begin;
  chunk.moved = go;
}

// Puts the names in order by merging, if most bodies are in the same cell as at
// the last sort: those are in order already.
bool CellList::merge_moved(float large, const std::uint32_t* keys) {
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    name_bodies(large, chunks_[c]);
    find_moved(keys, c);
  });
  std::uint64_t* const moved = moved_.data();
  std::uint64_t* end = moved;
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    if (chunks_[c].moved >= moved_room_) return false;
    end = std::copy_n(moved + c * moved_room_, chunks_[c].moved, end);
  }
  sort_keys(moved, end);
  // The moved ones of a chunk are those before the first that stayed in the next chunk.
  const std::uint64_t* const stay = spare_name_.data();
  for (auto c = chunks_.rbegin(); c != chunks_.rend(); ++c) {
    std::uint64_t* const first = &*c == &chunks_.front() ? moved
                                 : c->stayed == 0        ? end
                                                         : std::lower_bound(moved, end, stay[c->begin]);
    c->moved = static_cast<std::uint32_t>(end - first);
    end = first;
  }
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    const std::uint64_t* m = moved;
    std::uint64_t* out = name_.data();
    for (std::size_t k = 0; k < c; ++k) {
      m += chunks_[k].moved;
      out += chunks_[k].moved + chunks_[k].stayed;
    }
    const std::uint64_t* const s = stay + chunks_[c].begin;
    std::merge(s, s + chunks_[c].stayed, m, m + chunks_[c].moved, out);
  });
  return true;
}

SortCount CellList::sort(float large, std::uint32_t* order, std::uint32_t* keys) {
  const std::uint32_t n = b_.count;
  const std::size_t padded = kernels::round_up_block(n) + kernels::kBlock;
  name_.reserve(padded);
  spare_name_.reserve(padded);
  start_.reserve(4 * padded);
  cut_chunks(n);
  bool merged = false;
  if (sorted_ != 0 && patience_ == 0) {
    merged = merge_moved(large, keys);
    if (!merged) patience_ = kPatience;
  } else if (patience_ > 0) {
    --patience_;
  }
  if (!merged) {
    const int wanted = 64 - std::countl_zero(rows_ * stride_ + 1);
    const int passes = (wanted + kDigitBits - 1) / kDigitBits;
    const int bits = (wanted + passes - 1) / passes;
    counts_.reserve(chunks_.size() << kDigitBits);
    s_.pool.run(chunks_.size(), [&](std::size_t c) { name_bodies(large, chunks_[c]); });
    for (int k = 0; k < passes; ++k) sort_by_digit(slot_bits_ + k * bits, bits);
    name_.swap(spare_name_);
  }
  SortCount out;
  for (const Chunk& c : chunks_) {
    out.large += c.large;
    out.dead += c.dead;
  }
  out.small = n - out.large - out.dead;
  for (std::size_t i = out.small; i < n; ++i) {
    order[i] = static_cast<std::uint32_t>(name_[i] & ((std::uint64_t{1} << slot_bits_) - 1));
  }
  list_cells(out.small, order, keys);
  sorted_ = out.small;
  stays_ = sorted_ != 0;
  s_.pool.run((cells_ + kTaskCells - 1) / kTaskCells, [&](std::size_t t) {
    const auto begin = static_cast<std::uint32_t>(t) * kTaskCells;
    find_neighbours(begin, std::min(cells_, begin + kTaskCells));
  });
  return out;
}

// Numbers the cells of the sorted bodies.
void CellList::list_cells(std::uint32_t bodies, std::uint32_t* order, std::uint32_t* keys) {
  const std::uint64_t* const from = name_.data();
  const std::uint64_t slots = (std::uint64_t{1} << slot_bits_) - 1;
  const auto begins = [=](std::uint32_t i) { return (from[i] ^ from[i - 1]) > slots; };
  // Chunks begin where a cell begins.
  std::uint32_t end = bodies;
  for (std::size_t c = chunks_.size(); c-- > 0;) {
    Chunk& chunk = chunks_[c];
    chunk.end = end;
    chunk.begin = std::min(chunk.begin, end);
    while (chunk.begin > 0 && chunk.begin < end && !begins(chunk.begin)) ++chunk.begin;
    end = chunk.begin;
  }
  const auto count = [&](const Chunk& chunk) {
    std::uint32_t cells = chunk.begin < chunk.end ? 1 : 0;
    for (std::uint32_t i = chunk.begin + 1; i < chunk.end; ++i) cells += begins(i) ? 1u : 0u;
    return cells;
  };
  if (chunks_.size() > 1) {
    s_.pool.run(chunks_.size(), [&](std::size_t c) { chunks_[c].cells = count(chunks_[c]); });
  }
  cells_ = 0;
  for (Chunk& c : chunks_) cells_ += std::exchange(c.cells, cells_);
  s_.pool.run(chunks_.size(), [&](std::size_t c) {
    Chunk& chunk = chunks_[c];
    std::uint64_t* const name = spare_name_.data();
    std::uint32_t* const first = start_.data() + 1;
    std::size_t cell = chunk.cells;
    const std::uint64_t slot = slots;
    const int shift = slot_bits_;
    // Without branches: each body writes that the next cell begins behind it,
    // and the last body of a cell is right.
    for (std::uint32_t i = chunk.begin; i < chunk.end; ++i) {
      cell += i != chunk.begin && begins(i) ? 1u : 0u;
      name[cell] = from[i] >> shift;
      first[4 * (cell + 1)] = i + 1;
      order[i] = static_cast<std::uint32_t>(from[i] & slot);
      keys[i] = static_cast<std::uint32_t>(4 * cell);
    }
    if (chunk.begin < chunk.end) chunk.cells = static_cast<std::uint32_t>(cell + 1);
  });
  if (chunks_.size() == 1) cells_ = chunks_[0].cells;
  name_.swap(spare_name_);
  for (std::uint32_t k = 0; k < kSentinels; ++k) name_[cells_ + k] = kNoName;
  start_[1] = 0;
  start_[4 * std::size_t{cells_} + 1] = bodies;
}

// Finds, for cells begin..end, the runs of bodies that the pair search looks
// at. The cells of the row above come in the same order as the cells below. The
// advance is computed without branches, and two halves run interleaved, because
// each step depends on the one before.
void CellList::find_neighbours(std::uint32_t begin, std::uint32_t end) {
  const std::uint64_t* const name = name_.data();
  std::uint32_t* const start = start_.data();
  const std::uint64_t stride = stride_;
  const std::uint64_t last_row = periodic_ ? (rows_ - 1) * stride : kNoName;
  const auto below = [=](std::size_t c, std::uint64_t bound) {
    return std::size_t{name[c] < bound} + std::size_t{name[c + 1] < bound} + std::size_t{name[c + 2] < bound};
  };
  const auto middle_above = [=](std::size_t c) { return name[c] >= last_row ? name[c] - last_row : name[c] + stride; };
  const auto look = [=](std::size_t c, std::size_t& above) {
    const std::uint64_t middle = middle_above(c);
    const std::uint64_t first = middle == 0 ? 0 : middle - 1;
    for (std::size_t step = 3; step == 3;) above += step = below(above, first);
    const std::size_t past = above + below(above, middle + 2);
    const std::size_t east = c + 1 + std::size_t{name[c + 1] == name[c] + 1};
    start[4 * c] = start[4 * above + 1];
    start[4 * c + 2] = start[4 * east + 1];
    start[4 * c + 3] = start[4 * past + 1];
  };
  // The row above the last row of a periodic world is the first one.
  const auto seam = static_cast<std::uint32_t>(std::lower_bound(name + begin, name + end, last_row) - name);
  for (const auto& [from, to] : {std::pair{begin, seam}, std::pair{seam, end}}) {
    if (from == to) continue;
    const std::size_t half = (to - from) / 2, second = from + half;
    const auto seek = [&](std::size_t c) {
      const std::uint64_t middle = middle_above(c);
      return static_cast<std::size_t>(std::lower_bound(name, name + cells_, middle == 0 ? 0 : middle - 1) - name);
    };
    std::size_t above[2] = {seek(from), seek(second)};
    for (std::size_t k = 0; k < half; ++k) {
      look(from + k, above[0]);
      look(second + k, above[1]);
    }
    if (second + half < to) look(second + half, above[1]);
  }
}

// Steps of doubling length go away from the guess until the cell lies between two of them.
std::uint32_t CellList::find(std::uint64_t row, std::uint64_t column, std::uint32_t guess) const {
  const std::uint64_t name = row * stride_ + column;
  const std::uint64_t* const names = name_.data();
  std::uint32_t low = std::min(guess, cells_), high = low;  // at the end: names[low - 1] < name <= names[high]
  for (std::uint32_t step = 1; low > 0 && names[low - 1] >= name; step *= 2) {
    high = low - 1;
    low = high - std::min(high, step - 1);
  }
  if (high == low) {
    for (std::uint32_t step = 1; high < cells_ && names[high] < name; step *= 2) {
      low = high + 1;
      high = std::min(cells_, low + step - 1);
    }
  }
  return static_cast<std::uint32_t>(std::lower_bound(names + low, names + high, name) - names);
}

// By symmetry the cells to the west and below hold as many bodies as those to
// the east and above.
double CellList::neighbours(const std::uint32_t* keys, std::uint32_t bodies) const {
  const std::uint32_t stride = std::max(1u, bodies / 2048);
  double sum = 0, samples = 0;
  for (std::uint32_t i = 0; i < bodies; i += stride, samples += 1) {
    const std::uint32_t* const s = start_.data() + keys[i];
    sum += (s[5] - s[1]) + 2.0 * ((s[2] - s[5]) + (s[3] - s[0]));
  }
  return samples > 0 ? sum / samples : 0;
}

}  // namespace psim
