// groups[] of a scene file: many alike bodies, placed by a layout or listed.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "file/parse_limits.h"
#include "file/parse_parts.h"
#include "place/shape_size.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 5> kLayouts = {"lattice", "hex", "random", "explicit", "ring"};
constexpr std::array<std::string_view, 11> kPlacedKeys = {
    "layout", "count", "region", "shape", "shapes", "radius", "jitter", "velocity", "velocity_spread", "seed", "links"};
constexpr std::array<std::string_view, 9> kListedKeys = {"layout", "x",  "y",  "shape",   "shapes",
                                                         "radius", "vx", "vy", "velocity"};

// Of a group: `radius`, `shape` or `shapes`, one of them. Gives the radius node, or nothing if the shape
// said it all.
std::optional<Node> radius_or_shape(const Node& node, const Context& context, GroupDesc& group) {
  const std::optional<Node> radius = node.find("radius"), shapes = node.find("shapes");
  const std::optional<Node> shape = shapes ? shapes : node.find("shape");
  if (radius && shape) {
    node.fail_at_key("radius", "stands beside " + std::string(shapes ? "\"shapes\"" : "\"shape\"") +
                                   ": one of the two says how large a body is");
  }
  if (shapes && node.find("shape")) node.fail_at_key("shapes", "stands beside \"shape\": one of the two");
  if (!shape) return node.require("radius");
  group.body.shape = shapes ? read_shapes(*shapes, context, group.body) : read_shape(*shape, context, group.body.type);
  if (std::holds_alternative<ChainShape>(group.body.shape)) {
    shape->fail("is no shape of a group: chains stand in \"bodies\"");
  }
  group.radius_min = group.radius_max = bounding_radius(group.body.shape);
  if (is_disc(group.body.shape)) group.body.shape = DiscShape{};
  return std::nullopt;
}

std::vector<double> read_column(const Node& node, Range range, std::size_t wanted) {
  node.expect_array(0, kMostBodiesInGroup);
  if (node.size() != wanted) {
    node.fail(count_text(node.size()) + ", \"x\" has " + std::to_string(wanted) + ": one for each body");
  }
  std::vector<double> column(wanted);
  for (std::size_t k = 0; k < wanted; ++k) column[k] = node.element(k).number(range);
  return column;
}

void read_placed(const Node& node, const Context& context, GroupDesc& group) {
  const Node count = node.require("count"), region = node.require("region");
  group.count = count.integer(0, kMostBodiesInGroup);
  group.region = read_bounds(region);
  const Bounds& b = context.bounds;
  if (group.region.xmin < b.xmin || group.region.ymin < b.ymin || group.region.xmax > b.xmax ||
      group.region.ymax > b.ymax) {
    region.fail(bounds_text(group.region) + " reaches out of the world: inside world.bounds " + bounds_text(b));
  }
  if (const std::optional<Node> radius = radius_or_shape(node, context, group)) {
    if (radius->json().is_array()) {
      radius->expect_array(2, 2);
      const Node largest = radius->element(1);
      group.radius_min = read_radius(radius->element(0), context);
      group.radius_max = read_radius(largest, context);
      if (group.radius_min > group.radius_max) {
        largest.fail("is less than the smallest: [smallest, largest]");
      }
    } else {
      group.radius_min = group.radius_max = read_radius(*radius, context);
    }
  }
  group.jitter = node.number_or("jitter", group.jitter, kJitter);
  if (group.jitter != 0 && group.layout == Layout::ring) {
    node.fail_at_key("jitter", "is for layout \"lattice\" or \"hex\": the bodies of a ring stand where it says");
  }
  group.velocity = node.vec2_or("velocity", group.velocity, limits::kVelocity);
  group.velocity_spread = node.number_or("velocity_spread", group.velocity_spread, limits::kSpeed);
  if (const std::optional<Node> seed = node.find("seed")) {
    group.seed = seed->integer(0, std::numeric_limits<std::uint64_t>::max());
  }
  group.links = read_links(node, group);
}

void expect_in_interval(const Node& column, const std::vector<double>& values, double min, double max) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (values[k] >= min && values[k] <= max) continue;
    column.element(k).fail(exact_text(values[k]) + " is outside the world: inside world.bounds, " + exact_text(min) +
                           " to " + exact_text(max));
  }
}

void read_listed(const Node& node, const Context& context, GroupDesc& group) {
  const Node x = node.require("x"), y = node.require("y");
  x.expect_array(0, kMostBodiesInGroup);
  group.count = x.size();
  group.x = read_column(x, limits::kCoordinate, x.size());
  group.y = read_column(y, limits::kCoordinate, x.size());
  expect_in_interval(x, group.x, context.bounds.xmin, context.bounds.xmax);
  expect_in_interval(y, group.y, context.bounds.ymin, context.bounds.ymax);

  const std::optional<Node> radius = radius_or_shape(node, context, group);
  if (radius && radius->json().is_array()) {
    group.radius = read_column(*radius, limits::kRadius, x.size());
    for (std::size_t k = 0; k < x.size(); ++k) read_radius(radius->element(k), context);
    if (!group.radius.empty()) {
      const auto [least, most] = std::ranges::minmax(group.radius);
      group.radius_min = least;
      group.radius_max = most;
    }
  } else {
    if (radius) group.radius_min = group.radius_max = read_radius(*radius, context);
    group.radius = {group.radius_min};
  }

  const std::optional<Node> vx = node.find("vx"), vy = node.find("vy");
  if ((vx || vy) && node.find("velocity")) {
    node.fail_at_key("velocity", "stands beside \"vx\" or \"vy\": one of the two ways");
  }
  if (vx) group.vx = read_column(*vx, limits::kVelocity, x.size());
  if (vy) group.vy = read_column(*vy, limits::kVelocity, x.size());
  group.velocity = node.vec2_or("velocity", group.velocity, limits::kVelocity);
}

GroupDesc read_group(const Node& node, const Context& context) {
  static constexpr auto kPlaced = joined(kPlacedKeys, kSharedBodyKeys);
  static constexpr auto kListed = joined(kListedKeys, kSharedBodyKeys);
  constexpr std::array<Layout, 5> kOf = {Layout::lattice, Layout::hex, Layout::random, Layout::explicit_list,
                                         Layout::ring};
  node.expect_object();
  GroupDesc group;
  const Node layout = node.require("layout");
  group.layout = kOf[layout.one_of(kLayouts)];
  const bool listed = group.layout == Layout::explicit_list;
  node.expect_object(listed ? KeyList(kListed) : KeyList(kPlaced));
  read_shared_body_keys(node, context, group.body);
  if (listed) {
    read_listed(node, context, group);
  } else {
    read_placed(node, context, group);
  }
  return group;
}

}  // namespace

void read_groups(const Node& scene, Context& context, Scene& out) {
  const std::optional<Node> groups = scene.find("groups");
  if (!groups) return;
  groups->expect_array(0, kMostBodiesInGroup);
  out.groups.reserve(groups->size());
  for (std::size_t k = 0; k < groups->size(); ++k) {
    out.groups.push_back(read_group(groups->element(k), context));
    context.body_count += out.groups.back().count;
  }
}

}  // namespace psim::scene
