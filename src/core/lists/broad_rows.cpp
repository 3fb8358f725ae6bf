// Strips of rows of cells, and the walks through the cells: the pairs of a strip, and the bodies around one.
#include <algorithm>
#include <array>
#include <cmath>

#include "lists/broad_cells.h"

namespace psim {
namespace {

using kernels::kBlock;

// Bodies a strip: few enough for many strips a thread, enough for full blocks.
std::uint32_t strip_bodies(std::uint32_t n) { return std::clamp<std::uint32_t>(n / 192, 128, 1024); }

void cut_rows(const kernels::GridView& g, const std::uint32_t* start, std::uint32_t target, PairTable& table) {
  const auto rows = static_cast<std::uint32_t>(g.rows);
  for (std::uint32_t row = 0; row < rows;) {
    Strip s;
    s.row_begin = row;
    s.body_begin = start[row * g.stride];
    do {
      ++row;
    } while (row < rows && start[row * g.stride] - s.body_begin < target);
    s.row_end = row;
    s.body_end = start[row * g.stride];
    table.strips.push_back(s);
  }
}

void cut_listed_rows(const CellList& cells, const std::uint32_t* keys, std::uint32_t target, PairTable& table) {
  for (std::uint32_t begin = 0; begin < table.large_begin;) {
    const std::uint32_t last = std::min(begin + target, table.large_begin) - 1;
    Strip s;
    s.body_begin = begin;
    s.body_end = cells.first(cells.find(cells.row(keys[last] / 4) + 1, 0, keys[last] / 4));
    table.strips.push_back(s);
    begin = s.body_end;
  }
}

// Cells along an axis of the grid within `reach` cells of a place. In a periodic world they may lie beyond the seam.
std::array<std::int64_t, 2> span(double at, double reach, std::int32_t n, bool periodic) {
  const auto whole = [](double x) { return static_cast<std::int64_t>(std::clamp(std::floor(x), -0x1p40, 0x1p40)); };
  const std::int64_t from = whole(at - reach - 0.01), to = whole(at + reach + 0.01), last = n - 1;
  if (!periodic) return {std::clamp<std::int64_t>(from, 0, last), std::clamp<std::int64_t>(to, 0, last)};
  return to - from > last ? std::array<std::int64_t, 2>{0, last} : std::array<std::int64_t, 2>{from, to};
}

}  // namespace

void BroadCells::cut_strips(PairTable& table) const {
  table.strips.clear();
  const std::uint32_t n = s_.bodies.count, target = strip_bodies(n);
  if (listed_) {
    cut_listed_rows(list_, keys_.data(), target, table);
  } else if (large_ > 0) {
    cut_rows(grid_.view, sort_.start(), target, table);
  }
  // Across a periodic seam the last strip meets the first, so one must be even and the other odd.
  if (grid_.periodic && table.strips.size() % 2 == 1 && table.strips.size() > 1) {
    const Strip last = table.strips.back();
    table.strips.pop_back();
    table.strips.back().row_end = last.row_end;
    table.strips.back().body_end = last.body_end;
  }
  table.strips.push_back({.body_begin = table.large_begin, .body_end = n});
}

kernels::PairRow BroadCells::view() const {
  return {.pos = s_.bodies.built.data(),
          .reach = s_.bodies.reach.data(),
          .key = keys_.data(),
          .start = listed_ ? list_.start() : sort_.start(),
          .next_row = 1,
          .pitch_x = static_cast<float>(s_.lattice.pitch_x()),
          .pitch_y = static_cast<float>(s_.lattice.pitch_y())};
}

// The slots and neighbours of a row of the grid, as the pair kernel takes them.
kernels::PairRow BroadCells::row_view(std::uint32_t row) const {
  kernels::PairRow v = view();
  const auto stride = static_cast<std::int32_t>(grid_.view.stride);
  v.next_row = stride;
  if (grid_.periodic) {
    if (row + 1 == static_cast<std::uint32_t>(grid_.view.rows)) {
      v.next_row = -stride * (grid_.view.rows - 1);
    }
    v.seam_first = row * grid_.view.stride;
    v.seam_last = v.seam_first + static_cast<std::uint32_t>(grid_.view.cols) - 1;
  }
  return v;
}

bool BroadCells::surely_within(std::uint32_t begin, std::uint32_t end, const Bounds& inner) const {
  if (listed_ || end > large_begin()) return false;
  const kernels::GridView& g = grid_.view;
  const std::uint32_t first = keys_[begin], last = keys_[end - 1], row = first / g.stride;
  if (last / g.stride != row) return false;
  constexpr double kRounded = 0.25;  // cells: the cell of a body is found in float
  // Whether the cells from `low` to `high` along an axis lie between two places.
  const auto within = [&](double mid, float offset, double cell, double low, double high, double from, double to) {
    const double zero = mid - static_cast<double>(offset) * cell;  // m: where cell 0 begins
    return zero + (low - kRounded) * cell >= from && zero + (high + 1 + kRounded) * cell <= to;
  };
  return within(g.mid_x * s_.lattice.pitch_x(), g.offset_x, grid_.cell[0], first % g.stride, last % g.stride,
                inner.xmin, inner.xmax) &&
         within(g.mid_y * s_.lattice.pitch_y(), g.offset_y, grid_.cell[1], row, row, inner.ymin, inner.ymax);
}

// Bodies that meet held ones are searched one by one, so that pairs of two held bodies go before there are many.
bool BroadCells::find_run(const kernels::PairRow& row, std::uint32_t begin, std::uint32_t end, const HeldBodies& held,
                          kernels::PairList& list) const {
  if (!held.any(begin, end)) return s_.kernels.find_pairs(row, begin, end, list);
  for (std::uint32_t i = begin; i < end; ++i) {
    if (!s_.kernels.find_pairs(row, i, i + 1, list)) return false;
    held.drop_pairs(i, list);
  }
  return true;
}

bool BroadCells::find_pairs(const Strip& s, const HeldBodies& held, kernels::PairList& list) const {
  if (listed_) return find_listed(s, held, list);
  const std::uint32_t* const start = sort_.start();
  for (std::uint32_t row = s.row_begin; row < s.row_end; ++row) {
    const std::uint32_t begin = start[row * grid_.view.stride], end = start[(row + 1) * grid_.view.stride];
    if (begin != end && !find_run(row_view(row), begin, end, held, list)) return false;
  }
  return true;
}

// Listed cells know the bodies of the row above, so a strip is one run. In a
// periodic world the first and the last cell of a row are searched one by one.
bool BroadCells::find_listed(const Strip& s, const HeldBodies& held, kernels::PairList& list) const {
  if (s.body_begin == s.body_end) return true;
  if (!list_.periodic()) return find_run(view(), s.body_begin, s.body_end, held, list);
  const std::uint32_t end = keys_[s.body_end - 1] / 4 + 1;
  for (std::uint32_t cell = keys_[s.body_begin] / 4; cell < end;) {
    if (list_.column(cell) == 0 || list_.column(cell) == list_.last_column()) {
      if (!find_at_seam(cell++, held, list)) return false;
      continue;
    }
    const std::uint32_t next = list_.find(list_.row(cell), list_.last_column(), cell);
    if (!find_run(view(), list_.first(cell), list_.first(next), held, list)) return false;
    cell = next;
  }
  return true;
}

// Searches a cell at the west or the east end of a row, also across the seam.
bool BroadCells::find_at_seam(std::uint32_t cell, const HeldBodies& held, kernels::PairList& list) const {
  const kernels::PairRow v = view();
  const std::uint32_t* const s = list_.start() + 4 * std::size_t{cell};
  const std::uint64_t row = list_.row(cell);
  const bool west = list_.column(cell) == 0;
  const std::uint64_t far = west ? list_.last_column() : 0;
  const auto only = [&](std::uint64_t r) {
    return std::array{list_.first(list_.find(r, far)), list_.first(list_.find(r, far + 1))};
  };
  const auto across = only(row), across_above = only(list_.row_above(row));
  for (std::uint32_t i = list_.first(cell); i < list_.first(cell + 1); ++i) {
    list.first[i] = list.count;
    if (list.count + kBlock > list.capacity) return false;
    if (!s_.kernels.find_near(v, i, i + 1, s[2], list) || !s_.kernels.find_near(v, i, s[0], s[3], list) ||
        (!west && !s_.kernels.find_near(v, i, across[0], across[1], list)) ||
        !s_.kernels.find_near(v, i, across_above[0], across_above[1], list)) {
      return false;
    }
    held.drop_pairs(i, list);
  }
  return true;
}

bool BroadCells::find_around(std::uint32_t i, kernels::PairList& list) const {
  if (list.count + kBlock > list.capacity) return false;
  if (large_begin() == 0) return true;
  const kernels::PairRow v = view();
  const std::int32_t* const at = v.pos + 2 * std::size_t{i};
  const double reach = static_cast<double>(v.reach[i]) + static_cast<double>(most_);
  const auto compare = [&](std::uint32_t from, std::uint32_t to) { return s_.kernels.find_near(v, i, from, to, list); };
  if (listed_) {
    const double half[2] = {reach / s_.lattice.pitch_x(), reach / s_.lattice.pitch_y()};
    return list_.in_box(at, half, compare);
  }
  const kernels::GridView& g = grid_.view;
  const auto place = [](std::int32_t x, std::int32_t mid, float scale, float offset) {
    return static_cast<double>(wrap_sub(x, mid)) * static_cast<double>(scale) + static_cast<double>(offset);
  };
  const auto cols = span(place(at[0], g.mid_x, g.scale_x, g.offset_x), reach / grid_.cell[0], g.cols, grid_.periodic);
  const auto rows = span(place(at[1], g.mid_y, g.scale_y, g.offset_y), reach / grid_.cell[1], g.rows, grid_.periodic);
  for (std::int64_t r = rows[0]; r <= rows[1]; ++r) {
    const auto row = static_cast<std::uint32_t>((r % g.rows + g.rows) % g.rows);
    const std::uint32_t* const start = sort_.start() + row * g.stride;
    const auto run = [&](std::int64_t from, std::int64_t last) { return compare(start[from], start[last + 1]); };
    const bool ok = cols[0] < 0         ? run(cols[0] + g.cols, g.cols - 1) && run(0, cols[1])
                    : cols[1] >= g.cols ? run(0, cols[1] - g.cols) && run(cols[0], g.cols - 1)
                                        : run(cols[0], cols[1]);
    if (!ok) return false;
  }
  return true;
}

// Counts as pair_kernel.h searches: four of the own run and four of the row above, then eight of each at a time.
void BroadCells::sample_lanes(std::uint64_t& lanes, std::uint64_t& used) const {
  if (listed_) return;
  const auto eights = [](std::uint32_t n) { return n > 4 ? (n - 4 + 7) / 8 * 8 : 0; };
  for (std::uint32_t i = 0; i < large_begin(); i += 64) {
    const std::uint32_t key = keys_[i];
    const kernels::PairRow row = row_view(key / grid_.view.stride);
    const std::uint32_t* const above = row.start + static_cast<std::int32_t>(key) + row.next_row;
    const std::uint32_t own = row.start[key + 2] - (i + 1), next = above[2] - above[-1];
    lanes += 8 + eights(own) + eights(next);
    used += own + next;
  }
}

}  // namespace psim
