// L1 to L6, L13 to L15: the same scene seen otherwise moves in the same way.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "change.h"
#include "course.h"
#include "law.h"
#include "scenes.h"
#include "shapes.h"

namespace psim::laws {
namespace {

constexpr int kFrames = 60;
constexpr double kShare = 1e-6;  // of the scene's size
constexpr double kChaos = 1e-4;  // of the scene's size: a nudge of rounding that grows to more says nothing

// Draws again what a change needs from what the scene itself is, so that a shrunk scene is changed alike.
Draw draw_of(const Scene& scene) { return Draw(scene.seed * 7919 + 17); }

double apart_of(const BodyState& a, const BodyState& b) {
  const double turned = std::remainder(a.angle - b.angle, 2 * M_PI) * a.radius;
  return std::max(std::hypot(a.x - b.x, a.y - b.y), std::fabs(turned));
}

// How far the moving bodies of the scene as it is are from those of another course; back(state, time) maps its states.
template <class Back>
std::optional<Fault> compared(const Scene& scene, const Course& course, const Course& other, double allowed,
                              const Back& back, double dt) {
  for (std::size_t frame = 0; frame < std::min(course.size(), other.size()); ++frame) {
    for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
      if (scene.bodies[id].type != BodyType::dynamic_body) continue;
      const double off = apart_of(course[frame][id], back(other[frame][id], static_cast<double>(frame) * dt));
      if (!(off > allowed)) continue;
      return Fault{static_cast<int>(frame),
                   fmt::format("body {} is {:.3g} m off, allowed are {:.3g}", id, off, allowed)};
    }
  }
  return std::nullopt;
}

double fastest_in(const Course& course) {
  double most = 0;
  for (const auto& frame : course) {
    for (const BodyState& b : frame) most = std::max(most, std::hypot(b.vx, b.vy));
  }
  return most;
}

// What may become in this scene of places off by the rounding of the lattice and velocities off by that of floats, m.
// They round in every frame, at speeds up to `fastest`.
double grown_rounding(const Scene& scene, const Course& course, double fastest) {
  constexpr double kNudge = 1e-7;
  const double rounded = 0x1p-24 * fastest;
  double most = 0;
  for (const double sign : {-1.0, 1.0}) {
    Scene nudged = scene;
    for (BodyDesc& b : nudged.bodies) {
      if (b.type != BodyType::dynamic_body) continue;
      b.position = {b.position.x + sign * kNudge, b.position.y + kNudge};
      b.velocity = {b.velocity.x + sign * rounded, b.velocity.y + rounded};
    }
    const Course other = course_of(nudged, kFrames);
    for (std::size_t frame = 0; frame < course.size(); ++frame) {
      for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
        most = std::max(most, apart_of(course[frame][id], other[frame][id]));
      }
    }
  }
  return most;
}

// Compares two courses of a scene. `size`, m, is the larger one of both scenes, since places round in proportion to the
// ways that bodies go. Impacts on corners multiply differences: then what a nudge becomes is allowed as well, and where a
// nudge becomes large nothing is said.
template <class Back>
std::optional<Fault> same_course(const Scene& scene, const Course& course, const Course& other, double size,
                                 const Back& back, double dt) {
  const auto fault = compared(scene, course, other, kShare * size, back, dt);
  if (!fault) return fault;
  const double grown = 10 * grown_rounding(scene, course, std::max(fastest_in(course), fastest_in(other)));
  if (grown > kChaos * size) return std::nullopt;
  return compared(scene, course, other, std::max(kShare * size, grown), back, dt);
}

std::optional<Fault> same_as(const Scene& scene, const Scene& changed, const Change& change) {
  const auto back = [&](const BodyState& s, double time) { return change.back(s, time); };
  const double size = std::max(size_of(scene, kFrames), size_of(changed, kFrames) / change.scale);
  return same_course(scene, course_of(scene, kFrames), course_of(changed, kFrames), size, back, changed.world.dt);
}

std::optional<Fault> mirrored(const Scene& scene) {
  Change change;
  change.mirror = true;
  return same_as(scene, change.of(scene), change);
}

std::optional<Fault> turned(const Scene& scene) {
  Change change;
  change.quarters = draw_of(scene).from(1, 3);
  return same_as(scene, change.of(scene), change);
}

// Places that a double can hold far away, too.
Scene on_a_grid(Scene scene) {
  for (BodyDesc& b : scene.bodies) {
    for (double* at : {&b.position.x, &b.position.y}) *at = std::round(*at * 0x1p20) * 0x1p-20;
  }
  return scene;
}

