// A picture in linear light that figures are painted on, every pixel by the share of it that they
// cover (coverage.h).
//
// Bodies do not overlap, so two that meet in a pixel share it: each takes of what is still free
// before it hides what is there ("disjoint over", T. Porter, T. Duff, Compositing Digital Images, 1984,
// as extended by the X Rendering Extension). A pile of discs smaller than a pixel is therefore as bright
// as the area that they cover, which repeated mixing would miss. Lines are laid over.
//
// Figures are kept apart from the background until the end. Costs, 1920 x 1080: see docs/pictures.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "coverage.h"

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

class Canvas {
 public:
  Canvas(int width, int height, Colour background = {});

  /// An empty picture.
  void clear(Colour background);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Paints a rectangle of the background, over those before.
  void background_rect(double x0, double y0, double x1, double y1, Colour colour);

  /// A disc. One of 3 pixels of radius or more gets a darker rim. What is not opaque lets through what lies
  /// below.
  void disc(double x, double y, double radius, Colour colour, float opacity = 1);
  /// The same for all points within `radius` of a convex polygon, in either order; two points are a
  /// capsule.
  void convex(std::span<const Point> points, double radius, Colour colour, float opacity = 1);
  /// Laid over what is there, with round ends, without a rim.
  void line(Point from, Point to, double thickness, Colour colour);
  void ring(double x, double y, double radius, double thickness, Colour colour);

  /// 8-bit sRGB, rows from the top, 3 bytes a pixel.
  void to_srgb(std::vector<std::uint8_t>& bytes) const;

 private:
  // The light of the figures in a pixel, r, g, b already multiplied by the share of it that they cover, and
  // that share: one register. (A type of g++ and clang++.)
  using Light = float __attribute__((vector_size(16)));
  struct Rect {
    double x0, y0, x1, y1;
    Colour colour;
  };
  struct Look {
    Light light, rim;
    float opacity;
    bool has_rim, shares;  // shares: disjoint from what is there
  };

  static Light light_of(Colour c) { return Light{c.r, c.g, c.b, 1}; }
  bool begin(double x0, double y0, double x1, double y1, bool has_rim);
  bool begin_outline(bool has_rim);
  void paint(const Look& look);
  void background_row(int y, std::vector<Colour>& row) const;

  int width_, height_;
  Colour background_;
  std::vector<Rect> rects_;
  std::vector<Light> pixels_;
  Coverage outer_, inner_;  // the figure at work, and what its rim encloses
  PixelBox box_;            // of that figure
  std::vector<Point> outline_;
};

}  // namespace psim::cli
