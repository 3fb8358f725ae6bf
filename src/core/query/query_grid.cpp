#include "query/query_grid.h"

#include <algorithm>
#include <array>
#include <bit>

namespace psim {
namespace {

constexpr std::size_t kSample = 512;  // size of the sample from which the box of a grid is found
constexpr double kSlack = 1 + 1e-9;   // factor on reaches, since cells are found by rounded numbers

// Radii of a class differ by less than a factor of four.
std::size_t size_class(float radius) { return std::bit_cast<std::uint32_t>(radius) >> 24; }

}  // namespace

void QueryGrid::begin(Vec2 period, std::size_t room) {
  period_[0] = period.x;
  period_[1] = period.y;
  items_.clear();
  items_.reserve(room);
}

void QueryGrid::add(QueryItem item) {
  if (period_[0] > 0) item.x -= period_[0] * std::floor(item.x / period_[0] + 0.5);
  if (period_[1] > 0) item.y -= period_[1] * std::floor(item.y / period_[1] + 0.5);
  items_.push_back(item);
}

// Lays a grid over its members. Cells are as large as the largest member, and there are about as many cells as members.
// The box holds all but the outermost few of a sample, and is half as large again.
void QueryGrid::choose(Level& g, std::span<const std::uint32_t> members) {
  const double n = static_cast<double>(members.size());
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300}, size[2];
  for (const std::uint32_t k : members) {
    const QueryItem& item = items_[k];
    low[0] = std::min(low[0], item.x);
    low[1] = std::min(low[1], item.y);
    high[0] = std::max(high[0], item.x);
    high[1] = std::max(high[1], item.y);
    g.most = std::max(g.most, static_cast<double>(item.radius));
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (period_[axis] > 0) {
      g.low[axis] = -period_[axis] / 2;
      size[axis] = period_[axis];
      continue;
    }
    sample_.clear();
    for (std::size_t k = 0; k < members.size(); k += members.size() / kSample + 1) {
      sample_.push_back(axis == 0 ? items_[members[k]].x : items_[members[k]].y);
    }
    // Total order: equal numbers are alike.
    std::sort(sample_.begin(), sample_.end());
    const std::size_t few = sample_.size() / 64;
    const double inner_low = sample_[few], inner_high = sample_[sample_.size() - 1 - few];
    const double margin = (inner_high - inner_low) / 4 + 2 * g.most;
    g.low[axis] = std::fmax(low[axis], inner_low - margin);
    size[axis] = std::fmin(high[axis], inner_high + margin) - g.low[axis];
  }
  double edge = std::fmax(2 * g.most, std::sqrt(size[0] * size[1] / n));
  edge = std::fmax(edge, std::fmax(size[0], size[1]) / (4 * n + 16));
  for (int axis = 0; axis < 2; ++axis) {
    const double cells = edge > 0 ? std::floor(size[axis] / edge) : 0;
    g.cells[axis] = static_cast<std::int64_t>(std::fmax(cells, 1));
    g.edge[axis] = edge > 0 ? edge : 1;
    if (period_[axis] > 0) {
      g.edge[axis] = size[axis] / static_cast<double>(g.cells[axis]);
    } else if (size[axis] > edge * static_cast<double>(g.cells[axis])) {
      ++g.cells[axis];
    }
    g.per[axis] = 1 / g.edge[axis];
  }
  g.most = g.most * kSlack + 1e-9 * std::fmax(g.edge[0], g.edge[1]);
}

void QueryGrid::build() {
  // Sorts the items by class of size.
  std::array<std::uint32_t, 257> begin{};
  for (const QueryItem& item : items_) ++begin[size_class(item.radius) + 1];
  for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
  std::array<std::uint32_t, 257> next = begin;
  order_.resize(items_.size());
  for (std::uint32_t k = 0; k < items_.size(); ++k) {
    order_[next[size_class(items_[k].radius)]++] = k;
  }
  levels_.clear();
  key_.resize(items_.size());
  std::size_t cells = 0;
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
    if (begin[c] == begin[c + 1]) continue;
    const std::span members(order_.data() + begin[c], begin[c + 1] - begin[c]);
    Level g;
    choose(g, members);
    g.first = cells;
    const auto last_x = static_cast<double>(g.cells[0] - 1);
    const auto last_y = static_cast<double>(g.cells[1] - 1);
    for (const std::uint32_t k : members) {
      const std::int64_t x = cell((items_[k].x - g.low[0]) * g.per[0], last_x);
      const std::int64_t y = cell((items_[k].y - g.low[1]) * g.per[1], last_y);
      key_[k] = static_cast<std::uint32_t>(cells + static_cast<std::size_t>(y * g.cells[0] + x));
    }
    cells += static_cast<std::size_t>(g.cells[0] * g.cells[1]);
    levels_.push_back(g);
  }
  start_.assign(cells + 2, 0);
  for (const std::uint32_t key : key_) ++start_[key + 2];
  for (std::size_t c = 2; c < start_.size(); ++c) start_[c] += start_[c - 1];
  sorted_.resize(items_.size());
  for (std::size_t k = 0; k < items_.size(); ++k) sorted_[start_[key_[k] + 1]++] = items_[k];
  start_.pop_back();
}

std::size_t QueryGrid::bytes() const {
  return (items_.capacity() + sorted_.capacity()) * sizeof(QueryItem) +
         (start_.capacity() + key_.capacity() + order_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace psim
