#include "options/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "options/calibration.h"
#include "options/scene_choice.h"
#include "output/user_error.h"
#include "psim/limits.h"

namespace psim::cli {
namespace {

constexpr int kMostSubsteps = static_cast<int>(limits::kSubsteps.max);
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What the calibration says about this scene.
class Prospects {
 public:
  Prospects(const Calibration& table, const SceneTraits& traits, double dt) : table_(table), traits_(traits), dt_(dt) {}

  /// `pairs` in the lists, `slowness` of this machine against the calibration's.
  TargetSettings settings(Integrator integrator, int substeps, double pairs, double slowness) const {
    const auto bodies = static_cast<double>(traits_.moving);
    const FrameCost cost = table_.cost(traits_.kind, integrator);
    const double items = costs_by_body(traits_.kind) ? bodies : pairs;
    const double ns = cost.body * bodies + cost.item * items * substeps;
    return {integrator, substeps, error(integrator, substeps), 1e-6 * ns * slowness};
  }

  double error(Integrator integrator, int substeps) const {
    return table_.error(traits_.kind, integrator, traits_.rate * dt_ / substeps);
  }

  /// Every integrator that was measured with 1 to 64 substeps.
  std::vector<TargetSettings> all(double pairs, double slowness) const {
    std::vector<TargetSettings> all;
    for (const Integrator integrator : table_.integrators(traits_.kind)) {
      for (int n = 1; n <= kMostSubsteps; ++n) {
        all.push_back(settings(integrator, n, pairs, slowness));
      }
    }
    return all;
  }

  /// In the lists of so many bodies, once those that fall have come together.
  double usual_pairs() const {
    return table_.cost(traits_.kind, Integrator::verlet).pairs_per_body * static_cast<double>(traits_.moving);
  }

