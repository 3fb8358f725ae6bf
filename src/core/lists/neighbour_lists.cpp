// How new neighbour lists are made, each choice by predicted cost, and which candidates a step takes (docs/step.md).
#include "lists/neighbour_lists.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"
#include "bodies/body_store.h"

namespace psim {
namespace {

// Margin around bodies in the lists, as a share of the radius: a tenth suits piles (docs/performance.md).
constexpr double kSkinOfRadius = 0.1;
// A body is at rest if it goes less than kAtRest of the skin in a frame. Where no more than kFewMoving of all bodies
// are faster, lists have room for kRoomFrames frames.
constexpr double kAtRest = 0.02, kFewMoving = 1.0 / 32, kRoomFrames = 8;
// Among bodies of several parts, of which each pair is several in each frame, lists that last are made only if all but
// kFewMoving of the bodies, who may be renewed alone, need at least so many frames to use up the skin.
constexpr double kLeastFrames = 2;
// Lists that last by what discs have in common (common_motion.h) are made for so many bodies, since fewer do not cost
// much and settle a little better with fresh lists; where bodies cover so much of the area around them; and where all but
// kFewMoving use up kMostSkin usual skins in no less than kCommonFrames. Whether that is so is looked at in each kTryStep-th
// step until it is. The skin is what these use up in kSkinFrames, but
// not less than the usual one; towards what is fixed, bodies get kBesideFrames of their motion. Edges of regions are in
// typical radii. docs/decisions/031-common-motion.md
constexpr std::uint32_t kManyBodies = 4096;
constexpr double kCrowd = 0.8, kMostSkin = 3, kCommonFrames = 1.3, kSkinFrames = 6, kBesideFrames = 12, kRegion = 16;
constexpr std::uint64_t kTryStep = 8;
// A body is far faster than the others if it is so many times as fast as all but kFewMoving of them, and goes so many
// typical radii in a frame. A gas has hardly any of these.
constexpr double kFarFaster = 3, kFarRadii = 4;

struct ListPlan {
  ListMode mode = ListMode::persistent;
  BroadPhaseParams broad;
  ListNumbers made;
};

// Radii and velocities of some 2,000 bodies, chosen by slot; without those that are far faster than nearly all. These
// have margins of their own.
struct Sample {
  double radius = 0;                    // typical, m
  Vec2 mean;                            // m/s
  double square = 0;                    // mean |v|^2
  double fastest = 0, fastest_off = 0;  // largest |v| and |v - mean|, m/s
  double off() const { return std::sqrt(greater(square - mean.x * mean.x - mean.y * mean.y, 0)); }
};

// The k-th smallest of n numbers for each body that is looked at, k = share n.
template <class Number>
double quantile(const BodyStore& b, double share, const Number& number) {
  std::array<double, 4096> numbers{};  // each_sampled() gives fewer
  std::size_t n = 0;
  b.each_sampled([&](std::uint32_t i) { numbers[n++] = number(i); });
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(n));
  // Total order: equal numbers are alike.
  std::nth_element(numbers.begin(), at, numbers.begin() + static_cast<std::ptrdiff_t>(n));
  return *at;
}

// The typical radius of bodies of several sizes: their mean, unless a few giants make it large.
double typical_radius(const BodyStore& b, double mean) {
  return lesser(mean, 2 * quantile(b, 0.5, [&](std::uint32_t i) { return static_cast<double>(b.radius[i]); }));
}

Sample sample_bodies(const BodyStore& b, double least_radius, bool mixed_radii, double dt) {
  Sample s;
  const auto square_of = [&](std::uint32_t i) { return dot(b.velocity(i), b.velocity(i)); };
  double n = 0, slower = 0, largest = 0;
  b.each_sampled([&](std::uint32_t i) {
    n += 1;
    s.radius += static_cast<double>(b.radius[i]);
    largest = greater(square_of(i), largest);
  });
  if (n == 0) {  // every body that was looked at is gone: as if all were at rest
    s.radius = least_radius;
    return s;
  }
  s.radius /= n;
  if (mixed_radii) s.radius = typical_radius(b, s.radius);
  const double far = kFarRadii * s.radius / dt;
  double most = far * far;
  if (!(largest <= most)) most = greater(kFarFaster * kFarFaster * quantile(b, 1 - kFewMoving, square_of), most);
  b.each_sampled([&](std::uint32_t i) {
    const Vec2 v = b.velocity(i);
    if (!(dot(v, v) <= most)) return;
    slower += 1;
    s.square += dot(v, v);
    s.mean = s.mean + v;
    s.fastest = greater(length_of(v), s.fastest);
  });
  if (slower == 0) return s;
  s.square /= slower;
  s.mean = {s.mean.x / slower, s.mean.y / slower};
  b.each_sampled([&](std::uint32_t i) {
    if (square_of(i) <= most) s.fastest_off = greater(length_of(b.velocity(i) - s.mean), s.fastest_off);
  });
  return s;
}

// The share of the sampled bodies that are faster than `speed`, m/s.
double share_above(const BodyStore& b, double speed) {
  double above = 0, n = 0;
  b.each_sampled([&](std::uint32_t i) {
    const Vec2 v = b.velocity(i);
    n += 1;
    above += !(dot(v, v) <= speed * speed);
  });
  return above / greater(n, 1);
}

// How far impacts within a step may move a body, m, at such a speed: little in a thin gas of equals, more where discs
// are close (`close`, 0 to 1), much where a heavy body meets a light one.
double impact_slack(const ListSettings& world, double speed, double close, double dt) {
  const double g = length_of(world.desc->gravity);
  return 0.02 * static_cast<double>(world.least_radius) + g * dt * dt + (world.uneven ? 1.0 : close) * speed * dt;
}

// The plan for bodies that fly: margins for several frames, of which each step selects the pairs that can meet; or,
// where those margins would soon be used up, lists for this step alone. The choice is by cost: to build lists takes
// kBuild for each body and kTest for each body that it is looked at with, to select takes kSelect for each candidate.
// Both counts follow from the number density.
void plan_flight(const NeighbourLists& lists, const ListSettings& world, const Sample& s, double dt, ListPlan& out) {
  constexpr double kBuild = 25, kTest = 0.25, kSelect = 5;  // ns, measured (docs/performance.md)
  const WorldDesc& desc = *world.desc;
  const std::uint32_t count = lists.surroundings.bodies.count;
  BroadPhaseParams& p = out.broad;
  const double r = s.radius;
  const double frame = kMarginFrames * dt * std::sqrt(s.square);  // m a frame, with reserve
  const double area =
      lists.broad.cells().area_about(r, (desc.bounds.xmax - desc.bounds.xmin) * (desc.bounds.ymax - desc.bounds.ymin));
  // Where bodies lie in heaps their number in the box says little: the last grid says more.
  const double density = greater(count / area, lists.broad.cells().density());
  // Without restitution impacts only slow bodies down.
  if (world.restitution) {
    out.made.crowding = std::clamp(3 * count / area * 3.14159 * r * r, 0.1, 1.0);
  }
  out.mode = ListMode::one_step;
  // Candidates of a body up to `outer` away: hard discs leave a distance of 2 r around it empty, but where they are
  // packed every other body is a candidate.
  const auto pairs = [&](double outer) {
    return greater(1.5708 * density * (outer * outer - 4 * r * r), 1.5708 * density * outer * outer - 0.5);
  };
  const auto build = [&](double reach) {
    const double edge = greater(2 * reach, std::sqrt(0.7 * area / count));
    return kBuild + kTest * 4.5 * density * edge * edge;
  };
  const double half = kMarginFrames * dt / 2;
  const double skin = 0.505 * impact_slack(world, out.made.speed, out.made.crowding, dt);
  // The last choice is kept if it is nearly as good: every change needs arrays of another size.
  const auto favour = [&](double frames) { return lists.selects() && frames == lists.made.frames ? 0.97 : 1.0; };
  p.outer = 2 * (r + skin + 1.2 * half * out.made.speed);
  double best = favour(0) * (build(r + skin + half * s.fastest_off) + kSelect * pairs(p.outer));
  p.margin = {.skin = static_cast<float>(skin),
              .time = static_cast<float>(half),
              .common_x = static_cast<float>(s.mean.x),
              .common_y = static_cast<float>(s.mean.y)};
  p.ahead = static_cast<float>(half);
  for (const double k : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0}) {
    const double reach = r + k * (1.2 * frame + 0.3 * kMarginFrames * dt * s.fastest);
    const double cost = favour(k) * (build(reach) / k + kSelect * pairs(2 * r + 3 * k * frame));
    if (!(cost < best)) continue;
    best = cost;
    const double room = greater(desc.skin * k, 1);  // frames; a step needs one
    p.outer = 2 * r + 3 * room * frame;
    p.margin = {.skin = static_cast<float>(0.02 * r + room * 1.2 * frame),
                .time = static_cast<float>(room * kMarginFrames * dt * 0.3)};
    out.mode = ListMode::selected_each_step;
    p.ahead = 0;
    out.made.frames = k;
  }
}

