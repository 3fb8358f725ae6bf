// Bad scene files, NaN in one body, and the same scene in every variant. psim only.
#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "stress.h"

namespace psim::accuracy::stress {
namespace {

std::unique_ptr<World> world_of(const Scene& scene, const RunOptions& options) {
  std::string error;
  auto world = build_world(scene, options, error);
  if (!world) throw std::runtime_error(error);
  world->set_sleeping(false);
  return world;
}

/// Rough discs that fall in a bin, one of them far off in the air.
Scene landing(int discs) {
  const Material rough = material(0.2, 0.3);
  Scene scene = walled_scene(60, 60, rough, {0, -kGravity});
  for (int k = 0; k < discs; ++k) {
    scene.bodies.push_back(disc({1 + 1.05 * (k % 20) + 0.01 * (k / 20), 1 + 1.05 * (k / 20)}, {}, rough));
  }
  scene.bodies.push_back(disc({50, 50}, {}, rough));
  return scene;
}

/// In place of one value of a good scene.
struct Mistake {
  std::string_view good, bad;
};

constexpr std::string_view kGoodScene = R"({"psim": 1,
 "world": {"bounds": [-9, -9, 9, 9], "boundary": "open", "gravity": [0, -9.81]},
 "step": {"dt": 0.01, "substeps": 4},
 "materials": {"m": {"density": 1, "restitution": 0.5, "friction": 0.3}},
 "bodies": [{"shape": {"disc": {"radius": 0.5}}, "position": [0, 1], "material": "m",
             "mass": 2.5}],
 "groups": [{"layout": "lattice", "count": 3, "region": [0, 2, 8, 8], "radius": 0.25}]})";

constexpr std::array<Mistake, 24> kMistakes = {{
    {"\"radius\": 0.5", "\"radius\": 0"},
    {"\"radius\": 0.5", "\"radius\": -1"},
    {"\"radius\": 0.5", "\"radius\": 1e300"},
    {"\"radius\": 0.5", "\"radius\": NaN"},
    {"\"radius\": 0.5", "\"radius\": 1e999"},
    {"\"mass\": 2.5", "\"mass\": 0"},
    {"\"mass\": 2.5", "\"mass\": -1"},
    {"\"mass\": 2.5", "\"mass\": 1e300"},
    {"\"mass\": 2.5", "\"mass\": null"},
    {"\"density\": 1", "\"density\": 0"},
    {"\"restitution\": 0.5", "\"restitution\": 1.5"},
    {"\"restitution\": 0.5", "\"restitution\": Infinity"},
    {"\"friction\": 0.3", "\"friction\": -0.1"},
    {"[0, 1]", "[0, 1e300]"},
    {"[0, 1]", "[0, \"1\"]"},
    {"[0, -9.81]", "[0, -1e300]"},
    {"[-9, -9, 9, 9]", "[9, -9, -9, 9]"},
    {"\"dt\": 0.01", "\"dt\": 0"},
    {"\"dt\": 0.01", "\"dt\": 1e9"},
    {"\"substeps\": 4", "\"substeps\": 0"},
    {"\"substeps\": 4", "\"substeps\": 1e9"},
    {"\"count\": 3", "\"count\": -3"},
    {"\"count\": 3", "\"count\": 1e12"},
    {"[0, 2, 8, 8]", "[8, 2, 0, 8]"},
}};

}  // namespace

int bad_scenes_taken() {
  std::string error;
  if (!parse_scene(kGoodScene, "scene.json", error)) throw std::runtime_error(error);
  int taken = 0;
  for (const Mistake& mistake : kMistakes) {
    std::string text(kGoodScene);
    const std::size_t at = text.find(mistake.good);
    if (at == std::string::npos) throw std::logic_error("nothing to spoil");
    text.replace(at, mistake.good.size(), mistake.bad);
    const bool refused = !parse_scene(text, "scene.json", error);
    taken += refused && error.starts_with("scene.json:") && error.find('\n') == error.npos ? 0 : 1;
  }
  return taken;
}

int bodies_changed_by_nan() {
  constexpr std::uint32_t kOthers = 200;
  const Scene scene = landing(kOthers);
  const auto hurt = world_of(scene, {best_isa(), 2}), without = world_of(scene, {best_isa(), 2});
  const auto frames = [&](int count) {
    for (int k = 0; k < count; ++k) {
      hurt->step();
      without->step();
    }
  };
  frames(30);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  hurt->set_velocity(hurt->id_of(kOthers), {kNan, kNan}, kNan);
  without->remove_body(without->id_of(kOthers));
  frames(60);
  const PublishedState s = hurt->published(), t = without->published();
  int changed = 0;
  for (std::size_t k = 0; k < kOthers; ++k) {
    const bool same = s.x[k] == t.x[k] && s.y[k] == t.y[k] && s.angle[k] == t.angle[k] && s.vx[k] == t.vx[k] &&
                      s.vy[k] == t.vy[k] && s.omega[k] == t.omega[k];
    changed += same ? 0 : 1;
  }
  return changed;
}

int variants_that_differ() {
  const Scene scene = landing(1000);
  const auto hash_of = [&scene](Isa isa, int threads) {
    const auto world = world_of(scene, {isa, threads});
    for (int k = 0; k < 120; ++k) world->step();
    return world->state_hash();
  };
  const std::uint64_t first = hash_of(Isa::scalar, 1);
  int different = 0;
  for (const Isa isa : kAllIsas) {
    if (!isa_available(isa)) continue;
    for (const int threads : {1, 2, 4}) different += hash_of(isa, threads) == first ? 0 : 1;
  }
  return different;
}

}  // namespace psim::accuracy::stress
