// One pair of shapes that may collide within a substep, with the places and angles that the bodies have at that time: for
// shape_impacts.cpp alone. A body has a virtual start, from which it moves as if it had met nothing.
//
// The time is found by conservative advancement (Mirtich 1996): along the present normal, hulls come together no faster
// than their fastest corners, whose accelerations are bounded. A microsecond for a pair that is near.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/rotor.h"
#include "least.h"
#include "solver/approach.h"
#include "solver/shape_hit.h"
#include "solver/solver_run.h"

namespace psim {

namespace shape_impact {

constexpr double kTouch = 1e-3;  // share of the inner radius: hulls so near touch
// The solver pushes out an overlap that is so many times as deep, unless it parts within so many seconds.
constexpr double kTooDeep = 10, kPartingTime = 0.1;
// Elastic bodies part by this share of their overlap in a sweep, and no faster than that.
constexpr double kPartingShare = 0.2, kPartingSpeed = 3;  // -, m/s
constexpr int kMostSteps = 100, kRockSteps = 2;

struct Around {
  const Surroundings& s;
  const kernels::BodyView& view;
  const Manifolds& manifolds;
  bool surfaces;   // some run
  Vec2 gravity;    // m/s^2
  double& virial;  // N s m: of the impacts so far
};

// A pair whose bodies may collide in this substep.
class ShapeImpact {
 public:
  ShapeImpact(const Around& around, const ManifoldPair& pair, kernels::ManifoldBlock& block, std::uint32_t lane)
      : in_(around),
        pair_(pair),
        c_(block),
        l_(lane),
        a_(mover(pair.a, block.wa[lane], block.ga[lane])),
        b_(mover(pair.b, block.wb[lane], block.gb[lane])),
        hull_b_(hull(pair.b, pair.part_b, own_b_)),
        hull_a_(hull_of_a()) {
    near_ = kTouch * double{hull_b_.inner};
    if (pair.of_piece()) return;
    if (!pair.fixed_a) near_ = std::min(near_, kTouch * double{hull_a_.inner});
    way_ = in_.s.lattice.way(in_.s.bodies.point(pair.a), in_.s.bodies.point(pair.b));
    start_ = way_;
  }

  /// Collides the bodies, if they do so before the substep ends. An impact from `due` on waits for a later sweep. Returns
  /// whether they did, or will. The solver leaves the pair
  /// alone in this substep unless its impact is too slow to bounce, or left over in the last sweep (least_e is 1): no body
  /// leaves through fixed ground.
  bool collide_in(double h, double floor, float least_e, float due) {
    float& e = c_.e[l_];
    Hit hit;
    const double slowest = e < 1 ? floor / double{e} : 0;  // what is elastic never comes to rest
    if (too_fast(h)) return false;
    Found found = find(h, slowest, hit);
    if (found == Found::hit && (e < least_e || (pair_.fixed_a && least_e >= 1))) found = Found::slow;
    if (found == Found::slow && e == 1 && hit.count == 0) {
      part(hit, h);
      found = Found::none;
    }
    if (found != Found::slow) e = -e;
    if (found != Found::hit || hit.time >= double{due}) return found == Found::hit;
    find_impulses(a_, b_, -double{e}, hit);
    bounce(hit);
    return true;
  }

  /// Bodies that were apart meet at their time: the solver goes by the contact of that time, after the impact, or else by
  /// that of the time at which they were last seen apart, unless it presses already. There is none in a substep in which
  /// they surely stay apart.
  void land(Manifolds& manifolds, ManifoldPair& pair, double h) const {
    if (too_fast(h) || c_.point[0].impulse[l_] > 0 || c_.point[1].impulse[l_] > 0) return;
    Hit hit;
    const bool meet = find(h, 0, hit) == Found::hit;
    if (hit.m.count == 0) {
      for (kernels::ManifoldBlock::Point& p : c_.point) p.gap[l_] = kNoGap;
      pair.margin = -1;  // the hulls are looked at again in the next step
      return;
    }
    const double t = hit.time;
    const Manifold m = hit.m;
    if (meet) strike(hit, t, h);
    put(manifolds, pair, m, t);
  }

