// L7 and L8: energy and momentum.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "course.h"
#include "law.h"
#include "scenes.h"
#include "shapes.h"

namespace psim::laws {
namespace {

double spring_energy(const Scene& scene, World& world, const std::vector<JointId>& joints) {
  double sum = 0;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const JointDesc& d = scene.joints[k].joint;
    const auto state = world.joint(joints[k]);
    if (!state || d.stiffness == 0) continue;
    double stretch = state->value;
    if (d.type == JointType::spring)
      stretch = std::hypot(state->anchor_b.x - state->anchor_a.x, state->anchor_b.y - state->anchor_a.y) -
                d.length.value_or(0);
    sum += d.stiffness * stretch * stretch / 2;
  }
  return sum;
}

Scene elastic_pen(Draw& draw) {
  Scene scene = space(draw.chance(0.3));
  const Material material = elastic();
  add_pen(draw, scene, material);
  fill_pen(draw, scene, draw.from(1, 40), draw.logarithmic(0.5, 20), draw.chance(0.4), &material);
  return scene;
}

Scene any_pen(Draw& draw) {
  Scene scene = space(draw.chance(0.8));
  add_pen(draw, scene, draw_material(draw));
  fill_pen(draw, scene, draw.from(1, 40), draw.logarithmic(0.5, 30), false, nullptr);
  return scene;
}

Scene something_closed(Draw& draw) {
  switch (draw.below(5)) {
    case 0:
      return elastic_pen(draw);
    case 1:
      return any_pen(draw);
    case 2:
      return one_mover(draw);
    default:
      return jointed(draw);
  }
}

bool all_elastic(const Scene& scene) {
  if (!scene.joints.empty()) return false;
  return std::ranges::all_of(scene.bodies,
                             [](const BodyDesc& b) { return b.material.restitution == 1 && b.material.friction == 0; });
}

bool only_discs(const Scene& scene) {
  return std::ranges::all_of(scene.bodies, [](const BodyDesc& b) {
    return b.type != BodyType::dynamic_body || std::holds_alternative<DiscShape>(b.shape);
  });
}

// Springs without a length take it from their start: it must be known here.
Scene with_lengths(Scene scene) {
  const auto world = world_of(scene);
  for (std::size_t k = 0; k < scene.joints.size(); ++k) {
    JointDesc& d = scene.joints[k].joint;
    const auto state = world->joint({static_cast<std::uint32_t>(k), 0});
    if (d.length || !state || d.type == JointType::revolute || d.type == JointType::weld) continue;
    if (d.type == JointType::prismatic) continue;
    d.length = std::hypot(state->anchor_b.x - state->anchor_a.x, state->anchor_b.y - state->anchor_a.y);
  }
  return scene;
}

std::optional<Fault> energy(const Scene& drawn) {
  const Scene scene = with_lengths(drawn);
  std::vector<JointId> joints;
  for (std::uint32_t k = 0; k < scene.joints.size(); ++k) joints.push_back({k, 0});
  const auto world = world_of(scene);
  const auto sum = [&](double& potential) {
    const Diagnostics d = world->diagnostics();
    potential = d.potential + spring_energy(scene, *world, joints);
    return d.kinetic + potential;
  };
  double potential = 0;
  const double start = sum(potential);
  double least = start, floor = potential, top = start;
  // What places exact to 1e-7 m leave of the energy of bodies at rest.
  constexpr double kExact = 1e-7;
  const double pull = std::hypot(scene.world.gravity.x, scene.world.gravity.y);
  double rounding = 0;
  for (const BodyDesc& b : scene.bodies) {
    rounding += kExact * (kExact + pull) * (b.mass > 0 ? b.mass : b.material.density * area_of(b.shape));
  }
  for (const SceneJoint& j : scene.joints) rounding += kExact * kExact * j.joint.stiffness;
  const bool kept = all_elastic(scene);
  const double share = kept ? (only_discs(scene) ? 1e-4 : 5e-3) : 1e-3;
  double worst = 0, lost = 0;
  int worst_frame = 0;
  for (int frame = 1; frame <= 600 && world->escaped_total() == 0; ++frame) {
    world->step();
    if (world->escaped_total() != 0) break;
    const double now = sum(potential);
    if (!std::isfinite(now)) return Fault{frame, "the energy is not a number"};
    floor = std::min(floor, potential);
    top = std::max(top, now);
    if (now - least > worst) worst = now - least, worst_frame = frame;
    lost = std::max(lost, start - now);
    least = std::min(least, now);
  }
  const double scale = top - floor;
  if (worst > share * scale + rounding) {
    return Fault{worst_frame, fmt::format("energy grew by {:.3g} J of {:.3g}, {:.3g} of it, allowed {:.3g}", worst,
                                          scale, worst / scale, share)};
  }
  if (kept && lost > share * scale) {
    return Fault{600, fmt::format("an elastic scene lost {:.3g} of its energy, allowed {:.3g}", lost / scale, share)};
  }
  return std::nullopt;
}

Scene free_cloud(Draw& draw) {
  Scene scene = draw.chance(0.4) ? two_that_meet(draw) : space(false);
  if (scene.bodies.empty()) {
    fill_pen(draw, scene, draw.from(2, 30), 5, false, nullptr);
    for (BodyDesc& b : scene.bodies) {  // towards the middle
      b.velocity.x -= b.position.x;
      b.velocity.y -= b.position.y;
    }
  }
  return scene;
}

// World::diagnostics has both sums; what they are compared with is what the bodies carry one by one.
std::optional<Fault> momentum(const Scene& scene) {
  const auto world = world_of(scene);
  const Diagnostics start = world->diagnostics();
  double speed = 0, reach = 0, mass = 0;
  for (const BodyDesc& b : scene.bodies) {
    const double m = b.mass > 0 ? b.mass : b.material.density * area_of(b.shape);
    mass += m;
    speed = std::max(speed, std::hypot(b.velocity.x, b.velocity.y) + std::fabs(b.angular_velocity) * reach_of(b.shape));
    reach = std::max(reach, std::hypot(b.position.x, b.position.y));
  }
  for (int frame = 1; frame <= 180; ++frame) {
    world->step();
    const Diagnostics now = world->diagnostics();
    const double off = std::hypot(now.momentum_x - start.momentum_x, now.momentum_y - start.momentum_y);
    if (off > 1e-5 * mass * speed) {
      return Fault{frame, fmt::format("momentum changed by {:.3g} of {:.3g} kg m/s", off, mass * speed)};
    }
    const double turned = std::fabs(now.angular_momentum - start.angular_momentum);
    const double about = mass * speed * (reach + speed * frame * scene.world.dt);
    if (turned > 1e-4 * about) {
      return Fault{frame, fmt::format("angular momentum changed by {:.3g} of {:.3g} kg m^2/s", turned, about)};
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Law> sum_laws() {
  return {{"L7", "energy never grows, and stays where everything is elastic", Spare::movers, something_closed, energy},
          {"L8", "momentum stays where nothing is fixed", Spare::movers, free_cloud, momentum}};
}

}  // namespace psim::laws
