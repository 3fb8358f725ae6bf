// fluids[] of a scene file: what a fluid is made of, and which places its particles begin at.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "file/parse_limits.h"
#include "file/parse_parts.h"
#include "place/fluid_places.h"
#include "psim/fluid.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 4> kFluidPlaces = {"region", "disc", "polygon", "layout"};
constexpr std::array<std::string_view, 5> kFluidKeys = {"spacing", "density", "viscosity", "surface_tension",
                                                        "velocity"};
constexpr std::array<std::string_view, 5> kFluidListKeys = {"layout", "x", "y", "vx", "vy"};
constexpr std::array<std::string_view, 2> kFluidDiscKeys = {"position", "radius"};
constexpr std::array<std::string_view, 1> kFluidPolygonKeys = {"vertices"}, kFluidLayouts = {"explicit"};

// The fluids that emitters name, before these are read: one of them may begin without particles.
bool is_fed(const Node& scene, std::size_t fluid) {
  const std::optional<Node> emitters = scene.find("emitters");
  if (!emitters || !emitters->is_array()) return false;
  for (std::size_t k = 0; k < emitters->size(); ++k) {
    const Json& emitter = emitters->element(k).json();
    if (!emitter.is_object()) continue;
    const auto named = emitter.find("fluid");
    if (named == emitter.end() ? fluid == 0 : *named == fluid) return true;
  }
  return false;
}

// The one key that says where the particles are; empty if there is none and the fluid is fed by an emitter.
std::string_view place_key(const Node& node, bool fed) {
  std::string_view found;
  for (const std::string_view key : kFluidPlaces) {
    if (!node.find(key)) continue;
    if (!found.empty()) {
      node.fail_at_key(key, "stands beside \"" + std::string(found) + "\": one of them says where the particles are");
    }
    found = key;
  }
  if (found.empty() && !fed) {
    node.fail("one of the keys " + word_list(kFluidPlaces) + " is missing, and no emitter lets this fluid out");
  }
  return found;
}

void expect_within(const Node& node, const Bounds& box, const Bounds& world) {
  if (box.xmin >= world.xmin && box.ymin >= world.ymin && box.xmax <= world.xmax && box.ymax <= world.ymax) return;
  node.fail(bounds_text(box) + " reaches out of the world: inside world.bounds " + bounds_text(world));
}

FluidDisc read_fluid_disc(const Node& node, const Context& context) {
  node.expect_object(kFluidDiscKeys);
  const Node radius = node.require("radius");
  const FluidDisc disc{node.require("position").vec2(limits::kCoordinate), radius.number(limits::kRadius)};
  const Vec2 c = disc.position;
  expect_within(node, {c.x - disc.radius, c.y - disc.radius, c.x + disc.radius, c.y + disc.radius}, context.bounds);
  return disc;
}

FluidPolygon read_fluid_polygon(const Node& node, const Context& context) {
  node.expect_object(kFluidPolygonKeys);
  const Node vertices = node.require("vertices");
  vertices.expect_array(3, kMostFluidVertices);
  FluidPolygon polygon;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    polygon.vertices.push_back(vertices.element(k).vec2(limits::kCoordinate));
    expect_inside(vertices.element(k), polygon.vertices.back(), context.bounds);
  }
  return polygon;
}

// A column of a list: as many numbers as there are particles.
std::vector<double> read_numbers(const Node& node, Range range, std::size_t wanted) {
  node.expect_array(0, kMostParticles);
  if (node.size() != wanted) {
    node.fail(count_text(node.size()) + ", \"x\" has " + std::to_string(wanted) + ": one for each particle");
  }
  std::vector<double> column(wanted);
  for (std::size_t k = 0; k < wanted; ++k) column[k] = node.element(k).number(range);
  return column;
}

