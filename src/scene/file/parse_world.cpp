// materials, world, step and fields of a scene file.
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "file/parse_limits.h"
#include "file/parse_parts.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 5> kMaterialKeys = {"density", "restitution", "friction", "tangent_speed",
                                                           "rolling_resistance"};
constexpr std::array<std::string_view, 6> kWorldKeys = {"bounds",         "boundary", "gravity",
                                                        "linear_damping", "material", "mixing"};
constexpr std::array<std::string_view, 3> kBoundaries = {"walls", "periodic", "open"};
constexpr std::array<std::string_view, 6> kStepKeys = {
    "dt", "substeps", "sleeping", "integrator", "restitution_threshold", "skin"};
constexpr std::array<std::string_view, 4> kIntegrators = {"verlet", "euler", "rk4", "symplectic4"};
constexpr std::array<std::string_view, 4> kFieldTypes = {"well", "drag", "buoyancy", "wind"};
constexpr std::array<std::string_view, 6> kWellKeys = {"type",      "position", "strength",
                                                       "softening", "exponent", "range"};
constexpr std::array<std::string_view, 2> kMixingKeys = {"restitution", "friction"};
constexpr std::array<std::string_view, 3> kDragKeys = {"type", "linear", "quadratic"};
constexpr std::array<std::string_view, 7> kBuoyancyKeys = {
    "type", "region", "density", "linear_damping", "angular_damping", "flow", "mask"};
constexpr std::array<std::string_view, 7> kWindKeys = {"type", "velocity", "density", "drag", "lift", "region", "mask"};

std::uint32_t mask_or_all(const Node& field) {
  const auto mask = field.find("mask");
  return mask ? static_cast<std::uint32_t>(mask->integer(0, kAllCategories)) : 0xFFFFFFFFu;
}

BuoyancyField read_buoyancy(const Node& field) {
  field.expect_object(kBuoyancyKeys);
  BuoyancyField water;
  water.region = read_bounds(field.require("region"));
  water.density = field.require("density").number(limits::kDensity);
  water.linear_damping = field.number_or("linear_damping", water.linear_damping, limits::kDamping);
  water.angular_damping = field.number_or("angular_damping", water.angular_damping, limits::kDamping);
  if (const auto flow = field.find("flow")) water.flow = flow->vec2(limits::kVelocity);
  water.mask = mask_or_all(field);
  return water;
}

WindField read_wind(const Node& field) {
  field.expect_object(kWindKeys);
  WindField wind;
  wind.velocity = field.require("velocity").vec2(limits::kVelocity);
  wind.density = field.require("density").number(limits::kDensity);
  wind.drag = field.number_or("drag", wind.drag, limits::kWindFactor);
  wind.lift = field.number_or("lift", wind.lift, limits::kWindFactor);
  if (const auto region = field.find("region")) wind.region = read_bounds(*region);
  wind.mask = mask_or_all(field);
  return wind;
}

Field read_field(const Node& field) {
  field.expect_object();
  const Node type = field.require("type");
  if (type.one_of(kFieldTypes) == 0) {
    field.expect_object(kWellKeys);
    WellField well;
    const Node position = field.require("position"), strength = field.require("strength");
    well.position = position.vec2(limits::kCoordinate);
    well.strength = strength.number(limits::kWellStrength);
    well.softening = field.number_or("softening", well.softening, limits::kWellLength);
    well.exponent = field.number_or("exponent", well.exponent, limits::kWellExponent);
    well.range = field.number_or("range", well.range, limits::kWellLength);
    return well;
  }
  if (type.one_of(kFieldTypes) == 2) return read_buoyancy(field);
  if (type.one_of(kFieldTypes) == 3) return read_wind(field);
  field.expect_object(kDragKeys);
  DragField drag;
  drag.linear = field.number_or("linear", drag.linear, limits::kDamping);
  drag.quadratic = field.number_or("quadratic", drag.quadratic, limits::kDamping);
  return drag;
}

}  // namespace

std::string bounds_text(const Bounds& b) {
  return '[' + exact_text(b.xmin) + ", " + exact_text(b.ymin) + ", " + exact_text(b.xmax) + ", " + exact_text(b.ymax) +
         ']';
}

Bounds read_bounds(const Node& node) {
  node.expect_array(4, 4);
  const Bounds bounds{node.element(0).number(limits::kCoordinate), node.element(1).number(limits::kCoordinate),
                      node.element(2).number(limits::kCoordinate), node.element(3).number(limits::kCoordinate)};
  const double width = bounds.xmax - bounds.xmin, height = bounds.ymax - bounds.ymin;
  if (!(width > 0 && height > 0)) {
    node.fail(bounds_text(bounds) +
              " is no area: [xmin, ymin, xmax, ymax] with xmin < xmax and "
              "ymin < ymax");
  }
  for (const double extent : {width, height}) {
    if (limits::kExtent.contains(extent)) continue;
    node.fail(bounds_text(bounds) + ": width and height " + range_text(limits::kExtent) + " m");
  }
  return bounds;
}

