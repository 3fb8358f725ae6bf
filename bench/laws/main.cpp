// laws: random scenes against the laws that hold in every scene (docs/laws.md).
//
//   laws                         a minute of all laws from a new seed, which it prints
//   laws --seed 7 --seconds 600  from a seed that is known
//   laws --law L7 --law L9       two of them
//   laws --compounds             bodies of several shapes
//   laws --fluids                scenes with fluids
//   laws --scene FILE --law L7   one scene, from a file that a run has written
//   laws --known FILE            as a test: a law may be broken as often as the file says, no more
// A scene that breaks a law is made small and written to --out. Exit 1 if there is one, 2 if asked wrongly.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "course.h"
#include "law.h"
#include "psim/scene.h"
#include "shapes.h"
#include "shrink.h"

namespace psim::laws {

const std::vector<Law>& all_laws() {
  static const std::vector<Law> laws = [] {
    std::vector<Law> all;
    for (auto some : {symmetry_laws(), sum_laws(), solid_laws(), time_laws()}) {
      all.insert(all.end(), some.begin(), some.end());
    }
    std::sort(all.begin(), all.end(),
              [](const Law& a, const Law& b) { return std::stoi(a.name.substr(1)) < std::stoi(b.name.substr(1)); });
    return all;
  }();
  return laws;
}

}  // namespace psim::laws

namespace {

using namespace psim;
using namespace psim::laws;

constexpr std::array kSubsteps = {1, 4, 16};

struct Options {
  std::vector<std::string> names;
  std::string scene, known, out = "laws-broken";
  std::uint64_t seed = 0;
  double seconds = 60;
  int first = 0, scenes = std::numeric_limits<int>::max(), tries = 200, most = 3;
  bool list = false, compounds = false, fluids = false;
};

struct Count {
  int scenes = 0, broken = 0;
};

// One scene of a law: the seed and the number of the scene say which.
Scene scene_of(const Law& law, const Options& options, int number) {
  const std::uint64_t seed = options.seed;
  Draw draw(seed ^ (std::stoull(law.name.substr(1)) * 0x9E3779B97F4A7C15u) ^
            (static_cast<std::uint64_t>(number) << 32));
  Scene scene = law.draw(draw);
  scene.seed = draw.bits() >> 40;
  scene.name = (options.fluids ? "fluids-" : "") + law.name + "-" + std::to_string(seed) + "-" + std::to_string(number);
  scene.world.substeps = kSubsteps[static_cast<std::size_t>(number) % kSubsteps.size()];
  for (BodyDesc& body : scene.bodies) {
    const bool large = reach_of(body.shape) > 3;  // a press
    if (!options.compounds || body.type != BodyType::dynamic_body || large || draw.chance(0.3)) continue;
    body.shape = draw_compound(draw, reach_of(body.shape));
  }
  return scene;
}

// What there is of fluids in it, or nothing.
std::string particles_of(const Scene& scene) {
  if (scene.fluids.empty()) return {};
  return fmt::format(", {} particles of {} fluids", world_of(scene)->fluid_report().particles, scene.fluids.size());
}

void tell(const Options& options, const Law& law, Scene scene, const Fault& fault) {
  fmt::print("{} broken by {} ({} substeps) in frame {}: {}\n", law.name, scene.name, scene.world.substeps, fault.frame,
             fault.what);
  const Scene small = shrunk(law, scene, options.tries);
  const auto left = law.broken(small);
  std::filesystem::create_directories(options.out);
  const std::string file = options.out + "/" + scene.name + ".json";
  std::ofstream(file) << scene_to_json(small);
  fmt::print("  {} of {} bodies{}, {}; {}\n", small.bodies.size(), scene.bodies.size(), particles_of(small),
             left ? left->what : "", file);
  std::fflush(stdout);
}

// By law: the share of scenes that break it. A law that the file does not name holds in all.
std::map<std::string, double> known_shares(const std::string& file) {
  std::map<std::string, double> shares;
  std::ifstream in(file);
  std::string name;
  for (double share = 0; in >> name >> share;) shares[name] = share;
  return shares;
}

// How many scenes may break a law of which a share is known: four standard deviations above the mean.
double most_broken(double share, int scenes) { return share * scenes + 4 * std::sqrt(share * scenes); }

int run(const Options& options, const std::vector<Law>& laws) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto known = known_shares(options.known);
  std::map<std::string, Count> counts;
  std::map<std::string, std::vector<int>> broken;
  fmt::print("seed {}\n", options.seed);
  const auto over = [&] { return std::chrono::duration<double>(Clock::now() - start).count() >= options.seconds; };
  for (int number = options.first; number - options.first < options.scenes && !over(); ++number) {
    for (const Law& law : laws) {
      if (over()) break;
      Count& count = counts[law.name];
      ++count.scenes;
      const Scene scene = scene_of(law, options, number);
      const auto fault = law.broken(scene);
      if (!fault) continue;
      broken[law.name].push_back(number);
      if (++count.broken <= options.most && known[law.name] == 0) tell(options, law, scene, *fault);
    }
  }
  int faults = 0;
  for (const Law& law : laws) {
    const Count& count = counts[law.name];
    const bool fault = count.broken > most_broken(known[law.name], count.scenes);
    faults += fault ? 1 : 0;
    fmt::print("{:4} {:6} scenes {:6} broken  {}{}\n", law.name, count.scenes, count.broken, law.text,
               fault && known[law.name] > 0 ? fmt::format(": more than {:.2g} of them", known[law.name]) : "");
    if (!fault || known[law.name] == 0) continue;
    const Scene scene = scene_of(law, options, broken[law.name].front());
    tell(options, law, scene, *law.broken(scene));
  }
  return faults == 0 ? 0 : 1;
}

