// psim was built with PSIM_PROFILE_HEADER: every stage of every step is a zone, on workers, too. The engine's own trace
// has the same spans.
#include <psim/psim.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "../../profile/counting_zone.h"

namespace {

using Counts = std::map<std::pair<std::string, bool>, int>;  // by name, and whether on the first thread

int fail(const char* what, std::string_view name) {
  std::fprintf(stderr, "zones: %s: %.*s\n", what, static_cast<int>(name.size()), name.data());
  return 1;
}

bool on_worker(const ZoneSeen& zone) { return zone.thread != std::this_thread::get_id(); }

bool worker_seen() {
  const std::lock_guard lock(zones_seen.mutex);
  return std::ranges::any_of(zones_seen.ended, on_worker);
}

std::unique_ptr<psim::World> make_world() {
  std::string error;
  auto world = psim::World::create({.bounds = {0, 0, 112, 300}}, {.threads = 4}, error);
  for (int k = 0; world && k < 20'000; ++k) {
    const psim::Vec2 at{1 + 1.1 * (k % 100), 1 + 1.1 * (k / 100)};
    if (world->add_body({.shape = psim::DiscShape{0.5}, .position = at}, error) == psim::kNoBody) return nullptr;
  }
  return world;
}

}  // namespace

int main() {
  const auto world = make_world();
  if (!world) return fail("no world", "");
  world->enable_snapshots(true);
  world->step();
  zones_seen.ended.clear();
  zones_seen.begun = 0;
  world->start_trace();
  // On a busy machine the first thread may do all jobs of a step.
  for (int frame = 0; frame < 60 || (frame < 3000 && !worker_seen()); ++frame) world->step();
  world->stop_trace();

  Counts zones, spans;
  for (const ZoneSeen& zone : zones_seen.ended) {
    const bool first = !on_worker(zone);
    if (std::ranges::find(psim::kStageNames, zone.name) == psim::kStageNames.end()) {
      if (zone.name != "wait" || !first) return fail("a zone that no page names", zone.name);
    } else {
      ++zones[{zone.name, first}];
    }
  }
  for (const psim::TraceEvent& span : world->take_trace()) {
    if (std::string_view(span.name) != "wait") ++spans[{span.name, span.thread == 0}];
  }
  if (!zones_seen.nested) return fail("a zone ends before one that it holds", "");
  if (static_cast<std::size_t>(zones_seen.begun) != zones_seen.ended.size()) return fail("a zone has no end", "");
  for (const auto& [span, count] : spans) {
    if (zones[span] != count) return fail("zones are not the spans of the trace", span.first);
  }
  for (const char* name : {"broad_phase", "narrow_phase", "colouring", "solver", "integrate", "sleep", "publish"}) {
    if (zones[{name, true}] == 0) return fail("no zone", name);
  }
  if (!worker_seen()) return fail("no zone on a worker", "");
  std::printf("%zu zones\n", zones_seen.ended.size());
  return 0;
}
