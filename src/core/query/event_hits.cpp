// Hits: contacts whose bodies approach fast before the solver, and that an impulse answers.
//
// A disc's normal is that of the moment at which it will touch, as it goes, so that oblique hits are
// told with the speed that counts. A contact is answered if it is closed at the end of the step; or if the
// bodies would have met within the step and at least half of the approach is gone (an impact in its midst).
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/rotor.h"
#include "base/tasks.h"
#include "bodies/body_store.h"
#include "query/events.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr double kAnswered = 0.5;  // share of the approach that must be gone

Vec2 velocity(const BodyStore& b, std::uint32_t slot) {
  if (slot == kNoSlot) return {};
  return {static_cast<double>(b.vel[2 * std::size_t{slot}]), static_cast<double>(b.vel[2 * std::size_t{slot} + 1])};
}

// The velocity of the point of a body at an arm.
Vec2 velocity(const BodyStore& b, std::uint32_t slot, double x, double y) {
  const Vec2 v = velocity(b, slot);
  if (slot == kNoSlot || b.rim_speed.empty()) return v;
  const double omega = static_cast<double>(b.rim_speed[slot]) / static_cast<double>(b.radius[slot]);
  return {v.x - omega * y, v.y + omega * x};
}

// The time at which a point at d with velocity u comes within r of the origin; < 0: never.
double meeting(Vec2 d, Vec2 u, double r) {
  const double c = dot(d, d) - r * r, b = dot(d, u);
  if (c <= 0) return 0;
  const double square = dot(u, u), root = b * b - square * c;
  return b < 0 && root >= 0 ? (-b - std::sqrt(root)) / square : -1;
}

}  // namespace

Vec2 EventList::closing(const Observed& s, const Candidate& c) {
  if (c.kind != Candidate::kManifold) return velocity(s.bodies, c.slot_b) - velocity(s.bodies, c.slot_a);
  const ManifoldPoint& p = s.contacts.manifolds.pairs()[c.at].manifold.point[c.corner];
  return velocity(s.bodies, c.slot_b, static_cast<double>(p.bx), static_cast<double>(p.by)) -
         velocity(s.bodies, c.slot_a, static_cast<double>(p.ax), static_cast<double>(p.ay));
}

// Appends a candidate if its bodies come near fast enough. `d` leads from the point of A to that of B. Round surfaces
// meet where the points are `reach` apart; if `reach` is 0 they are flat, with `gap` between them along the normal.
void EventList::consider(const Observed& s, Candidate c, Vec2 d, double reach, double gap, double dt,
                         std::vector<Candidate>& out) const {
  const BodyStore& b = s.bodies;
  const Vec2 u = closing(s, c);
  double time = 0;
  if (reach > 0) {
    time = meeting(d, u, reach);
    if (time > 0) {
      const Vec2 at = d + time * u;
      c.nx = at.x / reach;
      c.ny = at.y / reach;
    }
  }
  c.speed = -(c.nx * u.x + c.ny * u.y);
  if (!(c.speed > options_.hit_speed)) return;
  if (!(reach > 0)) time = std::fmax(gap, 0) / c.speed;
  c.meets = time >= 0 && time <= kMarginFrames * dt;
  time = std::fmin(std::fmax(time, 0), dt);
  const Vec2 v = velocity(b, c.slot_b), centre = s.to_world(s.place(c.slot_b));
  Vec2 arm;
  if (c.kind == Candidate::kManifold) {
    const ManifoldPair& pair = s.contacts.manifolds.pairs()[c.at];
    const ManifoldPoint& p = pair.manifold.point[c.corner];
    // The point lies midway between the bodies, unless they meet within the step: then it is the point of that moment.
    const double half = pair.ahead ? 0 : static_cast<double>(p.gap) / 2;
    arm = {static_cast<double>(p.bx) + half * c.nx, static_cast<double>(p.by) + half * c.ny};
  } else {
    const double r = static_cast<double>(b.radius[c.slot_b]);
    arm = {-r * c.nx, -r * c.ny};
  }
  c.point = centre + time * v + arm;
  out.push_back(c);
}

// Whether two bodies move against each other fast enough, in any direction.
bool EventList::fast(const Observed& s, std::uint32_t slot_a, std::uint32_t slot_b) const {
  const Vec2 u = velocity(s.bodies, slot_b) - velocity(s.bodies, slot_a);
  return dot(u, u) > options_.hit_speed * options_.hit_speed;
}

void EventList::approach(const Observed& s, double dt) {
  candidates_.clear();
  if (!options_.hits) return;
  const std::uint32_t blocks = s.contacts.discs.pairs.blocks;
  const std::size_t tasks = stream_tasks(blocks);
  found_.resize(std::max(found_.size(), tasks));
  s.pool.run(tasks, [&](std::size_t t) {
    found_[t].clear();
    approach_pairs(s, stream_range(t, blocks), dt, found_[t]);
  });
  for (std::size_t t = 0; t < tasks; ++t) candidates_.insert(candidates_.end(), found_[t].begin(), found_[t].end());
  approach_statics(s, dt);
  approach_manifolds(s, dt);
}

