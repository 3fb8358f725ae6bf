#include "query/query_grid.h"

#include <algorithm>
#include <bit>

#include "base/elementary.h"
#include "base/sort_keys.h"

namespace psim {
namespace {

constexpr std::size_t kSample = 512;  // size of the sample from which the box of a grid is found
constexpr double kSlack = 1 + 1e-9;   // factor on reaches, since cells are found by rounded numbers

// Radii of a class differ by less than a factor of four.
std::uint32_t size_class(const QueryItem& item) { return std::bit_cast<std::uint32_t>(item.radius) >> 24; }
constexpr std::uint32_t kClasses = 256;

bool by_class(const QueryItem& a, const QueryItem& b) { return size_class(a) < size_class(b); }

}  // namespace

Vec2 nearest_copy(Vec2 at, Vec2 period) {
  const auto nearest = [](double x, double width) {
    if (!(width > 0)) return x;
    const double near = x - width * std::floor(x / width + 0.5);
    return std::fabs(near) <= width ? near : std::remainder(x, width);  // far away the product is rounded
  };
  return {nearest(at.x, period.x), nearest(at.y, period.y)};
}

void QueryGrid::begin(Vec2 period, std::size_t room) {
  period_ = period;
  items_.clear();
  items_.reserve(room);
}

void QueryGrid::add(QueryItem item) {
  item.at = nearest_copy(item.at, period_);
  items_.push_back(item);
}

// Lays a grid over its members. Cells are as large as the largest member, and there are about as many cells as members.
// The box holds all but the outermost few of a sample, and is half as large again.
void QueryGrid::choose(Level& g, std::span<const QueryItem> members) {
  const double n = static_cast<double>(members.size());
  for (const QueryItem& item : members) g.most = std::max(g.most, static_cast<double>(item.radius));
  const auto bound = [&](Axis& axis, double Vec2::*along) {  // returns the size of the box
    axis.period = period_.*along;
    axis.low = -axis.period / 2;
    if (!axis.ends()) return axis.period;
    double low = 1e300, high = -1e300;
    for (const QueryItem& item : members) {
      low = std::min(low, item.at.*along);
      high = std::max(high, item.at.*along);
    }
    sample_.clear();
    for (std::size_t k = 0; k < members.size(); k += members.size() / kSample + 1) {
      sample_.push_back(members[k].at.*along);
    }
    // Total order: equal numbers are alike.
    std::sort(sample_.begin(), sample_.end());
    const std::size_t few = sample_.size() / 64;
    const double inner_low = sample_[few], inner_high = sample_[sample_.size() - 1 - few];
    const double margin = (inner_high - inner_low) / 4 + 2 * g.most;
    axis.low = greater(inner_low - margin, low);
    return lesser(high, inner_high + margin) - axis.low;
  };
  const double width = bound(g.x, &Vec2::x), height = bound(g.y, &Vec2::y);
  double edge = greater(2 * g.most, std::sqrt(width * height / n));
  edge = greater(greater(width, height) / (4 * n + 16), edge);
  const auto cut = [&](Axis& axis, double size) {
    axis.count = static_cast<std::int64_t>(greater(edge > 0 ? std::floor(size / edge) : 0, 1));
    axis.edge = edge > 0 ? edge : 1;
    if (!axis.ends()) {
      axis.edge = size / static_cast<double>(axis.count);
    } else if (size > edge * static_cast<double>(axis.count)) {
      ++axis.count;
    }
    axis.per = 1 / axis.edge;
  };
  cut(g.x, width);
  cut(g.y, height);
  g.most = g.most * kSlack + 1e-9 * greater(g.x.edge, g.y.edge);
}

void QueryGrid::build() {
  if (!std::is_sorted(items_.begin(), items_.end(), by_class)) {
    sort_by_first(items_, sorted_, start_, kClasses, size_class, by_class);
  }
  levels_.clear();
  key_.resize(items_.size());
  std::size_t cells = 0;
  for (std::size_t begin = 0, end = 0; begin < items_.size(); begin = end) {
    while (end < items_.size() && size_class(items_[end]) == size_class(items_[begin])) ++end;
    Level& g = levels_.emplace_back();
    choose(g, std::span(items_).subspan(begin, end - begin));
    g.first = cells;
    for (std::size_t k = begin; k < end; ++k) {
      const std::int64_t at = g.y.cell(items_[k].at.y) * g.x.count + g.x.cell(items_[k].at.x);
      key_[k] = static_cast<std::uint32_t>(cells + static_cast<std::size_t>(at));
    }
    cells += static_cast<std::size_t>(g.x.count * g.y.count);
  }
  start_.assign(cells + 2, 0);
  for (const std::uint32_t key : key_) ++start_[key + 2];
  for (std::size_t c = 2; c < start_.size(); ++c) start_[c] += start_[c - 1];
  sorted_.resize(items_.size());
  for (std::size_t k = 0; k < items_.size(); ++k) sorted_[start_[key_[k] + 1]++] = items_[k];
  start_.pop_back();
}

}  // namespace psim
