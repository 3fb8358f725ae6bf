// Who wakes: bodies that moving ones are about to meet, bodies that the host moves or takes away, and all that leaned
// on them. Each caller fills the queue of those to wake; wake_queued() empties it.
#include <algorithm>
#include <cmath>

#include "sleep/sleep.h"
#include "sleep/sleep_contacts.h"

namespace psim {
namespace {

constexpr float kNear = 1.02f;    // neighbours are looked for within this many times the reach of a body
constexpr float kDeeper = 0.25f;  // m/s: an impact twice as fast wakes one ring of neighbours more
constexpr std::uint32_t kMostRings = 7;

// The rings of neighbours that wake with a body when another one hits it at `speed`.
std::uint32_t rings_of(float speed, float mass, float hit_mass) {
  speed *= std::fmin(std::fmax(mass / hit_mass, 1.0f), 1000.0f);
  std::uint32_t n = 0;
  for (; speed > kDeeper && n < kMostRings; speed /= 2) ++n;
  return n;
}

// Whether a disc at `at` with radius `reach` touches a fixed shape.
bool touches(const LatticePoint& at, double reach, const StaticShape& shape, const StaticShapes& statics,
             const Lattice& lattice) {
  const double px = lattice.pitch_x(), py = lattice.pitch_y();
  const double ax = wrap_sub(at.x, shape.p.x) * px, ay = wrap_sub(at.y, shape.p.y) * py;
  double x = ax, y = ay, round = static_cast<double>(shape.radius);
  if (shape.segment) {
    const double ux = wrap_sub(shape.q.x, shape.p.x) * px, uy = wrap_sub(shape.q.y, shape.p.y) * py;
    const double share = std::fmin(std::fmax((ax * ux + ay * uy) / (ux * ux + uy * uy), 0), 1);
    x = ax - share * ux;
    y = ay - share * uy;
  } else if (shape.whole) {
    round = static_cast<double>(statics.hull(shape).reach);
  }
  return x * x + y * y <= (reach + round) * (reach + round);
}

}  // namespace

// Brings a body back into the columns, at rest where it lay.
void Sleep::wake_one(const SleepSource& source, std::uint32_t id) {
  BodyStore& bodies = source.population.bodies;
  const std::uint32_t k = bodies.info[id].slot;
  const Sleeper s = sleepers.list[k];
  sleepers.list[k] = sleepers.list.back();
  bodies.info[sleepers.list[k].id].slot = k;
  sleepers.list.pop_back();
  source.population.statics.remove_sleeping(s.first_shape, s.pieces);
  for (std::uint32_t t = s.first_touch; t < s.first_touch + s.touches; ++t) sleepers.recent.add(sleepers.touches[t]);
  bodies.enter(id, s.at, s.angle);
  sleepers.mark_woken(id, s.at);
  sleepers.woke = sleepers.changed = true;
}

// Wakes the bodies of the queue, those that are stacked or joined with them, and rings of neighbours around them.
bool Sleep::wake_queued(const SleepSource& source) {
  BodyStore& bodies = source.population.bodies;
  std::vector<Waking>& queue = sleepers.queue;
  bool any = false;
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const Waking now = queue[k];
    if (bodies.info[now.id].place != Place::asleep) continue;
    const Sleeper self = sleepers.list[bodies.info[now.id].slot];
    if (!any) bodies.find_slots();
    wake_one(source, now.id);
    any = true;
    ask_joined_and_stacked(source, self, now.rings);
    if (now.rings != 0) ask_neighbours(source, self.at, now.id, now.rings);
  }
  queue.clear();
  if (!any) return false;
  sleepers.tidy();
  if (!source.joints.empty()) source.joints.follow_sleep(bodies);
  return true;
}

void Sleep::ask_joined_and_stacked(const SleepSource& source, const Sleeper& woken, std::uint32_t rings) {
  if (woken.group != kNoSlot) {
    for (const Sleeper& s : sleepers.list) {
      if (s.group == woken.group) sleepers.queue.push_back({s.id, rings});
    }
  }
  if (source.joints.empty()) return;
  source.joints.each_joined(woken.id, [&](std::uint32_t other) { sleepers.queue.push_back({other, rings}); });
}

// Queues the sleeping neighbours of a body that lay at `at`: one ring of them, or those that may lean on it.
void Sleep::ask_neighbours(const SleepSource& source, const LatticePoint& at, std::uint32_t id, std::uint32_t rings) {
  const BodyStore& bodies = source.population.bodies;
  const StaticShapes& statics = source.population.statics;
  const Lattice& lattice = source.lattice;
  const Vec2 g = source.gravity;
  const double weight = length_of(g);
  const float reach = bodies.properties(id).radius;
  const bool above = rings == Waking::kAbove;
  if (above && sleepers.queue.size() > Sleepers::kMostAbove) return;
  sleepers.found.clear();
  statics.near(at.x, at.y, kNear * reach, sleepers.found);
  for (const std::uint32_t shape : sleepers.found) {
    if (!statics[shape].asleep) continue;
    const std::uint32_t other = statics[shape].owner;
    if (above) {
      const LatticePoint& place = sleepers.list[bodies.info[other].slot].at;
      const double down =
          (wrap_sub(place.x, at.x) * lattice.pitch_x() * g.x + wrap_sub(place.y, at.y) * lattice.pitch_y() * g.y);
      if (down > 0.1 * weight * static_cast<double>(reach)) continue;  // it lies below
    }
    sleepers.queue.push_back({other, above ? Waking::kAbove : rings - 1});
  }
}

