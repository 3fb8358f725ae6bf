#include "verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <set>
#include <string_view>
#include <thread>
#include <vector>

#include "interrupt.h"
#include "progress.h"
#include "scene_choice.h"
#include "text.h"

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

// What one frame left behind, enough to name the stage that went astray.
struct Trail {
  std::uint64_t hash = 0;
  std::uint64_t pairs = 0, contacts = 0;
  std::uint32_t colours = 0;
  friend bool operator==(const Trail&, const Trail&) = default;
};

Trail trail_of(World& world) {
  const StepReport step = world.step();
  return {world.state_hash(), step.pairs, step.contacts, step.colours};
}

// The reference's trail; shorter than `frames` if interrupted.
std::vector<Trail> record(const Scene& scene, const Variant& variant, std::uint64_t frames) {
  const auto world = make_world(scene, variant.isa, variant.threads);
  std::vector<Trail> trail;
  Progress progress(variant.name(), frames);
  for (std::uint64_t frame = 1; frame <= frames && !interrupted(); ++frame) {
    trail.push_back(trail_of(*world));
    progress.update(frame, Progress::Clock::now());
  }
  return trail;
}

// The number of frames that agree with the trail; `other` is the first that does not.
std::uint64_t agreeing_frames(const Scene& scene, const Variant& variant,
                              const std::vector<Trail>& trail, Trail& other) {
  const auto world = make_world(scene, variant.isa, variant.threads);
  Progress progress(variant.name(), trail.size());
  for (std::uint64_t frame = 0; frame < trail.size() && !interrupted(); ++frame) {
    other = trail_of(*world);
    if (other != trail[frame]) return frame;
    progress.update(frame + 1, Progress::Clock::now());
  }
  return trail.size();
}

constexpr std::array<std::string_view, 6> kFields = {"x", "y", "angle", "vx", "vy", "omega"};

struct StateCopy {
  std::vector<std::uint32_t> id;
  std::array<std::vector<double>, kFields.size()> fields;
};

StateCopy state_after(const Scene& scene, const Variant& variant, std::uint64_t frames) {
  const auto world = make_world(scene, variant.isa, variant.threads);
  for (std::uint64_t frame = 0; frame < frames; ++frame) world->step();
  const PublishedState state = world->published();
  const std::array columns = {state.x, state.y, state.angle, state.vx, state.vy, state.omega};
  StateCopy copy;
  copy.id.assign(state.id.begin(), state.id.end());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    copy.fields[i].assign(columns[i].begin(), columns[i].end());
  }
  return copy;
}

struct Difference {
  bool velocity = false;  // any body's velocity or spin, not only places
  std::size_t bodies = 0;
  std::string first;  // body, field and both bit patterns
};

Difference compare(const StateCopy& a, const StateCopy& b) {
  Difference difference;
  if (a.id != b.id) {
    difference.first = fmt::format("{} bodies against {}", a.id.size(), b.id.size());
    return difference;
  }
  for (std::size_t row = 0; row < a.id.size(); ++row) {
    bool differs = false;
    for (std::size_t i = 0; i < kFields.size(); ++i) {
      const double u = a.fields[i][row], v = b.fields[i][row];
      const auto bits_u = std::bit_cast<std::uint64_t>(u), bits_v = std::bit_cast<std::uint64_t>(v);
      if (bits_u == bits_v || (u == 0 && v == 0)) continue;
      differs = true;
      difference.velocity = difference.velocity || i >= 3;
      if (difference.first.empty()) {
        difference.first = fmt::format("body {} {}: {} (0x{:016x}) against {} (0x{:016x})",
                                       a.id[row], kFields[i], u, bits_u, v, bits_v);
      }
    }
    difference.bodies += differs ? 1 : 0;
  }
  return difference;
}

// The earliest stage whose result is known to differ. What a stage hands on is only seen through
// the counts of the step and the state at its end, so this is where to begin to look.
std::string_view first_stage(const Trail& a, const Trail& b, const Difference& difference) {
  if (a.pairs != b.pairs) return "broad_phase";
  if (a.contacts != b.contacts && a.hash == b.hash) return "narrow_phase";
  if (a.colours != b.colours) return "colouring";
  return difference.velocity ? "solver" : "integrate";
}

std::string describe(const Scene& scene, const Variant& reference, const Variant& variant,
                     std::uint64_t frame, const Trail& a, const Trail& b) {
  Difference difference =
      compare(state_after(scene, reference, frame), state_after(scene, variant, frame));
  if (difference.bodies == 0 && difference.first.empty()) {
    difference.first = "so the difference did not come back when both ran again";
  }
  return fmt::format(
      "DIFFERS from {} in frame {}, stage {}\n  hash {} against {}, pairs {} against {}, contacts "
      "{} against {}, colours {} against {}\n  bodies that differ: {}{}{}\n",
      reference.name(), frame, first_stage(a, b, difference), hash_text(a.hash), hash_text(b.hash),
      a.pairs, b.pairs, a.contacts, b.contacts, a.colours, b.colours, difference.bodies,
      difference.bodies == 0 ? ", " : ", first ", difference.first);
}

}  // namespace

int verify_scene(const Options& options) {
  catch_interrupts();
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
  if (!interrupted()) line(reference, hash_text(final_hash) + "\n");

  std::size_t different = 0;
  for (std::size_t i = 1; i < all.size() && !interrupted(); ++i) {
    Trail other;
    const std::uint64_t agreeing = agreeing_frames(scene, all[i], trail, other);
    if (interrupted()) break;
    if (agreeing == trail.size()) {
      line(all[i], hash_text(final_hash) + "\n");
      continue;
    }
    ++different;
    line(all[i], describe(scene, reference, all[i], agreeing + 1, trail[agreeing], other));
  }
  if (interrupted()) {
    fmt::print(stderr, "psim: interrupted before the check was complete\n");
    return 1;
  }
  print_out(different == 0
                ? fmt::format("{} variants, {} frames: the same bits\n", all.size(), trail.size())
                : fmt::format("{} of {} variants differ\n", different, all.size()));
  return different == 0 ? 0 : 1;
}

}  // namespace psim::cli