  /// Bodies that press on each other in one point and come upon another one, which a block does that rocks, meet there at
  /// time t: the solver finds them after that impact.
  void rock(Manifolds& manifolds, ManifoldPair& pair, double h, double slowest) {
    pressed(h);
    double t = 0;
    Hit hit;
    int open = 2;
    for (int k = 0; k < kRockSteps; ++k) {  // the point that is open comes to the surface
      if (!meets(at(t), t, hit)) return;
      if (open == 2) open = hit.gap[1] > hit.gap[0] ? 1 : 0;
      if (!(-hit.approach[open] > slowest)) return;
      t = std::max(t - hit.gap[open] / hit.approach[open], std::max(a_.since, b_.since));
      if (!(t < h)) return;
    }
    const Manifold m = at(t);
    if (!meets(m, t, hit) || std::max(std::fabs(hit.gap[0]), std::fabs(hit.gap[1])) > 2 * near_) return;
    strike(hit, t, h);
    put(manifolds, pair, m, t);
  }

 private:
  enum class Found : std::uint8_t { none, slow, hit };

  // m/s: what the surfaces run.
  double belt() const { return in_.surfaces ? double{in_.manifolds.sides_of(pair_).belt()} : 0.0; }

  // Puts the contact of time t into its lane.
  void put(Manifolds& manifolds, ManifoldPair& pair, Manifold m, double t) const {
    const kernels::BodyView& view = in_.view;
    fit(m, t);
    if (m.count == 0) return;
    const auto speed = [&](std::uint32_t slot) { return Vec2{view.vel[2 * slot], view.vel[2 * slot + 1]}; };
    const Vec2 of_a = pair.of_piece() ? Vec2{} : speed(pair.a) + t * a_.falls;
    manifolds.foretell(pair, c_, m, view, speed(pair.b) + t * b_.falls - of_a, t);
    if (!pair.of_wall()) return;
    pair.base = in_.s.bodies.point(pair.b);  // where the body is at the time of the manifold
    pair.base.dx += static_cast<float>(b_.way(t).x);
    pair.base.dy += static_cast<float>(b_.way(t).y);
  }

  // The points of time t collide, with friction.
  void strike(Hit& hit, double t, double h) const {
    const Vec2 along{-hit.n.y, hit.n.x};
    const int k = hit.count == 2 && hit.approach[1] < hit.approach[0] ? 1 : 0;
    const double vt = dot(along, b_.velocity(t, hit.arm_b[k]) - a_.velocity(t, hit.arm_a[k])) + belt();
    const double friction = find_rough_impulses(a_, b_, along, k, vt, c_.mu[l_], std::fabs(c_.e[l_]), hit);
    Push push(hit);
    push.add(hit, k, friction * along);
    if (!pair_.fixed_a) settle(a_, -a_.inv_mass * push.sum, a_.inv_inertia * push.turn_a, t, h);
    settle(b_, b_.inv_mass * push.sum, b_.inv_inertia * push.turn_b, t, h);
    for (auto& p : c_.point) p.impulse[l_] = p.friction[l_] = 0;
  }

  // The bodies move on under the force with which they press on each other in this contact, until the impact.
  void pressed(double h) {
    Vec2 force;
    double turn_a = 0, turn_b = 0;
    const Vec2 n{c_.nx[l_], c_.ny[l_]};
    for (const kernels::ManifoldBlock::Point& p : c_.point) {
      const double l = std::max(p.impulse[l_], 0.0f) / h, f = p.friction[l_] / h;
      force = force + l * n + f * upright(n);
      turn_a -= l * double{p.at[l_]} + f * double{p.an[l_]};
      turn_b += l * double{p.bt[l_]} + f * double{p.bn[l_]};
    }
    const auto press = [&](Mover& m, double sign, double turn) {
      if (!(m.inv_mass > 0)) return;
      m.a = m.a + sign * m.inv_mass * force;
      m.alpha = m.inv_inertia * turn * double{in_.s.bodies.radius[m.slot]};
    };
    press(a_, -1, turn_a);
    press(b_, 1, turn_b);
  }

  // The two points of time t, and how they approach each other. False if one is alone.
  bool meets(const Manifold& m, double t, Hit& hit) const {
    hit.time = t;
    hit.n = {m.nx, m.ny};
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      hit.gap[k] = p.gap;
      hit.arm_b[k] = {p.bx, p.by};
      hit.arm_a[k] = pair_.of_piece() ? Vec2{} : Vec2{p.ax, p.ay};
      hit.approach[k] = dot(hit.n, b_.velocity(t, hit.arm_b[k]) - a_.velocity(t, hit.arm_a[k]));
    }
    hit.count = m.count;
    return m.count == 2;
  }