// The plan for discs that move fast, but hardly against those beside them: lists last as they do where bodies are at rest.
// False if they would not last. `before`: the last lists were such.
bool plan_common(NeighbourLists& lists, const ListSettings& world, bool before, double r, double dt,
                 BroadPhaseParams& p) {
  if (!before && world.step % kTryStep != 0) return false;
  const BodyStore& b = lists.surroundings.bodies;
  const double covered = 3.14159 * r * r * lists.broad.cells().density();
  if (world.shapes || b.count < kManyBodies || covered < kCrowd) return false;
  const double edge = kRegion * r, usual = static_cast<double>(p.margin.skin), most = kMostSkin * usual;
  const float* radius = b.radius.data();
  const auto widest = static_cast<double>(world.mixed_radii ? *std::max_element(radius, radius + b.count) : *radius);
  CommonMotion& common = lists.broad.common();
  if (4 * (widest + most) > edge || !common.cut(edge)) return false;
  const CommonMotion::Fixed fixed = lists.fixed_of(*world.desc);
  common.update(b.pos.data(), fixed, 0);
  const double used = kMarginFrames * dt * quantile(b, 1 - kFewMoving, [&](std::uint32_t i) {
                        return static_cast<double>(common.speed(i, b.pos.data() + 2 * std::size_t{i}));
                      });
  if (!(kCommonFrames * used <= most)) {
    common.stop();
    return false;
  }
  const double skin = std::clamp(kSkinFrames * used, usual, most);
  const double speed = quantile(b, 1 - kFewMoving, [&](std::uint32_t i) { return length_of(b.velocity(i)); });
  p.margin.skin = static_cast<float>(skin);
  p.margin.of_radius *= static_cast<float>(skin / usual);
  p.margin.beside = static_cast<float>(lesser(kBesideFrames * dt * speed, edge / 4));
  p.outer += 2 * (skin - usual);
  common.find_room(fixed, static_cast<double>(p.margin.beside));
  return true;
}

