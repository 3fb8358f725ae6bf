// A level drawn in the editor R.U.B.E. The program psim turns it into a saved state, which the game loads:
//
//   psim --scene rube_level.json --frames 0 --save level.state
//   rube_level level.state
//
// A ball rolls into a row of dominoes, and the last one rings a bell. Exits with 1 if it does not.
#include <psim/psim.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

// A state has no names: the index of a body is its place in the array "body" of the level.
constexpr std::uint32_t kBall = 1, kBell = 2, kWindmill = 3, kFirstDomino = 4, kLastDomino = 9;

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: rube_level LEVEL.state\n"), 2;
  std::string error;
  std::vector<std::byte> state;
  if (!psim::read_state(argv[1], state, error)) return std::fprintf(stderr, "%s\n", error.c_str()), 2;
  const auto world = psim::World::from_state(state, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 2;
  std::printf("bodies: %zu, joints: %zu\n", world->body_count(), world->joint_count());

  world->set_event_options({.sensors = true});  // what the game wants to hear
  bool rings = false;
  for (int frame = 1; frame <= 600; ++frame) {
    world->step();
    for (const psim::TouchEvent& touch : world->events().sensor_begin) {
      if (touch.a.index != kBell || touch.b.index != kLastDomino) continue;
      rings = true;
      std::printf("%.1f s: the last domino rings the bell\n", frame * world->desc().dt);
    }
  }
  int fallen = 0;
  for (std::uint32_t domino = kFirstDomino; domino <= kLastDomino; ++domino) {
    if (std::fabs(world->body(world->id_of(domino))->angle) > 0.5) ++fallen;
  }
  const double spin = world->body(world->id_of(kWindmill))->omega;
  std::printf("%d dominoes have fallen, the ball is at x = %.1f m, the windmill turns with %.2f rad/s\n", fallen,
              world->body(world->id_of(kBall))->x, spin);
  return rings && fallen == 6 && std::fabs(spin - 2) < 0.01 ? 0 : 1;
}
