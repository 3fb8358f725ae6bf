#include "run/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "options/scene_choice.h"
#include "os/interrupt.h"
#include "output/text.h"
#include "run/progress.h"
#include "run/state_comparison.h"
#include "run/trail.h"

namespace psim::cli {
namespace {

struct Variant {
  Isa isa;
  int threads;
  std::string name() const { return fmt::format("{} x {} threads", isa_name(isa), threads); }
};

std::vector<Variant> variants() {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const std::set<int> thread_counts = {1, 2, std::clamp(cores, 4, 256)};
  std::vector<Variant> all;
  for (const Isa isa : kAllIsas) {
    if (!isa_available(isa)) continue;
    for (const int threads : thread_counts) all.push_back({isa, threads});
  }
  return all;
}

// The reference's trail; shorter than `frames` if interrupted.
std::vector<Trail> record(const Scene& scene, const Variant& variant, std::uint64_t frames) {
  const auto world = make_world(scene, variant.isa, variant.threads);
  std::vector<Trail> trail;
  Progress progress(variant.name(), frames);
  for (std::uint64_t frame = 1; frame <= frames && !os::interrupted(); ++frame) {
    trail.push_back(step_and_trail(*world));
    progress.update(frame, Progress::Clock::now());
  }
  return trail;
}

// The number of frames that agree with the trail; `other` is the first that does not.
std::uint64_t agreeing_frames(const Scene& scene, const Variant& variant, const std::vector<Trail>& trail,
                              Trail& other) {
  const auto world = make_world(scene, variant.isa, variant.threads);
  Progress progress(variant.name(), trail.size());
  for (std::uint64_t frame = 0; frame < trail.size() && !os::interrupted(); ++frame) {
    other = step_and_trail(*world);
    if (other != trail[frame]) return frame;
    progress.update(frame + 1, Progress::Clock::now());
  }
  return trail.size();
}

std::unique_ptr<World> world_after(const Scene& scene, const Variant& variant, std::uint64_t frames) {
  auto world = make_world(scene, variant.isa, variant.threads);
  for (std::uint64_t frame = 0; frame < frames; ++frame) world->step();
  return world;
}

std::string describe(const Scene& scene, const Variant& reference, const Variant& variant, std::uint64_t frame,
                     const Trail& a, const Trail& b) {
  const auto world_a = world_after(scene, reference, frame);
  const auto world_b = world_after(scene, variant, frame);
  StateComparison states;
  states.add(frame, view_of(world_a->published()), view_of(world_b->published()));
  const bool fluids = !states.first() && world_a->state_hash() != world_b->state_hash();
  const std::string bodies = states.first()
                                 ? fmt::format("{}, first {}", states.differing_bodies(),
                                               difference_text(*states.first(), reference.name(), variant.name()))
                             : fluids ? "0: particles of fluids differ"
                                      : "0, so the difference did not come back when both ran again";
  return fmt::format("DIFFERS from {} in frame {}, stage {}\n  {}\n  bodies that differ: {}\n", reference.name(), frame,
                     fluids ? "fluid" : first_stage(a, b, states.motion_differs_at_first()), trails_text(a, b), bodies);
}

}  // namespace

int verify_scene(const Options& options) {
  os::catch_interrupts();
  const Scene scene = choose_scene(options);
  check_memory(scene);
  const std::vector<Variant> all = variants();
  const std::uint64_t frames = options.frame_count();
  const Variant& reference = all.front();

  const auto line = [](const Variant& variant, std::string_view text) {
    print_out(fmt::format("{:<7} {:>3} threads  {}", isa_name(variant.isa), variant.threads, text));
  };
  const std::vector<Trail> trail = record(scene, reference, frames);
  const auto final_hash = [&] {
    return trail.empty() ? make_world(scene, reference.isa, 1)->state_hash() : trail.back().hash;
  }();
  if (!os::interrupted()) line(reference, hash_text(final_hash) + "\n");

  std::size_t different = 0;
  for (std::size_t i = 1; i < all.size() && !os::interrupted(); ++i) {
    Trail other;
    const std::uint64_t agreeing = agreeing_frames(scene, all[i], trail, other);
    if (os::interrupted()) break;
    if (agreeing == trail.size()) {
      line(all[i], hash_text(final_hash) + "\n");
      continue;
    }
    ++different;
    line(all[i], describe(scene, reference, all[i], agreeing + 1, trail[agreeing], other));
  }
  if (os::interrupted()) {
    fmt::print(stderr, "psim: interrupted before the check was complete\n");
    return 1;
  }
  print_out(different == 0 ? fmt::format("{} variants, {} frames: the same bits\n", all.size(), trail.size())
                           : fmt::format("{} of {} variants differ\n", different, all.size()));
  return different == 0 ? 0 : 1;
}

}  // namespace psim::cli
