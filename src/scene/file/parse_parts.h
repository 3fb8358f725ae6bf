// The parts of a scene file, each read by a file of its own: parse_world.cpp, parse_shape.cpp,
// parse_body.cpp, parse_group.cpp, parse_fluid.cpp, parse_joint.cpp. All throw SceneError.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "file/parse_node.h"
#include "psim/scene.h"

namespace psim::scene {

/// What the parts need to know of each other.
struct Context {
  Bounds bounds;
  std::map<std::string, Material, std::less<>> materials;
  std::map<std::string, std::uint64_t, std::less<>> body_ids;  ///< by name
  std::uint64_t body_count = 0;
};

void read_materials(const Node& scene, Context& context);
/// After the materials; notes the bounds.
void read_world(const Node& scene, Context& context, WorldDesc& world);
void read_step(const Node& scene, Scene& out);
void read_fields(const Node& scene, WorldDesc& world);
void read_bodies(const Node& scene, Context& context, Scene& out);
void read_groups(const Node& scene, Context& context, Scene& out);
/// After the world.
void read_fluids(const Node& scene, const Context& context, Scene& out);
/// After the fluids.
void read_emitters(const Node& scene, const Context& context, Scene& out);
void read_drains(const Node& scene, Scene& out);
/// After bodies and groups.
void read_joints(const Node& scene, const Context& context, Scene& out);

/// The material of this name.
const Material& named_material(const Node& name, const Context& context);
/// A material that stands there itself.
Material read_material(const Node& node);
/// The keys of a material that there are, in a node that may have others.
void read_material_keys(const Node& node, Material& material);
/// `one_way`; nothing where there is no key.
std::optional<Vec2> read_one_way(const Node& node);

/// A shape of any kind that a body of this type may have.
Shape read_shape(const Node& shape, const Context& context, BodyType type);
/// The parts of a compound. The keys that it shares with its parts have been read.
Shape read_shapes(const Node& shapes, const Context& context, const BodyDesc& body);
double read_radius(const Node& radius, const Context& context);

/// The keys that bodies and groups share, without place, shape and velocity.
inline constexpr std::array<std::string_view, 22> kSharedBodyKeys = {"tangent_speed",
                                                                     "rolling_resistance",
                                                                     "one_way",
                                                                     "enabled",

                                                                     "type",
                                                                     "angle",
                                                                     "angular_velocity",
                                                                     "material",
                                                                     "density",
                                                                     "mass",
                                                                     "restitution",
                                                                     "friction",
                                                                     "gravity_scale",
                                                                     "bullet",
                                                                     "category",
                                                                     "mask",
                                                                     "fixed_rotation",
                                                                     "linear_damping",
                                                                     "angular_damping",
                                                                     "lock",
                                                                     "group",
                                                                     "sensor"};
void read_shared_body_keys(const Node& node, const Context& context, BodyDesc& body);
/// `category`, `mask` and `group`, each as in `filter` where there is no key.
Filter read_filter(const Node& node, Filter filter);
/// `links` of a lattice or hex group, whose keys before have been read.
std::optional<LinkDesc> read_links(const Node& group_node, const GroupDesc& group);

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
