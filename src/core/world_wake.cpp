// Who wakes, and why: what moving bodies are about to meet, what the host moves or takes away, and all that leaned on
// it. The rules are in docs/sleeping.md.
#include <algorithm>
#include <cmath>

#include "contact_visit.h"
#include "world_impl.h"

namespace psim {
namespace {

constexpr float kNear = 1.02f;    // of its reach: where a body's neighbours are looked for
constexpr float kDeeper = 0.25f;  // m/s: an impact twice as fast wakes one ring of neighbours more
constexpr std::uint32_t kMostRings = 7;

}  // namespace

// One body back into the columns, at rest where it lay.
void World::Impl::wake_one(std::uint32_t id) {
  BodyInfo& info = bodies.info[id];
  const std::uint32_t k = info.slot;
  const Sleeper s = sleepers.list[k];
  sleepers.list[k] = sleepers.list.back();
  bodies.info[sleepers.list[k].id].slot = k;
  sleepers.list.pop_back();
  sleepers.spoil_pack(k);
  sleepers.spoil_pack(sleepers.list.size());
  --bodies.asleep;
  shapes.take_up(s.first_shape, s.shapes);
  for (std::uint32_t t = s.first_touch; t < s.first_touch + s.touches; ++t) {
    sleepers.recent.add(sleepers.touches[t]);
  }
  bodies.reserve_slots(1);
  const std::size_t slot = bodies.count++;
  info.place = Place::moving;
  bodies.roster_changed = true;
  info.slot = static_cast<std::uint32_t>(slot);
  bodies.pos[2 * slot] = s.at.x;
  bodies.pos[2 * slot + 1] = s.at.y;
  bodies.disp[2 * slot] = s.at.dx;
  bodies.disp[2 * slot + 1] = s.at.dy;
  bodies.vel[2 * slot] = bodies.vel[2 * slot + 1] = 0;
  bodies.id[slot] = id;
  bodies.radius[slot] = bodies.surface(id).radius;
  bodies.linked[slot] = 0;
  bodies.clear_rests(slot);
  if (!bodies.spin.empty()) {
    bodies.spin[slot] = 0;
    bodies.angle[slot] = s.angle;
  }
  sleepers.mark_woken(bodies, lattice, id, s.at.x, s.at.y);
  sleepers.woke = sleepers.changed = true;
  spoil_lists();
  queries.forget_sleeping();
  queries.forget_moving();
}

// Wakes bodies, what is joined to them, and rings of neighbours around them. True if any slept.
bool World::Impl::wake(std::vector<Waking>& queue) {
  bool any = false;
  std::vector<std::uint32_t>& found = sleepers.found;
  const Vec2 g = desc.gravity;
  const double weight = std::sqrt(g.x * g.x + g.y * g.y);
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const Waking now = queue[k];
    if (bodies.info[now.id].place != Place::asleep) continue;
    const Sleeper self = sleepers.list[bodies.info[now.id].slot];
    const LatticePoint at = self.at;
    if (!any) bodies.find_slots();
    wake_one(now.id);
    any = true;
    if (self.group != kNoSlot) {
      for (const Sleeper& s : sleepers.list) {
        if (s.group == self.group) queue.push_back({s.id, now.rings});
      }
    }
    if (!joints.empty()) {
      joints.each_joined(now.id, [&](std::uint32_t other) { queue.push_back({other, now.rings}); });
    }
    if (now.rings == 0) continue;
    found.clear();
    shapes.near(at.x, at.y, kNear * bodies.surface(now.id).radius, found);
    const bool above = now.rings == Waking::kAbove;
    if (above && queue.size() > Sleepers::kMostAbove) continue;
    const float reach = bodies.surface(now.id).radius;
    for (const std::uint32_t shape : found) {
      if (!shapes[shape].asleep) continue;
      const std::uint32_t other = shapes[shape].owner;
      if (above) {  // what may lean on it
        const LatticePoint& place = sleepers.list[bodies.info[other].slot].at;
        const double down = (wrap_sub(place.x, at.x) * lattice.pitch_x() * g.x +
                             wrap_sub(place.y, at.y) * lattice.pitch_y() * g.y);
        if (down > 0.1 * weight * static_cast<double>(reach)) continue;
      }
      queue.push_back({other, above ? Waking::kAbove : now.rings - 1});
    }
  }
  queue.clear();
  if (!any) return false;
  sleepers.tidy();
  if (!joints.empty()) joints.follow_sleep(bodies);
  return true;
}

