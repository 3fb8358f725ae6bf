// What `psim --profile` costs a step. One world steps in rounds of three blocks, in random order: without the
// profiler, with it as psim runs it, and with spans in every frame. Work that drifts and a machine that is busy
// for a while meet all three alike; what is left goes with the number of rounds. Prints the median of the rounds'
// ratios with an interval by resampling (docs/performance.md). Beside other work half of the blocks wait for a core:
// --fastest compares the blocks at that quantile of each way instead, and tells their spans.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "psim/psim.h"
#include "psim/scene.h"
#include "report/profile.h"

namespace {

using namespace psim;
using Clock = std::chrono::steady_clock;

enum Way : std::size_t { kWithout, kProfile, kEveryFrame, kWays };

double quantile(std::vector<double> of, double share) {
  const auto at = of.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(of.size() - 1));
  std::nth_element(of.begin(), at, of.end());
  return *at;
}
double median(const std::vector<double>& of) { return quantile(of, 0.5); }

// 95 % of what `figure` gives for draws with repetition.
template <class Figure>
std::array<double, 2> interval(const Figure& figure) {
  constexpr std::size_t kDraws = 500;
  std::vector<double> figures(kDraws);
  for (double& f : figures) f = figure();
  std::sort(figures.begin(), figures.end());
  return {figures[kDraws / 40], figures[kDraws - 1 - kDraws / 40]};
}

std::vector<double> drawn(const std::vector<double>& of, std::mt19937_64& random) {
  std::uniform_int_distribution<std::size_t> any(0, of.size() - 1);
  std::vector<double> out(of.size());
  for (double& value : out) value = of[any(random)];
  return out;
}

class Blocks {
 public:
  Blocks(World& world, int frames)
      : world_(world), frames_(frames), some_(world.threads(), 1u << 20), all_(world.threads(), 1) {}

  /// ns of a block.
  double run(Way way) {
    const Clock::time_point begin = Clock::now();
    for (int n = 0; n < frames_; ++n) step(way);
    return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
  }
  std::uint64_t spans() const { return spans_; }

 private:
  // As in run.cpp of psim.
  void step(Way way) {
    if (way == kWithout) {
      world_.step();
      return;
    }
    cli::Profile& profile = way == kProfile ? some_ : all_;
    const bool looked_at = profile.looks_at(++frame_);
    if (looked_at) world_.start_trace();
    const StepReport report = world_.step();
    std::vector<TraceEvent> spans;
    if (looked_at) {
      spans = world_.take_trace();
      world_.stop_trace();
    }
    if (way == kEveryFrame) spans_ += spans.size();
    profile.add(report, looked_at ? &spans : nullptr);
  }

  World& world_;
  int frames_;
  cli::Profile some_, all_;
  std::uint64_t frame_ = 0, spans_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What psim --profile costs a step"};
  std::string scene = "pile";
  std::size_t particles = 20000;
  int threads = 2, warm = 400, rounds = 1000, frames = 16;
  bool sleeping = false;
  double fastest = 0;
  app.add_option("--scene", scene, "a built-in one");
  app.add_option("--particles", particles, "of it; 0: its own number");
  app.add_option("--threads", threads)->check(CLI::Range(1, 64));
  app.add_option("--warm", warm, "frames before the first round")->check(CLI::Range(0, 1000000));
  app.add_option("--rounds", rounds, "of three blocks")->check(CLI::Range(10, 1000000));
  app.add_option("--frames", frames, "a block")->check(CLI::Range(1, 100000));
  app.add_flag("--sleep", sleeping, "bodies may sleep");
  app.add_option("--fastest", fastest, "0: medians of the rounds' ratios")->check(CLI::Range(0.0, 0.5));
  CLI11_PARSE(app, argc, argv);

  std::string error;
  auto made = make_builtin(scene, particles, 1, error);
  if (made) made->world.sleeping = sleeping;
  const auto world = made ? build_world(*made, {best_isa(), threads}, error) : nullptr;
  if (!world) {
    fmt::print(stderr, "profiler: {}\n", error);
    return 1;
  }
  for (int n = 0; n < warm; ++n) world->step();

  Blocks blocks(*world, frames);
  std::mt19937_64 random(1);
  std::array<std::vector<double>, kWays> ns;
  std::vector<double> spans;  // of a block with all
  std::array<Way, kWays> order = {kWithout, kProfile, kEveryFrame};
  for (int round = 0; round < rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (const Way way : order) {
      const std::uint64_t before = blocks.spans();
      ns[way].push_back(blocks.run(way));
      if (way == kEveryFrame) spans.push_back(static_cast<double>(blocks.spans() - before));
    }
  }
  const double share = fastest > 0 ? fastest : 0.5;
  const double limit = quantile(ns[kEveryFrame], share);
  std::vector<double> counted;
  for (std::size_t n = 0; n < spans.size(); ++n) {
    if (ns[kEveryFrame][n] <= limit) counted.push_back(spans[n]);
  }
  fmt::print("{}, {} bodies, {} threads, {} rounds of 3 x {} frames: {:.4f} ms a frame, {:.0f} spans\n", scene,
             world->body_count(), threads, rounds, frames, quantile(ns[kWithout], share) * 1e-6 / frames,
             median(counted) / frames);
  const std::array<const char*, kWays> names = {"", "as psim --profile", "spans in every frame"};
  for (const Way way : {kProfile, kEveryFrame}) {
    std::vector<double> ratios;
    for (std::size_t n = 0; n < ns[way].size(); ++n) ratios.push_back(std::log(ns[way][n] / ns[kWithout][n]));
    const auto of_quantiles = [&](const std::vector<double>& with, const std::vector<double>& without) {
      return std::log(quantile(with, share) / quantile(without, share));
    };
    const double found = fastest > 0 ? of_quantiles(ns[way], ns[kWithout]) : median(ratios);
    const auto [low, high] = interval([&] {
      return fastest > 0 ? of_quantiles(drawn(ns[way], random), drawn(ns[kWithout], random))
                         : median(drawn(ratios, random));
    });
    const auto percent = [](double log) { return 100 * std::expm1(log); };
    fmt::print("{:<22}{:+.2f} % ({:+.2f} to {:+.2f})\n", names[way], percent(found), percent(low), percent(high));
  }
}
