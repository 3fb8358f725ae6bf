// The least that it takes: a world, a disc, a second of falling.
#include <psim/psim.h>

#include <cstdio>
#include <string>

int main() {
  psim::WorldDesc desc;  // 1 km x 1 km, walls, gravity 9.81 m/s^2 down, 60 frames a second
  std::string error;
  const auto world = psim::World::create(desc, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::BodyDesc ball;  // a disc of radius 0.5 m at (0, 0)
  const psim::BodyId id = world->add_body(ball, error);
  if (id == psim::kNoBody) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  for (int frame = 0; frame < 60; ++frame) world->step();

  std::printf("after 1 s the disc is at y = %.3f m\n", world->body(id)->y);
}