ListPlan plan_lists(NeighbourLists& lists, const ListSettings& world, bool common, double dt) {
  const WorldDesc& desc = *world.desc;
  const BodyStore& bodies = lists.surroundings.bodies;
  const Sample s = sample_bodies(bodies, static_cast<double>(world.least_radius), world.mixed_radii, dt);
  const double r = s.radius;
  ListPlan out;
  out.made = lists.made;
  out.made.frames = 0;
  out.made.skin = desc.skin;
  out.made.speed = s.off();
  out.made.crowding = 0.1;
  // A skin that is thinner than the usual one still allows for what impacts may do within a step.
  const double thin = lesser(impact_slack(world, out.made.speed, 1, dt) / r, kSkinOfRadius);
  const double skin_of_radius = greater(desc.skin * kSkinOfRadius, thin);
  out.broad.margin.skin = static_cast<float>(skin_of_radius * r);
  if (world.mixed_radii) out.broad.margin.of_radius = static_cast<float>(skin_of_radius);
  out.broad.margin.time = static_cast<float>(kMarginFrames * dt);
  out.broad.outer = 2 * (1 + skin_of_radius) * r;
  // Impacts in a two-dimensional gas: 2 D n v g(c) sqrt(pi), where c is the share of the area that bodies cover.
  const double density = lists.broad.cells().density(), covered = lesser(density * 3.14159 * r * r, 0.8);
  out.made.impact_rate = 7 * r * density * out.made.speed * (1 - 0.44 * covered) / ((1 - covered) * (1 - covered));
  const double speed = std::sqrt(s.square);
  const auto soon_used_up = [&] {
    const auto parts_of = [&](std::uint32_t i) { return static_cast<double>(bodies.kind(bodies.id[i]).hull_count); };
    if (!world.shapes || quantile(bodies, 0.5, parts_of) < 2) return false;
    const auto speed_of = [&](std::uint32_t i) { return length_of(bodies.velocity(i)); };
    return kLeastFrames * dt * quantile(bodies, 1 - kFewMoving, speed_of) > kSkinOfRadius * r;
  };
  if (std::isfinite(speed) && (kMarginFrames * dt * speed > kSkinOfRadius * r || soon_used_up())) {
    if (!plan_common(lists, world, common, r, dt, out.broad)) plan_flight(lists, world, s, dt, out);
  } else if (bodies.count >= BroadPhase::kSmallWorld &&
             share_above(bodies, kAtRest * kSkinOfRadius * r / (kMarginFrames * dt)) <= kFewMoving) {
    // What is fast among many at rest gets room for several frames, which costs the others little.
    out.broad.margin.time *= static_cast<float>(kRoomFrames);
  }
  return out;
}

}  // namespace

