// The parts of a scene file, each read by a file of its own: parse_world.cpp, parse_shape.cpp,
// parse_body.cpp, parse_group.cpp, parse_joint.cpp. All throw SceneError.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "parse_available.h"
#include "parse_node.h"
#include "psim/scene.h"

namespace psim::scene {

/// What the parts need to know of each other.
struct Context {
  Bounds bounds;
  std::map<std::string, Material, std::less<>> materials;
  std::set<std::string, std::less<>> body_names;
  std::uint64_t body_count = 0;
  Availability availability;
};

void read_materials(const Node& scene, Context& context);
/// After the materials; notes the bounds.
void read_world(const Node& scene, Context& context, WorldDesc& world);
void read_step(const Node& scene, Scene& out);
void read_fields(const Node& scene, WorldDesc& world);
void read_bodies(const Node& scene, Context& context, Scene& out);
void read_groups(const Node& scene, Context& context, Scene& out);
/// After bodies and groups.
void read_joints(const Node& scene, Context& context);

/// The material of this name.
const Material& named_material(const Node& name, const Context& context);

/// A shape of any kind. One that this version cannot simulate is noted, and gives a disc.
Shape read_shape(const Node& shape, Context& context);
double read_radius(const Node& radius, const Context& context);

/// The keys that bodies and groups share, without place, shape and velocity.
inline constexpr std::array<std::string_view, 11> kSharedBodyKeys = {
    "type",        "angle",    "angular_velocity", "material",       "density", "mass",
    "restitution", "friction", "gravity_scale",    "fixed_rotation", "bullet"};
void read_shared_body_keys(const Node& node, Context& context, BodyDesc& body);

/// Segments and chains are static.
void check_shape_against_type(const Node& shape, BodyType type, Context& context);

/// A place that is not inside the bounds is an error.
void expect_inside(const Node& node, Vec2 position, const Bounds& bounds);

/// xmin < xmax and ymin < ymax.
Bounds read_bounds(const Node& node);
std::string bounds_text(const Bounds& bounds);

/// Both lists as one, for the keys of an object.
template <std::size_t N, std::size_t M>
constexpr std::array<std::string_view, N + M> joined(const std::array<std::string_view, N>& own,
                                                     const std::array<std::string_view, M>& more) {
  std::array<std::string_view, N + M> all;
  for (std::size_t k = 0; k < N; ++k) all[k] = own[k];
  for (std::size_t k = 0; k < M; ++k) all[N + k] = more[k];
  return all;
}

}  // namespace psim::scene