  // Gives a body what an impact at a time of the substep, and what pressed until then, do to it. What pressed is not
  // repeated by the next kick.
  void settle(const Mover& m, Vec2 dv, double spin, double t, double h) const {
    const kernels::BodyView& view = in_.view;
    const Vec2 force = m.a - m.falls;
    const std::size_t i = m.slot;
    const double reach = in_.s.bodies.radius[i];
    move(m, t * force, t * m.alpha, 0.5 * t);
    move(m, dv, spin, t);
    const auto add = [](float& to, double what) { to = kernels::snapped(double{to} + what, kernels::kLeastOffset); };
    add(view.vel0[2 * i], h * force.x), add(view.vel0[2 * i + 1], h * force.y);
    add(view.rim_speed0[i], reach * h * m.alpha);
  }

  Mover mover(std::uint32_t slot, float inv_mass, float rim_gain) const {
    Mover m;
    m.slot = slot;
    if (slot == ManifoldPair::kNone) return m;
    const BodyStore& b = in_.s.bodies;
    const kernels::BodyView& view = in_.view;
    const double reach = b.radius[slot];
    m.v = {view.vel[2 * slot], view.vel[2 * slot + 1]};
    m.angle = b.angle[slot];
    m.now = rotor_of(m.angle);
    m.omega = double{view.rim_speed[slot]} / reach;
    m.inv_mass = inv_mass;
    m.inv_inertia = double{rim_gain} / (reach * reach);
    if (view.event_time != nullptr) m.since = view.event_time[slot];
    if (inv_mass > 0) m.a = view.acc != nullptr ? Vec2{view.acc[2 * slot], view.acc[2 * slot + 1]} : in_.gravity;
    m.falls = m.a;
    return m;
  }
  const Hull& hull(std::uint32_t slot, std::uint32_t part, std::optional<Hull>& own) const {
    const BodyStore& b = in_.s.bodies;
    if (!in_.manifolds.has_corners(slot)) return own.emplace(disc_hull(b.radius[slot]));
    return b.hulls[b.kind(b.id[slot]).first_hull + part];
  }
  const Hull& hull_of_a() {
    if (pair_.of_wall()) return own_a_.emplace(disc_hull(0));  // a point of the plane
    if (pair_.of_floor()) return own_a_.emplace(in_.manifolds.floor_of(pair_));
    if (!pair_.of_piece()) return hull(pair_.a, pair_.part_a, own_a_);
    return own_a_.emplace(
        in_.s.statics.seen_from(pair_.shape, in_.s.bodies.point(pair_.b), 16.0 * double{hull_b_.reach}));
  }

  // The solver sees to such bodies, and lets nobody through.
  bool too_fast(double h) const {
    const double size = pair_.fixed_a ? double{hull_b_.reach} : std::min(hull_a_.reach, hull_b_.reach);
    return h * length_of(b_.v - a_.v) > double{kMostSizes} * size;
  }

  // The time until which the bodies surely stay apart, or the end of the substep: the circles about them do not meet, or
  // a line across their last normal stays between them.
  double apart_until(double h) const {
    const double since = std::max(a_.since, b_.since);
    if (pair_.of_wall()) return since;
    if (!pair_.of_piece()) {
      const double reach = double{hull_a_.reach} + double{hull_b_.reach};
      if (length_of(way_) > reach + h * (length_of(b_.v - a_.v) + h * length_of(b_.a - a_.a))) return h;
    }
    const Vec2 n{pair_.manifold.nx, pair_.manifold.ny};
    const double gap = dot(n, way_ + b_.way(since) - a_.way(since)) - top_of(hull_a_, a_.rotor(since), n) -
                       top_of(hull_b_, b_.rotor(since), -1 * n);
    return gap > near_ ? since + apart_for(gap, since, n, h) : since;
  }
  Manifold at(double t) const {
    constexpr float kAny = 1e30f;
    const Vec2 d = way_ + b_.way(t) - a_.way(t);
    const Rotor qb = b_.rotor(t);
    if (!pair_.of_wall()) {
      return collide(hull_a_, a_.rotor(t), hull_b_, qb, static_cast<float>(d.x), static_cast<float>(d.y), kAny);
    }
    const Manifold& m = pair_.manifold;
    const Vec2 n{m.nx, m.ny}, since = in_.s.lattice.way(pair_.base, in_.s.bodies.point(pair_.b)) + d;
    const double height = dot(n, since - Vec2{m.point[0].bx, m.point[0].by}) + 0.5 * double{m.point[0].gap};
    return meet_plane(hull_b_, qb, m.nx, m.ny, static_cast<float>(height), kAny);
  }

