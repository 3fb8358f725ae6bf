// Which part of the world a picture shows, and where its metres fall on pixels.
#pragma once

#include "options/picture_options.h"
#include "picture/canvas.h"
#include "picture/scene_shapes.h"

namespace psim::cli {

/// The whole world, axis by axis, unless less than 60 % of it is in use: then what the bodies fill, in
/// an open world without fixed geometry far away. A little room is left around it.
Bounds view_of_all(const Scene& scene, const Moment& moment, const SceneShapes& shapes);

/// The view of a film. It begins with what the scene fills and widens, never narrows, as the scene spreads; a
/// few bodies of many that fly far away are let go. Depends on the pictures before alone.
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

 private:
  double scale_, left_, top_;
};

/// The size of a picture of the view whose longer side has `long_side` pixels; no side is shorter than 240.
PictureSize size_for(const Bounds& view, int long_side);

}  // namespace psim::cli