void expect_inside(const Node& node, Vec2 position, const Bounds& bounds) {
  if (position.x >= bounds.xmin && position.x <= bounds.xmax && position.y >= bounds.ymin &&
      position.y <= bounds.ymax) {
    return;
  }
  node.fail('[' + exact_text(position.x) + ", " + exact_text(position.y) +
            "] is outside the world: inside world.bounds " + bounds_text(bounds));
}

const Material& named_material(const Node& name, const Context& context) {
  const std::string& wanted = name.string();
  const auto found = context.materials.find(wanted);
  if (found != context.materials.end()) return found->second;
  std::vector<std::string_view> known;
  for (const auto& [key, material] : context.materials) known.push_back(key);
  constexpr std::size_t kMostListed = 20;
  const std::string near = hint(wanted, known);
  if (known.size() > kMostListed) known.resize(kMostListed);
  name.fail("no material \"" + printable(wanted) + '"' + near +
            (known.empty() ? "; the scene has no materials" : "; materials: " + word_list(known)));
}

void read_material_keys(const Node& node, Material& material) {
  material.density = node.number_or("density", material.density, limits::kDensity);
  material.restitution = node.number_or("restitution", material.restitution, limits::kRestitution);
  material.friction = node.number_or("friction", material.friction, limits::kFriction);
  material.tangent_speed = node.number_or("tangent_speed", material.tangent_speed, limits::kTangentSpeed);
  material.rolling_resistance =
      node.number_or("rolling_resistance", material.rolling_resistance, limits::kRollingResistance);
}

Material read_material(const Node& node) {
  node.expect_object(kMaterialKeys);
  Material material;
  read_material_keys(node, material);
  return material;
}

void read_materials(const Node& scene, Context& context) {
  const std::optional<Node> materials = scene.find("materials");
  if (!materials) return;
  materials->expect_object();
  for (const auto& [name, unused] : materials->json().get_ref<const Json::object_t&>()) {
    context.materials[name] = read_material(materials->require(name));
  }
}

void read_world(const Node& scene, Context& context, WorldDesc& world) {
  const Node node = scene.require("world");
  node.expect_object(kWorldKeys);
  const std::optional<Node> bounds = node.find("bounds"), boundary = node.find("boundary");
  world.bounds = context.bounds = bounds ? read_bounds(*bounds) : kOpenBounds;
  if (boundary) {
    constexpr std::array<Boundary, 3> kOf = {Boundary::walls, Boundary::periodic, Boundary::open};
    world.boundary = kOf[boundary->one_of(kBoundaries)];
    if (!bounds && world.boundary != Boundary::open) {
      boundary->fail("needs \"bounds\": a world without them is \"open\"");
    }
  } else if (!bounds) {
    world.boundary = Boundary::open;
  }
  if (const std::optional<Node> mixing = node.find("mixing")) {
    mixing->expect_object(kMixingKeys);
    const auto read_rule = [&](std::string_view key, Mixing& rule) {
      if (const auto given = mixing->find(key)) rule = static_cast<Mixing>(given->one_of(kMixingNames));
    };
    read_rule("restitution", world.mixing.restitution);
    read_rule("friction", world.mixing.friction);
  }
  world.gravity = node.vec2_or("gravity", world.gravity, limits::kGravity);
  world.linear_damping = node.number_or("linear_damping", world.linear_damping, limits::kDamping);
  if (const std::optional<Node> material = node.find("material")) {
    world.wall = named_material(*material, context);
  } else if (const auto wall = context.materials.find("wall"); wall != context.materials.end()) {
    world.wall = wall->second;
  }
}

void read_step(const Node& scene, Scene& out) {
  const std::optional<Node> step = scene.find("step");
  if (!step) return;
  step->expect_object(kStepKeys);
  out.world.dt = step->number_or("dt", out.world.dt, limits::kTimeStep);
  if (const std::optional<Node> substeps = step->find("substeps")) {
    out.world.substeps = static_cast<int>(substeps->integer(static_cast<std::uint64_t>(limits::kSubsteps.min),
                                                            static_cast<std::uint64_t>(limits::kSubsteps.max)));
  }
  out.world.sleeping = step->boolean_or("sleeping", out.world.sleeping);
  out.world.restitution_threshold =
      step->number_or("restitution_threshold", out.world.restitution_threshold, limits::kSpeed);
  out.world.skin = step->number_or("skin", out.world.skin, limits::kSkin);
  if (const std::optional<Node> integrator = step->find("integrator")) {
    out.world.integrator = kAllIntegrators[integrator->one_of(kIntegrators)];
  }
}

void read_fields(const Node& scene, WorldDesc& world) {
  const std::optional<Node> fields = scene.find("fields");
  if (!fields) return;
  fields->expect_array(0, 1000);
  for (std::size_t k = 0; k < fields->size(); ++k) {
    world.fields.push_back(read_field(fields->element(k)));
  }
}

}  // namespace psim::scene
