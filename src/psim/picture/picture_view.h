// Which part of the world a picture shows, and where its metres fall on pixels.
#pragma once

#include "options/picture_options.h"
#include "picture/canvas.h"
#include "picture/scene_shapes.h"

namespace psim::cli {

/// What bodies, fluids, joints and wells fill, but for bodies and particles far away from most others; in an open world only a part of ground
/// that reaches far. On an axis on which that is 60 % of a world with sides, all of it. A little room is left around it.
Bounds view_of_all(const Scene& scene, const Moment& moment, const SceneShapes& shapes);

/// The view of a film. It begins with what the scene fills and widens, never narrows, as the scene spreads; bodies that
/// fly far away from most others are let go. Depends on the pictures before alone.
class FilmView {
 public:
  FilmView(const Scene& scene, const SceneShapes& shapes) : scene_(scene), shapes_(shapes) {}
  const Bounds& follow(const Moment& moment);

 private:
  const Scene& scene_;
  const SceneShapes& shapes_;
  bool begun_ = false;
  Bounds wanted_, view_;
};

/// From metres to pixels, the same scale on both axes, the view in the middle.
class PictureCamera {
 public:
  PictureCamera(const Bounds& view, int width, int height);

  Point at(Vec2 metres) const { return {(metres.x - left_) * scale_, (top_ - metres.y) * scale_}; }
  double length(double metres) const { return metres * scale_; }
  /// The part of the world in a picture of this size.
  Bounds shown(int width, int height) const { return {left_, top_ - height / scale_, left_ + width / scale_, top_}; }

 private:
  double scale_, left_, top_;
};

/// The size of a picture of the view whose longer side has `long_side` pixels; no side is shorter than 240.
PictureSize size_for(const Bounds& view, int long_side);

}  // namespace psim::cli
