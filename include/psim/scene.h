// Scenes: what a JSON file or a built-in name describes, before it becomes a World.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "psim/desc.h"
#include "psim/world.h"

namespace psim {

enum class Layout : std::uint8_t { lattice, hex, random, explicit_list };

/// Many alike bodies placed by rule. See docs/scenes.md for the layouts.
struct GroupDesc {
  Layout layout = Layout::lattice;
  std::uint64_t count = 0;
  Bounds region;
  double radius_min = 0.5, radius_max = 0.5;  ///< metres; uniform between the two
  double jitter = 0;                          ///< 0..1 of the free gap
  Vec2 velocity;
  double velocity_spread = 0;  ///< uniform +-s on each axis
  std::uint64_t seed = 1;
  std::vector<double> x, y, radius, vx, vy;  ///< explicit_list only
  BodyDesc body;                             ///< everything else (type, material, mass, ...)
};

struct Scene {
  std::string name;
  std::string description;
  WorldDesc world;
  bool sleeping = true;
  std::vector<BodyDesc> bodies;
  std::vector<std::string> body_names;  ///< parallel to bodies; empty = unnamed
  std::vector<GroupDesc> groups;
  std::uint64_t seed = 1;  ///< mixed into every group's seed when set from outside

  /// Number of bodies that the scene will make.
  std::uint64_t body_count() const;
};

/// Reads a scene from JSON text. On failure returns nothing and one line in `error`:
/// FILE:LINE:COL: path: what was wrong, what is allowed. `file` is used in messages only.
std::optional<Scene> parse_scene(std::string_view text, std::string_view file, std::string& error);

/// Reads a file and parses it.
std::optional<Scene> load_scene(const std::string& path, std::string& error);

/// The JSON text of a scene, parseable by parse_scene to the same scene.
std::string scene_to_json(const Scene& scene);

struct BuiltinScene {
  std::string_view name;
  std::uint64_t default_particles;
  std::string_view description;  ///< one line: what it shows
};

/// Every built-in scene, in the order of `--list-scenes`.
const std::vector<BuiltinScene>& builtin_scenes();

/// Makes a built-in scene with `particles` discs (0 = its default) from `seed`.
std::optional<Scene> make_builtin(std::string_view name, std::uint64_t particles,
                                  std::uint64_t seed, std::string& error);

/// Places a group's bodies: columns ready for World::add_discs. One line in `error` if they do not
/// fit (cell smaller than the body, no room for a random layout).
struct PlacedGroup {
  std::vector<double> x, y, radius, vx, vy;
};
std::optional<PlacedGroup> place_group(const GroupDesc& group, std::string& error);

/// Makes a world and puts every body of the scene into it: `bodies` in order, then `groups`.
std::unique_ptr<World> build_world(const Scene& scene, const RunOptions& options,
                                   std::string& error);

/// What would go wrong when the scene runs: one line each (mass ratio, speed x dt against size,
/// sizes of very different scale, ...). Empty = nothing to say.
std::vector<std::string> check_scene(const Scene& scene);

}  // namespace psim
