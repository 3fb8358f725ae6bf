#include "errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "body_outlines.h"
#include "engines/peer_bodies.h"

namespace psim::peers {
namespace {

using reference::Outline;

struct Piece {
  Outline outline;
  Bounds box;
  std::size_t body = 0;
};

Piece piece_of(Outline outline, std::size_t body) {
  const reference::Vec first = outline.points[0];
  Bounds box{first.x, first.y, first.x, first.y};
  for (const reference::Vec p : outline.points) {
    box = {std::min(box.xmin, p.x), std::min(box.ymin, p.y), std::max(box.xmax, p.x), std::max(box.ymax, p.y)};
  }
  const double r = outline.radius;
  return {std::move(outline), {box.xmin - r, box.ymin - r, box.xmax + r, box.ymax + r}, body};
}

bool is_outside(const WorldDesc& world, const BodyState& s) {
  const Bounds& b = world.bounds;
  return world.boundary == Boundary::walls && (s.x < b.xmin || s.x > b.xmax || s.y < b.ymin || s.y > b.ymax);
}

std::vector<Piece> pieces_of(Run& run) {
  std::vector<Piece> pieces;
  const auto& states = run.bodies();
  for (std::size_t k = 0; k < states.size(); ++k) {
    const BodyState& s = states[k];
    if (is_outside(run.model().scene.world, s)) continue;
    for (Outline& o : test::outlines(run.model().bodies[k].shape, {s.x, s.y}, s.angle)) {
      pieces.push_back(piece_of(std::move(o), k));
    }
  }
  std::ranges::sort(pieces, {}, [](const Piece& p) { return p.box.xmin; });
  return pieces;
}

using Pair = std::pair<std::uint64_t, std::uint64_t>;

/// Pairs that a joint lets pass through each other, the lower id first.
std::set<Pair> tied(const Model& model) {
  std::set<Pair> pairs;
  for (const SceneJoint& j : model.scene.joints) {
    if (!j.joint.collide) pairs.emplace(std::min(j.a, j.b), std::max(j.a, j.b));
  }
  return pairs;
}

double depth_of(const Outline& a, const Outline& b) {
  if (a.points.size() == 1 && b.points.size() == 1) {
    const reference::Vec p = a.points[0], q = b.points[0];
    return a.radius + b.radius - std::hypot(q.x - p.x, q.y - p.y);
  }
  return reference::depth(a, b);
}

void append_walls(const Bounds& walls, const Piece& piece, std::vector<double>& depths) {
  const Bounds& b = piece.box;
  for (const double way : {walls.xmin - b.xmin, b.xmax - walls.xmax, walls.ymin - b.ymin, b.ymax - walls.ymax}) {
    if (way > 0) depths.push_back(way);
  }
}

}  // namespace

std::vector<double> overlaps(Run& run) {
  const Model& model = run.model();
  const std::vector<Piece> pieces = pieces_of(run);
  const std::set<Pair> passing = tied(model);
  const auto moves = [&](std::size_t k) { return model.bodies[k].type == BodyType::dynamic_body; };
  const auto may_touch = [&](std::size_t a, std::size_t b) {
    if (a == b || (!moves(a) && !moves(b))) return false;
    if (!accuracy::collide(model.bodies[a].filter, model.bodies[b].filter)) return false;
    return !passing.contains({std::min(a, b), std::max(a, b)});
  };
  std::vector<double> depths;
  // Sorted by the left edge, a piece meets only those that begin before it ends.
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    if (model.scene.world.boundary == Boundary::walls && moves(p.body)) {
      append_walls(model.scene.world.bounds, p, depths);
    }
    for (std::size_t j = i + 1; j < pieces.size() && pieces[j].box.xmin <= p.box.xmax; ++j) {
      const Piece& q = pieces[j];
      if (q.box.ymin > p.box.ymax || q.box.ymax < p.box.ymin) continue;
      if (!may_touch(p.body, q.body)) continue;
      const double deep = depth_of(p.outline, q.outline);
      if (deep > 0) depths.push_back(deep);
    }
  }
  std::ranges::sort(depths);
  return depths;
}

int passed_walls(Run& run) {
  const auto& states = run.bodies();
  int count = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const bool moves = run.model().bodies[k].type == BodyType::dynamic_body;
    if (moves && is_outside(run.model().scene.world, states[k])) ++count;
  }
  return count;
}

double joint_gap(Run& run) {
  const Model& model = run.model();
  const auto& states = run.bodies();
  const auto anchor = [&](std::uint64_t body, Vec2 at) {
    const BodyState& s = states[body];
    const double c = std::cos(s.angle), d = std::sin(s.angle);
    return Vec2{s.x + c * at.x - d * at.y, s.y + d * at.x + c * at.y};
  };
  double widest = 0;
  for (const SceneJoint& j : model.scene.joints) {
    const Vec2 a = anchor(j.a, j.joint.anchor_a), b = anchor(j.b, j.joint.anchor_b);
    const double apart = std::hypot(b.x - a.x, b.y - a.y);
    double gap = 0;
    if (j.joint.type == JointType::revolute) gap = apart;
    if (j.joint.type == JointType::distance) gap = std::abs(apart - length_of(model, j));
    if (j.joint.type == JointType::rope) gap = apart - length_of(model, j);
    widest = std::max(widest, gap);
  }
  return widest;
}

Displacement displacement(Run& run) {
  Displacement most;
  const auto& states = run.bodies();
  for (std::size_t k = 0; k < states.size(); ++k) {
    const BodyDesc& start = run.model().bodies[k];
    if (start.type != BodyType::dynamic_body) continue;
    most.sideways = std::max(most.sideways, std::abs(states[k].x - start.position.x));
    most.down = std::max(most.down, start.position.y - states[k].y);
  }
  return most;
}

}  // namespace psim::peers