 private:
  const Calibration& table_;
  const SceneTraits& traits_;
  double dt_;
};

// ---- error --------------------------------------------------------------------------------------

void choose_by_error(Target& target, const Prospects& prospects) {
  const auto all = prospects.all(prospects.usual_pairs(), 1);
  const TargetSettings* best = nullptr;
  const TargetSettings* least = &all.front();
  for (const TargetSettings& s : all) {
    if (s.error < least->error) least = &s;
    if (s.error > target.wanted) continue;
    const bool cheaper =
        !best || s.ms_per_frame < best->ms_per_frame || (s.ms_per_frame == best->ms_per_frame && s.error < best->error);
    if (cheaper) best = &s;
  }
  if (!best) {
    const std::string reach =
        std::isfinite(least->error)
            ? fmt::format("the least that was measured is {:.2g} ({}), with {} substeps, {}", least->error,
                          target.measure, least->substeps, integrator_name(least->integrator))
            : fmt::format("it is faster than anything measured; a shorter --dt would help");
    throw UserError(fmt::format("--target-error {}: out of reach for this scene of kind {}; {}", target.wanted,
                                scene_kind_name(target.traits.kind), reach));
  }
  target.chosen = *best;
  for (const TargetSettings& s : all) {
    if (s.error <= target.wanted || s.ms_per_frame > best->ms_per_frame) continue;
    if (!target.refused || s.error < target.refused->error) target.refused = s;
  }
}

// ---- time ---------------------------------------------------------------------------------------

struct Trial {
  double ms = 0;     ///< median frame
  double pairs = 0;  ///< of the lists, mean
};

// A few frames of the scene in a world of its own.
Trial try_scene(const Scene& scene, const Options& options) {
  using Clock = std::chrono::steady_clock;
  constexpr int kWarmFrames = 5, kLeastFrames = 5, kMostFrames = 60;
  constexpr double kMostSeconds = 0.5;
  const auto world = make_world(scene, options.isa, options.threads);
  world->prepare();
  for (int k = 0; k < kWarmFrames; ++k) world->step();
  std::vector<double> ms;
  Trial trial;
  const auto start = Clock::now();
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  for (int k = 0; k < kMostFrames && (k < kLeastFrames || since(start) < kMostSeconds); ++k) {
    const auto begin = Clock::now();
    trial.pairs += static_cast<double>(world->step().pairs);
    ms.push_back(1e3 * since(begin));
  }
  trial.pairs /= static_cast<double>(ms.size());
  const auto middle = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
  std::nth_element(ms.begin(), middle, ms.end());
  trial.ms = *middle;
  return trial;
}

// Without fields every integrator is the same.
Integrator tried_integrator(const Target& target, const Scene& scene) {
  return target.traits.kind == SceneKind::fields ? scene.world.integrator : Integrator::verlet;
}

void choose_by_time(Target& target, const Prospects& prospects, const Scene& scene, const Options& options) {
  const Trial trial = try_scene(scene, options);
  const double expected =
      prospects.settings(tried_integrator(target, scene), scene.world.substeps, trial.pairs, 1).ms_per_frame;
  const bool gathers = target.traits.kind != SceneKind::gas && target.traits.kind != SceneKind::elastic_shapes;
  const double pairs = gathers ? std::max(trial.pairs, prospects.usual_pairs()) : trial.pairs;
  const double slowness = expected > 0 ? trial.ms / expected : 1;

  const auto all = prospects.all(pairs, slowness);
  const TargetSettings* best = nullptr;
  const TargetSettings* fastest = &all.front();
  for (const TargetSettings& s : all) {
    if (s.ms_per_frame < fastest->ms_per_frame) fastest = &s;
    if (s.ms_per_frame > target.wanted) continue;
    // Where errors are not known, more substeps are better.
    const bool better = !best || s.error < best->error ||
                        (s.error == kInfinity && best->error == kInfinity && s.substeps > best->substeps);
    if (better) best = &s;
  }
  if (!best) {
    throw UserError(
        fmt::format("--target-ms {}: out of reach for this scene here; the fastest settings, {} substep{}, {}, "
                    "take about {:.2g} ms a frame",
                    target.wanted, fastest->substeps, fastest->substeps == 1 ? "" : "s",
                    integrator_name(fastest->integrator), fastest->ms_per_frame));
  }
  target.chosen = *best;
  for (const TargetSettings& s : all) {
    if (s.ms_per_frame <= target.wanted || !(s.error < best->error)) continue;
    if (!target.refused || s.ms_per_frame < target.refused->ms_per_frame) target.refused = s;
  }
}

// ---- words --------------------------------------------------------------------------------------

std::string settings_text(const TargetSettings& s) {
  return fmt::format("{} substep{}, {}", s.substeps, s.substeps == 1 ? "" : "s", integrator_name(s.integrator));
}

std::string error_text(double error) {
  return std::isfinite(error) ? fmt::format("error {:.2g}", error)
                              : std::string("error unknown, faster than anything measured");
}

}  // namespace

std::optional<Target> apply_target(const Options& options, Scene& scene) {
  if (!options.target_error && !options.target_ms) return std::nullopt;
  const Calibration table(kCalibrationCsv);
  Target target;
  target.of_time = options.target_ms.has_value();
  target.wanted = target.of_time ? *options.target_ms : *options.target_error;
  target.traits = traits_of(scene);
  target.measure = table.measure(target.traits.kind);
  if (table.integrators(target.traits.kind).empty()) {
    throw UserError(fmt::format("{}: scenes of kind {} were never measured; accuracy --calibrate does",
                                target.of_time ? "--target-ms" : "--target-error",
                                scene_kind_name(target.traits.kind)));
  }
  const Prospects prospects(table, target.traits, scene.world.dt);
  if (target.of_time) {
    choose_by_time(target, prospects, scene, options);
  } else {
    choose_by_error(target, prospects);
  }
  scene.world.substeps = target.chosen.substeps;
  scene.world.integrator = target.chosen.integrator;
  return target;
}

std::string target_text(const Target& target) {
  std::string text = target.of_time ? fmt::format("Target {} ms a frame: {}: expected {:.2g} ms, {}", target.wanted,
                                                  settings_text(target.chosen), target.chosen.ms_per_frame,
                                                  error_text(target.chosen.error))
                                    : fmt::format("Target error {}: {}: expected {}", target.wanted,
                                                  settings_text(target.chosen), error_text(target.chosen.error));
  if (target.refused) {
    text += target.of_time
                ? fmt::format("; {}: {:.2g} ms", settings_text(*target.refused), target.refused->ms_per_frame)
                : fmt::format("; {}: {}", settings_text(*target.refused), error_text(target.refused->error));
  }
  text += fmt::format("\nTarget kind {} ({}), rate {:.3g} /s; error: {}\n", scene_kind_name(target.traits.kind),
                      target.traits.because, target.traits.rate, target.measure);
  return text;
}

}  // namespace psim::cli
