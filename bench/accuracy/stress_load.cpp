// Step lengths, mass ratios, overlaps and crowds: what the contact solver is asked to carry.
#include <array>
#include <cstdint>

#include "stress.h"
#include "stress_world.h"

namespace psim::accuracy::stress {
namespace {

constexpr double kDiameter = 1, kRadius = 0.5;

constexpr int kColumns = 15;

std::unique_ptr<World> bin(double dt, Material m) {
  WorldDesc desc;
  const double width = kColumns * 1.02 + 1;
  desc.bounds = {0, 0, width, 4 * width};
  desc.boundary = Boundary::walls;
  desc.wall = m;
  desc.dt = dt;
  auto world = make(desc);
  Discs discs;
  for (int j = 0; j < kColumns; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      discs.push(1 + 1.02 * i + 0.007 * ((i * 7 + j * 13) % 3), 0.51 + 1.02 * j);
    }
  }
  add(*world, discs, kRadius, m);
  return world;
}

bool all_inside(World& world) {
  const Bounds b = world.desc().bounds;
  const PublishedState s = world.published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    if (!(s.x[k] >= b.xmin && s.x[k] <= b.xmax && s.y[k] >= b.ymin && s.y[k] <= b.ymax))
      return false;
  }
  return true;
}

/// Steps for 20 s, at least 20 times; `step_of(k)` is the length of step k.
template <class StepOf>
Landing watch_landing(World& world, StepOf step_of) {
  Landing landing;
  const double start = energy(world);
  double time = 0;
  for (int k = 0; time < 20 || k < 20; ++k) {
    const double dt = step_of(k);
    world.step(dt);
    time += dt;
    landing.energy_gain = std::max(landing.energy_gain, energy(world) / start - 1);
  }
  landing.whole = all_finite(world) && all_inside(world);
  landing.speed = rms_speed(world);
  landing.overlap = world.diagnostics().max_penetration / kDiameter;
  return landing;
}

}  // namespace

bool Landing::stable() const {
  return whole && energy_gain < 1e-6 && speed < 1e-3 && overlap < 0.1;
}

Landing land(double dt, double restitution, double friction) {
  const auto world = bin(dt, {1, restitution, friction});
  return watch_landing(*world, [dt](int) { return dt; });
}

Landing land_at_random_steps(double shortest, double longest) {
  const auto world = bin(1.0 / 60, {1, 0.3, 0.5});
  std::uint64_t bits = 1;
  return watch_landing(*world, [=](int) mutable {
    bits = bits * 6364136223846793005u + 1442695040888963407u;
    return shortest + (longest - shortest) * static_cast<double>(bits >> 11) * 0x1p-53;
  });
}

double largest_stable_step() {
  constexpr std::array<double, 12> kPerSecond = {240, 120, 60, 45, 30, 25, 20, 15, 10, 5, 2, 1};
  double largest = 0;
  for (const double per_second : kPerSecond) {
    const double dt = 1 / per_second;
    if (!land(dt, 0, 0).stable() || !land(dt, 0.3, 0.5).stable()) break;
    largest = dt;
  }
  return largest;
}

double speed_after_a_short_step(double short_step) {
  const auto world = bin(1.0 / 60, {1, 0.3, 0.5});
  run(*world, 1200);
  world->step(short_step);
  double speed = 0;
  for (int k = 0; k < 60; ++k) {
    world->step();
    speed = std::max(speed, fastest(*world));
  }
  return speed;
}

// ---- mass ratios ------------------------------------------------------------------------------

Load heavy_on_light(double ratio) {
  const auto world = make(open_world());
  add(*world, ground());
  BodyDesc light = disc({0, kRadius});
  light.mass = 1;
  light.fixed_rotation = true;
  BodyDesc heavy = light;
  heavy.position.y = 3 * kRadius;
  heavy.mass = ratio;
  const BodyId lower = add(*world, light), upper = add(*world, heavy);
  run(*world, 600);
  const BodyState l = state(*world, lower), u = state(*world, upper);
  const double below = kRadius - l.y, above = kDiameter - std::hypot(u.x - l.x, u.y - l.y);
  return {std::max(below, above) / kRadius, fastest(*world)};
}

double first_sinking_ratio(double overlap) {
  double ratio = 1e-6;
  while (ratio < 1e7 && heavy_on_light(ratio).overlap <= overlap) ratio *= 1.1;
  return ratio;
}