CommonMotion::Fixed NeighbourLists::fixed_of(const WorldDesc& desc) const {
  const Vec2 c = surroundings.lattice.centre();
  return {desc.boundary == Boundary::walls,
          {desc.bounds.xmin - c.x, desc.bounds.ymin - c.y, desc.bounds.xmax - c.x, desc.bounds.ymax - c.y}};
}

void NeighbourLists::measure(const ListSettings& world, double dt) {
  const WorldDesc& desc = *world.desc;
  const bool common = broad.common().on();
  broad.common().stop();
  ListPlan plan = plan_lists(*this, world, common, dt);
  const bool selected = plan.mode != ListMode::persistent;
  const double reach = plan.broad.outer + (selected ? 0 : 2 * kMarginFrames * dt * plan.made.speed);
  const double growth = made.reach > 0 ? reach * reach / (made.reach * made.reach) : 1;
  const bool changed = broad.cells().density() == 0 || selected != selects() || plan.made.frames != made.frames ||
                       plan.made.skin != made.skin;
  mode = plan.mode;
  made = plan.made;
  made.reach = reach;
  BroadPhaseParams& p = plan.broad;
  if (!changed) p.outer = 0;
  if (!changed && world.makes_room) p.growth = std::clamp(growth, 1.0, 4.0);
  p.sample = world.governed;
  p.periodic = desc.boundary == Boundary::periodic;
  p.mixed_radii = world.mixed_radii;
  p.link_all = world.link_all;
  p.walls = fixed_of(desc).walls;
  p.bounds = fixed_of(desc).bounds;
  renewal.forget();
  broad.measure(p);
}

bool NeighbourLists::move(std::size_t begin, std::size_t end) {
  const bool last = end == broad.cells().moves();
  broad.move(begin, end);
  if (last && !selects()) std::swap(table, old_table);
  return last;
}

