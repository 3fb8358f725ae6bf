#include "run/diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

#include "options/scene_choice.h"
#include "os/interrupt.h"
#include "output/text.h"
#include "output/user_error.h"
#include "run/progress.h"
#include "run/state_comparison.h"
#include "run/state_file.h"
#include "run/trail.h"

namespace psim::cli {
namespace {

struct Names {
  std::string a, b;
};

// Two courses of one scene begin with the same bodies; later one side may lose some.
void require_same_bodies(const Names& names, const StateView& a, const StateView& b) {
  if (a.id.size() != b.id.size()) {
    throw UserError(
        fmt::format("{} has {} bodies and {} has {}: only states of the same bodies "
                    "can be compared",
                    names.a, grouped(a.id.size()), names.b, grouped(b.id.size())));
  }
  const auto [in_a, in_b] = std::ranges::mismatch(a.id, b.id);
  if (in_a == a.id.end()) return;
  throw UserError(
      fmt::format("body {} is only in {}: only states of the same bodies can be "
                  "compared",
                  std::min(*in_a, *in_b), *in_a < *in_b ? names.a : names.b));
}

struct Compared {
  std::uint64_t frames = 0;
  std::uint64_t bodies = 0;  // at the start
  bool by_frame = true;      // false for two states
};

std::string totals_text(const StateComparison& states, const Compared& compared) {
  std::string text;
  if (compared.by_frame) {
    text = fmt::format("Frames that differ: {} of {}\n", grouped(states.differing_frames()), grouped(compared.frames));
  }
  fmt::format_to(std::back_inserter(text), "Bodies that differ: {} of {}\n{:<6} {:>18}{}\n",
                 grouped(states.differing_bodies()), grouped(compared.bodies), "Field", "largest difference",
                 compared.by_frame ? "      frame       body" : "       body");
  for (std::size_t i = 0; i < kStateFields.size(); ++i) {
    const StateComparison::Largest& largest = states.largest()[i];
    fmt::format_to(std::back_inserter(text), "{:<6} {:>18.6g}", kStateFields[i], largest.difference);
    if (largest.difference > 0) {
      if (compared.by_frame) fmt::format_to(std::back_inserter(text), " {:>10}", largest.frame);
      fmt::format_to(std::back_inserter(text), " {:>10}", largest.body);
    }
    text += "\n";
  }
  return text;
}

std::string same_text(const Compared& compared) {
  if (!compared.by_frame) return fmt::format("The same bits: {} bodies\n", grouped(compared.bodies));
  return fmt::format("The same bits: {} frames, {} bodies\n", grouped(compared.frames), grouped(compared.bodies));
}

// ---- two files -----------------------------------------------------------------------------------

void require_same_kind(const Names& names, const StateFile& a, const StateFile& b) {
  if (a.is_trajectory() == b.is_trajectory()) return;
  const auto kind = [](const StateFile& file) { return file.is_trajectory() ? "a trajectory" : "a state"; };
  throw UserError(fmt::format("{} is {} and {} is {}: compare like with like", names.a, kind(a), names.b, kind(b)));
}

int diff_files(const std::string& path_a, const std::string& path_b) {
  const Names names = {one_line(path_a), one_line(path_b)};
  StateFile a(path_a), b(path_b);
  require_same_kind(names, a, b);
  StateComparison states;
  Compared compared;
  compared.by_frame = a.is_trajectory();
  bool more_a = a.next_frame(), more_b = b.next_frame();
  for (; more_a && more_b; more_a = a.next_frame(), more_b = b.next_frame()) {
    if (a.frame() != b.frame()) {
      throw UserError(
          fmt::format("{} has frame {} where {} has frame {}: write both with the same "
                      "--every",
                      names.a, a.frame(), names.b, b.frame()));
    }
    if (compared.frames == 0) {
      require_same_bodies(names, a.view(), b.view());
      compared.bodies = a.view().id.size();
    }
    states.add(a.frame(), a.view(), b.view());
    ++compared.frames;
  }

  std::string text;
  if (states.first()) {
    text =
        compared.by_frame ? fmt::format("First difference in frame {}: ", states.first()->frame) : "First difference: ";
    text += difference_text(*states.first(), names.a, names.b) + "\n";
    text += totals_text(states, compared);
  } else {
    text = same_text(compared);
  }
  const bool same_length = more_a == more_b;
  if (!same_length) {
    fmt::format_to(std::back_inserter(text), "Frame {} is only in {}: the other one has ended\n",
                   more_a ? a.frame() : b.frame(), more_a ? names.a : names.b);
  }
  print_out(text);
  return states.first() || !same_length ? 1 : 0;
}

// ---- two settings --------------------------------------------------------------------------------

// The first frame whose counts or state differ, and what it left behind on both sides.
struct Parting {
  std::uint64_t frame = 0;
  Trail a, b;
};

std::string side_text(const Options& options, const World& world) {
  const WorldDesc& desc = world.desc();
  return fmt::format("{} {}, {} threads, {} bodies, {} substeps of {} s, {}", one_line(options.scene),
                     isa_name(world.isa()), world.threads(), grouped(world.body_count()), desc.substeps,
                     desc.dt / desc.substeps, integrator_name(desc.integrator));
}

std::string parting_text(const Parting& parting, const StateComparison& states) {
  const auto& first = states.first();
  const auto body = [&] { return difference_text(*first, "A", "B"); };
  if (parting.frame == 0) return fmt::format("First difference before any step: {}\n", body());
  const bool state_too = first && first->frame == parting.frame;
  std::string text =
      fmt::format("First difference in frame {}, stage {}: {}\n  {}\n", parting.frame,
                  first_stage(parting.a, parting.b, state_too && states.motion_differs_at_first()),
                  state_too ? body() : "the counts, not yet the bodies", trails_text(parting.a, parting.b));
  if (first && !state_too) {
    fmt::format_to(std::back_inserter(text), "First body that differs, in frame {}: {}\n", first->frame, body());
  }
  return text;
}

std::unique_ptr<World> side_world(const Options& side) {
  const Scene scene = choose_scene(side);
  check_memory(scene);
  return make_world(scene, side.isa, side.threads);
}

int diff_settings(const Options& side_a, const Options& side_b) {
  os::catch_interrupts();
  const auto a = side_world(side_a), b = side_world(side_b);
  require_same_bodies({"side A", "side B"}, view_of(a->published()), view_of(b->published()));
  print_out(fmt::format("A: {}\nB: {}\n", side_text(side_a, *a), side_text(side_b, *b)));

  const std::uint64_t frames = side_a.frame_count();
  StateComparison states;
  std::optional<Parting> parting;
  if (!states.add(0, view_of(a->published()), view_of(b->published()))) parting.emplace();
  Progress progress("A and B", frames);
  for (std::uint64_t frame = 1; frame <= frames; ++frame) {
    if (os::interrupted()) {
      fmt::print(stderr, "psim: interrupted before the comparison was complete\n");
      return 1;
    }
    const Trail trail_a = step_and_trail(*a), trail_b = step_and_trail(*b);
    if (trail_a != trail_b && !parting) parting = {frame, trail_a, trail_b};
    if (trail_a.hash != trail_b.hash) {
      states.add(frame, view_of(a->published()), view_of(b->published()));
    }
    progress.update(frame, Progress::Clock::now());
  }
  progress.clear();

  const Compared compared = {frames + 1, a->body_count() + a->escaped_total(), true};
  print_out(parting ? parting_text(*parting, states) + totals_text(states, compared) : same_text(compared));
  return parting ? 1 : 0;
}

}  // namespace

int diff(const Options& options) {
  if (!options.sides.empty()) return diff_settings(options.sides[0], options.sides[1]);
  return diff_files(options.files[0], options.files[1]);
}

}  // namespace psim::cli
