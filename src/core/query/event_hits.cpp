// Hits: contacts whose bodies approach fast before the solver, and that an impulse answers.
//
// The normal of a disc is that of the moment at which it will touch at its present velocity, so that an oblique hit has
// the speed along the normal of that moment. A contact is answered if it is closed at the end of the step; or if the
// bodies would have met within the step and at least half of the approach is gone: the impact was over before its end.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "base/elementary.h"
#include "base/rotor.h"
#include "query/events.h"

namespace psim {
namespace {

using Candidate = HitList::Candidate;

constexpr double kAnswered = 0.5;  // share of the approach that must be gone

// The velocity of the point of a body at the arm.
Vec2 velocity(const BodyStore& b, const Candidate::Side& side) {
  if (side.slot == kNoSlot) return {};
  const Vec2 v = b.velocity(side.slot);
  const double omega = b.omega_of(side.slot);
  return {v.x - omega * side.arm.y, v.y + omega * side.arm.x};
}
Vec2 closing(const BodyStore& b, const Candidate& c) { return velocity(b, c.b) - velocity(b, c.a); }
// The same at the other point of a manifold.
Vec2 other_closing(const BodyStore& b, const Candidate& c) {
  return velocity(b, {c.b.slot, c.b.id, c.arm_b}) - velocity(b, {c.a.slot, c.a.id, c.arm_a});
}

// The impulses at the points of a hit that change the approach there as it did, added up.
double impulse_of(const BodyStore& b, const Candidate& c) {
  // What an impulse of 1 N s at one point gives to the approach at another one, 1/kg.
  const auto gain = [&](const Candidate::Side& side, Vec2 arm, Vec2 other) {
    if (side.slot == kNoSlot) return 0.0;
    const BodyProperties& of = b.properties(b.id[side.slot]);
    const double r = wide(of.radius), turns = r > 0 ? wide(of.rim_gain) / (r * r) : 0;
    return wide(of.inv_mass) + turns * cross(arm, c.normal) * cross(other, c.normal);
  };
  const Vec2 arm_a[] = {c.a.arm, c.arm_a}, arm_b[] = {c.b.arm, c.arm_b};
  const auto k = [&](int i, int j) { return gain(c.a, arm_a[i], arm_a[j]) + gain(c.b, arm_b[i], arm_b[j]); };
  const double lost = c.speed + dot(c.normal, closing(b, c)), k11 = k(0, 0);
  if (!(k11 > 0)) return 0;
  const double alone = greater(lost / k11, 0);
  if (!c.two) return alone;
  const double other = c.other_speed + dot(c.normal, other_closing(b, c)), k12 = k(0, 1), k22 = k(1, 1);
  const double det = k11 * k22 - k12 * k12, j1 = (k22 * lost - k12 * other) / det,
               j2 = (k11 * other - k12 * lost) / det;
  return det > 1e-6 * k11 * k22 && j1 >= 0 && j2 >= 0 ? j1 + j2 : alone;
}

// The time at which a point at d with velocity u comes within r of the origin; < 0: never.
double meeting(Vec2 d, Vec2 u, double r) {
  const double c = dot(d, d) - r * r, b = dot(d, u);
  if (c <= 0) return 0;
  const double square = dot(u, u), root = b * b - square * c;
  return b < 0 && root >= 0 ? (-b - std::sqrt(root)) / square : -1;
}

// How two surfaces lie before the step.
struct Surfaces {
  Vec2 d;             // m: from the point of A to that of B
  double reach = 0;   // m: round surfaces meet where the points are so far apart; 0: flat surfaces
  double gap = 0;     // m: between flat surfaces, along the normal
  double beyond = 0;  // m: from the point of B along the normal to where they meet
};

// Finds the contacts whose bodies come near at speed.
struct Approach {
  const Observed& world;
  double least_speed, dt;  // m/s, s
  const BodyStore& b = world.bodies;
  const PairTable& table = world.table;
  const ContactStore& discs = world.contacts.discs;
  const Manifolds& manifolds = world.contacts.manifolds;

  // Whether two bodies move against each other fast enough, in any direction.
  bool fast(std::uint32_t slot_a, std::uint32_t slot_b) const {
    const Vec2 u = b.velocity(slot_b) - (slot_a == kNoSlot ? Vec2{} : b.velocity(slot_a));
    return dot(u, u) > least_speed * least_speed;
  }

  // Appends a candidate if its bodies come near fast enough.
  void consider(Candidate c, const Surfaces& s, std::vector<Candidate>& out) const {
    const Vec2 u = closing(b, c);
    double time = 0;
    if (s.reach > 0) {
      time = meeting(s.d, u, s.reach);
      const Vec2 at = s.d + time * u;
      if (time > 0) c.normal = {at.x / s.reach, at.y / s.reach};
    }
    c.speed = -dot(c.normal, u);
    if (!(c.speed > least_speed)) return;
    if (!(s.reach > 0)) time = greater(s.gap, 0) / c.speed;
    c.meets = time >= 0 && time <= kMarginFrames * dt;
    time = lesser(greater(time, 0), dt);
    c.point = world.lattice.to_world(b.point(c.b.slot)) + time * b.velocity(c.b.slot) + (c.b.arm + s.beyond * c.normal);
    out.push_back(c);
  }

