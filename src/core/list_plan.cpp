// How the neighbour lists of a build are made: for how long, with which margins, from a sample of the bodies' speeds.
#include <algorithm>
#include <cmath>

#include "world_impl.h"

namespace psim {

// How the lists of a build should be made.
struct World::Impl::ListPlan {
  double outer = 0;    ///< m: a typical distance up to which two bodies are candidates
  bool loose = false;  ///< bodies fly: select from the candidates every step
  kernels::ReachParams margin;
  double frames = 0;      ///< that loose lists are made for; 0: one, looking ahead
  float ahead = 0;        ///< s: not 0 for lists of one step, see BroadPhaseParams
  double speed = 0;       ///< m/s, root mean square of the sample about its mean
  double impacts = 0;     ///< 1/s: of a body, if all were in flight
  double crowding = 0.1;  ///< 0.1 to 1: how likely one impact leads to another within a step
};

namespace {

// Margin around bodies in the lists: a tenth of the radius suits piles (docs/performance.md).
constexpr double kSkinOfRadius = 0.1;
// Among bodies at rest, which go less than this share of the skin in a frame, no more than this share of them all
// may be faster for lists to have room for so many frames.
constexpr double kAtRest = 0.02, kFewMoving = 1.0 / 32, kRestFrames = 8;

// Radii and velocities of some bodies, by slot; of those that are gone nothing counts, nor is it saved.
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
    return Vec2{static_cast<double>(b.vel[2 * std::size_t{i}]),
                static_cast<double>(b.vel[2 * std::size_t{i} + 1])};
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
  if (n == 0) {  // all that were looked at: as if at rest
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

// The share of some bodies that are faster, m/s.
double share_above(const BodyStore& b, double speed) {
  const std::uint32_t stride = std::max(1u, b.count / 2048);
  double above = 0, n = 0;
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const auto x = static_cast<double>(b.vel[2 * std::size_t{i}]), y = static_cast<double>(b.vel[2 * std::size_t{i} + 1]);
    n += 1;
    above += !(x * x + y * y <= speed * speed);
  }
  return above / std::fmax(n, 1);
}

}  // namespace

// What impacts within a step do to velocities moves bodies by this much, m: little in a thin gas of
// equals, more where discs are close, much where a heavy body meets a light one.
double World::Impl::impact_slack(double speed, double close, double dt) const {
  const double g = std::sqrt(desc.gravity.x * desc.gravity.x + desc.gravity.y * desc.gravity.y);
  return 0.02 * static_cast<double>(least_radius) + g * dt * dt +
         (plan.uneven ? 1.0 : close) * speed * dt;
}

// Lists for one step or some frames: how fast bodies move against those around them now.
void World::Impl::measure_speeds(double dt) {
  const bool periodic = desc.boundary == Boundary::periodic;
  speeds.measure(bodies, candidates.strips, {plan.uneven, periodic, lattice.pitch_y(), kMarginFrames * dt}, pool);
  slack.resize(candidates.strips.size());
}

// Of a strip: never more than what the speeds all over the world ask for, and less where all move alike
// (docs/decisions/013-slack-by-strip.md).
double World::Impl::slack_of(std::size_t strip, double dt) const {
  constexpr double kReserve = 8;  // of the r.m.s. speed: all of it where one in 64 moves
  return impact_slack(std::fmin(sampled_speed, kReserve * speeds.at(strip)), crowding, dt);
}

// Bodies at rest or creeping: a thin skin, and the candidates are the contacts while it lasts.
// Bodies in flight: margins for several frames, of which each step selects the pairs that can meet;
// or, where they would soon be used up, lists for this step alone. The choice is by cost: building
// takes kBuild a body and kTest a body looked at, selecting kSelect a candidate, and both counts
// follow from the number density.
World::Impl::ListPlan World::Impl::plan_lists(double dt) const {
  constexpr double kBuild = 25, kTest = 0.25, kSelect = 5;  // ns, measured (docs/performance.md)
  const Sample s = sample_bodies(bodies, static_cast<double>(least_radius));
  const double r = s.radius;
  ListPlan out;
  out.speed = s.off();
  // A thinner skin than the usual one is still what impacts within a step may take.
  const double thin = std::fmin(impact_slack(out.speed, 1, dt) / r, kSkinOfRadius);
  const double skin_of_radius = std::fmax(desc.skin * kSkinOfRadius, thin);
  out.margin.skin = static_cast<float>(skin_of_radius * r);
  out.margin.time = static_cast<float>(kMarginFrames * dt);
  out.outer = 2 * (1 + skin_of_radius) * r;
  // Of a gas in two dimensions, 2 D n v g(c) sqrt(pi), with c the share of the area that is covered.
  const double covered = std::fmin(broad.density() * 3.14159 * r * r, 0.8);
  out.impacts =
      7 * r * broad.density() * out.speed * (1 - 0.44 * covered) / ((1 - covered) * (1 - covered));
  const double speed = std::sqrt(s.square);
  const double frame = kMarginFrames * dt * speed;  // m a frame, with reserve
  if (!(frame > kSkinOfRadius * r) || !std::isfinite(speed)) {
    // What is fast among many at rest has room for several frames, which costs the others little.
    if (bodies.count >= BroadPhase::kSmallWorld &&
        share_above(bodies, kAtRest * kSkinOfRadius * r / (kMarginFrames * dt)) <= kFewMoving) {
      out.margin.time *= static_cast<float>(kRestFrames);
    }
    return out;
  }
  const double area =
      broad.area_about(bodies, r, (desc.bounds.xmax - desc.bounds.xmin) *
                                      (desc.bounds.ymax - desc.bounds.ymin));
  // Where bodies lie in heaps their number a box says little: the last grid says more.
  const double density = std::fmax(bodies.count / area, broad.density());
  // Without restitution impacts only slow bodies down.
  if (plan.restitution) {
    out.crowding = std::clamp(3 * bodies.count / area * 3.14159 * r * r, 0.1, 1.0);
  }
  out.loose = true;
  // Candidates of a body up to `outer` away: hard discs leave 2 r around it empty, but where they
  // are packed all but itself is there.
  const auto pairs = [&](double outer) {
    return std::fmax(1.5708 * density * (outer * outer - 4 * r * r),
                     1.5708 * density * outer * outer - 0.5);
  };
  const auto build = [&](double reach) {
    const double edge = std::fmax(2 * reach, std::sqrt(0.7 * area / bodies.count));
    return kBuild + kTest * 4.5 * density * edge * edge;
  };
  const double half = kMarginFrames * dt / 2;
  const double skin = 0.505 * impact_slack(out.speed, out.crowding, dt);
  // The last choice is kept if it is nearly as good: every change of mind needs room of its own.
  const auto favour = [&](double frames) { return loose && frames == list_frames ? 0.97 : 1.0; };
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
    out.ahead = 0;
    out.frames = k;
  }
  return out;
}

