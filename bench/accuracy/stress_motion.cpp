// Speed, far places, denormals, long runs, smooth ground and time reversed.
#include <array>
#include <chrono>
#include <set>
#include <utility>

#include "closed_forms.h"
#include "stress_trial.h"

namespace psim::accuracy::stress {
namespace {

constexpr double kSmall = 0.1;    // m, radius of what is shot
constexpr double kVast = 0x1p17;  // m, half a world that nothing leaves at 1e5 m/s in a second
constexpr double kSubstep = 1.0 / 240;

BodyDesc small_disc(Vec2 position, Vec2 velocity, double restitution) {
  return disc(position, velocity, material(restitution), kSmall);
}

/// In which who starts so far ahead is through and a metre on.
int frames_to_pass(double ahead, double speed) {
  return static_cast<int>(std::ceil((ahead + 1) / speed * kFrameRate)) + 1;
}

BodyDesc thin_wall(double restitution) { return segment({0, -60000}, {0, 60000}, material(restitution)); }

}  // namespace

// ---- speed ------------------------------------------------------------------------------------

int lone_discs_through_a_wall(double speed, double angle, double restitution, const Start& start) {
  const Vec2 way = {std::cos(angle), std::sin(angle)};
  int through = 0;
  for (int k = 0; k < 200; ++k) {
    const double ahead = 1 + speed / 60 * (1.0 + 0.01 * k);  // a frame or two before the wall
    Scene scene = open_scene(kVast, {0, 0});
    scene.bodies = {thin_wall(restitution),
                    small_disc({-ahead * way.x, -ahead * way.y}, {speed * way.x, speed * way.y}, restitution)};
    Trial trial(scene, start);
    trial.frames(frames_to_pass(ahead, speed));
    through += trial.body(1).x > 0 ? 1 : 0;
  }
  return through;
}

int discs_through_a_wall(double speed, double restitution, const Start& start) {
  Scene scene = open_scene(kVast, {0, 0});
  scene.bodies.push_back(thin_wall(restitution));
  for (int k = 0; k < 200; ++k) {
    scene.bodies.push_back(
        small_disc({-5 - 0.13 * k, -100.0 + k}, {speed * std::cos(0.15 * (k % 10)), 0}, restitution));
  }
  Trial trial(scene, start);
  std::set<std::size_t> through;
  const int frames = std::max(30, frames_to_pass(40, speed));
  for (int frame = 0; frame < frames; ++frame) {
    trial.frame();
    for (std::size_t k = 1; k <= 200; ++k) {
      if (trial.body(k).x > 0) through.insert(k);
    }
  }
  return static_cast<int>(through.size());
}

int bullets_through_each_other(double speed, double restitution, const Start& start) {
  int passed = 0;
  for (int k = 0; k < 50; ++k) {
    const double ahead = 1 + speed / 60 * (1.0 + 0.02 * k);
    Scene scene = open_scene(kVast, {0, 0});
    scene.bodies = {small_disc({-ahead, 0}, {speed, 0}, restitution), small_disc({ahead, 0}, {-speed, 0}, restitution)};
    Trial trial(scene, start);
    trial.frames(frames_to_pass(ahead, speed));
    passed += trial.body(0).x > trial.body(1).x ? 1 : 0;
  }
  return passed;
}

namespace {

/// Two discs without restitution that come at each other, `offset` diameters apart across; the
/// largest of `measure` over 50 places within a frame.
template <class Measure>
double worst_meeting(double reach, double offset, const Start& start, Measure measure) {
  const double speed = reach * 2 * kSmall / kSubstep / 2;  // of each
  double worst = 0;
  for (int k = 0; k < 50; ++k) {
    const double ahead = 1 + speed / 60 * (1.0 + 0.02 * k);
    Scene scene = open_scene(kVast, {0, 0});
    scene.bodies = {small_disc({-ahead, 0}, {speed, 0}, 0), small_disc({ahead, 2 * kSmall * offset}, {-speed, 0}, 0)};
    Trial trial(scene, start);
    const double before = kinetic_energy(trial.run());
    trial.frames(frames_to_pass(ahead, speed));
    worst = std::max(worst, measure(trial, before, speed));
  }
  return worst;
}

}  // namespace

double energy_of_inelastic_pair(double reach, const Start& start) {
  double worst = 0;
  for (const double offset : {0.1, 0.5, 0.9}) {
    worst = std::max(worst, worst_meeting(reach, offset, start, [](Trial& trial, double before, double /*speed*/) {
                       return kinetic_energy(trial.run()) / before;
                     }));
  }
  return worst;
}

double deflection_at_a_miss(double reach, double distance, const Start& start) {
  return worst_meeting(reach, distance, start, [](Trial& trial, double /*before*/, double speed) {
    return std::hypot(trial.body(0).vx - speed, trial.body(0).vy) / speed;
  });
}

// ---- far away, denormals ----------------------------------------------------------------------

namespace {

/// 100 rough discs that fall on ground, in a world of 64 m about (x, 0).
Scene landing_at(double x) {
  const Material rough = material(0.2, 0.3);
  Scene scene = open_scene(64);
  scene.world.bounds.xmin += x;
  scene.world.bounds.xmax += x;
  scene.bodies.push_back(segment({-60, 0}, {60, 0}, rough));
  scene.bodies.back().position.x = x;
  for (int k = 0; k < 100; ++k) {
    const double left = x + (k % 10) * 1.0625 + 0.015625 * (k / 10);
    scene.bodies.push_back(disc({left, 0.625 + (k / 10) * 1.0625}, {0.25 * (k % 7), 0}, rough));
  }
  return scene;
}

/// 60 x 60 touching discs at velocities and gravity of this size.
Scene touching_discs(double size) {
  Scene scene = open_scene(1024, {0, -kGravity * size});
  for (int j = 0; j < 60; ++j) {
    for (int i = 0; i < 60; ++i) {
      const Vec2 v = {((i * 7 + j * 13) % 11 - 5) * 0.1 * size, ((i * 5 + j * 3) % 7 - 3) * 0.1 * size};
      scene.bodies.push_back(disc({1.0 * i, 1.0 * j}, v, material(0.5, 0.5)));
    }
  }
  return scene;
}

/// Of one frame.
double seconds_of_a_frame(Trial& trial) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  trial.frame();
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

double difference_at(double x, const Start& start) {
  Trial here(landing_at(0), start), there(landing_at(x), start);
  here.frames(300);
  there.frames(300);
  const double grain = std::abs(x) * 0x1p-52;  // of a double at x
  double worst = 0;
  for (std::size_t k = 0; k < here.bodies().size(); ++k) {
    const BodyState &s = here.body(k), &t = there.body(k);
    const double place = std::max(std::abs(t.x - (s.x + x)) - grain, 0.0);
    worst = std::max(
        {worst, place, std::abs(t.y - s.y), std::abs(t.vx - s.vx), std::abs(t.vy - s.vy), std::abs(t.omega - s.omega)});
  }
  return worst;
}

// Frames in turn, and the median of the ratios: the clock of a processor may change by half from second to second.
double denormal_slowdown(const Start& start) {
  Trial least(touching_discs(1e-38), start), common(touching_discs(1e-6), start);
  least.frames(5);
  common.frames(5);
  std::vector<double> ratios;
  for (int k = 0; k < 81; ++k) {
    const double of_least = seconds_of_a_frame(least);
    ratios.push_back(of_least / seconds_of_a_frame(common));
  }
  std::ranges::nth_element(ratios, ratios.begin() + 40);
  return ratios[40];
}

// ---- long runs --------------------------------------------------------------------------------

namespace {

/// `measure` after every frame.
template <class Measure>
Drift watch(Trial& trial, int frames, Measure measure) {
  Drift drift;
  double first = 0, last = 0;
  const int tenth = std::max(frames / 10, 1);
  for (int k = 0; k < frames; ++k) {
    trial.frame();
    const double value = measure();
    drift.largest = std::max(drift.largest, std::abs(value));
    if (k < tenth) first += value / tenth;
    if (k >= frames - tenth) last += value / tenth;
  }
  drift.change = last - first;
  return drift;
}

Drift watch_energy(Trial& trial, int frames) {
  const double start = energy(trial.run());
  return watch(trial, frames, [&] { return energy(trial.run()) / start - 1; });
}

const reference::Orbit kOrbit;

Scene orbit() {
  const auto v = kOrbit.start_velocity();
  Scene scene = open_scene(128, {0, 0});
  scene.world.fields.push_back(WellField{{0, 0}, kOrbit.gm, 0, 2, 0});
  scene.bodies = {disc({kOrbit.start().x, 0}, {v.x, v.y}, material(0), 0.01)};
  return scene;
}

Scene bounce() {
  Scene scene = open_scene(1024);
  scene.bodies = {ground(material(1), 1000), disc({0, 1.5}, {}, material(1))};
  return scene;
}

Scene gas(int columns, double cell) {
  Scene scene = periodic_scene(columns * cell, columns * cell);
  for (int k = 0; k < columns * columns; ++k) {
    scene.bodies.push_back(
        disc({cell * (0.5 + k % columns) + 0.1 * ((k * 7) % 5), cell * (0.5 + k / columns) + 0.1 * ((k * 3) % 7)},
             {0.3 * ((k * 37) % 21 - 10), 0.33 * ((k * 53) % 19 - 9)}, material(1)));
  }
  return scene;
}

}  // namespace

Drift kepler_energy(int frames, const Start& start) {
  Trial trial(orbit(), start);
  return watch(trial, frames, [&] {
    const BodyState& s = trial.body(0);
    return kOrbit.energy_of({s.x, s.y}, {s.vx, s.vy}) / kOrbit.energy() - 1;
  });
}

Drift bounce_energy(int frames, const Start& start) {
  Trial trial(bounce(), start);
  return watch_energy(trial, frames);
}

Drift gas_energy(int frames, const Start& start) {
  Trial trial(gas(8, 2), start);
  return watch_energy(trial, frames);
}

Drift stack_place(double friction, int frames, const Start& start) {
  constexpr std::size_t kTop = 10;
  Scene scene = open_scene(1024);
  for (std::size_t k = 0; k <= kTop; ++k) {
    scene.bodies.push_back(disc({0, static_cast<double>(k)}, {}, material(0, friction)));
  }
  scene.bodies.front().type = BodyType::static_body;
  Trial trial(scene, start);
  trial.frames(600);
  const BodyState rest = trial.body(kTop);
  return watch(trial, frames, [&] { return std::hypot(trial.body(kTop).x - rest.x, trial.body(kTop).y - rest.y); });
}

// ---- smooth ground ----------------------------------------------------------------------------

Glide glide(double speed, double friction, const Start& start) {
  const Material m = material(0, friction);
  Scene scene = open_scene(1024);
  scene.bodies.push_back(disc({0, kRadius}, {speed, 0}, m));
  if (friction > 0) scene.bodies.back().angular_velocity = -speed / kRadius;
  for (int k = -5; k < 1000; ++k) {
    scene.bodies.push_back(segment({1.0 * k, 0}, {k + 1.0, 0}, m));
  }
  Trial trial(scene, start);
  trial.frames(60);
  const double level = trial.body(0).y;
  const int frames = static_cast<int>(900 / speed * 60);
  Glide glide;
  for (int k = 0; k < frames; ++k) {
    trial.frame();
    glide.bump = std::max(glide.bump, std::abs(trial.body(0).y - level));
  }
  glide.speed_lost = 1 - trial.body(0).vx / speed;
  return glide;
}

// ---- time reversed ----------------------------------------------------------------------------

namespace {

/// `period` is the side of a periodic world, 0 elsewhere.
double return_error(const Scene& scene, const Start& start, int frames, double period = 0) {
  Trial trial(scene, start);
  const std::vector<BodyState> from = trial.bodies();
  trial.frames(frames);
  for (std::size_t k = 0; k < from.size(); ++k) {
    const BodyState& b = trial.body(k);
    if (b.type != BodyType::dynamic_body) continue;
    trial.run().simulation().set_velocity(k, {-b.vx, -b.vy}, -b.omega);
  }
  trial.frames(frames);
  const auto off = [period](double d) { return period > 0 ? std::remainder(d, period) : d; };
  double worst = 0;
  for (std::size_t k = 0; k < from.size(); ++k) {
    worst = std::max(worst, std::hypot(off(trial.body(k).x - from[k].x), off(trial.body(k).y - from[k].y)));
  }
  return worst;
}

}  // namespace

double orbit_return(int frames, const Start& start) { return return_error(orbit(), start, frames); }

double bounce_return(int frames, const Start& start) { return return_error(bounce(), start, frames); }

double gas_return(int frames, const Start& start) { return return_error(gas(10, 2.8), start, frames, 28); }

}  // namespace psim::accuracy::stress
