// emitters[] and drains[] of a scene file: where fluids come from and where they go.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "file/parse_parts.h"
#include "psim/fluid.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 6> kEmitterKeys = {"segment", "speed", "fluid", "start", "end", "limit"};
constexpr std::array<std::string_view, 1> kDrainKeys = {"region"};
constexpr Range kSeconds{0, 1e9};

EmitterDesc read_emitter(const Node& node, const Context& context, std::size_t fluids) {
  node.expect_object(kEmitterKeys);
  EmitterDesc emitter;
  const Node segment = node.require("segment");
  segment.expect_array(2, 2);
  Vec2* const ends[] = {&emitter.from, &emitter.to};
  for (std::size_t k = 0; k < 2; ++k) {
    *ends[k] = segment.element(k).vec2(limits::kCoordinate);
    expect_inside(segment.element(k), *ends[k], context.bounds);
  }
  const double dx = emitter.to.x - emitter.from.x, dy = emitter.to.y - emitter.from.y;
  if (!limits::kRodLength.contains(std::sqrt(dx * dx + dy * dy))) {
    segment.fail("its two points are the same: a segment must have a length");
  }
  emitter.speed = node.require("speed").number(limits::kVelocity);
  const std::optional<Node> fluid = node.find("fluid");
  if (fluids == 0) node.fail("lets out a fluid, and the scene has none: \"fluids\" is missing");
  if (fluid) emitter.fluid = static_cast<FluidId>(fluid->integer(0, fluids - 1));
  emitter.start = node.number_or("start", 0, kSeconds);
  if (const auto end = node.find("end")) {
    emitter.end = end->number(kSeconds);
    if (emitter.end < emitter.start) end->fail("is less than \"start\": " + exact_text(emitter.start) + " or more");
  }
  if (const auto limit = node.find("limit")) emitter.limit = limit->integer(0, kMostParticles);
  return emitter;
}

}  // namespace

void read_emitters(const Node& scene, const Context& context, Scene& out) {
  const std::optional<Node> emitters = scene.find("emitters");
  if (!emitters) return;
  emitters->expect_array(0, kMostEmitters);
  for (std::size_t k = 0; k < emitters->size(); ++k) {
    out.emitters.push_back(read_emitter(emitters->element(k), context, out.fluids.size()));
  }
}

void read_drains(const Node& scene, Scene& out) {
  const std::optional<Node> drains = scene.find("drains");
  if (!drains) return;
  drains->expect_array(0, kMostDrains);
  for (std::size_t k = 0; k < drains->size(); ++k) {
    const Node drain = drains->element(k);
    drain.expect_object(kDrainKeys);
    out.drains.push_back(read_bounds(drain.require("region")));
  }
}

}  // namespace psim::scene