// How far impacts within dt seconds may move the bodies of a strip against each other, m. Where masses differ,
// thrown.reach() has that, body by body.
double NeighbourLists::slack(const ListSettings& world, double dt, std::size_t strip) const {
  constexpr double kReserve = 8;  // of the r.m.s. speed: all of the sample's speed where one body in 64 moves
  const double least = impact_slack(world, 0, 1, dt);
  if (world.uneven) return least;
  const double speed = lesser(made.speed, kReserve * speeds.at(strip));
  // A row that meets a heap stops within the step, and the next row, which moves as it did, is to be known to follow.
  return greater(impact_slack(world, speed, made.crowding, dt), least + kMarginFrames * speeds.closing(strip) * dt);
}

void NeighbourLists::select(const ListSettings& world, double dt, std::size_t begin, std::size_t end) {
  if (begin == 0) {
    std::swap(table, old_table);
    if (world.uneven) {
      thrown.measure(candidates);
      thrown.find_reach(made.speed, dt);
    } else {
      speeds.measure(candidates.strips);
    }
    for (Column<std::uint32_t>* picked : {&picked_owner, &picked_other}) {
      picked->release_if_short(candidates.owner.capacity());
      picked->reserve(candidates.owner.capacity());
    }
    table.large_begin = candidates.large_begin;
    table.strips.assign(candidates.strips.begin(), candidates.strips.end());
    broad.begin_table(table, candidates.body_count, world.link_all);
  }
  const kernels::BodyView view = surroundings.bodies.view();
  kernels::PairSelection selection;
  selection.owner = candidates.owner.data();
  selection.other = candidates.other.data();
  selection.radius = world.uneven ? thrown.reach() : surroundings.bodies.radius.data();
  selection.pitch_x = static_cast<float>(surroundings.lattice.pitch_x());
  selection.pitch_y = static_cast<float>(surroundings.lattice.pitch_y());
  selection.time = static_cast<float>(kMarginFrames * dt);
  surroundings.pool.run(end - begin, [&](std::size_t n) {
    Strip& s = table.strips[begin + n];
    kernels::PairSelection mine = selection;
    mine.slack = static_cast<float>(slack(world, dt, begin + n));
    mine.out_owner = picked_owner.data() + s.pair_begin;
    mine.out_other = picked_other.data() + s.pair_begin;
    s.pair_end = s.pair_begin + surroundings.kernels.select_pairs(view, mine, s.pair_begin, s.pair_end);
  });
  if (end != table.strips.size()) return;
  std::uint32_t total = 0;
  for (Strip& s : table.strips) {  // candidates that are not selected take no room
    const std::uint32_t n = s.pair_end - s.pair_begin;
    s.pair_begin = total;
    s.pair_end = total += n;
  }
  table.owner.reserve_loosely(total + kernels::kBlock);
  table.other.reserve_loosely(total + kernels::kBlock);
  table.pair_room = total;
}

void NeighbourLists::pack(std::size_t begin, std::size_t end) {
  surroundings.pool.run(end - begin, [&](std::size_t n) {
    const std::size_t index = begin + n;
    const Strip& s = table.strips[index];
    const std::uint32_t from = candidates.strips[index].pair_begin;
    std::copy_n(picked_owner.data() + from, s.pair_end - s.pair_begin, table.owner.data() + s.pair_begin);
    std::copy_n(picked_other.data() + from, s.pair_end - s.pair_begin, table.other.data() + s.pair_begin);
    // Where the pairs of each body begin; a body without pairs begins where the next one does.
    std::uint32_t i = s.body_begin;
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      for (const std::uint32_t owner = table.owner[p]; i <= owner; ++i) table.first[i] = p;
    }
    for (; i < s.body_end; ++i) table.first[i] = s.pair_end;
    const std::vector<StaticPair>& near = candidates.static_contacts[index];
    table.static_contacts[index].reserve(near.capacity());  // assign() alone would leave no room to spare
    table.static_contacts[index].assign(near.begin(), near.end());
    link_strip(table, index, surroundings.bodies.linked.data());
  });
  if (end == table.strips.size()) table.mark_strips();
}

}  // namespace psim