void EventList::approach_pairs(const Observed& s, BlockRange r, double dt, std::vector<Candidate>& out) const {
  const BodyStore& b = s.bodies;
  const PairLanes& c = s.contacts.discs.pairs;
  const std::uint32_t dummies = s.contacts.solved.dummies();
  for (std::size_t l = std::size_t{r.begin} * kBlock; l < std::size_t{r.end} * kBlock; ++l) {
    if (c.body[2 * l] >= dummies) continue;
    Candidate pair;
    pair.slot_a = s.contacts.solved.slot(c.body[2 * l]);
    pair.slot_b = s.contacts.solved.slot(c.body[2 * l + 1]);
    if (!fast(s, pair.slot_a, pair.slot_b)) continue;
    pair.at = static_cast<std::uint32_t>(l);
    pair.id_a = b.id[pair.slot_a];
    pair.id_b = b.id[pair.slot_b];
    pair.nx = static_cast<double>(c.nx[l]);
    pair.ny = static_cast<double>(c.ny[l]);
    const double reach = static_cast<double>(c.rsum[l]);
    const double far = reach + static_cast<double>(c.gap[l]);
    consider(s, pair, {far * pair.nx, far * pair.ny}, reach, 0, dt, out);
  }
}

void EventList::approach_statics(const Observed& s, double dt) {
  const BodyStore& b = s.bodies;
  const StaticLanes& c = s.contacts.discs.fixed;
  const std::uint32_t dummies = s.contacts.solved.dummies();
  for (std::size_t l = 0; l < std::size_t{c.blocks} * kBlock; ++l) {
    if (c.body[l] >= dummies) continue;
    Candidate static_pair;
    static_pair.kind = Candidate::kStatic;
    static_pair.at = static_cast<std::uint32_t>(l);
    static_pair.slot_b = s.contacts.solved.slot(c.body[l]);
    if (!fast(s, kNoSlot, static_pair.slot_b)) continue;
    static_pair.id_b = b.id[static_pair.slot_b];
    if (c.shape[l] < kWallLeft) static_pair.id_a = s.statics[c.shape[l]].owner;
    static_pair.nx = static_cast<double>(c.nx[l]);
    static_pair.ny = static_cast<double>(c.ny[l]);
    const bool round = c.refresh[l] < 1e30f;
    consider(s, static_pair, {static_cast<double>(c.base_x[l]), static_cast<double>(c.base_y[l])},
             round ? static_cast<double>(c.rsum[l]) : 0, static_cast<double>(c.gap[l]), dt, candidates_);
  }
}

void EventList::approach_manifolds(const Observed& s, double dt) {
  for (std::uint32_t k = 0; k < s.contacts.manifolds.pairs().size(); ++k) {
    const ManifoldPair& p = s.contacts.manifolds.pairs()[k];
    if (p.lane == PairName::kNone) continue;
    for (int corner = 0; corner < p.manifold.count; ++corner) {
      Candidate pair;
      pair.kind = Candidate::kManifold;
      pair.at = k;
      pair.corner = corner;
      pair.slot_a = p.a;
      pair.slot_b = p.b;
      pair.id_a = p.id_a;
      pair.id_b = p.id_b;
      pair.nx = static_cast<double>(p.manifold.nx);
      pair.ny = static_cast<double>(p.manifold.ny);
      consider(s, pair, {}, 0, static_cast<double>(p.gap[corner]), dt, candidates_);
    }
  }
}

// Keeps the candidates that were answered: each pair once, at the highest speed.
void EventList::keep_hits(const Observed& s) {
  const BodyStore& b = s.bodies;
  const auto there = [&](std::uint32_t slot, std::uint32_t id) { return slot == kNoSlot || b.id[slot] == id; };
  const auto closed = [&](const Candidate& c) {
    switch (c.kind) {
      case Candidate::kPair:
        return !std::signbit(s.contacts.discs.pairs.impulse[c.at]);
      case Candidate::kStatic:
        return !std::signbit(s.contacts.discs.fixed.impulse[c.at]);
      case Candidate::kManifold:
        break;
    }
    return s.contacts.manifolds.closed(s.contacts.manifolds.strip_of(c.at), s.contacts.manifolds.pairs()[c.at]);
  };
  std::erase_if(candidates_, [&](const Candidate& c) {
    if (!there(c.slot_a, c.id_a) || !there(c.slot_b, c.id_b)) return true;  // a body left in this step
    if (closed(c)) return false;
    const Vec2 u = closing(s, c);
    return !(c.meets && c.nx * u.x + c.ny * u.y >= (kAnswered - 1) * c.speed);
  });
  for (Candidate& c : candidates_) {  // a wall comes last: its number is the highest
    if (c.id_a < c.id_b) continue;
    std::swap(c.id_a, c.id_b);
    c.nx = -c.nx;
    c.ny = -c.ny;
  }
  // Total order: all members that a hit shows.
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& o) {
    if (a.id_a != o.id_a) return a.id_a < o.id_a;
    if (a.id_b != o.id_b) return a.id_b < o.id_b;
    if (a.id_b == kNoSlot && a.nx != o.nx) return a.nx < o.nx;
    if (a.id_b == kNoSlot && a.ny != o.ny) return a.ny < o.ny;
    if (a.speed != o.speed) return a.speed > o.speed;
    return std::tie(a.point.x, a.point.y, a.nx, a.ny) < std::tie(o.point.x, o.point.y, o.nx, o.ny);
  });
  const auto same = [](const Candidate& a, const Candidate& o) {
    return a.id_a == o.id_a && a.id_b == o.id_b && (a.id_b != kNoSlot || (a.nx == o.nx && a.ny == o.ny));
  };
  candidates_.erase(std::unique(candidates_.begin(), candidates_.end(), same), candidates_.end());
  hits_.clear();
  for (const Candidate& c : candidates_) {
    const BodyId other = c.id_b == kNoSlot ? kNoBody : handle(s, c.id_b, false);
    hits_.push_back({handle(s, c.id_a, false), other, c.point, {c.nx, c.ny}, c.speed});
  }
}

}  // namespace psim
