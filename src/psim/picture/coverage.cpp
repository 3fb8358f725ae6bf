#include "picture/coverage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "picture/packed.h"

namespace psim::cli {

PixelBox pixel_box(double x0, double y0, double x1, double y1, int width, int height) {
  // Clamped as doubles: a figure far outside must not overflow an int. What is clamped is not negative: cutting its
  // fraction off is rounding down.
  const auto down = [](double v, int most) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(most))); };
  const auto up = [&](double v, int most) {
    const int whole = down(v, most);
    return whole < most && v > whole ? whole + 1 : whole;
  };
  return {down(x0, width), down(y0, height), up(x1, width), up(y1, height)};
}

void Coverage::begin(const PixelBox& box, int first, int end) {
  columns_ = static_cast<std::size_t>(box.right - box.left);
  stride_ = columns_ + 2;
  left_ = box.left;
  top_ = box.top;
  width_ = box.right - box.left;
  height_ = box.bottom - box.top;
  left_column_ = box.left;
  first_row_ = first;
  skipped_ = first - box.top;
  end_ = end - box.top;
  const auto rows = static_cast<std::size_t>(end - first);
  if (cells_.size() < stride_ * rows) cells_.resize(stride_ * rows);
  if (touched_.size() < rows) touched_.resize(rows, kUntouched);
  if (row_.size() < columns_) row_.resize(columns_);
}

void Coverage::polygon(std::span<const Point> corners, Point centre, double scale) {
  if (corners.empty()) return;
  const Double2 shift = {centre.x - left_, centre.y - top_}, most = {width_, height_}, none = {};
  const auto place = [&](const Point& p) { return shift + scale * Double2{p.x, p.y}; };
  const auto is_inside = [&](Double2 p) { return is_within(p, none, most); };
  Double2 from = place(corners.back());
  bool was_inside = is_inside(from);
  for (const Point& corner : corners) {
    const Double2 to = place(corner);
    const bool inside = is_inside(to);
    if (was_inside && inside) {
      add(static_cast<float>(from[0]), static_cast<float>(from[1]), static_cast<float>(to[0]),
          static_cast<float>(to[1]));
    } else {
      add_clipped({from[0], from[1]}, {to[0], to[1]});
    }
    from = to;
    was_inside = inside;
  }
}

// A piece of an edge within one row, from x0 to x1, `height` rows high (signed). With
//   I(x) = 0 left of the piece, (x - low)^2 / (2 (high - low)) along it, x - (low + high) / 2 right of it,
// the share of pixel i on the piece's right is I(i+1) - I(i), and the cells get its differences.
inline void Coverage::add_in_row(int box_row, float x0, float x1, float height) {
  const auto row = static_cast<std::size_t>(box_row - skipped_);
  const float low = std::min(x0, x1), high = std::max(x0, x1);
  const int first = static_cast<int>(low), last = static_cast<int>(high);
  Touched& touched = touched_[row];
  if (first < touched.first) touched.first = first;
  if (last >= touched.last) touched.last = last + 1;
  float* const cells = cells_.data() + row * stride_ + first;
  if (first == last) {
    const float left_of = height * ((low + high) * 0.5f - static_cast<float>(first));
    cells[0] += height - left_of;
    cells[1] += left_of;
    return;
  }
  const float scale = 0.5f / (high - low);
  float reach = static_cast<float>(first + 1) - low;
  float integral = reach * reach * scale, before = integral;  // I at a pixel's right side, that pixel's share
  cells[0] += height * integral;
  const int pixels = last - first;
  for (int i = 1; i < pixels; ++i) {
    reach = static_cast<float>(first + i + 1) - low;
    const float next = reach * reach * scale;
    const float share = next - integral;
    cells[i] += height * (share - before);
    integral = next;
    before = share;
  }
  const float share = static_cast<float>(last + 1) - (low + high) * 0.5f - integral;
  cells[pixels] += height * (share - before);
  cells[pixels + 1] += height * (1 - share);
}

void Coverage::add(float x0, float y0, float x1, float y1) {
  if (y0 == y1) return;
  float sign = 1;
  if (y0 > y1) {
    std::swap(x0, x1);
    std::swap(y0, y1);
    sign = -1;
  }
  int row = static_cast<int>(y0);
  if (y1 <= static_cast<float>(row + 1)) {
    if (row >= skipped_ && row < end_) add_in_row(row, x0, x1, sign * (y1 - y0));
    return;
  }
  const float slope = (x1 - x0) / (y1 - y0);
  const float low = std::min(x0, x1), high = std::max(x0, x1);
  const auto at = [&](float bottom) { return std::clamp(x0 + slope * (bottom - y0), low, high); };
  float x = x0, y = y0;
  if (row < skipped_) {
    row = skipped_;
    y = static_cast<float>(row);
    if (y < y1) x = at(y);
  }
  for (; y < y1 && row < end_; ++row) {
    const float bottom = std::min(static_cast<float>(row + 1), y1);
    const float next = bottom == y1 ? x1 : at(bottom);
    add_in_row(row, x, next, sign * (bottom - y));
    x = next;
    y = bottom;
  }
}

// What is above and below the box goes; what is left of it counts as if it stood on its left side,
// and likewise on the right.
void Coverage::add_clipped(Point from, Point to) {
  if (std::max(from.y, to.y) <= 0 || std::min(from.y, to.y) >= height_) return;
  const auto at_y = [&](double y) { return from.x + (to.x - from.x) * ((y - from.y) / (to.y - from.y)); };
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
  const auto row = static_cast<std::size_t>(y - first_row_);
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
