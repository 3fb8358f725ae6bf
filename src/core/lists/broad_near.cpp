// The last part of the broad phase: bodies near walls and fixed shapes, and which bodies are in any list.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>

#include "lists/broad_phase.h"

namespace psim {

void BroadPhase::cut_near(const PairTable& table) {
  near_pieces_.clear();
  for (std::uint32_t s = 0; s < table.strips.size(); ++s) {
    const Strip& strip = table.strips[s];
    Near piece{s, strip.body_begin, strip.body_end};
    while (fixed_ && piece.end - piece.begin > kNearPiece) {
      Near some = piece;
      some.end = piece.begin = some.begin + kNearPiece;
      some.last = piece.first = false;
      near_pieces_.push_back(some);
    }
    near_pieces_.push_back(piece);
  }
}

double BroadPhase::expected_near(std::size_t strip) const {
  if (near_a_body_.empty()) return 0;
  const std::size_t large = near_a_body_.size() - 1;  // the group of large bodies, which lie near many shapes
  if (strip == near_pieces_.back().strip) return near_a_body_[large];
  double most = 0;
  for (std::size_t s = strip == 0 ? 0 : strip - 1; s < std::min(strip + 2, large); ++s) {
    most = std::max(most, near_a_body_[s]);
  }
  return most;
}

// The pieces of one strip run one after the other, because they write to one list.
void BroadPhase::find_near(PairTable& table, std::size_t begin, std::size_t end) {
  const auto strip_of = [&](std::size_t piece) { return std::size_t{near_pieces_[piece].strip}; };
  const std::size_t first = strip_of(begin);
  pool_.run(strip_of(end - 1) + 1 - first, [&](std::size_t n) {
    const auto at = std::partition_point(near_pieces_.begin(), near_pieces_.end(),
                                         [&](const Near& p) { return p.strip < first + n; });
    for (auto k = std::max(begin, static_cast<std::size_t>(at - near_pieces_.begin()));
         k < end && strip_of(k) == first + n; ++k) {
      find_statics(near_pieces_[k], table);
      if (near_pieces_[k].last) link(table, first + n);
    }
  });
  if (end != nears()) return;
  near_pairs_ = 0;
  near_a_body_.resize(table.strips.size());
  for (std::size_t s = 0; s < table.strips.size(); ++s) {
    const Strip& strip = table.strips[s];
    near_pairs_ += table.static_contacts[s].size();
    near_a_body_[s] =
        static_cast<double>(table.static_contacts[s].size()) / std::max(strip.body_end - strip.body_begin, 1u);
  }
  table.mark_strips();
}

void BroadPhase::link(const PairTable& table, std::size_t index) const {
  const Strip& s = table.strips[index];
  std::uint8_t* const linked = b_.linked.data();
  const auto mark = [=](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(linked[slot]).store(0xFF, std::memory_order_relaxed);
  };
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    mark(table.owner[p]);
    mark(table.other[p]);
  }
  for (const StaticPair& pair : table.static_contacts[index]) mark(pair.body);
}

void BroadPhase::near_body(std::uint32_t i, std::vector<std::uint32_t>& found, std::vector<StaticPair>& out) const {
  const BroadPhaseParams& p = params_;
  const double reach = static_cast<double>(b_.reach[i]) + common_way();
  const std::int32_t* at = b_.built.data() + 2 * std::size_t{i};
  if (p.walls) {
    const double x = at[0] * lattice_.pitch_x(), y = at[1] * lattice_.pitch_y();
    if (x - reach < p.bounds.xmin) out.push_back({i, kWallLeft, 0});
    if (x + reach > p.bounds.xmax) out.push_back({i, kWallRight, 0});
    if (y - reach < p.bounds.ymin) out.push_back({i, kWallBottom, 0});
    if (y + reach > p.bounds.ymax) out.push_back({i, kWallTop, 0});
  }
  if (statics_.any()) {
    found.clear();
    statics_.near(at[0], at[1], static_cast<float>(reach), found);
    for (const std::uint32_t shape : found) out.push_back({i, shape, 0});
  }
}

// How far the common velocity goes within the margin's time: fixed shapes move by that against it.
double BroadPhase::common_way() const {
  const Vec2 common{static_cast<double>(params_.margin.common_x), static_cast<double>(params_.margin.common_y)};
  return length_of(common) * static_cast<double>(params_.margin.time);
}

