// The table of built-in scenes, and what they share.
#include "builtin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

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
    Entry{{"pile", 100'000, "a dense block of discs settling on the floor, no bounce, no friction"},
          pile},
    Entry{{"rough-pile", 100'000, "the same block with friction 0.5 and restitution 0.1"},
          rough_pile},
    Entry{{"dam", 20'000, "a column of discs let go at one end of a tank"}, dam},
    Entry{{"hourglass", 5'000, "discs running through the neck of a glass made of chains"},
          hourglass},
    Entry{{"galton", 2'000, "discs falling from a hopper through rows of pegs into bins"}, galton},
    Entry{{"mixed-sizes", 20'000, "large, middling and small discs (radii 50 : 8 : 1) in one pile"},
          mixed_sizes},
    Entry{{"billiard", 16, "a rack broken by a cue disc: no losses, no gravity"}, billiard},
    Entry{{"orbits", 2'000, "small discs circling a gravity well in an open world"}, orbits},
    Entry{
        {"gas-periodic", 20'000, "an elastic gas in a periodic box: energy and momentum are kept"},
        gas_periodic},
    Entry{{"million", 1'000'000, "the scene discs with a million of them"}, discs},
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

GroupDesc lattice(std::uint64_t n, const Bounds& region, double radius, double jitter,
                  const Material& material) {
  GroupDesc group;
  group.layout = Layout::lattice;
  group.count = n;
  group.region = region;
  group.radius_min = group.radius_max = radius;
  group.jitter = jitter;
  group.body.material = material;
  return group;
}

void add_static(Scene& scene, const char* name, Vec2 position, Shape shape,
                const Material& material) {
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
    for (const builtin::Entry& entry : builtin::kScenes) infos.push_back(entry.info);
    return infos;
  }();
  return scenes;
}

std::optional<Scene> make_builtin(std::string_view name, std::uint64_t particles,
                                  std::uint64_t seed, std::string& error) {
  for (const builtin::Entry& entry : builtin::kScenes) {
    if (entry.info.name != name) continue;
    if (particles > builtin::kMostParticles) {
      error = "scene " + std::string(name) + " with " + std::to_string(particles) +
              " particles: 1 to " + std::to_string(builtin::kMostParticles);
      return std::nullopt;
    }
    Scene scene = entry.make(particles ? particles : entry.info.default_particles, seed);
    scene.name = name;
    scene.description = entry.info.description;
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
