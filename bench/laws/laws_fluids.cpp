// L1 to L3, L5 to L9 and L17, of scenes with fluids.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "change.h"
#include "course.h"
#include "fluid_scenes.h"
#include "fluid_sums.h"
#include "law.h"
#include "shapes.h"

namespace psim::laws {
namespace {

constexpr int kFrames = 60;
// Fewer particles than this are no water: the laws of its motion say nothing of them.
constexpr std::size_t kFewest = 50;
// What a law allows two runs of one scene to differ by: a share of the side of a square that has the fluids' area, and a
// share of the largest energy. Particles of a scene that is mirrored or turned lie elsewhere in the cells of the grid, and
// splashes make much of small differences.
struct Allowed {
  double place = 0.02, energy = 0.1;
};
// The same where particles lie at the same places in the cells, so that only the rounding differs.
constexpr Allowed kRounding = {1e-3, 1e-3};
constexpr double kGrowth = 1e-3;    // of the largest energy
constexpr double kMomentum = 0.03;  // of mass times speed at the start
constexpr double kDepth = 1;        // spacings: a line holds water back as if it were two spacings wide
constexpr double kBodyOut = 0.1;    // m

Draw draw_of(const Scene& scene) { return Draw(scene.seed * 7919 + 17); }

bool has_water(const Scene& scene) {
  return !scene.fluids.empty() && world_of(scene)->fluid_report().particles >= kFewest;
}

// The number, or a very large one if it is none.
double or_huge(double v) { return std::isfinite(v) ? v : 1e300; }

double length(Vec2 v) { return std::hypot(v.x, v.y); }
double apart(Vec2 a, Vec2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

// J: the largest energy of a course. Potential counts from the lowest middle of a particle or body at the start, or from
// where the centre of all comes to, if that is lower.
double largest_energy(const Scene& scene, const std::vector<FluidSums>& course) {
  const double pull = length(scene.world.gravity);
  double floor = course[0].potential - course[0].mass * pull * course[0].height, most = -1e300;
  for (const FluidSums& s : course) {
    floor = std::min(floor, s.potential);
    most = std::max(most, s.energy());
  }
  return most - floor;
}

// ---- L1, L2, L5, L6: the same water, seen otherwise -------------------------------------------------------------------

std::optional<Fault> same_water(const Scene& drawn, const Change& change, Allowed allowed = {}) {
  if (!has_water(drawn)) return std::nullopt;
  const Scene scene = with_particles(drawn);
  const Scene changed = change.of(scene);
  const auto one = sums_course(scene, scene, {}, kFrames), other = sums_course(changed, scene, change, kFrames);
  const double size = std::sqrt(fluid_area(scene)), energy = largest_energy(scene, one);
  double place = 0, most = 0;
  int frame_place = 0, frame_energy = 0;
  for (int frame = 0; frame <= kFrames; ++frame) {
    const auto k = static_cast<std::size_t>(frame);
    const FluidSums &a = one[k], &b = other[k];
    const double off = std::max({or_huge(apart(a.mean, b.mean)), or_huge(apart(a.spread, b.spread)),
                                 or_huge(apart(a.centre, b.centre))}) /
                       size;
    if (off > place) place = off, frame_place = frame;
    const double gained = or_huge(std::fabs(a.energy() - b.energy()) / energy);
    if (gained > most) most = gained, frame_energy = frame;
  }
  if (!(place <= allowed.place)) {
    return Fault{frame_place,
                 fmt::format("places are off by {:.3g} of the water's size, energy by {:.3g}", place, most)};
  }
  if (!(most <= allowed.energy)) {
    return Fault{frame_energy,
                 fmt::format("energy is off by {:.3g}, places by {:.3g} of the water's size", most, place)};
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
  return same_water(scene, change, kRounding);
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

std::optional<Fault> energy_within(const Scene& scene, double allowed) {
  if (!has_water(scene)) return std::nullopt;
  const auto course = sums_course(scene, scene, {}, 300);
  const double scale = largest_energy(scene, course);
  double least = course[0].energy(), worst = 0;
  int frame_worst = 0;
  for (std::size_t frame = 1; frame < course.size(); ++frame) {
    const double now = course[frame].energy();
    if (!std::isfinite(now)) return Fault{static_cast<int>(frame), "the energy is not a number"};
    if (now - least > worst) worst = now - least, frame_worst = static_cast<int>(frame);
    least = std::min(least, now);
  }
  if (worst <= allowed * scale) return std::nullopt;
  return Fault{frame_worst,
               fmt::format("energy grew by {:.3g} J of {:.3g}, {:.3g} of it", worst, scale, worst / scale)};
}

std::optional<Fault> energy(const Scene& scene) { return energy_within(scene, kGrowth); }
std::optional<Fault> tenth(const Scene& scene) { return energy_within(scene, 0.1); }

std::optional<Fault> momentum(const Scene& scene) {
  if (!has_water(scene)) return std::nullopt;
  const auto course = sums_course(scene, scene, {}, 120);
  const FluidSums& start = course[0];
  if (!(start.moving > 0)) return std::nullopt;  // nothing to compare with
  const double size = std::sqrt(fluid_area(scene));
  double worst = 0, turned = 0;
  int frame_worst = 0;
  for (std::size_t frame = 1; frame < course.size(); ++frame) {
    const double off = or_huge(apart(course[frame].momentum, start.momentum) / start.moving);
    if (off > worst) worst = off, frame_worst = static_cast<int>(frame);
    turned = std::max(turned, std::fabs(course[frame].angular - start.angular) / (start.moving * size));
  }
  if (worst <= kMomentum) return std::nullopt;
  return Fault{frame_worst, fmt::format("momentum changed by {:.3g} of {:.3g} kg m/s, angular momentum by {:.3g}",
                                        worst, start.moving, turned)};
}

// ---- L9 ---------------------------------------------------------------------------------------------------------------

// How far particles are out of the pen and deep within bodies, and bodies out of the pen, at most.
struct Strayed {
  double out = 0, deep = 0, body = 0;  // spacings, spacings, m
  int within = 0;                      // the body that a particle is deepest in
  bool too_far() const { return out > kDepth || deep > kDepth || body > kBodyOut; }
};

// How far a place is out of a pen that ends at `right`, m.
double out_of_pen(Vec2 at, double right) {
  if (!std::isfinite(at.x + at.y)) return 1e300;
  return std::max({at.x - right, -kPen - at.x, at.y - kPen, -kPen - at.y});
}

void look_for_strays(const Scene& scene, const World& world, double right, Strayed& strayed) {
  const double spacing = scene.fluids[0].fluid.spacing;
  std::vector<FluidParticleState> particles;
  world.fluid_particles(particles);
  for (const FluidParticleState& p : particles) {
    strayed.out = std::max(strayed.out, out_of_pen(p.position, right) / spacing);
  }
  for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) {
    const BodyDesc& desc = scene.bodies[id];
    const auto state = world.body(world.id_of(id));
    if (!state) {
      strayed.body = 1e9;
      return;
    }
    for (const FluidParticleState& p : particles) {
      const double deep = depth_in(desc.shape, *state, p.position) / spacing;
      if (deep > strayed.deep) strayed.deep = deep, strayed.within = static_cast<int>(id);
    }
    if (desc.type != BodyType::dynamic_body) continue;
    for (const Vec2& at : places_of(desc.shape, *state)) strayed.body = std::max(strayed.body, out_of_pen(at, right));
  }
}

std::optional<Fault> nobody_passes(const Scene& scene) {
  if (scene.fluids.empty()) return std::nullopt;
  double right = kPen;
  for (std::size_t k = 0; k < scene.body_names.size(); ++k) {
    if (scene.body_names[k] == kPartition) right = scene.bodies[k].position.x;
  }
  const auto world = world_of(scene);
  const std::size_t start = world->fluid_report().particles;
  Strayed strayed;
  for (int frame = 1; frame <= 120; ++frame) {
    world->step();
    if (world->fluid_report().particles != start) return Fault{frame, "particles left the world"};
    look_for_strays(scene, *world, right, strayed);
    if (!strayed.too_far()) continue;
    return Fault{
        frame,
        fmt::format("a particle is {:.3g} spacings out of the pen, one {:.3g} deep in body {}, a body {:.3g} m out",
                    strayed.out, strayed.deep, strayed.within, strayed.body)};
  }
  return std::nullopt;
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
      {"L5", "Galilei: where everything moves evenly, water moves the same against it", Spare::all, without_walls,
       drifting},
      {"L6", "scale: lengths x 4, times x 2, masses x k: the same motion, scaled", Spare::all, any, scaled},
      {"L7", "energy of water and bodies never grows", Spare::movers, without_drives, energy},
      {"L8", "momentum of water and bodies stays within 3 % where nothing is fixed", Spare::all, fluid_adrift,
       momentum},
      {"L9", "neither water nor bodies pass what is solid", Spare::movers, fast_fluid_pen, nobody_passes},
      {"L17", "energy of water and bodies grows by a tenth at most", Spare::movers, without_drives, tenth}};
  return laws;
}

}  // namespace psim::laws
