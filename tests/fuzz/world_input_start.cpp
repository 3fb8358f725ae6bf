// Worlds that begin as a scene: groups by layout, ropes and nets of its own links.
#include <cstddef>
#include <string>
#include <vector>

#include "world_descs.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

LinkDesc links(ByteSource& in) {
  LinkDesc l;
  l.type = one_of(in, {JointType::distance, JointType::spring, JointType::rope});
  l.stiffness = in.uniform(0, 5000);
  l.damping = in.uniform(0, 50);
  l.diagonals = in.chance(80);
  l.pin = one_of(in, {Pin::none, Pin::top, Pin::corners, Pin::left, Pin::ends});
  l.collide = in.chance(60);
  if (in.chance(60)) l.break_force = in.uniform(0.1, 500);
  if (in.chance(60)) l.drag = in.uniform(0, 5), l.lift = in.uniform(0, 5);
  return l;
}

}  // namespace

// False if the scene is refused.
bool Session::create_from_scene(const WorldDesc& desc, const RunOptions& options, bool twins) {
  Scene scene;
  scene.name = "fuzz";
  scene.world = desc;
  scene.seed = in_.byte();
  for (std::size_t k = in_.below(4); k > 0; --k) scene.bodies.push_back(body(in_));
  for (std::size_t k = 1 + in_.below(2); k > 0; --k) {
    GroupDesc g = group(600);
    if (g.layout != Layout::random && in_.chance(128)) g.links = links(in_);
    if (in_.chance(40)) g.body.shape = BoxShape{g.radius_min, g.radius_min, 0};
    scene.groups.push_back(g);
  }
  for (std::size_t k = in_.below(5); k > 0; --k) {
    SceneJoint joint;
    joint.a = in_.below_wide(scene.body_count() + 1);
    joint.b = in_.below_wide(scene.body_count() + 1);
    joint.joint.type = static_cast<JointType>(in_.below(12));
    if (in_.chance(30)) joint.a = kWorldSide;
    joint.joint_a = in_.below(4);
    joint.joint_b = in_.below(4);
    joint.joint.stiffness = in_.number(0, 500);
    scene.joints.push_back(joint);
  }
  say("scene of %zu bodies and %zu groups", static_cast<std::size_t>(scene.body_count()), scene.groups.size());
  std::string error, first_error;
  const bool one = !twins || options.threads < 1 || options.threads > 256;  // a twin has threads that are accepted
  for (int k = 0; k < (one ? 1 : 2); ++k) {
    worlds_.push_back(build_world(scene, k == 0 ? options : RunOptions{Isa::scalar, 1}, error));
    require((worlds_.back() != nullptr) == error.empty(), "build_world: a world or an error: " + error);
    if (k == 0) first_error = error;
    require(error == first_error, "build_world: two variants differ: \"" + first_error + "\" and \"" + error + "\"");
  }
  if (!worlds_.back()) {
    refused(error);
    return false;
  }
  for (const std::string& line : check_scene(scene)) {
    require(!line.empty() && line.find('\n') == line.npos, "check_scene: lines: " + line);
  }
  World& w = *worlds_.front();
  require(w.body_count() == scene.body_count(), "build_world: as many bodies as the scene has");
  require(forecast(scene).bodies == scene.body_count(), "forecast: as many bodies as the scene has");
  const PublishedState s = w.published();
  for (const std::uint32_t index : s.id) live(w.id_of(index));
  for (std::uint32_t k = 0; k < w.joint_count(); ++k) {
    joints_.push_back({k, 0});
    require(w.is_valid_joint(joints_.back()), "build_world: joints count from 0");
    jointed_ = true;
  }
  return true;
}

}  // namespace psim::fuzz
