// The shapes of bodies and groups.
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/rotor.h"
#include "bodies/hull.h"
#include "file/parse_limits.h"
#include "file/parse_parts.h"
#include "psim/outline.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 7> kShapes = {"disc",    "box",     "polygon", "outline",
                                                     "capsule", "segment", "chain"};
constexpr std::array<std::string_view, 12> kPartKeys = {
    "tangent_speed", "rolling_resistance", "one_way",  "position", "angle", "density",
    "restitution",   "friction",           "category", "mask",     "group", "sensor"};
constexpr std::array<std::string_view, 1> kDiscKeys = {"radius"};
constexpr std::array<std::string_view, 2> kBoxKeys = {"size", "radius"};
constexpr std::array<std::string_view, 2> kPolygonKeys = {"vertices", "radius"};
constexpr std::array<std::string_view, 3> kCapsuleKeys = {"p1", "p2", "radius"};
constexpr std::array<std::string_view, 2> kSegmentKeys = {"p1", "p2"};
constexpr std::array<std::string_view, 3> kChainKeys = {"vertices", "loop", "materials"};

bool same(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }

std::vector<Vec2> read_points(const Node& node, std::size_t least, std::size_t most) {
  node.expect_array(least, most);
  std::vector<Vec2> points;
  points.reserve(node.size());
  for (std::size_t k = 0; k < node.size(); ++k) {
    points.push_back(node.element(k).vec2(limits::kCoordinate));
  }
  return points;
}

SegmentShape read_segment(const Node& node) {
  const Node p1 = node.require("p1"), p2 = node.require("p2");
  const SegmentShape segment{p1.vec2(limits::kCoordinate), p2.vec2(limits::kCoordinate)};
  if (same(segment.p1, segment.p2)) p2.fail("is p1: two points apart from each other");
  return segment;
}

// One material for each segment: its name, or itself.
std::vector<Material> read_segment_materials(const Node& node, std::size_t segments, const Context& context) {
  node.expect_array(0, kMostChainVertices);
  if (node.size() != segments) {
    node.fail("has " + std::to_string(node.size()) + " elements: one for each segment, " + std::to_string(segments));
  }
  std::vector<Material> materials;
  materials.reserve(segments);
  for (std::size_t k = 0; k < segments; ++k) {
    const Node element = node.element(k);
    materials.push_back(element.is_string() ? named_material(element, context) : read_material(element));
  }
  return materials;
}

ChainShape read_chain(const Node& node, const Context& context) {
  ChainShape chain;
  chain.loop = node.boolean_or("loop", false);
  const Node vertices = node.require("vertices");
  chain.vertices = read_points(vertices, chain.loop ? 3 : 2, kMostChainVertices);
  for (std::size_t k = 1; k < chain.vertices.size(); ++k) {
    if (same(chain.vertices[k], chain.vertices[k - 1])) {
      vertices.element(k).fail("is the vertex before it: two neighbours apart from each other");
    }
  }
  if (chain.loop && same(chain.vertices.front(), chain.vertices.back())) {
    vertices.element(vertices.size() - 1)
        .fail("is the first vertex: a loop joins its last vertex to the first by itself");
  }
  if (std::string error; !is_line(chain.vertices, error)) vertices.fail(std::move(error));
  if (const std::optional<Node> materials = node.find("materials")) {
    chain.materials = read_segment_materials(*materials, chain.vertices.size() - (chain.loop ? 0 : 1), context);
  }
  return chain;
}

CapsuleShape read_capsule(const Node& node, const Context& context) {
  const SegmentShape line = read_segment(node);
  const Node radius = node.require("radius");
  return {line.p1, line.p2, read_radius(radius, context)};
}

BoxShape read_box(const Node& node) {
  const Node size = node.require("size");
  const Vec2 sides = size.vec2(limits::kRadius);
  return {sides.x, sides.y, node.number_or("radius", 0, limits::kRounding)};
}

PolygonShape read_polygon(const Node& node) {
  const Node vertices = node.require("vertices");
  PolygonShape polygon{read_points(vertices, 3, kMostPolygonVertices), 0};
  polygon.radius = node.number_or("radius", 0, limits::kRounding);
  return polygon;
}

// The convex polygons that an outline is cut into.
std::vector<ShapePart> read_outline(const Node& node) {
  node.expect_object(kPolygonKeys);
  const std::vector<Vec2> vertices = read_points(node.require("vertices"), 3, kMostOutlineVertices);
  const double radius = node.number_or("radius", 0, limits::kRounding);
  std::string error;
  std::vector<ShapePart> parts = cut_outline(vertices, radius, error);
  if (!error.empty()) node.fail(std::move(error));
  return parts;
}

// Concave, crossing itself, without area, too small: what the engine cannot simulate.
Shape checked(const Node& node, Shape shape) {
  HullSet unused;
  std::string error;
  if (!make_hulls(shape, true, unused, error)) node.fail(std::move(error));
  return shape;
}

}  // namespace

