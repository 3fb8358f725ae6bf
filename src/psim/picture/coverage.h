// The exact share of every pixel that a figure covers. In: its outline, closed polygons.
// Out, row by row: areas, 0..1, exact but for the rounding of floats, whatever the size: a figure
// smaller than a pixel gives its area.
//
// How: every edge adds, to the pixels of each row that it crosses, the area between itself and the right end of
// the row, signed by its direction; what belongs to the left of a pixel's own share is kept as
// differences from pixel to pixel, so that an edge touches only the pixels that it runs through and
// a running sum of the row gives the areas. The cost is that of the pixels on the outline, about
// 6 ns each, and of the sum over the figure's pixels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace psim::cli {

/// A place in a picture, in pixels; pixel (x, y) covers [x, x+1] x [y, y+1], y grows downwards.
struct Point {
  double x = 0, y = 0;
};

/// Whole pixels: columns left to right - 1, rows top to bottom - 1.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
  bool is_empty() const { return left >= right || top >= bottom; }
};

/// The pixels within [x0, x1] x [y0, y1] that a picture of this size has.
PixelBox pixel_box(double x0, double y0, double x1, double y1, int width, int height);

class Coverage {
 public:
  /// Begins a figure. What lies outside of the box is cut off. Every row of the one before must have
  /// been taken. Of the box's rows only those from `first` to before `end` are made; they are the same as with all.
  void begin(const PixelBox& box, int first, int end);
  void begin(const PixelBox& box) { begin(box, box.top, box.bottom); }

  /// Adds a loop with the corners centre + scale * corner. A convex one may go either way round; a hole goes
  /// the other way round than what it is in.
  void polygon(std::span<const Point> corners, Point centre = {}, double scale = 1);

  /// The pixels of a row from column `left` on.
  struct Row {
    int left = 0;
    std::span<const float> shares;
  };
  /// Row `y` of the picture. To be called once a row; what it returns lasts until the next call.
  Row take_row(int y);

 private:
  // The cells of a row that are not zero: first to last.
  struct Touched {
    int first, last;
  };
  static constexpr Touched kUntouched{1 << 30, -1};

  void add(float x0, float y0, float x1, float y1);
  void add_clipped(Point from, Point to);
  void add_in_row(int box_row, float x0, float x1, float height);

  double left_ = 0, top_ = 0, width_ = 0, height_ = 0;  // of the box
  int left_column_ = 0, first_row_ = 0;
  int skipped_ = 0;           // rows of the box above the first that is made
  int end_ = 0;               // of those made, in rows of the box
  std::size_t columns_ = 0;   // of the box
  std::size_t stride_ = 0;    // two cells more: an edge may stand on the right side
  std::vector<float> cells_;  // differences; all zero between figures
  std::vector<Touched> touched_;
  std::vector<float> row_;
};

}  // namespace psim::cli