  void pairs(const Strip& strip, std::vector<Candidate>& out) const {
    for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) {
      const std::uint32_t i = table.owner[p], j = table.other[p], lane = table.contact[p];
      if (!fast(i, j)) continue;
      const Vec2 normal{wide(discs.pairs.nx[lane]), wide(discs.pairs.ny[lane])};
      const double reach = wide(discs.pairs.rsum[lane]);
      consider({{i, b.id[i]}, {j, b.id[j]}, &discs.pairs.impulse, lane, normal},
               {(reach + wide(discs.pairs.gap[lane])) * normal, reach, 0, -wide(b.radius[j])}, out);
    }
  }

  void statics(const std::vector<StaticPair>& pairs, std::vector<Candidate>& out) const {
    for (const auto& [i, shape, lane] : pairs) {
      if (!fast(kNoSlot, i)) continue;
      const bool wall = shape >= kWallLeft;
      const std::uint32_t owner = wall ? kNoSlot : world.statics[shape].owner;
      const std::uint32_t part = wall ? 0 : world.statics[shape].part;
      const Vec2 normal{wide(discs.fixed.nx[lane]), wide(discs.fixed.ny[lane])};
      const Vec2 d{wide(discs.fixed.base_x[lane]), wide(discs.fixed.base_y[lane])};
      const bool round = discs.fixed.refresh[lane] < 1e30f;
      consider({{kNoSlot, owner, {}, part}, {i, b.id[i]}, &discs.fixed.impulse, lane, normal},
               {d, round ? wide(discs.fixed.rsum[lane]) : 0, wide(discs.fixed.gap[lane]), -wide(b.radius[i])}, out);
    }
  }

  // The point lies midway between the bodies, unless they meet within the step: then it is the point of that moment.
  void shapes(std::vector<Candidate>& out) const {
    for (std::uint32_t k = 0; k < manifolds.pairs().size(); ++k) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      if (!pair.active && !pair.flying) continue;
      const Vec2 normal{wide(pair.manifold.nx), wide(pair.manifold.ny)};
      for (int corner = 0; corner < pair.manifold.count; ++corner) {
        const ManifoldPoint& p = pair.manifold.point[corner];
        const std::uint32_t part_a = pair.of_wall()    ? 0
                                     : pair.of_piece() ? world.statics[pair.shape].part
                                                       : pair.part_a;
        const Candidate::Side first{pair.a, pair.id_a, {wide(p.ax), wide(p.ay)}, part_a};
        const Candidate::Side second{pair.b, pair.id_b, {wide(p.bx), wide(p.by)}, pair.part_b};
        Candidate c{first, second, nullptr, k, normal};
        if (pair.manifold.count == 2) {
          const ManifoldPoint& q = pair.manifold.point[1 - corner];
          c.two = true;
          c.arm_a = {wide(q.ax), wide(q.ay)}, c.arm_b = {wide(q.bx), wide(q.by)};
          c.other_speed = -dot(normal, other_closing(b, c));
        }
        consider(c, {{}, 0, wide(pair.gap[corner]), pair.ahead ? 0 : wide(p.gap) / 2}, out);
      }
    }
  }
};

}  // namespace

void HitList::approach(const Observed& world, double least_speed, double dt) {
  const Approach find{world, least_speed, dt};
  const PairTable& table = world.table;
  found_.resize(std::max(found_.size(), table.strips.size() + 1));
  world.pool.run(table.strips.size(), [&](std::size_t strip) {
    find.pairs(table.strips[strip], found_[strip]);
    find.statics(table.static_contacts[strip], found_[strip]);
  });
  find.shapes(found_[table.strips.size()]);
}

void HitList::collect(const Observed& world) {
  const BodyStore& b = world.bodies;
  const Manifolds& manifolds = world.contacts.manifolds;
  const auto there = [&](const Candidate::Side& side) { return side.slot == kNoSlot || b.id[side.slot] == side.id; };
  const auto answered = [&](const Candidate& c) {
    const bool touches = c.impulses != nullptr ? closed((*c.impulses)[c.at])
                                               : manifolds.closed(manifolds.strip_of(c.at), manifolds.pairs()[c.at]);
    return touches || (c.meets && dot(c.normal, closing(b, c)) >= (kAnswered - 1) * c.speed);
  };
  for (std::vector<Candidate>& some : found_) {
    std::copy_if(some.begin(), some.end(), std::back_inserter(answered_), [&](const Candidate& c) {
      return there(c.a) && there(c.b) && answered(c);  // some bodies left in this step
    });
    some.clear();
  }
  for (Candidate& c : answered_) {  // a wall comes last: its number is the highest
    if (c.a.id < c.b.id) continue;
    std::swap(c.a, c.b);
    std::swap(c.arm_a, c.arm_b);
    c.normal = -1 * c.normal;
  }
  const auto who = [](const Candidate& c) {  // a body may hit several walls
    const Vec2 wall = c.b.id == kNoSlot ? c.normal : Vec2{};
    return std::tuple(c.a.id, c.b.id, wall.x, wall.y);
  };
  const auto order = [&](const Candidate& c) {
    return std::tuple(who(c), -c.speed, c.point.x, c.point.y, c.normal.x, c.normal.y, c.a.part, c.b.part);
  };
  // Total order: all members that a hit shows.
  std::sort(answered_.begin(), answered_.end(),
            [&](const Candidate& x, const Candidate& y) { return order(x) < order(y); });
  const auto end = std::unique(answered_.begin(), answered_.end(),
                               [&](const Candidate& x, const Candidate& y) { return who(x) == who(y); });
  hits.clear();
  for (auto c = answered_.begin(); c != end; ++c) {
    hits.push_back({world.handle(c->a.id), world.handle(c->b.id), c->point, c->normal, c->speed, impulse_of(b, *c),
                    c->a.part, c->b.part});
  }
  answered_.clear();
}

}  // namespace psim
