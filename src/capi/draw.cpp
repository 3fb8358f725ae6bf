// A world is drawn by the caller's functions.
#include "psim/debug_draw.h"

#include <algorithm>
#include <array>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

namespace {

class Drawing : public psim::DebugDraw {
 public:
  explicit Drawing(const psim_debug_draw& by) : by_(by) {}

  void circle(psim::Vec2 centre, double radius, double angle, psim::DrawKind kind, psim::BodyId body) override {
    if (by_.circle != nullptr) by_.circle(by_.user, to_c(centre), radius, angle, number(kind), to_c(body));
  }
  void polygon(std::span<const psim::Vec2> corners, double radius, psim::DrawKind kind, psim::BodyId body) override {
    if (by_.polygon == nullptr) return;
    std::array<psim_vec2, psim::kMostPolygonVertices> out{};
    const std::size_t count = std::min(corners.size(), out.size());
    std::transform(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(count), out.begin(),
                   [](psim::Vec2 v) { return to_c(v); });
    by_.polygon(by_.user, out.data(), count, radius, number(kind), to_c(body));
  }
  void line(psim::Vec2 from, psim::Vec2 to, psim::DrawKind kind) override {
    if (by_.line != nullptr) by_.line(by_.user, to_c(from), to_c(to), number(kind));
  }
  void point(psim::Vec2 at, psim::DrawKind kind) override {
    if (by_.point != nullptr) by_.point(by_.user, to_c(at), number(kind));
  }

 private:
  static std::int32_t number(psim::DrawKind kind) { return static_cast<std::int32_t>(kind); }

  const psim_debug_draw& by_;
};

}  // namespace

psim_result psim_world_debug_draw(psim_world* world, const psim_debug_draw* draw) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_debug_draw given;
    if (const psim_result r = read(call, "draw", draw, given); r != PSIM_OK) return r;
    psim::DebugDrawOptions options;
    options.bodies = given.bodies != 0;
    options.joints = given.joints != 0;
    options.contacts = given.contacts != 0;
    options.forces = given.forces != 0;
    options.bounds = given.bounds != 0;
    options.particles = given.particles != 0;
    options.force_scale = given.force_scale;
    options.normal_length = given.normal_length;
    if (given.has_region != 0) options.region = to_cpp(given.region);
    Drawing drawing(given);
    if (w.debug_draw(drawing, options)) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "region, force_scale and normal_length must be finite");
  });
}