int run_file(const Options& options, const std::vector<Law>& laws) {
  std::string error;
  const auto scene = load_scene(options.scene, error);
  if (!scene) {
    fmt::print(stderr, "laws: {}\n", error);
    return 2;
  }
  int broken = 0;
  for (const Law& law : laws) {
    const auto fault = law.broken(*scene);
    broken += fault.has_value() ? 1 : 0;
    fmt::print("{} {}\n", law.name, fault ? fmt::format("broken in frame {}: {}", fault->frame, fault->what) : "holds");
  }
  return broken == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Random scenes against the laws that hold in every scene.");
  app.add_option("--law", options.names, "laws to check, e.g. L7 (all)");
  app.add_option("--seed", options.seed, "seed of the scenes (0: a new one)");
  app.add_option("--seconds", options.seconds, "how long (60)")->check(CLI::PositiveNumber);
  app.add_option("--scenes", options.scenes, "how many scenes of each law, at most")->check(CLI::PositiveNumber);
  app.add_option("--first", options.first, "number of the first scene (0)")->check(CLI::NonNegativeNumber);
  app.add_option("--known", options.known, "file of laws and the shares of scenes that may break them")
      ->check(CLI::ExistingFile);
  app.add_option("--scene", options.scene, "check this file alone");
  app.add_option("--out", options.out, "folder for scenes that break a law (laws-broken)");
  app.add_option("--tries", options.tries, "runs to make such a scene small (200)");
  app.add_option("--most", options.most, "scenes written of a law (3)");
  app.add_flag("--compounds", options.compounds, "most bodies that move have several shapes");
  app.add_flag("--fluids", options.fluids, "scenes have fluids");
  app.add_flag("--list", options.list, "the laws");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    fmt::print(stderr, "laws: {}\n", e.what());
    return 2;
  }
  std::vector<Law> laws;
  for (const Law& law : options.fluids ? fluid_laws() : all_laws()) {
    if (options.names.empty() || std::ranges::count(options.names, law.name) != 0) laws.push_back(law);
  }
  if (laws.empty()) {
    fmt::print(stderr, "laws: no such law; laws --list names them\n");
    return 2;
  }
  if (options.list) {
    for (const Law& law : laws) fmt::print("{:4} {}\n", law.name, law.text);
    return 0;
  }
  if (!options.scene.empty()) return run_file(options, laws);
  while (options.seed == 0) options.seed = std::random_device{}() % 1000000;
  return run(options, laws);
}
