// Scenes: what a JSON file or a built-in name describes, before it becomes a World.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "psim/desc.h"
#include "psim/fluid.h"
#include "psim/joint.h"
#include "psim/world.h"

namespace psim {

enum class Layout : std::uint8_t { lattice, hex, random, explicit_list, ring };

/// Which bodies of a linked group stand still.
enum class Pin : std::uint8_t { none, top, corners, left, ends };

/// Joins the neighbours of a lattice, hex or ring group, centre to centre, at the distance that they are
/// placed at: a rope, a net, a cloth. The links of a ring close it.
struct LinkDesc {
  JointType type = JointType::distance;  ///< distance, spring or rope
  double stiffness = 0;                  ///< spring: N/m
  double damping = 0;                    ///< spring: N s/m
  bool diagonals = false;                ///< lattice: the two diagonals of every cell, too
  Pin pin = Pin::none;                   ///< pinned bodies are static
  bool collide = false;                  ///< whether neighbours still collide
  double break_force = 0;                ///< N: a link that bears more in a step goes; 0: it holds whatever comes
  double pressure = 0;                   ///< ring: N/m: pushes each link outwards
  double drag = 0, lift = 0;             ///< 0 to 1000: the links catch wind, as JointDesc::wind_drag says
  bool area = false;                     ///< ring: keeps the area inside, as JointDesc::area says
  /// distance, of a ring or a single row or column: N m/rad; above 0 links are beams, each welded to its two bodies, that
  /// bend in their middle by an angle that takes this x the angle. So beams of the length l bend as one does with
  /// EI = bending x l.
  double bending = 0;
  std::optional<double> bending_damping = {};  ///< N m s/rad, of beams; absent: bending x 1 ms
};

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
  std::optional<LinkDesc> links;             ///< lattice, hex and ring only
  /// Everything else (type, material, mass, ...). A shape other than a disc is that of every body,
  /// and is placed by the circle around its origin that holds it; no chains.
  BodyDesc body;
};

/// The world as a body of a joint of a scene.
inline constexpr std::uint64_t kWorldSide = 0xFFFFFFFFu;

/// A joint of a scene: bodies by their index in the scene, which is their id, or kWorldSide. A gear has joints instead.
struct SceneJoint {
  std::uint64_t a = 0, b = 0;
  JointDesc joint;                         ///< its a and b, and those of a gear, are filled in when the world is made
  std::uint64_t joint_a = 0, joint_b = 0;  ///< gear: joints before it, by their index in Scene::joints
};

/// A disc that is full of a fluid, metres.
struct FluidDisc {
  Vec2 position;
  double radius = 0;
};
/// An area that is full of a fluid, within a line that is closed: what is inside by the even-odd rule.
struct FluidPolygon {
  std::vector<Vec2> vertices;
};
/// Particles one by one; no velocities: as SceneFluid says.
struct FluidList {
  std::vector<double> x, y, vx, vy;
};

/// A fluid of a scene. An area is filled with a lattice that begins half a spacing from the lower left corner of the
/// rectangle around it, rows from the bottom. A fluid that begins empty has a list of no particles.
struct SceneFluid {
  FluidDesc fluid;
  std::variant<Bounds, FluidDisc, FluidPolygon, FluidList> place;
  Vec2 velocity;  ///< of all particles, m/s
};

struct Scene {
  std::string name;
  std::string description;
  WorldDesc world;
  std::vector<BodyDesc> bodies;
  std::vector<std::string> body_names;  ///< parallel to bodies; empty = unnamed
  std::vector<GroupDesc> groups;
  std::vector<SceneJoint> joints;
  std::vector<SceneFluid> fluids;
  std::uint64_t seed = 1;  ///< mixed into every group's seed when set from outside
  /// One line each: what of a file in another format is approximated or left out.
  std::vector<std::string> notes;

  std::vector<EmitterDesc> emitters;
  std::vector<Bounds> drains;

  /// Number of bodies that the scene will make.
  std::uint64_t body_count() const;
};

/// Reads a scene from JSON text, psim's own or that of R.U.B.E. (docs/scenes.md). On failure returns nothing and one
/// line in `error`: FILE:LINE:COL: path: what was wrong, what is allowed. `file` is used in messages only.
std::optional<Scene> parse_scene(std::string_view text, std::string_view file, std::string& error);

/// Reads a file and parses it.
std::optional<Scene> load_scene(const std::string& path, std::string& error);

/// The JSON text of a scene, parseable by parse_scene to the same scene.
std::string scene_to_json(const Scene& scene);

struct BuiltinScene {
  std::string_view name;
  std::uint64_t default_particles;
  std::string_view description;  ///< one line: what it shows
  bool sized = true;             ///< whether the number of bodies can be chosen
};

/// Every built-in scene, in the order of `--list-scenes`.
const std::vector<BuiltinScene>& builtin_scenes();

/// Makes a built-in scene with `particles` bodies (0 = its default) from `seed`.
std::optional<Scene> make_builtin(std::string_view name, std::uint64_t particles, std::uint64_t seed,
                                  std::string& error);

/// Places a group's bodies: columns ready for World::add_discs. One line in `error` if they do not
/// fit (cell smaller than the body, no room for a random layout).
struct PlacedGroup {
  std::vector<double> x, y, radius, vx, vy;
};
std::optional<PlacedGroup> place_group(const GroupDesc& group, std::string& error);

/// Makes a world and puts every body of the scene into it: `bodies` in order, then `groups`; then joints and fluids.
std::unique_ptr<World> build_world(const Scene& scene, const RunOptions& options, std::string& error);

/// forecast() tells here what a scene will take, without building it.
struct SceneForecast {
  static constexpr std::uint64_t kMostPairs = std::uint64_t{1} << 28;  ///< that the lists of a world hold

  std::uint64_t bodies = 0;
  std::uint64_t pairs = 0;  ///< about so many pairs of moving bodies are near each other at the start
  std::uint64_t bytes = 0;  ///< of its world after the first step, to within a factor of about 2
};
/// O(bodies log sizes).
SceneForecast forecast(const Scene& scene);

/// What would go wrong when the scene runs: one line each (mass ratio, speed x dt against size,
/// sizes of very different scale, ...). Empty = nothing to say.
std::vector<std::string> check_scene(const Scene& scene);

}  // namespace psim