// True if no wall or fixed shape is near the box of all bodies of a piece.
bool BroadPhase::nothing_near(const Near& piece) const {
  const std::int32_t* const at = b_.built.data();
  std::int32_t low[2] = {INT32_MAX, INT32_MAX}, high[2] = {INT32_MIN, INT32_MIN};
  float most = 0;
  for (std::size_t i = piece.begin; i < piece.end; ++i) {
    for (const std::size_t axis : {0u, 1u}) {
      low[axis] = std::min(low[axis], at[2 * i + axis]);
      high[axis] = std::max(high[axis], at[2 * i + axis]);
    }
    most = std::max(most, b_.reach[i]);
  }
  if (piece.begin == piece.end) return true;
  const double reach = static_cast<double>(most) + common_way();
  const double px = lattice_.pitch_x(), py = lattice_.pitch_y();
  const double xmin = low[0] * px, xmax = high[0] * px, ymin = low[1] * py, ymax = high[1] * py;
  const BroadPhaseParams& p = params_;
  if (p.walls && (xmin - reach < p.bounds.xmin || xmax + reach > p.bounds.xmax || ymin - reach < p.bounds.ymin ||
                  ymax + reach > p.bounds.ymax)) {
    return false;
  }
  const auto r = static_cast<double>(static_cast<float>(reach));  // rounded as the bodies' own queries are
  return statics_.surely_none({xmin - r, ymin - r, xmax + r, ymax + r});
}

// Walls: only bodies in rows and columns that a wall can reach are looked at;
// where cells are listed, only cells that the longest reach brings to a wall.
// Fixed shapes: every body queries their grid, if any lies near its piece.
void BroadPhase::find_statics(const Near& piece, PairTable& table) const {
  const BroadPhaseParams& p = params_;
  const std::size_t index = piece.strip;
  std::vector<StaticPair>& out = table.static_contacts[index];
  if (piece.first) out.clear();
  const Strip& s = table.strips[index];
  const double px = lattice_.pitch_x(), py = lattice_.pitch_y(), extra = common_way();
  const auto look = [&](std::uint32_t i) { near_body(i, table.found[index], out); };
  const bool large_group = index + 1 == table.strips.size();
  if (large_group || fixed_) {
    if (fixed_ && nothing_near(piece)) return;
    for (std::uint32_t i = piece.begin; i < piece.end; ++i) look(i);
    return;
  }
  if (!p.walls) return;
  if (listed_) {
    const double reach = static_cast<double>(most_) + extra;
    const double low_x = (p.bounds.xmin + reach) / px, high_x = (p.bounds.xmax - reach) / px;
    const double low_y = (p.bounds.ymin + reach) / py, high_y = (p.bounds.ymax - reach) / py;
    for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
      const std::int32_t* at = b_.built.data() + 2 * std::size_t{i};
      if (at[0] < low_x || at[0] > high_x || at[1] < low_y || at[1] > high_y) look(i);
    }
    return;
  }
  const kernels::GridView& g = grid_.view;
  const auto cell = [](double at, double pitch, std::int32_t mid, double edge, float offset) {
    return (at - mid * pitch) / edge + static_cast<double>(offset);
  };
  const double reach = static_cast<double>(most_) + extra;
  const double low_row = cell(p.bounds.ymin + reach, py, g.mid_y, grid_.cell_y, g.offset_y) + 0.01;
  const double high_row = cell(p.bounds.ymax - reach, py, g.mid_y, grid_.cell_y, g.offset_y) - 0.01;
  const double low_col = cell(p.bounds.xmin + reach, px, g.mid_x, grid_.cell_x, g.offset_x) + 0.01;
  const double high_col = cell(p.bounds.xmax - reach, px, g.mid_x, grid_.cell_x, g.offset_x) - 0.01;
  const std::uint32_t* start = sort_.start();
  for (std::uint32_t row = s.row_begin; row < s.row_end; ++row) {
    const std::uint32_t base = row * g.stride;
    const std::uint32_t begin = start[base], end = start[base + g.stride];
    if (row <= low_row || row + 1 > high_row) {
      for (std::uint32_t i = begin; i < end; ++i) look(i);
      continue;
    }
    std::uint32_t left = begin, right = end;
    if (low_col >= 0) {
      const double c = std::fmin(std::floor(low_col) + 1, g.cols);
      left = start[base + static_cast<std::uint32_t>(c)];
    }
    if (high_col < g.cols) {
      const double c = std::fmax(std::floor(high_col), 0);
      right = std::max(left, start[base + static_cast<std::uint32_t>(c)]);
    }
    for (std::uint32_t i = begin; i < left; ++i) look(i);
    for (std::uint32_t i = right; i < end; ++i) look(i);
  }
}

}  // namespace psim