double elastic_pair_error(double ratio) {
  constexpr double kSpeed = 7;
  double worst = 0;
  for (int k = 0; k < 20; ++k) {
    const auto world = make(open_world(1024, {0, 0}));
    const double offset = 0.049 * k, along = std::sqrt(1 - offset * offset);
    BodyDesc comer = disc({-3.03 - along, offset}, {kSpeed, 0}, kRadius, {1, 1, 0});
    BodyDesc target = disc({0, 0}, {0, 0}, kRadius, {1, 1, 0});
    comer.mass = 1;
    target.mass = ratio;
    const BodyId a = add(*world, comer), b = add(*world, target);
    run(*world, 60);
    const Vec2 n = {along, -offset};  // from the comer to the target, at the impact
    const double impulse = 2 * kSpeed * along * ratio / (1 + ratio);
    const BodyState p = state(*world, a), q = state(*world, b);
    worst = std::max({worst, std::hypot(p.vx - kSpeed + impulse * n.x, p.vy + impulse * n.y),
                      std::hypot(q.vx - impulse / ratio * n.x, q.vy - impulse / ratio * n.y)});
  }
  return worst / kSpeed;
}

double gravel_speed() {
  const auto world = make(open_world());
  add(*world, ground());
  Discs stones;
  for (int k = 0; k < 60; ++k) stones.push(-3 + 0.1 * k, 0.05);
  add(*world, stones, 0.05);
  add(*world, disc({0, 20.6}, {}, 20));
  double speed = 0;
  for (int k = 0; k < 600; ++k) {
    world->step();
    const PublishedState s = world->published();
    for (std::size_t stone = 1; stone <= 60; ++stone) {
      speed = std::max(speed, std::hypot(s.vx[stone], s.vy[stone]));
    }
  }
  return speed;
}

// ---- overlaps ---------------------------------------------------------------------------------

double speed_from_overlap(double overlap, double restitution, double mass_ratio) {
  const auto world = make(open_world(1024, {0, 0}));
  BodyDesc a = disc({0, 0}, {}, kRadius, {1, restitution, 0});
  BodyDesc b = a;
  b.position.x = kDiameter * (1 - overlap);
  a.mass = 1;
  b.mass = mass_ratio;
  add(*world, a);
  add(*world, b);
  double speed = 0;
  for (int k = 0; k < 300; ++k) {
    world->step();
    speed = std::max(speed, fastest(*world));
  }
  return speed;
}

double speed_from_overlapping_block(double overlap, double restitution) {
  const auto world = make(open_world(1024, {0, 0}));
  Discs discs;
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 12; ++i) {
      discs.push(i * kDiameter * (1 - overlap), j * kDiameter * (1 - overlap));
    }
  }
  add(*world, discs, kRadius, {1, restitution, 0});
  double speed = 0;
  for (int k = 0; k < 300; ++k) {
    world->step();
    speed = std::max(speed, fastest(*world));
  }
  return speed;
}

double jump_from_the_ground(double overlap) {
  const auto world = make(open_world());
  add(*world, ground());
  const BodyId id = add(*world, disc({0, kRadius * (1 - overlap)}));
  double height = 0;
  for (int k = 0; k < 300; ++k) {
    world->step();
    height = std::max(height, state(*world, id).y - kRadius);
  }
  return height;
}

OnePoint one_point(int discs) {
  const auto world = make(open_world(1024, {0, 0}));
  Discs all;
  for (int k = 0; k < discs; ++k) all.push(3.25, -1.5);
  add(*world, all, kRadius);
  run(*world, 120);
  OnePoint out;
  out.finite = all_finite(*world);
  out.speed = fastest(*world);
  const PublishedState s = world->published();
  double x = 0, y = 0, sum = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    x += s.vx[k];
    y += s.vy[k];
    sum += std::hypot(s.vx[k], s.vy[k]);
  }
  out.momentum = sum > 0 ? std::hypot(x, y) / sum : 0;
  return out;
}

// ---- crowds -----------------------------------------------------------------------------------

Crowd ring_on_a_big_disc() {
  constexpr double kBig = 20, kSmall = 0.1;
  WorldDesc desc = open_world(64, {0, 0});
  desc.fields.push_back(
      WellField{{0, 0}, kG, 1, 0, 0});  // a pull of g everywhere but at the centre
  const auto world = make(desc);
  add(*world, disc({0, 0}, {}, kBig));
  Discs ring;
  for (int k = 0; k < 600; ++k) {
    const double angle = 2 * std::numbers::pi * k / 600;
    ring.push((kBig + 0.2) * std::cos(angle), (kBig + 0.2) * std::sin(angle));
  }
  add(*world, ring, kSmall);
  run(*world, 600);
  return {all_finite(*world), world->diagnostics().max_penetration, fastest(*world)};
}

Crowd discs_on_a_plate() {
  const auto world = make(open_world());
  add(*world, segment({-0.01, 0}, {200.5, 0}));
  add(*world, segment({-0.01, 0}, {-0.01, 60}));
  add(*world, segment({200.5, 0}, {200.5, 60}));
  Discs discs;
  for (int j = 0; j < 50; ++j) {
    for (int i = 0; i < 200; ++i) {
      discs.push(0.5 + 1.002 * i + 0.001 * ((i * 7 + j * 13) % 2), 0.5 + 1.001 * j);
    }
  }
  add(*world, discs, kRadius);
  run(*world, 1200);
  return {all_finite(*world), world->diagnostics().max_penetration, fastest(*world)};
}

}  // namespace psim::accuracy::stress
