// The smallest use of an installed psim: one disc falls for a second and psim says where it is.
#include <psim/psim.h>

#include <cstdio>
#include <string>

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
  return body->y < 0 ? 0 : 1;
}
