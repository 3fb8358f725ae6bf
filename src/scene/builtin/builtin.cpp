// The table of built-in scenes, and what they share.
#include "builtin/builtin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "base/machine.h"
namespace psim {
namespace builtin {
namespace {

constexpr std::uint64_t kMostParticles = 10'000'000;

struct Entry {
  BuiltinScene info;
  Scene (*make)(std::uint64_t n, std::uint64_t seed);
};

constexpr std::array kScenes = {
    Entry{{"discs", 100'000, "discs thrown about in a wide box, falling and bouncing"}, discs},
    Entry{{"pile", 100'000, "a dense block of discs settling on the floor, no bounce, no friction"}, pile},
    Entry{{"rough-pile", 100'000, "the same block with friction 0.5 and restitution 0.1"}, rough_pile},
    Entry{{"dam", 20'000, "a column of discs let go at one end of a tank"}, dam},
    Entry{{"hourglass", 5'000, "discs running through the neck of a glass made of chains"}, hourglass},
    Entry{{"galton", 2'000, "discs falling from a hopper through rows of pegs into bins"}, galton},
    Entry{{"mixed-sizes", 20'000, "large, middling and small discs (radii 50 : 8 : 1) in one pile"}, mixed_sizes},
    Entry{{"billiard", 16, "a rack broken by a cue disc: no losses, no gravity"}, billiard},
    Entry{{"orbits", 2'000, "small discs circling a gravity well in an open world"}, orbits},
    Entry{{"gas-periodic", 20'000, "an elastic gas in a periodic box: energy and momentum are kept"}, gas_periodic},
    Entry{{"million", 1'000'000, "the scene discs with a million of them"}, discs},
    Entry{{"large_pyramid", 5050, "a pyramid of boxes with a base of 100 (Box2D's benchmark)"}, large_pyramid},
    Entry{{"many_pyramids", 22'000, "400 pyramids of 55 boxes on shelves (Box2D's benchmark)"}, many_pyramids},
    Entry{{"joint_grid", 10'000,
           "a net of discs on revolute joints, hung by the middle of its top row (Box2D's "
           "benchmark)"},
          joint_grid},
    Entry{{"tumbler", 2025, "boxes in a square drum that turns (Box2D's benchmark)"}, tumbler},
    Entry{{"washer", 8100, "boxes in a round drum with paddles (Box2D's benchmark)"}, washer},
    Entry{{"compounds", 3000, "bodies of two triangles each fall into a basin (Box2D's benchmark)"}, compounds},
    Entry{{"junkyard", 8000, "a blade pushes scrap to and fro in a basin (Box2D's benchmark)"}, junkyard},
    Entry{{"rain", 11'000, "a thousand ragdolls of 11 bodies falling on shelves (Box2D's benchmark)"}, rain},
    Entry{{"smash", 9600, "a heavy block hits a wall of boxes at 40 m/s, no gravity (Box2D's benchmark)"}, smash},
    Entry{{"spinner", 6076, "a driven bar in a ring of capsules, discs and boxes (Box2D's benchmark)"}, spinner},
    Entry{{"card_house", 40, "five storeys of thin cards held by friction (Box2D)", false}, card_house},
    Entry{{"arch", 21, "seventeen stones and four beams that stand by friction (Box2D)", false}, arch},
    Entry{{"vertical_stack", 15, "boxes on each other, a centimetre off in turn (Solver2D)"}, stack},
    Entry{{"stack_100", 100, "the same, a hundred high"}, stack},
    Entry{{"pyramid", 210, "a pyramid of boxes with a base of 20"}, pyramid},
    Entry{{"high_mass_ratio_1", 165, "three pyramids with tops 100, 200 and 300 times as heavy as a box (Solver2D)",
           false},
          high_mass_ratio_1},
    Entry{{"high_mass_ratio_2", 3, "a box let fall on two that are 400 times lighter (Solver2D)", false},
          high_mass_ratio_2},
    Entry{{"high_mass_ratio_3", 3, "the same on two triangles 800 times lighter (Solver2D)", false}, high_mass_ratio_3},
    Entry{{"overlap_recovery", 10, "boxes that overlap by a quarter at the start (Solver2D)", false}, overlap_recovery},
    Entry{{"ball_and_chain", 30, "thirty links that hold a ball 168 times as heavy as one (Solver2D)"}, ball_and_chain},
    Entry{{"far_pyramid", 55, "a pyramid of boxes 128 km from the origin (Solver2D)"}, far_pyramid},
    Entry{{"rush", 400, "discs drawn from all sides to a fixed one (Solver2D)"}, rush},
    Entry{{"bridge", 160, "planks on revolute joints between two piers, discs fall on them (Box2D)"}, bridge},
    Entry{{"chain", 30, "planks on revolute joints swinging from one end (Box2D)"}, chain},
    Entry{{"newtons_cradle", 5, "elastic discs on rods, one let fall"}, newtons_cradle},
    Entry{{"domino_run", 200, "a disc rolls into a row of dominoes"}, domino_run},
    Entry{{"rope", 100, "a row of linked discs swinging from one end"}, rope},
    Entry{{"cloth", 2500, "a square of linked discs hung by two corners, a ball falls on it"}, cloth},
    Entry{{"boxes_into_discs", 50'000, "fifty large boxes falling into a bed of small discs"}, boxes_into_discs},
};

}  // namespace

std::uint64_t ceil_sqrt(std::uint64_t n) {
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(n)));
  while (root * root < n) ++root;
  while (root > 0 && (root - 1) * (root - 1) >= n) --root;
  return root;
}

Bounds block(std::uint64_t n, std::uint64_t columns, double cell, double x, double y) {
  const std::uint64_t used = std::clamp<std::uint64_t>(columns, 1, std::max<std::uint64_t>(n, 1));
  const std::uint64_t rows = std::max<std::uint64_t>((n + used - 1) / used, 1);
  return {x, y, x + static_cast<double>(used) * cell, y + static_cast<double>(rows) * cell};
}

GroupDesc lattice(std::uint64_t n, const Bounds& region, double radius, double jitter, const Material& material) {
  GroupDesc group;
  group.layout = Layout::lattice;
  group.count = n;
  group.region = region;
  group.radius_min = group.radius_max = radius;
  group.jitter = jitter;
  group.body.material = material;
  return group;
}

void add_static(Scene& scene, const char* name, Vec2 position, Shape shape, const Material& material) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = std::move(shape);
  body.position = position;
  body.material = material;
  scene.bodies.push_back(std::move(body));
  scene.body_names.emplace_back(name);
}

}  // namespace builtin

const std::vector<BuiltinScene>& builtin_scenes() {
  static const std::vector<BuiltinScene> scenes = [] {
    std::vector<BuiltinScene> infos;
    infos.reserve(std::size(builtin::kScenes));
    for (const builtin::Entry& entry : builtin::kScenes) infos.push_back(entry.info);
    return infos;
  }();
  return scenes;
}

std::optional<Scene> make_builtin(std::string_view name, std::uint64_t particles, std::uint64_t seed,
                                  std::string& error) {
  const FloatSettings settings;
  for (const builtin::Entry& entry : builtin::kScenes) {
    if (entry.info.name != name) continue;
    const BuiltinScene& info = entry.info;
    if (!info.sized && particles != 0 && particles != info.default_particles) {
      error = "scene " + std::string(name) + " with " + std::to_string(particles) + " particles: it always has " +
              std::to_string(info.default_particles);
      return std::nullopt;
    }
    if (particles > builtin::kMostParticles) {
      error = "scene " + std::string(name) + " with " + std::to_string(particles) + " particles: 1 to " +
              std::to_string(builtin::kMostParticles);
      return std::nullopt;
    }
    Scene scene = entry.make(particles ? particles : info.default_particles, seed);
    scene.name = name;
    scene.description = info.description;
    scene.seed = seed;
    return scene;
  }
  error = "no built-in scene \"" + std::string(name) + "\"; there are";
  const char* separator = " ";
  for (const builtin::Entry& entry : builtin::kScenes) {
    error += separator + std::string(entry.info.name);
    separator = ", ";
  }
  return std::nullopt;
}

}  // namespace psim
