#include "coverage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace psim::cli {

PixelBox pixel_box(double x0, double y0, double x1, double y1, int width, int height) {
  // Clamped as doubles: a figure far outside must not overflow an int.
  const auto whole = [](double v, int most) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(most)));
  };
  return {whole(std::floor(x0), width), whole(std::floor(y0), height), whole(std::ceil(x1), width),
          whole(std::ceil(y1), height)};
}

void Coverage::begin(const PixelBox& box) {
  columns_ = static_cast<std::size_t>(box.right - box.left);
  stride_ = columns_ + 2;
  left_ = box.left;
  top_ = box.top;
  width_ = box.right - box.left;
  height_ = box.bottom - box.top;
  left_column_ = box.left;
  top_row_ = box.top;
  const std::size_t cells = stride_ * static_cast<std::size_t>(box.bottom - box.top);
  if (cells_.size() < cells) cells_.resize(cells);
  const auto rows = static_cast<std::size_t>(box.bottom - box.top);
  if (touched_.size() < rows) touched_.resize(rows, kUntouched);
  if (row_.size() < columns_) row_.resize(columns_);
}

void Coverage::polygon(std::span<const Point> corners, Point centre, double scale) {
  if (corners.empty()) return;
  const Point shift = {centre.x - left_, centre.y - top_};
  const auto place = [&](const Point& p) {
    return Point{shift.x + scale * p.x, shift.y + scale * p.y};
  };
  const auto is_inside = [this](const Point& p) {
    return p.x >= 0 && p.x <= width_ && p.y >= 0 && p.y <= height_;
  };
  Point from = place(corners.back());
  bool was_inside = is_inside(from);
  for (const Point& corner : corners) {
    const Point to = place(corner);
    const bool inside = is_inside(to);
    if (was_inside && inside) {
      add(static_cast<float>(from.x), static_cast<float>(from.y), static_cast<float>(to.x),
          static_cast<float>(to.y));
    } else {
      add_clipped(from, to);
    }
    from = to;
    was_inside = inside;
  }
}

// A piece of an edge within one row, from x0 to x1, `height` rows high (signed). With
//   I(x) = 0 left of the piece, (x - low)^2 / (2 (high - low)) along it, x - (low + high) / 2 right of it,
// the share of pixel i on the piece's right is I(i+1) - I(i), and the cells get its differences.
void Coverage::add_in_row(std::size_t row, float x0, float x1, float height) {
  const float low = std::min(x0, x1), high = std::max(x0, x1);
  const int first = static_cast<int>(low), last = static_cast<int>(high);
  touched_[row] = {std::min(touched_[row].first, first), std::max(touched_[row].last, last + 1)};
  float* const cells = cells_.data() + row * stride_;
  if (first == last) {
    const float left_of = height * ((low + high) * 0.5f - static_cast<float>(first));
    cells[first] += height - left_of;
    cells[first + 1] += left_of;
    return;
  }
  const float scale = 0.5f / (high - low);
  float before = 0, integral = 0;  // the last pixel's share, I at its right side
  for (int i = first; i < last; ++i) {
    const float reach = static_cast<float>(i + 1) - low;
    const float next = reach * reach * scale;
    const float share = next - integral;
    cells[i] += height * (share - before);
    integral = next;
    before = share;
  }
  const float share = static_cast<float>(last + 1) - (low + high) * 0.5f - integral;
  cells[last] += height * (share - before);
  cells[last + 1] += height * (1 - share);
}

void Coverage::add(float x0, float y0, float x1, float y1) {
  if (y0 == y1) return;
  float sign = 1;
  if (y0 > y1) {
    std::swap(x0, x1);
    std::swap(y0, y1);
    sign = -1;
  }
  auto row = static_cast<std::size_t>(y0);
  float next_row = static_cast<float>(row + 1);
  if (y1 <= next_row) {
    add_in_row(row, x0, x1, sign * (y1 - y0));
    return;
  }
  const float slope = (x1 - x0) / (y1 - y0);
  const float low = std::min(x0, x1), high = std::max(x0, x1);
  float x = x0, y = y0;
  while (y < y1) {
    const float bottom = std::min(next_row, y1);
    const float next = bottom == y1 ? x1 : std::clamp(x0 + slope * (bottom - y0), low, high);
    add_in_row(row++, x, next, sign * (bottom - y));
    x = next;
    y = bottom;
    next_row += 1;
  }
}

// What is above and below the box goes; what is left of it counts as if it stood on its left side,
// and likewise on the right.
void Coverage::add_clipped(Point from, Point to) {
  if (std::max(from.y, to.y) <= 0 || std::min(from.y, to.y) >= height_) return;
  const auto at_y = [&](double y) {
    return from.x + (to.x - from.x) * ((y - from.y) / (to.y - from.y));
  };
  const auto at_x = [&](double x) {
    return std::clamp(from.y + (to.y - from.y) * ((x - from.x) / (to.x - from.x)), 0.0, height_);
  };
  const auto cut = [&](Point p) {
    const double y = std::clamp(p.y, 0.0, height_);
    return y == p.y ? p : Point{at_y(y), y};
  };
  const Point a = cut(from), b = cut(to);
  // The sides of the box that the edge crosses between a and b, in its direction.
  const double first = a.x < b.x ? 0 : width_, second = width_ - first;
  const auto between = [&](double x) { return (a.x < x) != (b.x < x); };
  Point points[4] = {a};
  int count = 1;
  for (const double side : {first, second}) {
    if (between(side)) points[count++] = {side, at_x(side)};
  }
  points[count++] = b;
  const auto f = [](double v) { return static_cast<float>(v); };
  for (int k = 1; k < count; ++k) {
    const Point &p = points[k - 1], &q = points[k];
    add(f(std::clamp(p.x, 0.0, width_)), f(p.y), f(std::clamp(q.x, 0.0, width_)), f(q.y));
  }
}

Coverage::Row Coverage::take_row(int y) {
  const auto row = static_cast<std::size_t>(y - top_row_);
  const Touched touched = touched_[row];
  if (touched.last < 0) return {left_column_, {}};
  touched_[row] = kUntouched;
  float* const cells = cells_.data() + row * stride_;
  const auto first = static_cast<std::size_t>(touched.first);
  const auto end = static_cast<std::size_t>(touched.last) + 1;
  const std::size_t shown = std::min(end, columns_);  // the rest lies right of the box
  float sum = 0;
  for (std::size_t i = first; i < shown; ++i) {
    sum += cells[i];
    row_[i] = std::min(std::fabs(sum), 1.0f);
  }
  std::fill(cells + first, cells + end, 0.0f);
  if (shown <= first) return {left_column_, {}};
  return {left_column_ + touched.first, {row_.data() + first, shown - first}};
}

}  // namespace psim::cli
