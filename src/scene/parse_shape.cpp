// The shapes of bodies and groups.
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "parse_limits.h"
#include "parse_parts.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 6> kShapes = {"disc",    "box",     "polygon",
                                                     "capsule", "segment", "chain"};
constexpr std::array<std::string_view, 1> kDiscKeys = {"radius"};
constexpr std::array<std::string_view, 1> kBoxKeys = {"size"};
constexpr std::array<std::string_view, 1> kPolygonKeys = {"vertices"};
constexpr std::array<std::string_view, 3> kCapsuleKeys = {"p1", "p2", "radius"};
constexpr std::array<std::string_view, 2> kSegmentKeys = {"p1", "p2"};
constexpr std::array<std::string_view, 2> kChainKeys = {"vertices", "loop"};
constexpr std::size_t kMostChainVertices = 10'000'000;

bool same(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }

std::vector<Vec2> read_vertices(const Node& node, std::size_t least, std::size_t most,
                                bool closed) {
  node.expect_array(least, most);
  std::vector<Vec2> vertices;
  vertices.reserve(node.size());
  for (std::size_t k = 0; k < node.size(); ++k) {
    const Node vertex = node.element(k);
    vertices.push_back(vertex.vec2(kCoordinate));
    if (k > 0 && same(vertices[k], vertices[k - 1])) {
      vertex.fail("is the vertex before it: two neighbours apart from each other");
    }
  }
  if (closed && same(vertices.front(), vertices.back())) {
    node.element(node.size() - 1)
        .fail("is the first vertex: a closed shape joins its last vertex to the first by itself");
  }
  return vertices;
}

SegmentShape read_segment(const Node& node) {
  const Node p1 = node.require("p1"), p2 = node.require("p2");
  const SegmentShape segment{p1.vec2(kCoordinate), p2.vec2(kCoordinate)};
  if (same(segment.p1, segment.p2)) p2.fail("is p1: two points apart from each other");
  return segment;
}

ChainShape read_chain(const Node& node) {
  ChainShape chain;
  chain.loop = node.boolean_or("loop", false);
  const Node vertices = node.require("vertices");
  chain.vertices = read_vertices(vertices, chain.loop ? 3 : 2, kMostChainVertices, chain.loop);
  return chain;
}

void expect_box(const Node& node) {
  const Node size = node.require("size");
  size.vec2(kRadius);
}

}  // namespace

double read_radius(const Node& radius, const Context& context) {
  const double value = radius.number(kRadius);
  const Bounds& b = context.bounds;
  const double largest = std::max(b.xmax - b.xmin, b.ymax - b.ymin);
  if (value > largest) {
    radius.fail(number_text(value) + " is larger than the world: at most " + number_text(largest) +
                ", the longer side of world.bounds");
  }
  return value;
}

Shape read_shape(const Node& shape, Context& context) {
  shape.expect_object(kShapes);
  if (shape.size() != 1) {
    shape.fail("has " + std::to_string(shape.size()) + " kinds of shape: exactly one of " +
               word_list(kShapes));
  }
  const std::string& kind = shape.json().get_ref<const Json::object_t&>().begin()->first;
  const Node node = shape.require(kind);
  if (kind == "disc") {
    node.expect_object(kDiscKeys);
    const Node radius = node.require("radius");
    return DiscShape{read_radius(radius, context)};
  }
  if (kind == "segment") {
    node.expect_object(kSegmentKeys);
    return read_segment(node);
  }
  if (kind == "chain") {
    node.expect_object(kChainKeys);
    return read_chain(node);
  }
  if (kind == "box") {
    node.expect_object(kBoxKeys);
    expect_box(node);
    context.availability.uses(Feature::boxes, node);
  } else if (kind == "polygon") {
    node.expect_object(kPolygonKeys);
    const Node vertices = node.require("vertices");
    read_vertices(vertices, 3, kMostPolygonVertices, true);
    context.availability.uses(Feature::polygons, node);
  } else {
    node.expect_object(kCapsuleKeys);
    read_segment(node);
    const Node radius = node.require("radius");
    read_radius(radius, context);
    context.availability.uses(Feature::capsules, node);
  }
  return DiscShape{};
}

void check_shape_against_type(const Node& shape, BodyType type, Context& context) {
  if (type == BodyType::static_body) return;
  for (const std::string_view kind : {"segment", "chain"}) {
    if (const std::optional<Node> node = shape.find(kind)) {
      context.availability.uses(Feature::moving_segments, *node);
    }
  }
}

}  // namespace psim::scene
