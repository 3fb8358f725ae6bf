// L1 to L3 and L5 to L9 of scenes with fluids.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <variant>

#include "change.h"
#include "course.h"
#include "fluid_scenes.h"
#include "fluid_sums.h"
#include "law.h"

namespace psim::laws {
namespace {

constexpr int kFrames = 60;
// What a water that splashes may be off by when it is seen otherwise: shares of the depth that its area has as a square,
// and of the energy that it has over its lowest potential.
constexpr double kPlace = 0.01, kEnergy = 0.01;
constexpr double kGrowth = 1e-3;    // of energy
constexpr double kMomentum = 0.03;  // of mass times speed at the start

Draw draw_of(const Scene& scene) { return Draw(scene.seed * 7919 + 17); }

double length(Vec2 v) { return std::hypot(v.x, v.y); }
double apart(Vec2 a, Vec2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

// The energy over the lowest potential of a course, at most.
double energy_over_floor(const std::vector<FluidSums>& course) {
  double floor = 1e300, top = -1e300;
  for (const FluidSums& s : course) floor = std::min(floor, s.potential), top = std::max(top, s.energy());
  return top - floor;
}

// ---- L1, L2, L5, L6: the same water, seen otherwise -------------------------------------------------------------------

std::optional<Fault> same_water(const Scene& drawn, const Change& change) {
  if (drawn.fluids.empty()) return std::nullopt;
  const Scene scene = with_particles(drawn);
  const Scene changed = change.of(scene);
  const auto one = sums_course(scene, scene, {}, kFrames), other = sums_course(changed, scene, change, kFrames);
  const double size = std::sqrt(fluid_area(scene)), energy = energy_over_floor(one);
  double place = 0, most = 0;
  int frame_place = 0, frame_energy = 0;
  for (int frame = 0; frame <= kFrames; ++frame) {
    const auto k = static_cast<std::size_t>(frame);
    const FluidSums &a = one[k], &b = other[k];
    const double off =
        std::max({apart(a.mean, b.mean), apart(a.spread, b.spread), apart(a.centre, b.centre)}) / size;
    if (off > place) place = off, frame_place = frame;
    const double gained = std::fabs(a.energy() - b.energy()) / energy;
    if (gained > most) most = gained, frame_energy = frame;
  }
  if (!(place <= kPlace)) {
    return Fault{frame_place, fmt::format("places are off by {:.3g} of the water's size, energy by {:.3g}", place, most)};
  }
  if (!(most <= kEnergy)) {
    return Fault{frame_energy, fmt::format("energy is off by {:.3g}, places by {:.3g} of the water's size", most, place)};
  }
  return std::nullopt;
}

std::optional<Fault> mirrored(const Scene& scene) {
  Change change;
  change.mirror = true;
  return same_water(scene, change);
}

std::optional<Fault> turned(const Scene& scene) {
  Change change;
  change.quarters = draw_of(scene).from(1, 3);
  return same_water(scene, change);
}

std::optional<Fault> drifting(const Scene& scene) {
  Draw draw = draw_of(scene);
  Change change;
  change.boost = {draw.uniform(-20, 20), draw.uniform(-20, 20)};
  return same_water(scene, change);
}

std::optional<Fault> scaled(const Scene& scene) {
  Change change;
  change.scale = 4;
  change.slower = 2;
  change.heavier = draw_of(scene).logarithmic(0.1, 10);
  return same_water(scene, change);
}

// ---- L3 ---------------------------------------------------------------------------------------------------------------

double on_grid(double at) { return std::round(at * 0x1p20) * 0x1p-20; }

// All that has bits, but for places: where those differ, velocities do in the next frame.
struct Bits {
  std::vector<BodyState> bodies;
  std::vector<FluidParticleState> particles;
};

std::vector<Bits> bits_course(const Scene& scene) {
  const auto world = world_of(scene);
  std::vector<Bits> course;
  for (int frame = 0; frame <= kFrames; ++frame) {
    if (frame > 0) world->step();
    Bits bits;
    for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) {
      bits.bodies.push_back(world->body(world->id_of(id)).value_or(BodyState{}));
    }
    world->fluid_particles(bits.particles);
    course.push_back(std::move(bits));
  }
  return course;
}

bool alike(const BodyState& a, const BodyState& b) {
  return a.angle == b.angle && a.vx == b.vx && a.vy == b.vy && a.omega == b.omega;
}
bool alike(const FluidParticleState& a, const FluidParticleState& b) {
  return a.velocity.x == b.velocity.x && a.velocity.y == b.velocity.y && a.density == b.density &&
         a.pressure == b.pressure;
}

std::optional<Fault> moved(const Scene& drawn) {
  if (drawn.fluids.empty()) return std::nullopt;
  Draw draw = draw_of(drawn);
  Scene scene = with_particles(drawn);
  for (BodyDesc& b : scene.bodies) b.position = {on_grid(b.position.x), on_grid(b.position.y)};
  for (SceneFluid& f : scene.fluids) {
    auto& list = std::get<FluidList>(f.place);
    for (auto* places : {&list.x, &list.y}) {
      for (double& at : *places) at = on_grid(at);
    }
  }
  Change change;
  const double far = draw.chance(0.3) ? 1024 : 16;
  change.shift = {far * draw.from(-900, 900), far * draw.from(-900, 900)};
  const auto one = bits_course(scene), other = bits_course(change.of(scene));
  for (std::size_t frame = 0; frame < one.size(); ++frame) {
    const Bits &a = one[frame], &b = other[frame];
    const auto at = fmt::format("has other bits {} m and {} m away", change.shift.x, change.shift.y);
    if (a.particles.size() != b.particles.size()) return Fault{static_cast<int>(frame), "the fluid " + at};
    for (std::size_t k = 0; k < a.particles.size(); ++k) {
      if (!alike(a.particles[k], b.particles[k])) {
        return Fault{static_cast<int>(frame), fmt::format("particle {} {}", k, at)};
      }
    }
    for (std::size_t id = 0; id < a.bodies.size(); ++id) {
      if (!alike(a.bodies[id], b.bodies[id])) return Fault{static_cast<int>(frame), fmt::format("body {} {}", id, at)};
    }
  }
  return std::nullopt;
}

// ---- L7, L8 -----------------------------------------------------------------------------------------------------------

std::optional<Fault> energy(const Scene& scene) {
  if (scene.fluids.empty()) return std::nullopt;
  const auto course = sums_course(scene, scene, {}, 300);
  const double scale = energy_over_floor(course), floor = 1e-3 * course[0].mass * length(scene.world.gravity);
  double least = course[0].energy(), worst = 0;
  int frame_worst = 0;
  for (std::size_t frame = 1; frame < course.size(); ++frame) {
    const double now = course[frame].energy();
    if (!std::isfinite(now)) return Fault{static_cast<int>(frame), "the energy is not a number"};
    if (now - least > worst) worst = now - least, frame_worst = static_cast<int>(frame);
    least = std::min(least, now);
  }
  if (worst <= kGrowth * scale) return std::nullopt;
  return Fault{frame_worst, fmt::format("energy grew by {:.3g} J of {:.3g}, {:.3g} of it; it lifts all by {:.3g} m", worst, scale, worst / scale, 1e-3 * worst / floor)};
}

std::optional<Fault> momentum(const Scene& scene) {
  if (scene.fluids.empty()) return std::nullopt;
  const auto course = sums_course(scene, scene, {}, 120);
  const FluidSums& start = course[0];
  const double size = std::sqrt(fluid_area(scene));
  double worst = 0, turned = 0;
  int frame_worst = 0;
  for (std::size_t frame = 1; frame < course.size(); ++frame) {
    const double off = apart(course[frame].momentum, start.momentum) / start.moving;
    if (off > worst) worst = off, frame_worst = static_cast<int>(frame);
    turned = std::max(turned, std::fabs(course[frame].angular - start.angular) / (start.moving * size));
  }
  if (worst <= kMomentum) return std::nullopt;
  return Fault{frame_worst, fmt::format("momentum changed by {:.3g} of {:.3g} kg m/s, angular momentum by {:.3g}", worst, start.moving, turned)};
}

// ---- L9 ---------------------------------------------------------------------------------------------------------------

std::optional<Fault> nobody_passes(const Scene& scene) {
  if (scene.fluids.empty()) return std::nullopt;
  double right = kPen;
  for (std::size_t k = 0; k < scene.body_names.size(); ++k) {
    if (scene.body_names[k] == kPartition) right = scene.bodies[k].position.x;
  }
  const auto world = world_of(scene);
  double out = 0, deep = 0, body_out = 0;
  int frame_out = 0, frame_deep = 0, deep_body = 0;
  std::vector<FluidParticleState> particles;
  world->fluid_particles(particles);
  const std::size_t start = particles.size();
  for (int frame = 1; frame <= 120; ++frame) {
    world->step();
    world->fluid_particles(particles);
    if (particles.size() != start) return Fault{frame, fmt::format("{} particles left the world", start - particles.size())};
    for (const FluidParticleState& p : particles) {
      const double far = std::max({p.position.x - right, -kPen - p.position.x, p.position.y - kPen, -kPen - p.position.y}) / scene.fluids[0].fluid.spacing;
      if (far > out) out = far, frame_out = frame;
      for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) {
        const auto b = world->body(world->id_of(id));
        if (!b) return Fault{frame, fmt::format("body {} left the world", id)};
        const double depth = depth_in(scene.bodies[id].shape, *b, p.position)/ scene.fluids[0].fluid.spacing;
        if (depth > deep) deep = depth, frame_deep = frame, deep_body = static_cast<int>(id);
      }
    }
    for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) {
      if (scene.bodies[id].type != BodyType::dynamic_body) continue;
      const auto b = world->body(world->id_of(id));
      if (!b) return Fault{frame, fmt::format("body {} left the world", id)};
      const double far = std::max({b->x - right, -kPen - b->x, b->y - kPen, -kPen - b->y});
      body_out = std::max(body_out, far);
    }
  }
  if (out < 0.5 && deep < 0.5 && body_out < 0.1) return std::nullopt;
  return Fault{frame_out, fmt::format("out {:.3g} spacings, deep {:.3g} spacings in body {} ({}) frame {}, body out {:.3g}", out, deep, deep_body, deep_body<(int)scene.bodies.size() ? (int)scene.bodies[deep_body].type:-1, frame_deep, body_out)};
}

Scene any(Draw& draw) { return fluid_scene(draw, {}); }
Scene without_walls(Draw& draw) { return fluid_scene(draw, {.walls = false}); }
Scene without_drives(Draw& draw) { return fluid_scene(draw, {.driven = false, .tension = false}); }

}  // namespace

const std::vector<Law>& fluid_laws() {
  static const std::vector<Law> laws = {
      {"L1", "mirror: water mirrored in x moves as its mirror image", Spare::all, any, mirrored},
      {"L2", "turn: water turned by a right angle moves the same", Spare::all, any, turned},
      {"L3", "move: water elsewhere has the same bits", Spare::all, any, moved},
      {"L5", "Galilei: where everything moves evenly, water moves the same against it", Spare::all, without_walls, drifting},
      {"L6", "scale: lengths x 4, times x 2, masses x k: the same motion, scaled", Spare::all, any, scaled},
      {"L7", "energy of water and bodies never grows", Spare::movers, without_drives, energy},
      {"L8", "momentum of water and bodies stays where nothing is fixed", Spare::all, fluid_adrift, momentum},
      {"L9", "neither water nor bodies pass what is solid", Spare::movers, fast_fluid_pen, nobody_passes}};
  return laws;
}

}  // namespace psim::laws