  // How long hulls with a gap along n stay apart at least, or to the end of the substep. Corners come together by
  // closing t + growth t^2 / 2 at most.
  double apart_for(double gap, double t, Vec2 n, double h) const {
    const Corners a(hull_a_, a_.rotor(t), a_.omega, n), b(hull_b_, b_.rotor(t), b_.omega, {-n.x, -n.y});
    const double closing = -dot(n, b_.v + t * b_.a - a_.v - t * a_.a);
    const double growth = a_.omega * a_.omega * double{hull_a_.reach} + b_.omega * b_.omega * double{hull_b_.reach} +
                          std::max(0.0, -dot(n, b_.a - a_.a));
    double time = h - t;
    for (int k = 0; k < hull_b_.count; ++k) {
      for (int j = 0; j < hull_a_.count; ++j) {
        // Hulls that part are near each other for a while.
        const double way = std::max(gap + b.behind[k] + a.behind[j] - 0.5 * near_, 2 * near_);
        const double speed = closing + b.speed[k] + a.speed[j];
        if (way < time * (speed + 0.5 * growth * time)) time = time_to_close(way, speed, growth);
      }
    }
    return time;
  }

  // On ground of several segments a body meets the faces.
  void fit(Manifold& m, double t) const {
    if (!pair_.fixed_a || pair_.of_wall() || pair_.of_floor() || hull_a_.count != 2 || m.count == 0) return;
    const Vec2 d = way_ + b_.way(t) - a_.way(t);
    in_.manifolds.fit_within_step(pair_, m, hull_a_, hull_b_, b_.rotor(t), start_, d);
  }

  static double least_gap(const Manifold& m) {
    return m.count == 2 ? std::min(m.point[0].gap, m.point[1].gap) : m.point[0].gap;
  }

  // The first time at which the bodies touch and approach each other. Where the nearest points of now would touch, they
  // often do; else the search goes on by steps in which nothing can touch. What is near comes to touch at its present
  // speed, as good as.
  Found find(double h, double slowest, Hit& hit) const {
    double t = apart_until(h);
    if (t >= h) return Found::none;
    Manifold m = look(t);
    bool near = false;
    for (int k = 0; k < kMostSteps; ++k) {
      hit.time = t;
      hit.m = m;
      if (m.count == 0) return Found::none;
      const double gap = least_gap(m);
      if (gap <= near_) {
        const Found found = touch(m, t, slowest, hit);
        if (found == Found::hit && !near && hit.wait > 0) {
          near = true;
          t += hit.wait;
          if (t >= h) return Found::none;
          m = look(t);
          continue;
        }
        if (found != Found::none) return found;
        hit.depth = -gap;
        if (k == 0 && gap < -kTooDeep * near_ && hit.parting * kPartingTime < -gap) return Found::slow;
      }
      const double sure = t + apart_for(gap, t, {m.nx, m.ny}, h), guess = gap <= near_ ? h : t + time_to_touch(m, t);
      if (sure >= h) return Found::none;
      t = guess > sure && guess < h ? guess : sure;
      m = look(t);
      if (t == sure || (m.count != 0 && least_gap(m) >= -near_)) continue;
      t = sure;
      m = look(t);
    }
    return slowest > 0 ? Found::slow : Found::none;
  }
  Manifold look(double t) const {
    Manifold m = at(t);
    if (m.count != 0 && least_gap(m) <= near_) fit(m, t);
    return m;
  }

  // After which time the first point of a manifold touches if it goes on as it does.
  double time_to_touch(const Manifold& m, double t) const {
    const Vec2 n{m.nx, m.ny};
    double first = 1e30;
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      const Vec2 arm_b{p.bx, p.by}, arm_a = pair_.of_piece() ? Vec2{} : Vec2{p.ax, p.ay};
      const double closing = -dot(n, b_.velocity(t, arm_b) - a_.velocity(t, arm_a));
      if (closing > 0) first = std::min(first, double{p.gap} / closing);
    }
    return first;
  }

