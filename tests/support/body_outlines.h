// The shapes of the public API as outlines of the oracle (reference/outlines.h), which knows no psim.
#pragma once

#include <psim/desc.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

#include "outlines.h"

namespace psim::test {

inline reference::Vec exact(Vec2 v) { return {v.x, v.y}; }

/// The outlines of a body that stands at `at`, turned by `angle`.
inline std::vector<reference::Outline> outlines(const Shape& shape, Vec2 at, double angle) {
  std::vector<reference::Outline> parts;
  const double c = std::cos(angle), s = std::sin(angle);
  if (const auto* compound = std::get_if<CompoundShape>(&shape)) {
    for (const ShapePart& part : compound->parts) {
      const Shape simple = std::visit([](const auto& of) -> Shape { return of; }, part.shape);
      const Vec2 at_part{at.x + c * part.position.x - s * part.position.y,
                         at.y + s * part.position.x + c * part.position.y};
      for (reference::Outline& o : outlines(simple, at_part, angle + part.angle)) parts.push_back(std::move(o));
    }
    return parts;
  }
  const auto place = [&](Vec2 p) { return reference::Vec{at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y}; };
  if (const auto* disc = std::get_if<DiscShape>(&shape)) {
    parts.push_back({{exact(at)}, disc->radius});
  } else if (const auto* line = std::get_if<SegmentShape>(&shape)) {
    parts.push_back({{place(line->p1), place(line->p2)}, 0});
  } else if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) {
    parts.push_back({{place(capsule->p1), place(capsule->p2)}, capsule->radius});
  } else if (const auto* chain = std::get_if<ChainShape>(&shape)) {
    const std::size_t n = chain->vertices.size();
    for (std::size_t k = 0; k + (chain->loop ? 0 : 1) < n; ++k) {
      parts.push_back({{place(chain->vertices[k]), place(chain->vertices[(k + 1) % n])}, 0});
    }
  } else if (const auto* box = std::get_if<BoxShape>(&shape)) {
    const double x = box->width / 2, y = box->height / 2;
    parts.push_back({{place({-x, -y}), place({x, -y}), place({x, y}), place({-x, y})}, box->radius});
  } else if (const auto* polygon = std::get_if<PolygonShape>(&shape)) {
    parts.push_back({{}, polygon->radius});
    for (const Vec2 v : polygon->vertices) parts.back().points.push_back(place(v));
  }
  return parts;
}

}  // namespace psim::test
