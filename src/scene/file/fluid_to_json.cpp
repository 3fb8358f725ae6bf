#include <variant>

#include "file/json_text.h"

namespace psim::scene {
namespace {

struct AddPlace {
  Object& out;
  bool fed;

  void operator()(const Bounds& region) const { out.add("region", region); }
  void operator()(const FluidDisc& disc) const {
    out.raw("disc", Object().add("position", disc.position).add("radius", disc.radius).one_line());
  }
  void operator()(const FluidPolygon& polygon) const {
    out.raw("polygon", Object().raw("vertices", list_of(polygon.vertices)).one_line());
  }
  void operator()(const FluidList& list) const {
    if (list.x.empty() && fed) return;
    out.add("layout", std::string_view("explicit")).raw("x", list_of(list.x)).raw("y", list_of(list.y));
    if (!list.vx.empty()) out.raw("vx", list_of(list.vx));
    if (!list.vy.empty()) out.raw("vy", list_of(list.vy));
  }
};

}  // namespace

std::string fluid_text(const SceneFluid& fluid, bool fed) {
  Object out;
  std::visit(AddPlace{out, fed}, fluid.place);
  out.add("spacing", fluid.fluid.spacing).add("density", fluid.fluid.density);
  out.add_unless("viscosity", fluid.fluid.viscosity, 0);
  out.add_unless("surface_tension", fluid.fluid.surface_tension, 0).add_unless("velocity", fluid.velocity, {});
  return out.one_line();
}

std::string emitter_text(const EmitterDesc& emitter) {
  constexpr EmitterDesc kUsual;
  Object out;
  out.raw("segment", list_of(std::vector<Vec2>{emitter.from, emitter.to})).add("speed", emitter.speed);
  out.raw("fluid", std::to_string(emitter.fluid)).add_unless("start", emitter.start, kUsual.start);
  out.add_unless("end", emitter.end, kUsual.end);
  if (emitter.limit != kUsual.limit) out.raw("limit", std::to_string(emitter.limit));
  return out.one_line();
}

std::string drain_text(const Bounds& region) { return Object().add("region", region).one_line(); }

}  // namespace psim::scene
