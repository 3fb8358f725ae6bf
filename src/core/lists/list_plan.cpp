// How new neighbour lists are made: for how long and with which margins, from a sample of the bodies' speeds. Each
// choice is by predicted cost; docs/step.md describes it.
#include "lists/list_plan.h"

#include <algorithm>
#include <cmath>

#include "bodies/body_store.h"

namespace psim {

namespace {

// Margin around bodies in the lists, as a share of the radius: a tenth suits piles (docs/performance.md).
constexpr double kSkinOfRadius = 0.1;
// A body is at rest if it goes less than kAtRest of the skin in a frame. Where no more than kFewMoving of all bodies
// are faster, lists have room for kRestFrames frames.
constexpr double kAtRest = 0.02, kFewMoving = 1.0 / 32, kRestFrames = 8;

// Radii and velocities of some 2,000 bodies, chosen by slot. Bodies that are gone do not count.
struct Sample {
  double radius = 0;                    // mean, m
  double mean_x = 0, mean_y = 0;        // m/s
  double square = 0;                    // mean |v|^2
  double fastest = 0, fastest_off = 0;  // largest |v| and |v - mean|, m/s
  double off() const { return std::sqrt(std::fmax(square - mean_x * mean_x - mean_y * mean_y, 0)); }
};

Sample sample_bodies(const BodyStore& b, double least_radius) {
  const std::uint32_t stride = std::max(1u, b.count / 2048);
  Sample s;
  double n = 0;
  const auto velocity = [&](std::uint32_t i) {
    return Vec2{static_cast<double>(b.vel[2 * std::size_t{i}]), static_cast<double>(b.vel[2 * std::size_t{i} + 1])};
  };
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    n += 1;
    const Vec2 v = velocity(i);
    s.square += v.x * v.x + v.y * v.y;
    s.mean_x += v.x;
    s.mean_y += v.y;
    s.radius += static_cast<double>(b.radius[i]);
    s.fastest = std::fmax(s.fastest, std::sqrt(v.x * v.x + v.y * v.y));
  }
  if (n == 0) {  // every body that was looked at is gone: as if all were at rest
    s.radius = least_radius;
    return s;
  }
  s.square /= n;
  s.mean_x /= n;
  s.mean_y /= n;
  s.radius /= n;
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = velocity(i);
    const double x = v.x - s.mean_x, y = v.y - s.mean_y;
    s.fastest_off = std::fmax(s.fastest_off, std::sqrt(x * x + y * y));
  }
  return s;
}

// The share of the sampled bodies that are faster than `speed`, m/s.
double share_above(const BodyStore& b, double speed) {
  const std::uint32_t stride = std::max(1u, b.count / 2048);
  double above = 0, n = 0;
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const auto x = static_cast<double>(b.vel[2 * std::size_t{i}]),
               y = static_cast<double>(b.vel[2 * std::size_t{i} + 1]);
    n += 1;
    above += !(x * x + y * y <= speed * speed);
  }
  return above / std::fmax(n, 1);
}

