// Some rows of a picture, painted and turned into bytes by one thread while they lie in its cache.
//
// Bodies do not overlap, so two that meet in a pixel share it: each takes of what is still free
// before it hides what is there ("disjoint over", T. Porter, T. Duff, Compositing Digital Images, 1984,
// as extended by the X Rendering Extension). A pile of discs smaller than a pixel is therefore as bright
// as the area that they cover, which repeated mixing would miss. Lines are laid over.
//
// Figures are kept apart from the background until the end. A figure of several bands is painted in each, its rows
// there alone, by the same sums: a pixel does not depend on where bands end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/figure.h"
#include "picture/packed.h"

namespace psim::cli {

class Band {
 public:
  /// Begins a picture; what it is given is used until the next one begins.
  void begin_picture(int width, int height, const Figures& figures, const Backdrop& backdrop);

  /// Rows top to bottom - 1 with the figures of these numbers, as 8-bit sRGB, 3 bytes a pixel.
  void draw(int top, int bottom, std::span<const std::uint32_t> numbers, std::uint8_t* rgb);

 private:
  // The light of the figures in a pixel, r, g, b already multiplied by the share of it that they cover, and
  // that share.
  using Light = Float4;
  struct Look {
    Light light, rim;
    float opacity;
    bool has_rim, shares;  // shares: disjoint from what is there
  };
  struct Touched {
    int left, right;
  };

  static Light light_of(Colour c) { return Light{c.r, c.g, c.b, 1}; }
  static Look look_of(const Figure& figure, bool has_rim);
  void write(std::uint8_t* out, Light light) const;

  void paint_disc(const Figure& figure);
  void paint_convex(const Figure& figure);
  void paint_line(const Figure& figure);
  void paint_ring(const Figure& figure);
  void paint_field(const Figure& figure);
  void paint_field_row(const FieldArea& area, Colour colour, int y);
  bool begin(double x0, double y0, double x1, double y1, bool has_rim);
  bool begin_outline(bool has_rim);
  void paint(const Look& look);
  static void put(Light& pixel, Light light, float share, bool shares);
  void look_behind(int y);
  void finish_row(int y, std::uint8_t* out);
  void hide_outside(const Backdrop::Rect& window, int y, const Touched& touched);

  int width_ = 0, height_ = 0;  // of the picture
  int top_ = 0, bottom_ = 0;    // of the band
  const Figures* figures_ = nullptr;
  const Backdrop* backdrop_ = nullptr;
  const std::uint8_t* tones_ = nullptr;  // sRGB by steps of linear light
  std::vector<Light> pixels_;            // of the band; all zero between bands
  std::vector<Touched> touched_;         // of each row: the pixels that may be other than zero
  Coverage outer_, inner_;               // the figure at work, and what its rim encloses
  PixelBox box_;                         // of that figure
  std::vector<Point> outline_;
  std::vector<float> numbers_, slopes_;   // of a field at the height of a row: its numbers, and how they rise upwards
  std::vector<Light> tints_;              // likewise its colours
  std::vector<Light> behind_;             // the background of a row
  std::vector<std::uint8_t> behind_rgb_;  // the same as bytes
  std::vector<double> heights_, heights_before_;  // of each rectangle in it
};

}  // namespace psim::cli
