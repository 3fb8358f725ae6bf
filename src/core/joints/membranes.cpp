#include "joints/membranes.h"

#include <algorithm>
#include <cstddef>

#include "base/column.h"
#include "base/elementary.h"
#include "least.h"

namespace psim {
namespace {

constexpr std::size_t kMembranesOfJob = 512, kRingsOfJob = 8;
// A push that moves an end against the other by more than this share of the way between them in the time of a pass is
// cut down to it: beyond it, pressure would throw bodies about from substep to substep.
constexpr double kMostShare = 0.25;

// A ring keeps its area like a damped spring, with (w h)^2 = kRingStiffness and each half of a substep taking the share
// kRingDamping of the speed: of what is off, (1 - kRingDamping)^2 is left after a substep. It is stable up to 3.3.
constexpr double kRingStiffness = 1.6, kRingDamping = 0.6;
constexpr std::uint32_t kNothing = kNoSlot, kSeveral = kNothing - 1;  // of begins_

Vec2 vec2_at(const float* of, std::uint32_t body) {
  const std::size_t k = 2 * std::size_t{body};
  return {static_cast<double>(of[k]), static_cast<double>(of[k + 1])};
}

Vec2 arm_now(const kernels::BodyView& view, const MembraneEnd& end) {
  if (view.arm_change == nullptr || (end.arm.x == 0 && end.arm.y == 0)) return end.arm;
  const Vec2 change = end.inverse_radius * vec2_at(view.arm_change, end.body);
  return turned({.sine = change.y, .cosine = 1 + change.x}, end.arm);
}

void find_anchor(const kernels::BodyView& view, MembraneEnd& end) {
  const Vec2 arm = arm_now(view, end);
  end.off = vec2_at(view.disp, end.body) + arm;
  end.velocity = vec2_at(view.vel, end.body);
  if (view.rim_speed == nullptr) return;
  const double omega = static_cast<double>(view.rim_speed[end.body]) * end.inverse_radius;
  end.velocity = end.velocity + omega * upright(arm);
}

// N: what a wind does to a membrane of which the middle moves at `velocity`.
Vec2 blown(const WindField& wind, const Membrane& m, double length, Vec2 velocity) {
  const Vec2 air = wind.velocity - velocity;
  const double speed = length_of(air);
  if (!(speed > 0)) return {};
  const Vec2 along = (1 / speed) * air;
  Vec2 lee = (1 / length) * upright(m.way);  // the side that faces away from the wind
  double facing = dot(lee, along);
  if (facing < 0) lee = -1.0 * lee, facing = -facing;
  const double force = 0.5 * wind.density * length * facing * speed * speed;
  return force * (m.drag * along + m.lift * (lee - facing * along));
}

// Adds a push to the velocities of the body of an end, before the kick and now.
void push_end(const kernels::BodyView& view, const MembraneEnd& end, Vec2 push) {
  if (end.inverse_mass == 0) return;
  const std::size_t k = 2 * std::size_t{end.body};
  const auto add = [](float& to, double x) { to = kernels::snapped(static_cast<double>(to) + x); };
  const Vec2 change = end.inverse_mass * push;
  add(view.vel[k], change.x), add(view.vel[k + 1], change.y);
  add(view.vel0[k], change.x), add(view.vel0[k + 1], change.y);
  if (end.inverse_inertia == 0 || view.rim_speed == nullptr || (end.arm.x == 0 && end.arm.y == 0)) return;
  const double spin = end.inverse_inertia * cross(arm_now(view, end), push) / end.inverse_radius;
  add(view.rim_speed[end.body], spin);
  add(view.rim_speed0[end.body], spin);
}

}  // namespace

void Membranes::add(std::uint32_t joint, const std::uint32_t (&member)[2], std::uint32_t from, bool bounds) {
  Membrane m;
  m.joint = joint;
  m.member[0] = member[0], m.member[1] = member[1];
  m.from = from;
  m.bounds = bounds;
  all_.push_back(m);
}

void Membranes::lay_out(std::size_t members) {
  if (all_.empty()) return;
  crowds_.assign(members, 0);
  begins_.assign(members, kNothing);
  in_rings_.reserve(all_.size());
  rings_.reserve(all_.size());
  for (const Membrane& m : all_) ++crowds_[m.member[0]], ++crowds_[m.member[1]];
  for (std::uint32_t n = 0; n < all_.size(); ++n) {
    Membrane& m = all_[n];
    m.crowd[0] = crowds_[m.member[0]], m.crowd[1] = crowds_[m.member[1]];
    if (!m.bounds) continue;
    std::uint32_t& begins = begins_[m.member[m.from]];
    begins = begins == kNothing ? n : kSeveral;
  }
  for (std::uint32_t n = 0; n < all_.size(); ++n) {
    if (all_[n].bounds && all_[n].walk == kNothing) walk_from(n);
  }
}

// Follows the way from a membrane on, until it ends or comes to where some walk was. If that was this walk, what lies
// behind is a ring. Each membrane is in one walk.
void Membranes::walk_from(std::uint32_t first) {
  const auto begin = static_cast<std::ptrdiff_t>(in_rings_.size());
  std::uint32_t n = first;
  while (n < kSeveral && all_[n].walk == kNothing) {
    all_[n].walk = first;
    in_rings_.push_back(n);
    n = begins_[all_[n].member[1 - all_[n].from]];
  }
  const bool ring = n < kSeveral && all_[n].walk == first;
  const auto from = ring ? std::find(in_rings_.begin() + begin, in_rings_.end(), n) : in_rings_.end();
  in_rings_.erase(in_rings_.begin() + begin, in_rings_.end() - from < 3 ? in_rings_.end() : from);
  const auto end = static_cast<std::uint32_t>(in_rings_.size());
  if (end != static_cast<std::uint32_t>(begin)) rings_.push_back({static_cast<std::uint32_t>(begin), end});
}

void Membranes::set_wind(const std::vector<Field>& fields) {
  winds_.clear();
  bool catches = false;
  for (const Membrane& m : all_) catches = catches || m.drag > 0 || m.lift > 0;
  if (!catches) return;
  for (const Field& field : fields) {
    if (const auto* wind = std::get_if<WindField>(&field)) winds_.push_back(*wind);
  }
}

// Finds where a membrane is, and what its own pressure and the wind push.
void Membranes::stretch(const kernels::BodyView& view, Membrane& m, double time) const {
  m.push = m.gap_push = {};
  MembraneEnd &a = m.end[0], &b = m.end[1];
  find_anchor(view, a);
  find_anchor(view, b);
  m.way = m.base + (b.off - a.off);
  const double length = length_of(m.way);
  if (!(length > 0)) return;
  const double rate = greater(a.rate, b.rate), most = kMostShare / (rate * time);
  m.push = -lesser(greater(0.5 * m.pressure * time, -most), most) * upright(m.way);
  const Vec2 middle = a.at + a.off + 0.5 * m.way, velocity = 0.5 * (a.velocity + b.velocity);
  for (const WindField& wind : winds_) {
    if (wind.region && !contains(*wind.region, middle)) continue;
    const Vec2 force = blown(wind, m, length, velocity);
    const double size = length_of(force);
    if (!(size > 0)) continue;
    // However strong the wind, nothing gets faster than it.
    const double longest = length_of(wind.velocity - velocity) / (rate * size);
    m.push = m.push + 0.5 * lesser(time, longest) * force;
  }
}

// The inside of a ring pushes outwards with pressure = stiffness (rest - area) + damping shrinking. With the gradient g of the area by
// the places of the bodies, of inverse masses w, the area A follows A'' = pressure sum(g^2 w): the stiffness is that of the
// angular frequency w = sqrt(kRingStiffness)/h.
void Membranes::press_ring(BlockRange ring, double time) {
  const auto membrane = [&](std::uint32_t k) -> Membrane& { return all_[in_rings_[k < ring.end ? k : ring.begin]]; };
  Vec2 at;  // the place on the way round, from where it begins
  double rest = 0, area = 0, shrinking = 0, weight = 0, rate = 0;
  for (std::uint32_t k = ring.begin; k < ring.end; ++k) {
    const Membrane &m = membrane(k), &next = membrane(k + 1);
    const MembraneEnd &last = m.last(), &begin = next.first();
    const Vec2 way = m.way_on(), gap = (begin.at - last.at) + (begin.off - last.off);
    const Vec2 corner = at + way, behind = corner + gap;
    area += 0.5 * (cross(at, corner) + cross(corner, behind));
    shrinking += 0.5 * (cross(way, m.first().velocity + last.velocity) + cross(gap, last.velocity + begin.velocity));
    at = behind;
    rest += m.area;
    const double of_body = greater(last.rate / m.crowd[1 - m.from], begin.rate / next.crowd[next.from]);
    const Vec2 gradient = 0.5 * (way + gap + gap + next.way_on());
    weight += of_body * dot(gradient, gradient);
    rate = greater(rate, of_body);
  }
  if (!(weight > 0)) return;
  const double h = 2 * time, most = kMostShare / (rate * time);
  const double pressure = (kRingStiffness * (rest - area) / h + 2 * kRingDamping * shrinking) / (h * weight);
  const double push = lesser(greater(0.5 * pressure * time, -most), most);
  for (std::uint32_t k = ring.begin; k < ring.end; ++k) {
    Membrane& m = membrane(k);
    const MembraneEnd &last = m.last(), &begin = membrane(k + 1).first();
    m.push = m.push - push * upright(m.way_on());
    m.gap_push = -push * upright((begin.at - last.at) + (begin.off - last.off));
  }
}

void Membranes::press(const kernels::BodyView& view, double time, WorkerPool& pool) {
  run_each(all_.size(), kMembranesOfJob, pool, [&](std::size_t n, std::size_t) { stretch(view, all_[n], time); });
  run_each(rings_.size(), kRingsOfJob, pool, [&](std::size_t n, std::size_t) { press_ring(rings_[n], time); });
  for (const Membrane& m : all_) {
    push_end(view, m.end[0], m.push);
    push_end(view, m.end[1], m.push);
  }
  for (const BlockRange ring : rings_) {
    for (std::uint32_t k = ring.begin; k < ring.end; ++k) {
      const Membrane &m = all_[in_rings_[k]], &next = all_[in_rings_[k + 1 < ring.end ? k + 1 : ring.begin]];
      if (m.gap_push == Vec2{}) continue;
      push_end(view, m.last(), m.gap_push);
      push_end(view, next.first(), m.gap_push);
    }
  }
}

std::size_t Membranes::bytes() const { return bytes_of(all_, crowds_, begins_, in_rings_, rings_, winds_); }

void Membranes::release() { give_back(all_, crowds_, begins_, in_rings_, rings_, winds_); }

}  // namespace psim
