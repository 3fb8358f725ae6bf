// A picture in linear light that discs and lines are painted on with anti-aliased edges.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psim::cli {

/// Linear-light RGB, 0..1.
struct Colour {
  float r = 0, g = 0, b = 0;
};

/// From the 24-bit sRGB that designers write: 0xRRGGBB.
Colour from_srgb(std::uint32_t rgb);

inline Colour mix(Colour a, Colour b, float t) {
  return {a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}

/// A place on the canvas, in pixels.
struct Point {
  float x = 0, y = 0;
};

/// Pixel (x, y) covers [x, x+1] x [y, y+1]; y grows downwards.
class Canvas {
 public:
  Canvas(int width, int height, Colour background);

  int width() const { return width_; }
  int height() const { return height_; }

  void fill_rect(float x0, float y0, float x1, float y1, Colour colour);
  /// Paints a disc by the share of every pixel that it covers. One smaller than a pixel keeps its
  /// area as weight, so that a cloud of tiny discs has the right brightness. Discs of a few pixels
  /// and more get a darker rim.
  void disc(float cx, float cy, float radius, Colour colour);
  /// The same for all points within `radius` of a convex polygon, in either order; two points are a
  /// capsule.
  void convex(std::span<const Point> points, float radius, Colour colour);
  void ring(float cx, float cy, float radius, float thickness, Colour colour);
  void line(float x0, float y0, float x1, float y1, float thickness, Colour colour);

  /// 8-bit sRGB, rows from the top, 3 bytes a pixel.
  std::vector<std::uint8_t> to_srgb() const;

 private:
  // Paints by a signed distance to the edge, negative inside; `inner` is how deep the inside is, `outer` half
  // of the length.
  template <class Distance>
  void solid(float x0, float y0, float x1, float y1, float inner, float outer, Colour colour,
             const Distance& distance);
  // Calls paint(pixel, x, y) for the pixels of the rectangle that are on the canvas.
  template <class Paint>
  void for_pixels(float x0, float y0, float x1, float y1, const Paint& paint);

  int width_, height_;
  std::vector<Colour> pixels_;
};

}  // namespace psim::cli
