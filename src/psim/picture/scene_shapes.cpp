#include "picture/scene_shapes.h"

#include <cmath>

namespace psim::cli {

bool SceneShapes::is_drawn(const Moment& moment, std::size_t row) const {
  return moment.id[row] < known_ && std::isfinite(moment.x[row] + moment.y[row] + moment.angle[row]);
}

std::vector<Outline> SceneShapes::placed(const Moment& moment, std::size_t row) const {
  const BodyDesc& body = of(moment.id[row]);
  const Vec2 at = {moment.x[row], moment.y[row]};
  if (is_disc(body.shape)) return {{{at}, moment.radius[row]}};
  std::vector<Outline> all = outlines(body.shape);
  const double c = std::cos(moment.angle[row]), s = std::sin(moment.angle[row]);
  for (Outline& line : all) {
    for (Vec2& p : line.points) p = {at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y};
  }
  return all;
}

}  // namespace psim::cli
