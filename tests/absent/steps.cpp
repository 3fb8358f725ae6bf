// steps SCENE FRAMES [publish|profiler]: loads a scene file and takes its steps in one function, so that
// tests/absent/count can tell what of the engine they ran. One thread, the widest instruction set.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "psim/isa.h"
#include "psim/scene.h"
#include "psim/world.h"

// Named on valgrind's command line.
extern "C" [[gnu::noinline]] void counted_steps(psim::World& world, int frames) {
  for (int k = 0; k < frames; ++k) world.step();
}

int main(int count, char** arguments) {
  if (count < 3) {
    std::fputs("steps SCENE FRAMES [publish|profiler]\n", stderr);
    return 2;
  }
  std::string error;
  const auto scene = psim::load_scene(arguments[1], error);
  const auto world = scene ? psim::build_world(*scene, {psim::best_isa(), 1}, error) : nullptr;
  if (!world) {
    std::fprintf(stderr, "steps: %s\n", error.c_str());
    return 2;
  }
  const std::string with = count > 3 ? arguments[3] : "";
  if (with == "publish") world->enable_snapshots(true);
  if (with == "profiler") {
    world->start_trace();
    world->count_lane_use();
  }
  counted_steps(*world, std::atoi(arguments[2]));
  std::printf("%016llx\n", static_cast<unsigned long long>(world->state_hash()));
  return 0;
}
