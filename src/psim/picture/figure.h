// What a picture is made of: figures, in the order in which they are painted, on rectangles of the background.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "picture/coverage.h"

namespace psim::cli {

/// Linear-light RGB, 0..1.
struct Colour {
  float r = 0, g = 0, b = 0;
};

inline Colour mix(Colour a, Colour b, float t) {
  return {a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}

enum class FigureKind : std::uint8_t { disc, convex, line, ring, field };

/// 56 bytes. Lengths in pixels.
struct Figure {
  Point centre;       ///< of a disc or a ring
  double radius = 0;  ///< of a disc or a ring (outside), of a convex's corners, of a line's ends
  double hole = 0;    ///< radius of a ring's inside, if positive
  Colour colour;
  float opacity = 1;               ///< of a disc or a convex
  std::uint32_t first_corner = 0;  ///< of a convex or a line, in Figures::corners; of a field, its number
  std::uint16_t corners = 0;
  FigureKind kind = FigureKind::disc;
};

/// An area that is where a number exceeds an edge: the number is known at the nodes of a grid and runs bilinearly between
/// them.
struct FieldArea {
  Point corner;     ///< pixels: the first node; the next rows lie above it in the picture
  double cell = 0;  ///< pixels from node to node
  int columns = 0, rows = 0;
  float edge = 0;
  std::vector<float> numbers;   ///< of the nodes, row after row
  std::vector<Colour> colours;  ///< of the nodes; empty: the figure's
  /// Nothing is painted outside of x0 to x1 and y0 to y1, pixels.
  Point low{-1e30, -1e30}, high{1e30, 1e30};
};

struct Figures {
  std::vector<Figure> all;
  std::vector<Point> corners;
  std::vector<FieldArea> fields;

  std::span<const Point> corners_of(const Figure& figure) const {
    return {corners.data() + figure.first_corner, figure.corners};
  }
};

/// What lies behind: one colour, and rectangles over it, the later over the earlier. Figures may show within a window
/// alone.
struct Backdrop {
  struct Rect {
    double x0, y0, x1, y1;
    Colour colour;
  };
  Colour colour;
  std::vector<Rect> rects;
  std::optional<Rect> window;
};

}  // namespace psim::cli
