// The second half of the broad phase: bodies lie in cells and strips are cut;
// now the pairs of each strip are found.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "lists/broad_phase.h"

namespace psim {

using kernels::kBlock;

namespace {

// Where a search writes, which has room from pair_begin to pair_end.
template <class Searched>
kernels::PairList list_of(PairTable& table, const Searched& of) {
  return {table.owner.data(), table.other.data(), table.first.data(), of.pair_begin, of.pair_end};
}

}  // namespace

kernels::PairRow BroadPhase::view() const {
  return {.pos = b_.built.data(),
          .reach = b_.reach.data(),
          .key = sort_.keys(),
          .start = listed_ ? sort_.listed().start() : sort_.start(),
          .next_row = 1,
          .pitch_x = static_cast<float>(lattice_.pitch_x()),
          .pitch_y = static_cast<float>(lattice_.pitch_y())};
}

// The slots and neighbours of a row of the grid, as the pair kernel takes them.
kernels::PairRow BroadPhase::row_view(std::uint32_t row) const {
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

bool BroadPhase::search_strip(std::size_t index, PairTable& table) const {
  Strip& s = table.strips[index];
  kernels::PairList list = list_of(table, s);
  if (!(listed_ ? search_listed(s, list) : search_rows(s, list))) return false;
  s.pair_end = list.count;
  return true;
}

bool BroadPhase::search_rows(const Strip& s, kernels::PairList& list) const {
  const std::uint32_t* start = sort_.start();
  for (std::uint32_t row = s.row_begin; row < s.row_end; ++row) {
    const std::uint32_t begin = start[row * grid_.view.stride];
    const std::uint32_t end = start[(row + 1) * grid_.view.stride];
    if (begin == end) continue;
    if (!k_.find_pairs(row_view(row), begin, end, list)) return false;
  }
  return true;
}

// Listed cells know the bodies of the row above, so a strip is one run. In a
// periodic world the first and the last cell of a row are searched one by one.
bool BroadPhase::search_listed(const Strip& s, kernels::PairList& list) const {
  const kernels::PairRow v = view();
  const CellList& cells = sort_.listed();
  if (!cells.periodic()) return k_.find_pairs(v, s.body_begin, s.body_end, list);
  const auto run = [&](std::uint32_t from, std::uint32_t to) {
    return from == to || k_.find_pairs(v, cells.first(from), cells.first(to), list);
  };
  if (s.body_begin == s.body_end) return true;
  std::uint32_t from = sort_.keys()[s.body_begin] / 4;
  const std::uint32_t end = sort_.keys()[s.body_end - 1] / 4 + 1;
  while (from < end) {
    const std::uint32_t next_row = cells.find(cells.row(from) + 1, 0);
    std::uint32_t to = next_row;
    const bool last = cells.column(to - 1) == cells.last_column();
    if (last) --to;
    if (from < to && cells.column(from) == 0) {
      if (!search_seam(from++, list)) return false;
    }
    if (!run(from, to)) return false;
    if (last && !search_seam(to, list)) return false;
    from = next_row;
  }
  return true;
}

// Searches a cell at the west or the east end of a row, also across the seam.
bool BroadPhase::search_seam(std::uint32_t cell, kernels::PairList& list) const {
  const kernels::PairRow v = view();
  const CellList& cells = sort_.listed();
  const std::uint32_t* const s = cells.start() + 4 * std::size_t{cell};
  const std::uint64_t row = cells.row(cell), above = cells.row_above(row);
  const bool west = cells.column(cell) == 0;
  const std::uint64_t far = west ? cells.last_column() : 0;
  const auto only = [&](std::uint64_t r, std::uint32_t out[2]) {
    out[0] = cells.first(cells.find(r, far));
    out[1] = cells.first(cells.find(r, far + 1));
  };
  std::uint32_t across[2], across_above[2];
  only(row, across);
  only(above, across_above);
  for (std::uint32_t i = cells.first(cell); i < cells.first(cell + 1); ++i) {
    list.first[i] = list.count;
    if (list.count + kBlock > list.capacity) return false;
    if (!k_.find_near(v, i, i + 1, s[2], list) || !k_.find_near(v, i, s[0], s[3], list) ||
        (!west && !k_.find_near(v, i, across[0], across[1], list)) ||
        !k_.find_near(v, i, across_above[0], across_above[1], list)) {
      return false;
    }
  }
  return true;
}

// Compares some of the large bodies with the bodies in the grid under their box, and with the large bodies after them.
bool BroadPhase::search_large(std::size_t piece, PairTable& table) {
  LargePiece& s = large_pieces_[piece];
  kernels::PairList list = list_of(table, s);
  const kernels::PairRow v = view();
  for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
    table.first[i] = list.count;
    if (list.count + kBlock > list.capacity) return false;
    if (table.large_begin != 0 && !search_box(i, list)) return false;
    if (!(large_cells_.any() ? large_cells_.find(i, k_, list) : k_.find_near(v, i, i + 1, b_.count, list)))
      return false;
  }
  s.pair_end = list.count;
  return true;
}

bool BroadPhase::around(std::uint32_t i, std::uint32_t large_begin, kernels::PairList& list) const {
  if (list.count + kBlock > list.capacity) return false;
  if (large_begin != 0 && !search_box(i, list)) return false;
  if (large_cells_.any()) return large_cells_.around(b_.built.data() + 2 * std::size_t{i}, b_.reach[i], list);
  return k_.find_near(view(), i, large_begin, b_.count, list);
}

// Call after all searches: moves the pairs of the large bodies' pieces side by side.
void BroadPhase::join_large(PairTable& table) {
  Strip& s = table.strips.back();
  s.pair_begin = s.pair_end = table.pair_room;
  if (large_pieces_.empty()) return;
  if (!scattered_) {  // the rooms of the pieces lie side by side
    s.pair_begin = large_pieces_.front().pair_begin;
  } else {
    for (const LargePiece& p : large_pieces_) table.pair_room += p.pair_end - p.pair_begin;
    table.owner.reserve_loosely(table.pair_room + kBlock);
    table.other.reserve_loosely(table.pair_room + kBlock);
  }
  std::uint32_t to = s.pair_begin;
  for (const LargePiece& p : large_pieces_) {
    const std::uint32_t n = p.pair_end - p.pair_begin, shift = p.pair_begin - to;
    if (shift != 0) {
      std::memmove(table.owner.data() + to, table.owner.data() + p.pair_begin, n * sizeof(std::uint32_t));
      std::memmove(table.other.data() + to, table.other.data() + p.pair_begin, n * sizeof(std::uint32_t));
      for (std::uint32_t i = p.body_begin; i < p.body_end; ++i) table.first[i] -= shift;
    }
    to += n;
  }
  s.pair_end = to;
}

// Compares a large body with the bodies in the cells.
bool BroadPhase::search_box(std::uint32_t i, kernels::PairList& list) const {
  const kernels::PairRow v = view();
  const double reach = static_cast<double>(b_.reach[i]) + static_cast<double>(most_);
  const auto compare = [&](std::uint32_t from, std::uint32_t to) { return k_.find_near(v, i, from, to, list); };
  if (listed_) {
    const double half[2] = {reach / lattice_.pitch_x(), reach / lattice_.pitch_y()};
    return sort_.listed().in_box(b_.built.data() + 2 * std::size_t{i}, half, compare);
  }
  const kernels::GridView& g = grid_.view;
  const auto span = [](std::int32_t at, std::int32_t mid, float scale, float offset, double cells, std::int32_t n,
                       bool periodic, std::int64_t out[2]) {
    const double c = static_cast<double>(wrap_sub(at, mid)) * static_cast<double>(scale) + static_cast<double>(offset);
    const auto whole = [](double x) { return static_cast<std::int64_t>(std::clamp(std::floor(x), -0x1p40, 0x1p40)); };
    out[0] = whole(c - cells - 0.01);
    out[1] = whole(c + cells + 0.01);
    if (!periodic) {
      out[0] = std::clamp<std::int64_t>(out[0], 0, n - 1);
      out[1] = std::clamp<std::int64_t>(out[1], 0, n - 1);
    } else if (out[1] - out[0] >= n) {
      out[0] = 0;
      out[1] = n - 1;
    }
  };
  std::int64_t cols[2], rows[2];
  span(b_.built[2 * i], g.mid_x, g.scale_x, g.offset_x, reach / grid_.cell_x, g.cols, grid_.periodic, cols);
  span(b_.built[2 * i + 1], g.mid_y, g.scale_y, g.offset_y, reach / grid_.cell_y, g.rows, grid_.periodic, rows);
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

// Expected pairs a body of a strip, from the last build of it and of its neighbours.
double BroadPhase::expected_pairs(std::size_t strip) const {
  double most = 0;
  for (std::size_t s = strip == 0 ? 0 : strip - 1; s <= strip + 1; ++s) {
    most = std::max(most, s < pairs_a_body_.size() ? pairs_a_body_[s] : 1.0);
  }
  return 1.15 * most;
}

// The same for a piece of the large bodies, which keep their order from build to build.
double BroadPhase::expected_of_large(std::size_t piece) const {
  const bool same = pairs_a_piece_.size() == large_pieces_.size();
  return std::max(16.0, 1.25 * (same ? pairs_a_piece_[piece] : pairs_a_large_));
}

BroadPhase::Search BroadPhase::search_at(std::size_t search, const PairTable& table) const {
  const std::size_t unit = pending_[search - searched_], strips = table.strips.size() - 1;
  if (unit < strips) {
    const Strip& s = table.strips[unit];
    return {static_cast<double>(s.body_end - s.body_begin), expected_pairs(unit)};
  }
  const LargePiece& p = large_pieces_[unit - strips];
  return {static_cast<double>(p.body_end - p.body_begin), expected_of_large(unit - strips), true,
          large_cells_.any() ? large_cells_.tests() : static_cast<double>(table.body_count - p.body_begin)};
}

// Every search writes its pairs into room of its own. After all searches, those
// whose room was too small get more; they are the same ones on every ISA.
void BroadPhase::search(PairTable& table, std::size_t begin, std::size_t end) {
  const std::size_t strips = table.strips.size() - 1;
  pool_.run(end - begin, [&](std::size_t n) {
    const std::uint32_t s = pending_[begin - searched_ + n];
    full_[s] = s < strips ? !search_strip(s, table) : !search_large(s - strips, table);
  });
  if (end != searches()) return;
  searched_ = end;
  std::erase_if(pending_, [&](std::uint32_t s) { return full_[s] == 0; });
  if (pending_.empty()) {
    join_large(table);
    note_pairs(table);
    cut_near(table);
  } else {
    give_more_room(table);
  }
}

// Gives each pending search room for wanted(pairs a body that are expected, strip or piece) pairs, from `room` on.
template <class Wanted>
void BroadPhase::give_room(PairTable& table, std::uint32_t room, const Wanted& wanted) {
  const auto give = [&](double pairs_a_body, auto& of) {
    const double pairs = wanted(pairs_a_body, of);
    of.pair_begin = room;
    room += static_cast<std::uint32_t>(pairs) + kBlock;
    of.pair_end = room;
  };
  const std::size_t strips = table.strips.size() - 1;
  for (const std::uint32_t s : pending_) {
    if (s < strips) {
      give(expected_pairs(s), table.strips[s]);
    } else {
      give(expected_of_large(s - strips), large_pieces_[s - strips]);
    }
  }
  table.owner.reserve_loosely(room + kBlock);
  table.other.reserve_loosely(room + kBlock);
  table.pair_room = room;
}

// Gives room to all searches, by the numbers of the last build.
void BroadPhase::give_first_room(PairTable& table) {
  scattered_ = false;
  give_room(table, 0,
            [](double pairs_a_body, const auto& of) { return pairs_a_body * (of.body_end - of.body_begin) + 64; });
}

// Gives more room to the searches that ran full, by how far they came. What the others found stays.
void BroadPhase::give_more_room(PairTable& table) {
  constexpr double kReserve = 1.2, kMost = 16;
  const bool all = pending_.size() == full_.size();
  scattered_ = !all && (scattered_ || pending_.back() + 1 >= table.strips.size());
  give_room(table, all ? 0 : table.pair_room, [&](double, const auto& of) {
    const double had = of.pair_end - of.pair_begin, bodies = of.body_end - of.body_begin;
    const std::uint32_t reached = table.owner[of.pair_end - kBlock];  // of the last block that is surely written
    const double done = reached - of.body_begin + 0.5;
    return had * std::min(kReserve * std::max(bodies / done, 1.0), kMost);
  });
}

// Notes the number of pairs, from which the next build guesses.
void BroadPhase::note_pairs(const PairTable& table) {
  const auto each = [](const auto& of) {
    return static_cast<double>(of.pair_end - of.pair_begin) / std::max(of.body_end - of.body_begin, 1u);
  };
  pairs_a_body_.resize(table.strips.size() - 1);
  for (std::size_t s = 0; s < pairs_a_body_.size(); ++s) pairs_a_body_[s] = each(table.strips[s]);
  pairs_a_piece_.resize(large_pieces_.size());
  for (std::size_t p = 0; p < pairs_a_piece_.size(); ++p) pairs_a_piece_[p] = each(large_pieces_[p]);
  pairs_a_large_ = each(table.strips.back());
}

// Counts as pair_kernel.h searches: four of the own run and four of the row above, then eight of each at a time.
void BroadPhase::sample_lanes(std::uint32_t large_begin, std::uint64_t& lanes, std::uint64_t& used) const {
  if (listed_) return;
  const auto eights = [](std::uint32_t n) { return n > 4 ? (n - 4 + 7) / 8 * 8 : 0; };
  for (std::uint32_t i = 0; i < large_begin; i += 64) {
    const std::uint32_t key = sort_.keys()[i];
    const kernels::PairRow row = row_view(key / grid_.view.stride);
    const std::uint32_t* const above = row.start + static_cast<std::int32_t>(key) + row.next_row;
    const std::uint32_t own = row.start[key + 2] - (i + 1), next = above[2] - above[-1];
    lanes += 8 + eights(own) + eights(next);
    used += own + next;
  }
}

}  // namespace psim
