// Speed, far places, denormals, long runs, smooth ground and time reversed.
#include <chrono>
#include <cstdint>
#include <set>
#include <utility>

#include "closed_forms.h"
#include "stress.h"
#include "stress_world.h"

namespace psim::accuracy::stress {
namespace {

constexpr double kSmall = 0.1;    // m, radius of what is shot
constexpr double kVast = 0x1p17;  // m, half a world that nothing leaves at 1e5 m/s in a second
constexpr double kSubstep = 1.0 / 240;

}  // namespace

// ---- speed ------------------------------------------------------------------------------------

int lone_discs_through_a_wall(double speed, double angle, double restitution) {
  int through = 0;
  for (int k = 0; k < 200; ++k) {
    const auto world = make(open_world(kVast, {0, 0}));
    add(*world, segment({0, -60000}, {0, 60000}, {1, restitution, 0}));
    const Vec2 velocity = {speed * std::cos(angle), speed * std::sin(angle)};
    const double ahead = 1 + speed / 60 * (1.0 + 0.01 * k);  // a frame or two before the wall
    const BodyId id = add(*world, disc({-ahead * std::cos(angle), -ahead * std::sin(angle)},
                                       velocity, kSmall, {1, restitution, 0}));
    run(*world, 10);
    through += state(*world, id).x > 0 ? 1 : 0;
  }
  return through;
}

int discs_through_a_wall(double speed, double restitution) {
  const auto world = make(open_world(kVast, {0, 0}));
  add(*world, segment({0, -60000}, {0, 60000}, {1, restitution, 0}));
  for (int k = 0; k < 200; ++k) {
    add(*world, disc({-5 - 0.13 * k, -100.0 + k}, {speed * std::cos(0.15 * (k % 10)), 0}, kSmall,
                     {1, restitution, 0}));
  }
  std::set<std::uint32_t> through;
  for (int frame = 0; frame < 30; ++frame) {
    world->step();
    const PublishedState s = world->published();
    for (std::size_t k = 1; k < s.id.size(); ++k) {
      if (s.x[k] > 0) through.insert(s.id[k]);
    }
  }
  return static_cast<int>(through.size());
}

int bullets_through_each_other(double speed, double restitution) {
  int passed = 0;
  for (int k = 0; k < 50; ++k) {
    const auto world = make(open_world(kVast, {0, 0}));
    const double ahead = 1 + speed / 60 * (1.0 + 0.02 * k);
    const BodyId left = add(*world, disc({-ahead, 0}, {speed, 0}, kSmall, {1, restitution, 0}));
    const BodyId right = add(*world, disc({ahead, 0}, {-speed, 0}, kSmall, {1, restitution, 0}));
    run(*world, 10);
    passed += state(*world, left).x > state(*world, right).x ? 1 : 0;
  }
  return passed;
}

double energy_of_inelastic_pair(double reach) {
  const double speed = reach * 2 * kSmall / kSubstep / 2;  // of each
  double worst = 0;
  for (const double offset : {0.1, 0.5, 0.9}) {
    for (int k = 0; k < 50; ++k) {
      const auto world = make(open_world(kVast, {0, 0}));
      const double ahead = 1 + speed / 60 * (1.0 + 0.02 * k);
      add(*world, disc({-ahead, 0}, {speed, 0}, kSmall));
      add(*world, disc({ahead, 2 * kSmall * offset}, {-speed, 0}, kSmall));
      const double before = world->diagnostics().kinetic;
      run(*world, 10);
      worst = std::max(worst, world->diagnostics().kinetic / before);
    }
  }
  return worst;
}

double first_gaining_reach() {
  double reach = 0.1;
  while (reach < 100 && energy_of_inelastic_pair(reach) < 1.01) reach *= 1.1;
  return reach;
}

// ---- far away, denormals ----------------------------------------------------------------------

namespace {

/// 100 rough discs that fall on ground, in a world of 64 m about (x, 0).
std::unique_ptr<World> landing_at(double x) {
  WorldDesc desc = open_world(64);
  desc.bounds.xmin += x;
  desc.bounds.xmax += x;
  const auto material = Material{1, 0.2, 0.3};
  auto world = make(desc);
  BodyDesc floor = segment({-60, 0}, {60, 0}, material);
  floor.position.x = x;
  add(*world, floor);
  Discs discs;
  for (int k = 0; k < 100; ++k) {
    discs.push(x + (k % 10) * 1.0625 + 0.015625 * (k / 10), 0.625 + (k / 10) * 1.0625,
               0.25 * (k % 7));
  }
  add(*world, discs, 0.5, material);
  return world;
}

/// 60 x 60 touching discs at velocities and gravity of this size.
double seconds_a_step(double size) {
  using Clock = std::chrono::steady_clock;
  const auto world = make(open_world(1024, {0, -kG * size}));
  Discs discs;
  for (int j = 0; j < 60; ++j) {
    for (int i = 0; i < 60; ++i) {
      discs.push(i, j, ((i * 7 + j * 13) % 11 - 5) * 0.1 * size,
                 ((i * 5 + j * 3) % 7 - 3) * 0.1 * size);
    }
  }
  add(*world, discs, 0.5, {1, 0.5, 0.5});
  run(*world, 5);
  double best = 1e9;
  for (int k = 0; k < 40; ++k) {
    const Clock::time_point begin = Clock::now();
    world->step();
    best = std::min(best, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return best;
}

}  // namespace

double difference_at(double x) {
  const auto here = landing_at(0), there = landing_at(x);
  run(*here, 300);
  run(*there, 300);
  const PublishedState s = here->published(), t = there->published();
  const double grain = std::abs(x) * 0x1p-52;  // of a double at x
  double worst = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    const double place = std::max(std::abs(t.x[k] - (s.x[k] + x)) - grain, 0.0);
    worst = std::max({worst, place, std::abs(t.y[k] - s.y[k]), std::abs(t.vx[k] - s.vx[k]),
                      std::abs(t.vy[k] - s.vy[k]), std::abs(t.omega[k] - s.omega[k])});
  }
  return worst;
}

double denormal_slowdown() { return seconds_a_step(1e-38) / seconds_a_step(1e-6); }

// ---- long runs --------------------------------------------------------------------------------

namespace {

/// Steps the world; `measure` after every frame.
template <class Measure>
Drift watch(World& world, int frames, Measure measure) {
  Drift drift;
  double first = 0, last = 0;
  const int tenth = std::max(frames / 10, 1);
  for (int k = 0; k < frames; ++k) {
    world.step();
    const double value = measure();
    drift.largest = std::max(drift.largest, std::abs(value));
    if (k < tenth) first += value / tenth;
    if (k >= frames - tenth) last += value / tenth;
  }
  drift.change = last - first;
  return drift;
}

const reference::Orbit kOrbit;

std::unique_ptr<World> orbit_world(int substeps, BodyId& id) {
  WorldDesc desc = open_world(128, {0, 0});
  desc.substeps = substeps;
  desc.fields.push_back(WellField{{0, 0}, kOrbit.gm, 0, 2, 0});
  auto world = make(desc);
  const auto v = kOrbit.start_velocity();
  id = add(*world, disc({kOrbit.start().x, 0}, {v.x, v.y}, 0.01));
  return world;
}

std::unique_ptr<World> bounce_world(BodyId& id) {
  auto world = make(open_world());
  add(*world, ground({1, 1, 0}));
  id = add(*world, disc({0, 1.5}, {}, 0.5, {1, 1, 0}));
  return world;
}

std::unique_ptr<World> gas_world(int columns, double cell) {
  WorldDesc desc;
  desc.bounds = {0, 0, columns * cell, columns * cell};
  desc.boundary = Boundary::periodic;
  desc.gravity = {0, 0};
  auto world = make(desc);
  Discs discs;
  for (int k = 0; k < columns * columns; ++k) {
    discs.push(cell * (0.5 + k % columns) + 0.1 * ((k * 7) % 5),
               cell * (0.5 + k / columns) + 0.1 * ((k * 3) % 7), 0.3 * ((k * 37) % 21 - 10),
               0.33 * ((k * 53) % 19 - 9));
  }
  add(*world, discs, 0.5, {1, 1, 0});
  return world;
}

}  // namespace

Drift kepler_energy(int substeps_a_frame, int steps) {
  BodyId id;
  const auto world = orbit_world(substeps_a_frame, id);
  return watch(*world, steps / substeps_a_frame, [&] {
    const BodyState s = state(*world, id);
    return kOrbit.energy_of({s.x, s.y}, {s.vx, s.vy}) / kOrbit.energy() - 1;
  });
}

Drift bounce_energy(int frames) {
  BodyId id;
  const auto world = bounce_world(id);
  const double start = energy(*world);
  return watch(*world, frames, [&] { return energy(*world) / start - 1; });
}

Drift gas_energy(int frames) {
  const auto world = gas_world(8, 2);
  const double start = energy(*world);
  return watch(*world, frames, [&] { return energy(*world) / start - 1; });
}

Drift stack_place(double friction, int frames) {
  const auto world = make(open_world());
  BodyDesc foot = disc({0, 0}, {}, 0.5, {1, 0, friction});
  foot.type = BodyType::static_body;
  add(*world, foot);
  BodyId top;
  for (int k = 1; k <= 10; ++k) top = add(*world, disc({0, 1.0 * k}, {}, 0.5, {1, 0, friction}));
  run(*world, 600);
  const BodyState rest = state(*world, top);
  return watch(*world, frames, [&] {
    const BodyState s = state(*world, top);
    return std::hypot(s.x - rest.x, s.y - rest.y);
  });
}

// ---- smooth ground ----------------------------------------------------------------------------

Glide glide(double speed, double friction) {
  const Material m = {1, 0, friction};
  const auto world = make(open_world());
  for (int k = -5; k < 1000; ++k) add(*world, segment({1.0 * k, 0}, {k + 1.0, 0}, m));
  BodyDesc body = disc({0, 0.5}, {speed, 0}, 0.5, m);
  if (friction > 0) body.angular_velocity = -speed / 0.5;
  const BodyId id = add(*world, body);
  run(*world, 60);
  const double level = state(*world, id).y;
  Glide glide;
  while (state(*world, id).x < 990) {
    world->step();
    glide.bump = std::max(glide.bump, std::abs(state(*world, id).y - level));
  }
  glide.speed_lost = 1 - state(*world, id).vx / speed;
  return glide;
}

// ---- time reversed ----------------------------------------------------------------------------

namespace {

using Places = std::vector<std::pair<double, double>>;

Places places(World& world) {
  const PublishedState s = world.published();
  Places all;
  for (std::size_t k = 0; k < s.id.size(); ++k) all.emplace_back(s.x[k], s.y[k]);
  return all;
}

void reverse(World& world) {
  const PublishedState s = world.published();
  std::vector<BodyState> moving;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (s.type[k] == BodyType::dynamic_body) moving.push_back(state(world, world.id_of(s.id[k])));
  }
  for (const BodyState& b : moving) world.set_velocity(b.id, {-b.vx, -b.vy}, -b.omega);
}

/// `period` is the side of a periodic world, 0 elsewhere.
double return_error(World& world, int frames, double period = 0) {
  const Places start = places(world);
  run(world, frames);
  reverse(world);
  run(world, frames);
  const Places end = places(world);
  const auto off = [period](double d) { return period > 0 ? std::remainder(d, period) : d; };
  double worst = 0;
  for (std::size_t k = 0; k < start.size(); ++k) {
    worst = std::max(worst, std::hypot(off(end[k].first - start[k].first),
                                       off(end[k].second - start[k].second)));
  }
  return worst;
}

}  // namespace

double orbit_return(int substeps, int frames) {
  BodyId id;
  const auto world = orbit_world(substeps, id);
  return return_error(*world, frames);
}

double bounce_return(int frames) {
  BodyId id;
  const auto world = bounce_world(id);
  return return_error(*world, frames);
}

double gas_return(int frames) {
  const auto world = gas_world(10, 2.8);
  return return_error(*world, frames, 28);
}

}  // namespace psim::accuracy::stress