// The plan for bodies that fly: margins for several frames, of which each step selects the pairs that can meet; or,
// where those margins would soon be used up, lists for this step alone. The choice is by cost: to build lists takes
// kBuild for each body and kTest for each body that it is looked at with, to select takes kSelect for each candidate.
// Both counts follow from the number density.
void plan_flight(const BodyStore& bodies, const ListSettings& world, const Sample& s, double dt, ListPlan& out) {
  constexpr double kBuild = 25, kTest = 0.25, kSelect = 5;  // ns, measured (docs/performance.md)
  const WorldDesc& desc = *world.desc;
  const double r = s.radius;
  const double frame = kMarginFrames * dt * std::sqrt(s.square);  // m a frame, with reserve
  const double area =
      world.broad->cells().area_about(r, (desc.bounds.xmax - desc.bounds.xmin) * (desc.bounds.ymax - desc.bounds.ymin));
  // Where bodies lie in heaps their number in the box says little: the last grid says more.
  const double density = std::fmax(bodies.count / area, world.broad->cells().density());
  // Without restitution impacts only slow bodies down.
  if (world.restitution) {
    out.crowding = std::clamp(3 * bodies.count / area * 3.14159 * r * r, 0.1, 1.0);
  }
  out.mode = ListMode::one_step;
  // Candidates of a body up to `outer` away: hard discs leave a distance of 2 r around it empty, but where they are
  // packed every other body is a candidate.
  const auto pairs = [&](double outer) {
    return std::fmax(1.5708 * density * (outer * outer - 4 * r * r), 1.5708 * density * outer * outer - 0.5);
  };
  const auto build = [&](double reach) {
    const double edge = std::fmax(2 * reach, std::sqrt(0.7 * area / bodies.count));
    return kBuild + kTest * 4.5 * density * edge * edge;
  };
  const double half = kMarginFrames * dt / 2;
  const double skin = 0.505 * impact_slack(world, out.speed, out.crowding, dt);
  // The last choice is kept if it is nearly as good: every change needs arrays of another size.
  const auto favour = [&](double frames) { return world.selected && frames == world.frames ? 0.97 : 1.0; };
  out.outer = 2 * (r + skin + 1.2 * half * out.speed);
  double best = favour(0) * (build(r + skin + half * s.fastest_off) + kSelect * pairs(out.outer));
  out.margin = {static_cast<float>(skin), static_cast<float>(half), static_cast<float>(s.mean_x),
                static_cast<float>(s.mean_y)};
  out.ahead = static_cast<float>(half);
  for (const double k : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0}) {
    const double reach = r + k * (1.2 * frame + 0.3 * kMarginFrames * dt * s.fastest);
    const double cost = favour(k) * (build(reach) / k + kSelect * pairs(2 * r + 3 * k * frame));
    if (!(cost < best)) continue;
    best = cost;
    const double room = std::fmax(desc.skin * k, 1);  // frames; a step needs one
    out.outer = 2 * r + 3 * room * frame;
    out.margin = {static_cast<float>(0.02 * r + room * 1.2 * frame),
                  static_cast<float>(room * kMarginFrames * dt * 0.3), 0, 0};
    out.mode = ListMode::selected_each_step;
    out.ahead = 0;
    out.frames = k;
  }
}

}  // namespace

double impact_slack(const ListSettings& world, double speed, double close, double dt) {
  const double g = length_of(world.desc->gravity);
  return 0.02 * static_cast<double>(world.least_radius) + g * dt * dt + (world.uneven ? 1.0 : close) * speed * dt;
}

ListPlan plan_lists(const BodyStore& bodies, const ListSettings& world, double dt) {
  const WorldDesc& desc = *world.desc;
  const BroadCells& cells = world.broad->cells();
  const Sample s = sample_bodies(bodies, static_cast<double>(world.least_radius));
  const double r = s.radius;
  ListPlan out;
  out.speed = s.off();
  // A skin that is thinner than the usual one still allows for what impacts may do within a step.
  const double thin = std::fmin(impact_slack(world, out.speed, 1, dt) / r, kSkinOfRadius);
  const double skin_of_radius = std::fmax(desc.skin * kSkinOfRadius, thin);
  out.margin.skin = static_cast<float>(skin_of_radius * r);
  out.margin.time = static_cast<float>(kMarginFrames * dt);
  out.outer = 2 * (1 + skin_of_radius) * r;
  // Impacts in a two-dimensional gas: 2 D n v g(c) sqrt(pi), where c is the share of the area that bodies cover.
  const double covered = std::fmin(cells.density() * 3.14159 * r * r, 0.8);
  out.impacts = 7 * r * cells.density() * out.speed * (1 - 0.44 * covered) / ((1 - covered) * (1 - covered));
  const double speed = std::sqrt(s.square);
  if (kMarginFrames * dt * speed > kSkinOfRadius * r && std::isfinite(speed)) {
    plan_flight(bodies, world, s, dt, out);
  } else if (bodies.count >= BroadPhase::kSmallWorld &&
             share_above(bodies, kAtRest * kSkinOfRadius * r / (kMarginFrames * dt)) <= kFewMoving) {
    // What is fast among many at rest gets room for several frames, which costs the others little.
    out.margin.time *= static_cast<float>(kRestFrames);
  }
  return out;
}

}  // namespace psim