// Broad phase: how the lists are made.
void World::Impl::measure_bodies(const Span& span) {
  if (!bodies.spin.empty()) bodies.add_rotation();
  const ListPlan lists = plan_lists(span.step);
  const double reach = lists.outer + (lists.loose ? 0 : 2 * kMarginFrames * span.step * lists.speed);
  const double growth = list_reach > 0 ? reach * reach / (list_reach * list_reach) : 1;
  const bool changed = broad.density() == 0 || lists.loose != loose || lists.frames != list_frames ||
                       desc.skin != list_skin;
  loose = lists.loose;
  once = lists.ahead != 0;
  list_frames = lists.frames;
  list_reach = reach;
  list_skin = desc.skin;
  sampled_speed = lists.speed;
  crowding = lists.crowding;
  impact_rate = lists.impacts;
  BroadPhaseParams p;
  p.margin = lists.margin;
  p.ahead = lists.ahead;
  p.outer = changed ? lists.outer : 0;
  p.sample = governor.on();
  if (!changed && (detailed || governor.on() || span.step > span.frame)) p.growth = std::clamp(growth, 1.0, 4.0);
  p.walls = desc.boundary == Boundary::walls;
  p.periodic = desc.boundary == Boundary::periodic;
  p.mixed_radii = plan.radii;
  p.link_all = plan.fields;
  const Vec2 c = lattice.centre();
  p.bounds = {desc.bounds.xmin - c.x, desc.bounds.ymin - c.y, desc.bounds.xmax - c.x,
              desc.bounds.ymax - c.y};
  renewal.forget();
  broad.measure(bodies, shapes, p, kernels, pool);
  ahead.built = true;
}

// Bodies in cell order, once the last of them are moved.
void World::Impl::move_bodies(std::size_t begin, std::size_t end) {
  const bool last = end == broad.moves();
  if (last && !loose) {
    table.swap(old_table);
    ahead.swapped = true;
  }
  broad.move(bodies, kernels, pool, loose ? candidates : table, begin, end);
  if (!last) return;
  if (plan.fields) move_rests(bodies, broad.from(), pool);
  ahead.sorted = true;
}

}  // namespace psim