// By whole steps of any lattice: the same bits.
std::optional<Fault> moved(const Scene& drawn) {
  Draw draw = draw_of(drawn);
  const Scene scene = on_a_grid(drawn);
  Change change;
  const double far = draw.chance(0.3) ? 1024 : 16;
  change.shift = {far * draw.from(-900, 900), far * draw.from(-900, 900)};
  const Course course = course_of(scene, kFrames), other = course_of(change.of(scene), kFrames);
  for (std::size_t frame = 0; frame < course.size(); ++frame) {
    for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
      const BodyState& a = course[frame][id];
      const BodyState& b = other[frame][id];
      if (a.angle == b.angle && a.vx == b.vx && a.vy == b.vy && a.omega == b.omega) continue;
      return Fault{static_cast<int>(frame),
                   fmt::format("body {} has other bits {} m and {} m away", id, change.shift.x, change.shift.y)};
    }
  }
  return std::nullopt;
}

std::optional<Fault> in_any_order(const Scene& scene) {
  Draw draw = draw_of(scene);
  switch (draw.below(3)) {
    case 0:
      return same_as(scene, relisted(scene, draw), {});
    case 1:
      return same_as(scene, cut_finer(scene, draw), {});
    default:
      return same_as(scene, apart(scene), {});
  }
}

std::optional<Fault> drifting(const Scene& scene) {
  Draw draw = draw_of(scene);
  Change change;
  change.boost = {draw.uniform(-20, 20), draw.uniform(-20, 20)};
  return same_as(scene, change.of(scene), change);
}

std::optional<Fault> scaled(const Scene& scene) {
  Change change;
  change.scale = 4;
  change.slower = 2;
  change.heavier = draw_of(scene).logarithmic(0.1, 10);
  return same_as(scene, change.of(scene), change);
}

std::optional<Fault> falling(const Scene& scene) {
  Scene fall = scene;
  fall.world.gravity = {0, -9.81};
  const Course course = course_of(scene, kFrames), other = course_of(fall, kFrames);
  const auto back = [](BodyState s, double time) {
    s.y += 9.81 * time * time / 2;
    s.vy += 9.81 * time;
    return s;
  };
  return same_course(scene, course, other, size_of(fall, kFrames), back, scene.world.dt);
}

std::optional<Fault> on_kinematic_ground(const Scene& scene) { return same_as(scene, kinematic(scene), {}); }

Scene periodic_mover(Draw& draw) {
  Scene scene = one_mover(draw);
  scene.world.boundary = Boundary::periodic;
  scene.world.bounds = {-32, -256, 32, 256};
  return scene;
}

// Places wrap: a body counts where it is nearest to the one that it is compared with.
std::optional<Fault> across_the_seam(const Scene& scene) {
  Draw draw = draw_of(scene);
  Scene shifted = scene;
  const double wide = scene.world.bounds.xmax - scene.world.bounds.xmin;
  const double by = wide * draw.from(1, 63) / 64;
  const auto wrapped = [&](double x) { return x - wide * std::floor((x - scene.world.bounds.xmin) / wide); };
  for (BodyDesc& b : shifted.bodies) b.position.x = wrapped(b.position.x + by);
  const Course course = course_of(scene, kFrames);
  Course other = course_of(shifted, kFrames);
  for (std::size_t frame = 0; frame < course.size(); ++frame) {
    for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
      BodyState& b = other[frame][id];
      b.x = course[frame][id].x + std::remainder(b.x - by - course[frame][id].x, wide);
    }
  }
  return same_course(
      scene, course, other, size_of(scene, kFrames), [](const BodyState& s, double) { return s; }, scene.world.dt);
}

Scene one_or_two(Draw& draw) { return draw.chance(0.75) ? one_mover(draw) : two_that_meet(draw); }

}  // namespace

std::vector<Law> symmetry_laws() {
  return {{"L1", "mirror: the scene mirrored in x gives the mirrored motion", Spare::all, one_or_two, mirrored},
          {"L2", "turn: the scene turned by a right angle gives the turned motion", Spare::all, one_or_two, turned},
          {"L3", "move: the scene elsewhere has the same bits", Spare::all, one_or_two, moved},
          {"L4", "order: vertices in another order, straight parts cut, chains as segments: the same motion",
           Spare::all, one_on_terrain, in_any_order},
          {"L5", "Galilei: where everything moves evenly, bodies move the same against it", Spare::all, one_or_two,
           drifting},
          {"L6", "scale: lengths x 4, times x 2, masses x k: the same motion, scaled", Spare::all, one_or_two, scaled},
          {"L13", "fall: everything in free fall moves as without gravity", Spare::all, two_that_meet, falling},
          {"L14", "static bodies are like kinematic ones at rest", Spare::all, one_on_terrain, on_kinematic_ground},
          {"L15", "seam: a periodic world shifted by any amount gives the same motion", Spare::all, periodic_mover,
           across_the_seam}};
}

}  // namespace psim::laws
