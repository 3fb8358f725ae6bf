#include "lists/large_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/sort_keys.h"

namespace psim {
namespace {

constexpr std::size_t kExponents = 256;  // of floats: one level each at most
constexpr std::uint64_t kMostCells = std::uint64_t{1} << 30;
constexpr double kRowTests = 24;  // the cost of a row of cells beside its candidates, in comparisons

std::size_t exponent(float reach) { return std::bit_cast<std::uint32_t>(reach) >> 23 & 0xFF; }

}  // namespace

// A level for each exponent that a reach has, in ascending order.
void LargeCells::make_levels(const float* reach, std::uint32_t begin, std::uint32_t end) {
  std::array<std::uint32_t, kExponents> bodies{};
  std::array<float, kExponents> most{};
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t e = exponent(reach[i]);
    ++bodies[e];
    most[e] = std::max(most[e], reach[i]);
  }
  std::uint32_t place = 0, bucket = 0;
  for (std::size_t e = 0; e < kExponents; ++e) {
    if (bodies[e] == 0) continue;
    Level level;
    level.most = most[e];
    level.begin = place;
    level.end = place += bodies[e];
    level.bucket = bucket;
    level.mask = std::bit_ceil(bodies[e]) - 1;
    bucket += level.mask + 1;
    for (int k = 0; k < 2; ++k) {
      CellAxis& axis = level.axis[k];
      const double cells = std::floor(0x1p32 / (2 * static_cast<double>(most[e]) / pitch_[k] + 1));
      axis.per = axis.cells = cells >= 1 ? std::min(static_cast<std::uint64_t>(cells), kMostCells) : 1;
      axis.width = 0x1p32 / static_cast<double>(axis.per);
    }
    levels_.push_back(level);
  }
}

void LargeCells::build(const std::int32_t* at, const float* reach, std::uint32_t begin, std::uint32_t end,
                       const Lattice& lattice) {
  levels_.clear();
  if (end - begin < kLeast) {
    if (begin == end) release();
    return;
  }
  const std::size_t n = end - begin;
  begin_ = begin;
  pitch_[0] = lattice.pitch_x();
  pitch_[1] = lattice.pitch_y();
  make_levels(reach, begin, end);
  const std::size_t bucket = std::size_t{levels_.back().bucket} + levels_.back().mask + 1;
  at_.reserve(2 * n);
  reach_.reserve(n);
  slot_.reserve(n);
  place_.reserve(n);
  start_.reserve(bucket + 1);
  std::fill_n(start_.data(), bucket + 1, 0u);
  // Count the bodies of each bucket; then each start holds the end of its bucket and goes down as bodies come.
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = begin + k;
    const Level& level = *std::ranges::find_if(levels_, [&](const Level& l) { return !(l.most < reach[i]); });
    const std::uint32_t mine =
        level.bucket + bucket_of(level, level.axis[0].at(at[2 * i]), level.axis[1].at(at[2 * i + 1]));
    place_[k] = mine;
    ++start_[mine];
  }
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s <= bucket; ++s) start_[s] = sum += start_[s];
  for (std::size_t k = n; k-- > 0;) {
    const std::size_t i = begin + k;
    const std::uint32_t p = --start_[place_[k]];
    place_[k] = p;
    slot_[p] = static_cast<std::uint32_t>(i);
    at_[2 * std::size_t{p}] = at[2 * i];
    at_[2 * std::size_t{p} + 1] = at[2 * i + 1];
    reach_[p] = reach[i];
  }
}

void LargeCells::release() {
  levels_.clear();
  give_back(at_, reach_, slot_, place_, start_);
}

double LargeCells::tests() const {
  constexpr double kLevel = 250;  // a level costs as much as so many comparisons
  return kLevel * static_cast<double>(levels_.size());
}

template <class Among>
void LargeCells::each_run(const std::int32_t* at, float reach, const Among& among) const {
  for (const Level& level : levels_) {
    const double both = (static_cast<double>(reach) + static_cast<double>(level.most)) * 1.00001;
    const auto columns = level.axis[0].around(at[0], both / pitch_[0], true);
    const auto rows = level.axis[1].around(at[1], both / pitch_[1], true);
    const auto count = [](const auto& cells) { return static_cast<double>(cells[0].size() + cells[1].size()); };
    if (count(columns) > level.mask || count(rows) * (count(columns) + kRowTests) > level.end - level.begin) {
      among(level.begin, level.end);
      continue;
    }
    const std::uint32_t* const start = start_.data() + level.bucket;
    const auto run = [&](const CellRange& cells, std::uint64_t row) {
      if (cells.size() == 0) return;
      const std::uint32_t first = bucket_of(level, cells.first, row);
      const std::uint32_t last = first + static_cast<std::uint32_t>(cells.size()) - 1;
      among(start[first], start[std::min(last, level.mask) + 1]);
      if (last > level.mask) among(start[0], start[last - level.mask]);
    };
    for (const CellRange& some : rows) {
      for (std::uint64_t row = some.first; row < some.end; ++row) {
        for (const CellRange& cells : columns) run(cells, row);
      }
    }
  }
}

bool LargeCells::find(std::uint32_t i, const kernels::KernelTable& k, kernels::PairList& list) const {
  const std::uint32_t from = list.count, me = place_[i - begin_];
  kernels::PairRow row;
  row.pos = at_.data();
  row.reach = reach_.data();
  row.pitch_x = static_cast<float>(pitch_[0]);
  row.pitch_y = static_cast<float>(pitch_[1]);
  bool room = true;
  each_run(at_.data() + 2 * std::size_t{me}, reach_[me], [&](std::uint32_t begin, std::uint32_t end) {
    if (room && begin != end) room = k.find_near(row, me, begin, end, list);
  });
  if (!room) {
    std::fill(list.owner + from, list.owner + list.capacity, i);
    return false;
  }
  std::uint32_t* const begin = list.other + from;
  std::uint32_t* end = begin;
  for (const std::uint32_t* p = begin; p != list.other + list.count; ++p) {
    const std::uint32_t slot = slot_[*p];
    if (slot > i) *end++ = slot;
  }
  sort_keys(begin, end);
  end = std::unique(begin, end);  // buckets may be shared by rows
  list.count = static_cast<std::uint32_t>(end - list.other);
  std::fill(list.owner + from, list.owner + list.count, i);
  return true;
}

// Few bodies call this and each sees few, so it compares one by one, with the arithmetic of pair_kernel.h.
bool LargeCells::around(const std::int32_t* at, float reach, kernels::PairList& list) const {
  if (list.count + kernels::kBlock > list.capacity) return false;
  std::uint32_t* const begin = list.other + list.count;
  std::uint32_t* const last = list.other + list.capacity - 1;
  std::uint32_t* end = begin;
  const float px = static_cast<float>(pitch_[0]), py = static_cast<float>(pitch_[1]);
  each_run(at, reach, [&](std::uint32_t from, std::uint32_t to) {
    for (std::size_t p = from; p < to; ++p) {
      const float dx = static_cast<float>(wrap_sub(at_[2 * p], at[0])) * px;
      const float dy = static_cast<float>(wrap_sub(at_[2 * p + 1], at[1])) * py;
      const float sum = reach + reach_[p];
      *end = slot_[p];
      if (dx * dx + dy * dy < sum * sum && end != last) ++end;
    }
  });
  if (end == last) return false;
  sort_keys(begin, end);
  end = std::unique(begin, end);  // buckets may be shared by rows
  list.count = static_cast<std::uint32_t>(end - list.other);
  return true;
}

}  // namespace psim