bool Sleep::wake_reached(const SleepSource& source, double dt) {
  const Population& population = source.population;
  const BodyStore& bodies = population.bodies;
  const Lattice& lattice = source.lattice;
  const auto frame_s = static_cast<float>(dt) * kClosing;
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != kNoSlot || contact.shape >= kWallLeft) return;
    const StaticShape& shape = population.statics[contact.shape];
    if (!shape.asleep || !shape.alive) return;
    const std::size_t i = contact.b;
    float gap = contact.gap;
    const float speed = population.speed_of(i), way = speed * frame_s;
    if (!shape.segment && !shape.whole) {
      const auto x = static_cast<float>(wrap_sub(bodies.pos[2 * i], shape.p.x) * lattice.pitch_x());
      const auto y = static_cast<float>(wrap_sub(bodies.pos[2 * i + 1], shape.p.y) * lattice.pitch_y());
      gap = std::sqrt(x * x + y * y) - bodies.radius[i] - shape.radius;
    } else {
      gap -= way;  // the gap is that of the start of the frame
    }
    if (gap > way + Sleepers::ball(bodies.radius[i])) return;
    if (!sleepers.moves(i, sleepers.list[bodies.info[shape.owner].slot].creeps)) return;
    const float mass = bodies.properties(bodies.id[i]).mass, hit_mass = bodies.properties(shape.owner).mass;
    sleepers.queue.push_back({shape.owner, rings_of(speed, mass, hit_mass)});
  });
  if (!population.kinematics.empty()) {
    bodies.find_slots();
    for (const auto& [id, velocity] : population.kinematics) {
      const std::size_t i = bodies.info[id].slot;
      const float speed = population.speed_of(i);
      if (speed == 0 || bodies.kind(id).sensor) continue;
      ask_around(source, bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.radius[i] + speed * frame_s, 0);
    }
  }
  return wake_queued(source);
}

// Queues the sleepers whose box a square of half width `reach`, m, meets.
void Sleep::ask_around(const SleepSource& source, std::int32_t x, std::int32_t y, float reach, std::uint32_t rings) {
  const StaticShapes& statics = source.population.statics;
  sleepers.found.clear();
  statics.near(x, y, kNear * reach, sleepers.found);
  for (const std::uint32_t shape : sleepers.found) {
    if (statics[shape].asleep) sleepers.queue.push_back({statics[shape].owner, rings});
  }
}

void Sleep::keep_touches_of_woken(const SleepSource& source, bool impulses_valid) {
  if (!sleepers.woke) return;
  sleepers.woke = false;
  if (!impulses_valid) return;
  const Population& population = source.population;
  const StaticShapes& statics = population.statics;
  if (source.manifolds.any()) source.manifolds.keep_impulses(source.pool);
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != kNoSlot || !contact.loaded || contact.shape >= kWallLeft) return;
    if (!statics[contact.shape].asleep || statics[contact.shape].alive) return;
    Touch touch = contact.touch;
    touch.key = key_of(contact, population.bodies, statics);
    sleepers.recent.add(touch);
  });
}

bool Sleep::disturb(const SleepSource& source, std::uint32_t id) {
  const bool woke = source.population.bodies.info[id].place == Place::asleep && wake_body(source, id);
  sleepers.mark_moving(id);
  return woke;
}

bool Sleep::disturb_neighbours(const SleepSource& source, std::uint32_t id) {
  if (sleepers.empty()) return false;
  const BodyStore& bodies = source.population.bodies;
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::moving) {
    const std::size_t i = info.slot;
    ask_around(source, bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.radius[i], Waking::kAbove);
  } else if (info.place == Place::asleep) {
    sleepers.queue.push_back({id, 0});
    const LatticePoint at = sleepers.list[info.slot].at;
    ask_around(source, at.x, at.y, bodies.properties(id).radius, Waking::kAbove);
  } else if (info.place == Place::fixed) {
    return disturb_at_fixed(source, id);
  }
  return wake_queued(source);
}

bool Sleep::disturb_at_fixed(const SleepSource& source, std::uint32_t id) {
  if (sleepers.empty()) return false;
  const BodyStore& bodies = source.population.bodies;
  const StaticShapes& statics = source.population.statics;
  const std::uint32_t first = source.population.fixed[bodies.info[id].slot].first_shape;
  for (const Sleeper& s : sleepers.list) {
    const double reach = static_cast<double>(kNear * bodies.properties(s.id).radius);
    bool touched = false;
    for (std::uint32_t k = first; k < statics.size() && statics[k].owner == id && statics[k].alive; ++k) {
      touched = touched || touches(s.at, reach, statics[k], statics, source.lattice);
    }
    if (touched) sleepers.queue.push_back({s.id, Waking::kAbove});
  }
  return wake_queued(source);
}

bool Sleep::wake_body(const SleepSource& source, std::uint32_t id) {
  sleepers.queue.push_back({id, 0});
  return wake_queued(source);
}

bool Sleep::wake_all(const SleepSource& source) {
  for (const Sleeper& s : sleepers.list) sleepers.queue.push_back({s.id, 0});
  // Total order: a body sleeps once, and the queue was empty.
  std::sort(sleepers.queue.begin(), sleepers.queue.end(), [](const Waking& a, const Waking& b) { return a.id < b.id; });
  return wake_queued(source);
}

}  // namespace psim
