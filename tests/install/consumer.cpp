// The smallest use of an installed psim: one disc falls for a second, psim says where it is, and draws it.
#include <psim/psim.h>

#include <cstdio>
#include <span>
#include <string>

namespace {

// What derives from a class of the library.
struct Counted : psim::DebugDraw {
  int circles = 0, others = 0;
  void circle(psim::Vec2, double, double, psim::DrawKind, psim::BodyId) override { ++circles; }
  void polygon(std::span<const psim::Vec2>, double, psim::DrawKind, psim::BodyId) override { ++others; }
  void line(psim::Vec2, psim::Vec2, psim::DrawKind) override { ++others; }
  void point(psim::Vec2, psim::DrawKind) override { ++others; }
};

}  // namespace

int main() {
  std::string error;
  psim::WorldDesc desc;
  const auto world = psim::World::create(desc, psim::RunOptions{}, error);
  if (!world) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  const psim::BodyId id = world->add_body(psim::BodyDesc{}, error);
  if (!world->is_valid(id)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  for (int frame = 0; frame < 60; ++frame) world->step();
  const auto body = world->body(id);
  if (!body) return 1;
  std::printf("psim %s on %.*s: y = %g\n", PSIM_VERSION_STRING, static_cast<int>(psim::isa_name(world->isa()).size()),
              psim::isa_name(world->isa()).data(), body->y);
  Counted drawn;
  psim::DebugDrawOptions options;
  options.bounds = false;
  if (!world->debug_draw(drawn, options) || drawn.circles != 1 || drawn.others != 0) return 1;
  return body->y < 0 ? 0 : 1;
}
