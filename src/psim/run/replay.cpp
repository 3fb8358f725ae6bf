#include "run/replay.h"

#include <fmt/format.h>

#include "options/scene_choice.h"
#include "os/interrupt.h"
#include "output/text.h"
#include "output/user_error.h"
#include "psim/psim.h"

namespace psim::cli {
namespace {

RunOptions how_to_run(const Options& options) {
  RunOptions run;
  run.isa = options.isa;
  run.threads = options.threads;
  return run;
}

bool same_bounds(const WorldDesc& a, const WorldDesc& b) {
  return a.bounds.xmin == b.bounds.xmin && a.bounds.xmax == b.bounds.xmax && a.bounds.ymin == b.bounds.ymin &&
         a.bounds.ymax == b.bounds.ymax && a.boundary == b.boundary;
}

}  // namespace

std::unique_ptr<World> restored_world(const Options& options) {
  std::string error;
  std::vector<std::byte> state;
  if (!read_state(options.restore, state, error)) throw UserError(fmt::format("--restore {}", one_line(error)));
  auto world = World::from_state(state, how_to_run(options), error);
  if (!world) throw UserError(fmt::format("--restore {}: {}", one_line(options.restore), error));
  if (!same_bounds(world->desc(), choose_scene(options).world)) {
    throw UserError(fmt::format("--restore {}: is no state of --scene {}: its bounds are others",
                                one_line(options.restore), one_line(options.scene)));
  }
  world->set_max_bytes(static_cast<std::size_t>(options.memory_bytes));
  say_if_threads_lack(*world, options.threads);
  return world;
}

int replay_recording(const Options& options) {
  os::catch_interrupts();
  std::string error;
  std::vector<std::byte> bytes;
  if (!read_bytes(options.replay, bytes, error)) throw UserError(fmt::format("--replay {}", one_line(error)));
  const auto replay = Replay::open(bytes, how_to_run(options), error);
  if (!replay) throw UserError(fmt::format("--replay {}: {}", one_line(options.replay), error));
  while (!os::interrupted() && replay->differs_at() == 0 && replay->next()) {
  }
  const std::string name = one_line(options.replay);
  if (replay->differs_at() != 0) {
    print_out(fmt::format("{}: the state after step {} of {} is another than recorded\n", name, replay->differs_at(),
                          replay->steps_in_all()));
    return 1;
  }
  if (!replay->complete()) {
    if (!os::interrupted()) {
      throw UserError(fmt::format("--replay {}: it is damaged: it says {} steps and breaks off after {}", name,
                                  replay->steps_in_all(), replay->steps()));
    }
    fmt::print(stderr, "psim: interrupted after step {} of {}\n", replay->steps(), replay->steps_in_all());
    return 1;
  }
  print_out(fmt::format("{}: {} steps on {} x {} threads, {} hashes, all as recorded\nState {:#018x}\n", name,
                        replay->steps(), isa_name(options.isa), options.threads, replay->hashes(),
                        replay->world().state_hash()));
  return 0;
}

}  // namespace psim::cli
