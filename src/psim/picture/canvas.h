// A picture in linear light that figures are painted on, every pixel by the share of it that they
// cover (coverage.h). Figures are noted, 56 bytes each, in bands of rows; to_srgb() paints them, a thread a band
// (band.h). Costs, 1920 x 1080: see docs/pictures.md.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "picture/band.h"
#include "picture/figure.h"

namespace psim::cli {

/// From the 24-bit sRGB that designers write: 0xRRGGBB.
Colour from_srgb(std::uint32_t rgb);

class Canvas {
 public:
  Canvas(int width, int height, Colour background = {});

  /// An empty picture.
  void clear(Colour background);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Paints a rectangle of the background, over those before.
  void background_rect(double x0, double y0, double x1, double y1, Colour colour);

  /// Figures show within this rectangle alone.
  void show_within(double x0, double y0, double x1, double y1);

  /// A disc. One of 3 pixels of radius or more gets a darker rim. What is not opaque lets through what lies
  /// below.
  void disc(double x, double y, double radius, Colour colour, float opacity = 1);
  /// The same for all points within `radius` of a convex polygon, in either order; two points are a
  /// capsule.
  void convex(std::span<const Point> points, double radius, Colour colour, float opacity = 1);
  /// Laid over what is there, with round ends, without a rim.
  void line(Point from, Point to, double thickness, Colour colour);
  void ring(double x, double y, double radius, double thickness, Colour colour);
  /// An area that shares pixels with its neighbours as a disc does. `colour` is that of an area without colours of its
  /// own, which is paler at its edge.
  void field(FieldArea area, Colour colour);

  /// 8-bit sRGB, rows from the top, 3 bytes a pixel. The same bytes on any number of threads.
  void to_srgb(std::vector<std::uint8_t>& bytes, int threads = 1);

 private:
  void note(const Figure& figure, double x0, double y0, double x1, double y1);
  void note(Figure figure, std::span<const Point> corners);

  int width_, height_;
  Backdrop backdrop_;
  Figures figures_;
  std::vector<std::vector<std::uint32_t>> in_band_;  // numbers of the figures that reach into each
  std::vector<Band> bands_;                          // one a thread
};

}  // namespace psim::cli
