#ifdef __linux__
#include <sched.h>
#endif

#include <algorithm>
#include <thread>
#include <utility>

#include "engines/engine.h"

namespace psim::accuracy {

Engine absent_engine(std::string name, std::string version, std::string why) {
  Engine engine;
  engine.name = std::move(name);
  engine.version = std::move(version);
  engine.absent = std::move(why);
  return engine;
}

#ifndef PSIM_WITH_BOX2D24
Engine box2d24_engine() {
  return absent_engine("box2d", "2.4", "not built in: apt install libbox2d-dev, configure again");
}
#endif
#ifndef PSIM_WITH_BOX2D3
Engine box2d3_engine() {
  return absent_engine("box2d3", "3",
                       "not built in: install Box2D 3, configure again with "
                       "-DCMAKE_PREFIX_PATH=its prefix");
}
#endif
#ifndef PSIM_WITH_CHIPMUNK
Engine chipmunk_engine() {
  return absent_engine("chipmunk", "7", "not built in: apt install libchipmunk-dev, configure again");
}
#endif

std::vector<Engine> all_engines() { return {psim_engine(), box2d24_engine(), box2d3_engine(), chipmunk_engine()}; }

int usable_threads() {
#ifdef __linux__
  cpu_set_t mine;  // hardware_concurrency would count cores that this process is kept off
  return sched_getaffinity(0, sizeof mine, &mine) == 0 ? CPU_COUNT(&mine) : 1;
#else
  return static_cast<int>(std::max(std::thread::hardware_concurrency(), 1u));
#endif
}

}  // namespace psim::accuracy