// Wakes what moving bodies touch, or will within the next frame.
bool World::Impl::wake_reached(double dt) {
  std::vector<Waking>& queue = sleepers.queue;
  const auto frame_s = static_cast<float>(dt) * kClosing;
  const auto rings = [&](std::size_t slot, std::uint32_t hit) {
    const float mine = bodies.surface(bodies.id[slot]).mass, theirs = bodies.surface(hit).mass;
    float speed = speed_of(slot) * std::fmin(std::fmax(mine / theirs, 1.0f), 1000.0f);
    std::uint32_t n = 0;
    for (; speed > kDeeper && n < kMostRings; speed /= 2) ++n;
    return n;
  };
  each_contact([&](const Met& met) {
    if (met.a != kNoSlot || met.shape >= kWallLeft) return;
    const StaticShape& shape = shapes[met.shape];
    if (!shape.asleep || !shape.alive) return;
    const std::size_t i = met.b;
    float gap = met.gap;
    const float way = speed_of(i) * frame_s;
    if (!shape.segment && !shape.whole) {
      const auto x = static_cast<float>(wrap_sub(bodies.pos[2 * i], shape.p.x) * lattice.pitch_x());
      const auto y = static_cast<float>(wrap_sub(bodies.pos[2 * i + 1], shape.p.y) * lattice.pitch_y());
      gap = std::sqrt(x * x + y * y) - bodies.radius[i] - shape.radius;
    } else {
      gap -= way;  // it is of the frame's start
    }
    if (gap > way + Sleepers::ball(bodies.radius[i])) return;
    const bool loose = sleepers.list[bodies.info[shape.owner].slot].loose;
    if (sleepers.moves(bodies, lattice, i, loose)) queue.push_back({shape.owner, rings(i, shape.owner)});
  });
  if (!held.empty()) {
    bodies.find_slots();
    for (const auto& [id, velocity] : held) {
      const std::size_t i = bodies.info[id].slot;
      const float speed = speed_of(i);
      if (speed == 0 || bodies.make(id).sensor) continue;
      wake_around(bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.radius[i] + speed * frame_s, 0);
    }
  }
  return wake(queue);
}

// Asks for the sleepers whose box a square of half width `reach`, m, meets.
void World::Impl::wake_around(std::int32_t x, std::int32_t y, float reach, std::uint32_t rings) {
  sleepers.found.clear();
  shapes.near(x, y, kNear * reach, sleepers.found);
  for (const std::uint32_t shape : sleepers.found) {
    if (shapes[shape].asleep) sleepers.queue.push_back({shapes[shape].owner, rings});
  }
}

// Contacts of moving bodies with those that woke are pairs from now on.
void World::Impl::carry_woken() {
  if (!sleepers.woke) return;
  sleepers.woke = false;
  if (!impulses_valid) return;
  if (manifolds.any()) manifolds.keep_impulses(pool);
  each_contact([&](const Met& met) {
    if (met.a != kNoSlot || !met.bears || met.shape >= kWallLeft) return;
    if (!shapes[met.shape].asleep || shapes[met.shape].alive) return;
    Touch touch = met.touch;
    touch.key = key_of(met, bodies, shapes);
    sleepers.recent.add(touch);
  });
}

