// What a scene's joints are made of: its bodies by id, and the joints that the links of groups stand
// for. Ids run over `bodies`, then `groups`, as in the world that is made of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "psim/scene.h"

namespace psim {

/// Rods shorter than this have no direction, metres.
inline constexpr double kShortestJoint = 1e-9;

/// The bodies of a scene by id, without placing those of groups. Reads the scene as long as it lives.
class SceneBodies {
 public:
  explicit SceneBodies(const Scene& scene);

  BodyType type_of(std::uint64_t id) const;
  /// Whose description the body has.
  const BodyDesc& desc_of(std::uint64_t id) const;
  /// How far the anchors of a joint are apart at the start; nothing if one is in a group.
  std::optional<double> anchor_distance(const SceneJoint& joint) const;
  /// The id of the first body of groups[k].
  std::uint64_t first_of_group(std::size_t k) const { return first_[k]; }

 private:
  std::size_t group_of(std::uint64_t id) const;

  const Scene& scene_;
  std::vector<std::uint64_t> first_;  // id of each group's first body
};

/// Whether body k of a linked group stands still.
bool is_pinned(const GroupDesc& group, std::uint64_t k);

/// Whether the links of a group may be beams: those of a net would make a frame of it, which hardly shears.
bool may_bend(const GroupDesc& group);
inline constexpr const char* kMayBend = "is for a ring, or a single row or column";

/// Appends a joint for every pair of neighbours of which at least one moves; `first` is the id of the
/// group's first body. Anchors are the origins of the bodies, also of beams, which are welds half-way between the two.
void append_links(const GroupDesc& group, std::uint64_t first, std::vector<SceneJoint>& joints);

/// The scene's joints, then those of the groups' links.
std::vector<SceneJoint> all_joints(const Scene& scene);

/// What is drawn of a joint: a line from an anchor to another one.
struct DrawnJoint : SceneJoint {
  std::uint32_t number = 0;  ///< in all_joints(), and the index of its id in a world that was built from the scene
};
/// What is drawn of all joints. Of a pulley two, of a gear none.
std::vector<DrawnJoint> drawn_joints(const Scene& scene);

}  // namespace psim
