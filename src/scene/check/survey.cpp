#include "check/survey.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include "base/rotor.h"
#include "bodies/body_desc.h"
#include "place/links.h"
#include "place/placement.h"
#include "place/shape_size.h"

namespace psim {
namespace {

// What bodies of one description have in common.
struct Kind {
  std::shared_ptr<const HullSet> hulls;  // none: a disc
  double area = 0;                       // mass / density
  double inner = 0;
  std::shared_ptr<const std::vector<PartProperties>> parts = nullptr;  // of a compound whose parts differ
};

// What the parts of a body have, if some have something of their own.
std::shared_ptr<const std::vector<PartProperties>> parts_of(const BodyDesc& body) {
  const auto* compound = std::get_if<CompoundShape>(&body.shape);
  if (compound == nullptr) return nullptr;
  auto parts = std::make_shared<std::vector<PartProperties>>();
  for (const ShapePart& part : compound->parts) parts->push_back(part_properties(part, body));
  return parts;
}

Kind kind_of(const BodyDesc& body) {
  Kind kind;
  const Shape& shape = body.shape;
  if (is_disc(shape)) return kind;
  HullSet about_centre;
  auto hulls = std::make_shared<HullSet>();
  std::string error;
  if (!make_hulls(shape, true, about_centre, error) || !make_hulls(shape, false, *hulls, error)) {
    return kind;  // whoever builds the world says so
  }
  kind.area = about_centre.mass.area;
  const Hull& hull = about_centre.parts.front();
  kind.inner = hull.inner > 0 ? hull.inner : hull.reach;
  kind.hulls = std::move(hulls);
  kind.parts = parts_of(body);
  return kind;
}

bool leaves(const WorldDesc& world, const BodyDesc& body, const PlacedBody& placed) {
  const Bounds& b = world.bounds;
  const auto inside = [&](const Bounds& box, double slack) {
    return box.xmin >= b.xmin - slack && box.xmax <= b.xmax + slack && box.ymin >= b.ymin - slack &&
           box.ymax <= b.ymax + slack;
  };
  const Vec2 at{placed.x, placed.y};
  if (world.boundary != Boundary::walls) return !inside({at.x, at.y, at.x, at.y}, 0);
  const Shape shape = placed.hulls ? body.shape : Shape(DiscShape{placed.radius});
  return !inside(extent(shape, at, body.angle), placed.radius * kOverlapTolerance);
}

Owner owner_of(const BodyDesc& body, std::string name) {
  Owner owner;
  owner.name = std::move(name);
  owner.type = body.type;
  owner.gravity_scale = body.gravity_scale;
  owner.restitution = body.material.restitution;
  owner.is_disc = is_disc(body.shape);
  return owner;
}

void see(Survey& survey, Owner& owner, const WorldDesc& world, const BodyDesc& body, const Kind& kind,
         PlacedBody placed, Vec2 velocity) {
  const double r = kind.hulls ? kind.inner : placed.radius;
  const double area = kind.hulls ? kind.area : std::numbers::pi * r * r;
  const double mass = body.mass > 0 ? body.mass : body.material.density * area;
  const double speed = std::sqrt(velocity.x * velocity.x + velocity.y * velocity.y);
  owner.has_bodies = true;
  owner.radius_min = std::min(owner.radius_min, r);
  owner.radius_max = std::max(owner.radius_max, r);
  owner.mass_min = std::min(owner.mass_min, mass);
  owner.mass_max = std::max(owner.mass_max, mass);
  if (speed > owner.speed_over_radius * r) {
    owner.speed_over_radius = speed / r;
    owner.fastest = speed;
    owner.fastest_radius = r;
  }
  placed.hulls = kind.hulls;
  placed.turn = rotor_of(body.angle);
  placed.filter = body.filter;
  placed.parts = kind.parts;
  if (body.type == BodyType::dynamic_body && leaves(world, body, placed)) ++owner.outside;
  if (!body.sensor) survey.bodies.push_back(std::move(placed));
}

void see_segments(Survey& survey, const BodyDesc& body, std::uint32_t owner) {
  const Outline line = outlines(body.shape).front();
  std::vector<Vec2> vertices = line.points;
  if (line.closed && vertices.size() > 2) vertices.push_back(vertices.front());
  for (Vec2& v : vertices) v = to_world(v, body.position, body.angle);
  for (std::size_t k = 0; k + 1 < vertices.size(); ++k) {
    survey.segments.push_back({vertices[k], vertices[k + 1], owner, body.filter});
  }
}

// Segments and chains that stand or are led.
bool is_line(const BodyDesc& body) {
  return std::holds_alternative<ChainShape>(body.shape) ||
         (std::holds_alternative<SegmentShape>(body.shape) && body.type != BodyType::dynamic_body);
}

}  // namespace

namespace {

// A body as bodies to look at: itself, or, of a fixed one with several shapes, of which there may be thousands, each.
std::vector<BodyDesc> pieces_of(const BodyDesc& body) {
  const auto* compound = std::get_if<CompoundShape>(&body.shape);
  if (compound == nullptr || body.type != BodyType::static_body) return {body};
  BodyDesc bare = body;
  bare.shape = DiscShape{};
  std::vector<BodyDesc> pieces;
  for (const ShapePart& part : compound->parts) {
    BodyDesc& piece = pieces.emplace_back(bare);
    piece.shape = shape_of(part);
    piece.filter = part.filter.value_or(body.filter);
    piece.sensor = part.sensor.value_or(body.sensor);
    piece.position = to_world(part.position, body.position, body.angle);
    piece.angle = body.angle + part.angle;
  }
  return pieces;
}

}  // namespace

std::string body_name(const Scene& scene, std::size_t k) {
  std::string name = "bodies[" + std::to_string(k) + "]";
  if (k < scene.body_names.size() && !scene.body_names[k].empty()) {
    name += " \"" + scene.body_names[k] + "\"";
  }
  return name;
}

Survey look_at(const Scene& scene) {
  Survey survey;
  std::uint32_t id = 0;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k, ++id) {
    const BodyDesc& body = scene.bodies[k];
    Owner owner = owner_of(body, body_name(scene, k));
    const auto place = static_cast<std::uint32_t>(survey.owners.size());
    for (const BodyDesc& piece : pieces_of(body)) {
      if (is_line(piece)) {
        if (!piece.sensor) see_segments(survey, piece, place);
        continue;
      }
      PlacedBody placed{piece.position.x, piece.position.y, bounding_radius(piece.shape), place, 0, id};
      placed.moves = piece.type == BodyType::dynamic_body;
      see(survey, owner, scene.world, piece, kind_of(piece), placed, piece.velocity);
    }
    survey.owners.push_back(std::move(owner));
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    const GroupDesc group = seeded_group(scene, k);
    Owner owner = owner_of(group.body, "groups[" + std::to_string(k) + "]");
    const auto place = static_cast<std::uint32_t>(survey.owners.size());
    std::string error;
    if (const std::optional<PlacedGroup> placed = place_group(group, error)) {
      const Kind kind = kind_of(group.body);
      for (std::size_t i = 0; i < placed->x.size(); ++i, ++id) {
        PlacedBody body{placed->x[i], placed->y[i], placed->radius[i], place, static_cast<std::uint32_t>(i), id};
        body.moves = group.body.type == BodyType::dynamic_body && !is_pinned(group, i);
        see(survey, owner, scene.world, group.body, kind, body, {placed->vx[i], placed->vy[i]});
      }
    } else {
      survey.misplaced.push_back(owner.name + ": " + error);
    }
    survey.owners.push_back(std::move(owner));
  }
  return survey;
}

}  // namespace psim
