// bodies[] of a scene file, and the keys that they share with groups.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/range_text.h"
#include "base/rotor.h"
#include "file/parse_limits.h"
#include "file/parse_parts.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 3> kBodyTypes = {"dynamic", "static", "kinematic"};
constexpr std::array<std::string_view, 3> kLocks = {"x", "y", "angle"};
constexpr std::array<std::string_view, 5> kOwnKeys = {"name", "shape", "shapes", "position", "velocity"};

Locks read_locks(const Node& node) {
  node.expect_array(0, kLocks.size());
  Locks locks;
  for (std::size_t k = 0; k < node.size(); ++k) {
    constexpr std::array<bool Locks::*, 3> kOf = {&Locks::x, &Locks::y, &Locks::angle};
    bool& lock = locks.*kOf[node.element(k).one_of(kLocks)];
    if (lock) node.element(k).fail("stands there twice: each at most once");
    lock = true;
  }
  return locks;
}

BodyDesc read_body(const Node& node, Context& context, std::string& name) {
  static constexpr auto kKeys = joined(kOwnKeys, kSharedBodyKeys);
  node.expect_object(kKeys);
  BodyDesc body;
  if (const std::optional<Node> key = node.find("name")) {
    name = key->name();
    if (!name.empty() && !context.body_ids.emplace(name, context.body_count).second) {
      key->fail("another body has the name \"" + printable(name) + "\": names are unique");
    }
  }
  read_shared_body_keys(node, context, body);
  const Node position = node.require("position");
  const std::optional<Node> shapes = node.find("shapes");
  if (shapes && node.find("shape")) node.fail_at_key("shapes", "stands beside \"shape\": one of the two");
  body.position = position.vec2(limits::kCoordinate);
  expect_inside(position, body.position, context.bounds);
  body.shape = shapes ? read_shapes(*shapes, context, body) : read_shape(node.require("shape"), context, body.type);
  body.velocity = node.vec2_or("velocity", body.velocity, limits::kVelocity);
  return body;
}

}  // namespace

void read_shared_body_keys(const Node& node, const Context& context, BodyDesc& body) {
  if (const std::optional<Node> type = node.find("type")) {
    constexpr std::array<BodyType, 3> kOf = {BodyType::dynamic_body, BodyType::static_body, BodyType::kinematic_body};
    body.type = kOf[type->one_of(kBodyTypes)];
  }
  body.angle = node.number_or("angle", body.angle, limits::kAngle);
  body.angular_velocity = node.number_or("angular_velocity", body.angular_velocity, limits::kAngularVelocity);
  if (const std::optional<Node> material = node.find("material")) {
    body.material = named_material(*material, context);
  }
  read_material_keys(node, body.material);
  body.one_way = read_one_way(node).value_or(body.one_way);
  body.enabled = node.boolean_or("enabled", body.enabled);
  body.mass = node.number_or("mass", body.mass, limits::kMass);
  body.gravity_scale = node.number_or("gravity_scale", body.gravity_scale, limits::kGravityScale);
  body.fixed_rotation = node.boolean_or("fixed_rotation", body.fixed_rotation);
  body.bullet = node.boolean_or("bullet", body.bullet);
  body.filter = read_filter(node, body.filter);
  body.sensor = node.boolean_or("sensor", body.sensor);
  body.linear_damping = node.number_or("linear_damping", body.linear_damping, limits::kDamping);
  body.angular_damping = node.number_or("angular_damping", body.angular_damping, limits::kDamping);
  if (const std::optional<Node> locks = node.find("lock")) body.locks = read_locks(*locks);
}

std::optional<Vec2> read_one_way(const Node& node) {
  const std::optional<Node> key = node.find("one_way");
  if (!key) return std::nullopt;
  const Vec2 way = key->vec2(limits::kCoordinate);
  if (!limits::kAxis.contains(length_of(way))) key->fail("is no direction: its length " + range_text(limits::kAxis));
  return way;
}

Filter read_filter(const Node& node, Filter filter) {
  if (const std::optional<Node> category = node.find("category")) {
    filter.category = static_cast<std::uint32_t>(category->integer(0, kAllCategories));
  }
  if (const std::optional<Node> mask = node.find("mask")) {
    filter.mask = static_cast<std::uint32_t>(mask->integer(0, kAllCategories));
  }
  if (const std::optional<Node> group = node.find("group")) {
    filter.group = static_cast<std::int32_t>(group->signed_integer(-kLargestGroup, kLargestGroup));
  }
  return filter;
}

void read_bodies(const Node& scene, Context& context, Scene& out) {
  const std::optional<Node> bodies = scene.find("bodies");
  if (!bodies) return;
  bodies->expect_array(0, kMostBodiesInGroup);
  out.bodies.reserve(bodies->size());
  out.body_names.resize(bodies->size());
  for (std::size_t k = 0; k < bodies->size(); ++k) {
    out.bodies.push_back(read_body(bodies->element(k), context, out.body_names[k]));
    ++context.body_count;
  }
}

}  // namespace psim::scene