FluidList read_fluid_list(const Node& node, const Context& context) {
  node.require("layout").one_of(kFluidLayouts);
  const Node x = node.require("x"), y = node.require("y");
  x.expect_array(0, kMostParticles);
  const std::size_t n = x.size();
  FluidList list{read_numbers(x, limits::kCoordinate, n), read_numbers(y, limits::kCoordinate, n), {}, {}};
  const Bounds& b = context.bounds;
  for (std::size_t k = 0; k < n; ++k) {
    const bool beside = list.x[k] < b.xmin || list.x[k] > b.xmax;
    if (beside || list.y[k] < b.ymin || list.y[k] > b.ymax) {
      (beside ? x : y)
          .element(k)
          .fail(exact_text(beside ? list.x[k] : list.y[k]) + " is outside the world: inside world.bounds " +
                bounds_text(b));
    }
  }
  const std::optional<Node> vx = node.find("vx"), vy = node.find("vy");
  if ((vx || vy) && node.find("velocity")) {
    node.fail_at_key("velocity", "stands beside \"vx\" or \"vy\": one of the two ways");
  }
  if (vx) list.vx = read_numbers(*vx, limits::kVelocity, n);
  if (vy) list.vy = read_numbers(*vy, limits::kVelocity, n);
  return list;
}

// The particles that a fluid begins with.
void read_place(const Node& node, std::string_view key, const Context& context, SceneFluid& fluid) {
  if (key.empty()) {
    fluid.place = FluidList();
  } else if (key == "layout") {
    fluid.place = read_fluid_list(node, context);
  } else if (const Node place = node.require(key); key == "disc") {
    fluid.place = read_fluid_disc(place, context);
  } else if (key == "polygon") {
    fluid.place = read_fluid_polygon(place, context);
  } else {
    const Bounds region = read_bounds(place);
    expect_within(place, region, context.bounds);
    fluid.place = region;
  }
}

SceneFluid read_fluid(const Node& node, const Context& context, bool fed) {
  node.expect_object();
  SceneFluid fluid;
  const std::string_view key = place_key(node, fed);
  if (key.empty()) {
    node.expect_object(kFluidKeys);
  } else if (key == "layout") {
    node.expect_object(joined(kFluidListKeys, kFluidKeys));
  } else {
    node.expect_object(joined(std::array<std::string_view, 1>{key}, kFluidKeys));
  }
  fluid.fluid.spacing = node.require("spacing").number(limits::kSpacing);
  fluid.fluid.density = node.number_or("density", fluid.fluid.density, limits::kDensity);
  fluid.fluid.viscosity = node.number_or("viscosity", fluid.fluid.viscosity, limits::kViscosity);
  fluid.fluid.surface_tension = node.number_or("surface_tension", fluid.fluid.surface_tension, limits::kSurfaceTension);
  fluid.velocity = node.vec2_or("velocity", fluid.velocity, limits::kVelocity);
  read_place(node, key, context, fluid);
  return fluid;
}

}  // namespace

void read_fluids(const Node& scene, const Context& context, Scene& out) {
  const std::optional<Node> fluids = scene.find("fluids");
  if (!fluids) return;
  fluids->expect_array(0, kMostFluids);
  std::uint64_t count = 0;
  for (std::size_t k = 0; k < fluids->size(); ++k) {
    const Node node = fluids->element(k);
    out.fluids.push_back(read_fluid(node, context, is_fed(scene, k)));
    const FluidDesc &fluid = out.fluids.back().fluid, &first = out.fluids[0].fluid;
    if (fluid.spacing > first.spacing) {
      node.require("spacing").fail(exact_text(fluid.spacing) + " is larger than that of the first fluid: at most " +
                                   exact_text(first.spacing));
    }
    const std::uint64_t particles = count_particles(out.fluids.back());
    const bool listed = std::holds_alternative<FluidList>(out.fluids.back().place);
    if (particles == 0 && !listed) node.fail("has no room for a particle: a smaller spacing or a larger region");
    count += particles;
    if (count > kMostParticles) {
      node.fail("makes more than " + std::to_string(kMostParticles) +
                " particles in all, the most of a world: a larger spacing or a smaller region");
    }
  }
}

}  // namespace psim::scene