  // Which of the points that touch approach each other.
  Found touch(const Manifold& m, double t, double slowest, Hit& hit) const {
    hit = {};
    hit.time = t;
    hit.m = m;
    hit.n = {m.nx, m.ny};
    bool slow = false;
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      if (double{p.gap} > 2 * near_) continue;
      const Vec2 arm_b{p.bx, p.by};
      const Vec2 arm_a = pair_.of_piece() ? Vec2{} : Vec2{p.ax, p.ay};
      const double vn = dot(hit.n, b_.velocity(t, arm_b) - a_.velocity(t, arm_a));
      hit.parting = std::min(hit.parting, vn);
      if (!(vn < 0)) continue;
      if (!(-vn > slowest)) {
        slow = true;
        continue;
      }
      hit.wait = std::min(hit.wait, -double{p.gap} / vn);
      hit.arm_a[hit.count] = arm_a;
      hit.arm_b[hit.count] = arm_b;
      hit.approach[hit.count++] = vn;
    }
    return hit.count != 0 ? Found::hit : slow ? Found::slow : Found::none;
  }

  // Moves bodies apart that overlap and would hardly part by themselves. Their velocities stay, and so does their energy.
  void part(const Hit& hit, double h) const {
    const double wa = pair_.fixed_a ? 0 : a_.inv_mass, sum = wa + b_.inv_mass;
    const double way = std::min(kPartingShare * hit.depth, kPartingSpeed * h);  // m
    if (!(sum > 0)) return;
    const auto shift = [&](const Mover& m, double by) {
      float* const d = in_.view.disp + 2 * std::size_t{m.slot};
      d[0] = static_cast<float>(double{d[0]} + by * hit.n.x);
      d[1] = static_cast<float>(double{d[1]} + by * hit.n.y);
    };
    if (wa > 0) shift(a_, -way * wa / sum);
    shift(b_, way * b_.inv_mass / sum);
  }

  void bounce(const Hit& hit) {
    const Vec2 t{-hit.n.y, hit.n.x};
    Push push(hit);
    const int k = hit.impulse[1] > hit.impulse[0] ? 1 : 0;  // friction acts at the point that presses most
    const Vec2 between = way_ + b_.way(hit.time) - a_.way(hit.time);
    if (!pair_.of_piece()) in_.virial += dot(push.sum, between);
    const double mu = c_.mu[l_];
    if (mu > 0) {
      Mover a = a_, b = b_;
      a.v = a.v - a.inv_mass * push.sum, a.omega += a.inv_inertia * push.turn_a;
      b.v = b.v + b.inv_mass * push.sum, b.omega += b.inv_inertia * push.turn_b;
      const double vt = dot(t, b.velocity(hit.time, hit.arm_b[k]) - a.velocity(hit.time, hit.arm_a[k])) + belt();
      const double cap = mu * (hit.impulse[0] + hit.impulse[1]);
      push.add(hit, k, std::clamp(-vt / gain(a, b, hit, k, t, k, t), -cap, cap) * t);
    }
    if (!pair_.fixed_a) move(a_, -a_.inv_mass * push.sum, a_.inv_inertia * push.turn_a, hit.time);
    move(b_, b_.inv_mass * push.sum, b_.inv_inertia * push.turn_b, hit.time);
  }

  // Changes the velocity of a body at a time of the substep, and its virtual start with it.
  void move(const Mover& m, Vec2 dv, double spin, double time) const {
    const kernels::BodyView& view = in_.view;
    BodyStore& b = in_.s.bodies;
    const std::size_t i = m.slot;
    const auto add = [](float& to, double what) { to = kernels::snapped(double{to} + what, kernels::kLeastOffset); };
    const double reach = b.radius[i];
    for (float* v : {view.vel, view.vel0}) add(v[2 * i], dv.x), add(v[2 * i + 1], dv.y);
    for (float* u : {view.rim_speed, view.rim_speed0}) add(u[i], reach * spin);
    add(view.disp[2 * i], -time * dv.x);
    add(view.disp[2 * i + 1], -time * dv.y);
    b.angle[i] -= time * spin;
    add(view.angle_change[i], -time * spin);
    const SineCosine q = sine_cosine(view.angle_change[i]);
    view.arm_change[2 * i] = static_cast<float>(reach * (q.cosine - 1));
    view.arm_change[2 * i + 1] = static_cast<float>(reach * q.sine);
    if (view.event_time == nullptr) return;
    view.event_time[i] = std::max(static_cast<float>(time), kernels::kLeastTime);  // 0: no impact yet
  }

  const Around& in_;
  const ManifoldPair& pair_;
  kernels::ManifoldBlock& c_;
  const std::uint32_t l_;
  Mover a_, b_;
  std::optional<Hull> own_a_, own_b_;  // hulls that are made for the pair
  const Hull &hull_b_, &hull_a_;
  Vec2 way_, start_;  // m: from A to B, at the start of the substep and of the step
  double near_ = 0;   // m
};

}  // namespace shape_impact

}  // namespace psim