// The host is about to move or push a body.
void World::Impl::rouse(std::uint32_t id) {
  if (bodies.info[id].place == Place::asleep) {
    sleepers.queue.push_back({id, 0});
    wake(sleepers.queue);
  }
  sleepers.mark_moving(id);
}

// Something that stood at a place is gone, or goes: what leaned on it falls.
void World::Impl::rouse_around(const BodyInfo& info, std::uint32_t id) {
  if (sleepers.empty()) return;
  if (info.place == Place::moving) {
    const std::size_t i = info.slot;
    wake_around(bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.radius[i], Waking::kAbove);
  } else if (info.place == Place::asleep) {
    sleepers.queue.push_back({id, 0});
    const LatticePoint at = sleepers.list[info.slot].at;
    wake_around(at.x, at.y, bodies.surface(id).radius, Waking::kAbove);
  } else if (info.place == Place::fixed) {
    wake_touching_pieces(fixed[info.slot].first_shape, id);
  }
  wake(sleepers.queue);
}

// Sleepers that touch the pieces of a static body.
void World::Impl::wake_touching_pieces(std::uint32_t first, std::uint32_t owner) {
  const double px = lattice.pitch_x(), py = lattice.pitch_y();
  for (const Sleeper& s : sleepers.list) {
    const double reach = static_cast<double>(kNear * bodies.surface(s.id).radius);
    bool touches = false;
    for (std::uint32_t k = first; k < shapes.size() && shapes[k].owner == owner && shapes[k].alive; ++k) {
      const StaticShape& piece = shapes[k];
      const double ax = wrap_sub(s.at.x, piece.p.x) * px, ay = wrap_sub(s.at.y, piece.p.y) * py;
      double x = ax, y = ay, round = static_cast<double>(piece.radius);
      if (piece.segment) {
        const double ux = wrap_sub(piece.q.x, piece.p.x) * px, uy = wrap_sub(piece.q.y, piece.p.y) * py;
        const double share = std::fmin(std::fmax((ax * ux + ay * uy) / (ux * ux + uy * uy), 0), 1);
        x = ax - share * ux;
        y = ay - share * uy;
      } else if (piece.whole) {
        round = static_cast<double>(shapes.hull(piece).reach);
      }
      touches = touches || x * x + y * y <= (reach + round) * (reach + round);
    }
    if (touches) sleepers.queue.push_back({s.id, Waking::kAbove});
  }
}

void World::Impl::wake_all() {
  for (const Sleeper& s : sleepers.list) sleepers.queue.push_back({s.id, 0});
  std::sort(sleepers.queue.begin(), sleepers.queue.end(),
            [](const Waking& a, const Waking& b) { return a.id < b.id; });
  wake(sleepers.queue);
}

bool World::set_gravity(Vec2 gravity) {
  Impl& w = *impl_;
  if (!std::isfinite(gravity.x) || !std::isfinite(gravity.y)) return false;
  if (gravity.x == w.desc.gravity.x && gravity.y == w.desc.gravity.y) return true;
  w.settle_lists();
  if (w.ahead.part != Part::check) w.spoil_lists();  // made for the gravity of before
  w.desc.gravity = gravity;
  w.traits.gravity = gravity.x != 0 || gravity.y != 0;
  w.forces.reset();
  w.plan_stale = w.forces_stale = true;
  w.wake_all();
  return true;
}

void World::set_sleeping(bool on) {
  Impl& w = *impl_;
  if (on == w.desc.sleeping) return;
  w.settle_lists();
  w.desc.sleeping = w.traits.sleeping = on;
  w.plan_stale = true;
  if (!on) w.wake_all();
}

bool World::is_awake(BodyId id) const {
  return is_valid(id) && impl_->bodies.info[id.index].place == Place::moving;
}

bool World::wake(BodyId id) {
  if (!is_valid(id)) return false;
  impl_->settle_lists();
  impl_->sleepers.queue.push_back({id.index, 0});
  impl_->wake(impl_->sleepers.queue);
  return true;
}

}  // namespace psim