double read_radius(const Node& radius, const Context& context) {
  const double value = radius.number(limits::kRadius);
  const Bounds& b = context.bounds;
  const double largest = std::max(b.xmax - b.xmin, b.ymax - b.ymin);
  if (value > largest) {
    radius.fail(exact_text(value) + " is larger than the world: at most " + exact_text(largest) +
                ", the longer side of world.bounds");
  }
  return value;
}

namespace {

// The shape under the key that names its kind.
Shape read_kind(const Node& shape, std::string_view kind, const Context& context, BodyType type) {
  const Node node = shape.require(kind);
  if (kind == "disc") {
    node.expect_object(kDiscKeys);
    const Node radius = node.require("radius");
    return DiscShape{read_radius(radius, context)};
  }
  if (kind == "box") {
    node.expect_object(kBoxKeys);
    return checked(node, read_box(node));
  }
  if (kind == "polygon") {
    node.expect_object(kPolygonKeys);
    return checked(node, read_polygon(node));
  }
  if (kind == "outline") {
    std::vector<ShapePart> parts = read_outline(node);
    return checked(node, parts.size() == 1 ? shape_of(parts[0]) : CompoundShape{std::move(parts)});
  }
  if (kind == "capsule") {
    node.expect_object(kCapsuleKeys);
    return checked(node, read_capsule(node, context));
  }
  if (kind == "segment") {
    node.expect_object(kSegmentKeys);
    return checked(node, read_segment(node));
  }
  node.expect_object(kChainKeys);
  ChainShape chain = read_chain(node, context);
  if (type == BodyType::dynamic_body) {
    node.fail("is the shape of a dynamic body: a chain is \"static\" or \"kinematic\" only");
  }
  return chain;
}

// The one key of a shape that names its kind.
std::string_view kind_of(const Node& shape) {
  std::size_t kinds = 0;
  std::string_view found;
  for (const std::string_view kind : kShapes) {
    if (!shape.find(kind)) continue;
    ++kinds;
    found = kind;
  }
  if (kinds != 1) {
    shape.fail("has " + std::to_string(kinds) + " kinds of shape: exactly one of " + word_list(kShapes));
  }
  return found;
}

// All but the shape where that is an outline, which becomes several parts.
ShapePart read_part(const Node& node, const Context& context, const BodyDesc& body) {
  static constexpr auto kKeys = joined(kShapes, kPartKeys);
  node.expect_object(kKeys);
  ShapePart part;
  const auto simple = [&](const auto& shape) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(shape)>, CompoundShape>) part.shape = shape;
  };
  const std::string_view kind = kind_of(node);
  if (kind != "outline") std::visit(simple, read_kind(node, kind, context, body.type));
  part.position = node.vec2_or("position", part.position, limits::kCoordinate);
  part.angle = node.number_or("angle", part.angle, limits::kAngle);
  if (const auto key = node.find("density")) part.density = key->number(limits::kDensity);
  if (const auto key = node.find("restitution")) part.restitution = key->number(limits::kRestitution);
  if (const auto key = node.find("friction")) part.friction = key->number(limits::kFriction);
  if (node.find("category") || node.find("mask") || node.find("group")) part.filter = read_filter(node, body.filter);
  if (const auto key = node.find("tangent_speed")) part.tangent_speed = key->number(limits::kTangentSpeed);
  if (const auto key = node.find("rolling_resistance")) {
    part.rolling_resistance = key->number(limits::kRollingResistance);
  }
  part.one_way = read_one_way(node);
  if (const auto key = node.find("sensor")) part.sensor = key->boolean();
  return part;
}

// Adds the parts of an outline, each with what is the outline's own.
void add_outline(const Node& node, const ShapePart& whole, std::vector<ShapePart>& parts) {
  const SineCosine turn = sine_cosine(whole.angle);
  for (const ShapePart& piece : read_outline(node)) {
    ShapePart& part = parts.emplace_back(whole);
    part.shape = piece.shape;
    part.position = whole.position + turned(turn, piece.position);
  }
}

}  // namespace

Shape read_shape(const Node& shape, const Context& context, BodyType type) {
  shape.expect_object(kShapes);
  return read_kind(shape, kind_of(shape), context, type);
}

Shape read_shapes(const Node& shapes, const Context& context, const BodyDesc& body) {
  shapes.expect_array(1, kMostParts);
  CompoundShape compound;
  compound.parts.reserve(shapes.size());
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const Node node = shapes.element(k);
    const ShapePart part = read_part(node, context, body);
    if (const std::optional<Node> outline = node.find("outline")) {
      add_outline(*outline, part, compound.parts);
    } else {
      compound.parts.push_back(part);
    }
  }
  if (compound.parts.size() > kMostParts) {
    shapes.fail("has " + std::to_string(compound.parts.size()) + " parts with those of outlines: at most " +
                std::to_string(kMostParts));
  }
  return checked(shapes, std::move(compound));
}

}  // namespace psim::scene
