// A ragdoll falls down stairs: ten capsules on pins with limits and friction. Exits with 1 if a joint opens, a limb goes
// past its limit, or the ragdoll does not come to rest at the bottom.
#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace {

struct Bone {           // of a figure that stands upright and looks to the right
  std::size_t parent;   // index of the bone that it hangs on
  double from, to;      // m: heights of its joint and of its other end
  double radius, mass;  // m, kg
  double lower, upper;  // rad: limits of the angle against its parent
};
constexpr Bone kBones[] = {
    {0, 0.95, 1.4, 0.13, 35, 0, 0},     {0, 1.5, 1.65, 0.1, 5, -0.6, 0.6},   // trunk, which hangs on nothing; head
    {0, 1.4, 1.12, 0.05, 2.5, -1, 2.8}, {0, 1.4, 1.12, 0.05, 2.5, -1, 2.8},  // upper arms
    {2, 1.12, 0.8, 0.04, 2, 0, 2.4},    {3, 1.12, 0.8, 0.04, 2, 0, 2.4},     // lower arms
    {0, 0.95, 0.5, 0.08, 9, -0.5, 2},   {0, 0.95, 0.5, 0.08, 9, -0.5, 2},    // thighs
    {6, 0.5, 0.06, 0.06, 5, -2.4, 0},   {7, 0.5, 0.06, 0.06, 5, -2.4, 0},    // shins
};

}  // namespace

int main() {
  std::string error;
  // Hard blows open joints by about a centimetre with 4 substeps, by some millimetres with 16.
  const auto world = psim::World::create({.substeps = 16}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::ChainShape stairs{{{-4, 0}}};
  for (int k = 0; k < 7; ++k) {  // each step is 0.3 m wide and 0.2 m high
    stairs.vertices.push_back({0.3 * k, -0.2 * k});
    stairs.vertices.push_back({0.3 * k, -0.2 * (k + 1)});
  }
  stairs.vertices.push_back({12, -1.4});
  world->add_body({.type = psim::BodyType::static_body, .shape = stairs, .material = {.friction = 0.4}}, error);

  psim::BodyId bodies[std::size(kBones)];
  psim::JointId joints[std::size(kBones)];
  for (std::size_t k = 0; k < std::size(kBones); ++k) {
    const Bone& bone = kBones[k];
    bodies[k] = world->add_body({.shape = psim::CapsuleShape{{}, {0, bone.to - bone.from}, bone.radius},
                                 .position = {0, bone.from},
                                 .velocity = {3, 0},  // somebody pushed
                                 .material = {.friction = 0.4},
                                 .mass = bone.mass,
                                 .filter = {.group = -1}},  // bones do not collide with each other
                                error);
    if (k == 0) continue;
    joints[k] = world->add_joint({.type = psim::JointType::revolute,
                                  .a = bodies[bone.parent],
                                  .b = bodies[k],
                                  .anchor_a = {0, bone.from - kBones[bone.parent].from},
                                  .lower = bone.lower,
                                  .upper = bone.upper,
                                  .motor_limit = 4},  // N m: a motor with speed 0 is friction
                                 error);
  }

  double gap = 0, bent = 0;
  for (int frame = 1; frame <= 600; ++frame) {
    world->step();
    for (std::size_t k = 1; k < std::size(kBones); ++k) {
      const psim::JointState joint = *world->joint(joints[k]);
      gap = std::max(gap, std::hypot(joint.anchor_b.x - joint.anchor_a.x, joint.anchor_b.y - joint.anchor_a.y));
      bent = std::max({bent, kBones[k].lower - joint.value, joint.value - kBones[k].upper});
    }
    const psim::BodyState trunk = *world->body(bodies[0]);
    if (frame % 30 != 0 || frame > 120) continue;
    std::printf("%.1f s: the hip is at (%.1f, %.1f)\n", frame / 60.0, trunk.x, trunk.y);
  }
  const bool rests = !world->is_awake(bodies[0]) && world->body(bodies[0])->y < -1;
  std::printf("widest gap %.1e m, farthest past a limit %.1e rad, %s\n", gap, bent, rests ? "at rest" : "not at rest");
  return rests && gap < 0.01 && bent < 0.05 ? 0 : 1;
}
