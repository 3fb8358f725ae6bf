// What part of the world the window shows.
#pragma once

#include "psim/types.h"

namespace psim::view {

/// Pixels count from the window's upper left corner, y down; the world's y is up.
class Camera {
 public:
  /// Shows all of `part`, centred, with a small margin; the first `covered` pixels from the left
  /// stay free of it.
  void fit(const Bounds& part, int width, int height, int covered = 0);
  void resize(int width, int height);
  /// Moves the picture by (dx, dy) pixels.
  void pan(double dx, double dy);
  /// Zooms so that what is at the pixel (px, py) stays there.
  void zoom_at(double px, double py, double factor);

  Vec2 to_world(double px, double py) const;
  Vec2 to_screen(Vec2 place) const;
  double pixels_per_metre() const { return scale_; }
  Vec2 centre() const { return centre_; }
  /// The part of the world in the window.
  Bounds shown() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Vec2 centre_;
  double scale_ = 1;  // pixels a metre
  int width_ = 1, height_ = 1;
};

}  // namespace psim::view
