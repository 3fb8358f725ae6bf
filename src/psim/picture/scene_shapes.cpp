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

double SceneShapes::reach(const Moment& moment, std::size_t row) const {
  const Shape& shape = of(moment.id[row]).shape;
  return is_disc(shape) ? moment.radius[row] : bounding_radius(shape);
}

std::optional<JointEnds> SceneShapes::ends_of(const DrawnJoint& joint, const Moment& moment) {
  if (joint.number < moment.lost.size() && moment.lost[joint.number] != 0) return {};
  const std::array body = {joint.a, joint.b};
  JointEnds ends;
  ends.anchor = {joint.joint.anchor_a, joint.joint.anchor_b};
  for (std::size_t side = 0; side < 2; ++side) {
    if (body[side] == kWorldSide) continue;
    const std::size_t row = moment.row_of(body[side]);
    if (row == moment.size()) return {};
    ends.place[side] = {moment.x[row], moment.y[row]};
    ends.anchor[side] = to_world(ends.anchor[side], ends.place[side], moment.angle[row]);
    ends.moves[side] = moment.type[row] != BodyType::static_body;
  }
  const auto [from, to] = ends.anchor;
  if (!std::isfinite(from.x + from.y + to.x + to.y)) return {};
  return ends;
}

}  // namespace psim::cli
