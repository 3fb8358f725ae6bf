// Who wakes: bodies that moving ones are about to meet, bodies that the host moves or takes away, and all that leaned
// on them. Each caller fills the queue of those to wake; wake_queued() empties it.
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/elementary.h"
#include "base/room.h"
#include "base/sort_keys.h"
#include "sleep/sleep.h"
#include "sleep/sleep_contacts.h"

namespace psim {
namespace {

constexpr float kNear = 1.02f;    // neighbours are looked for within this many times the reach of a body
constexpr float kDeeper = 0.25f;  // m/s: an impact twice as fast wakes one ring of neighbours more
constexpr std::uint32_t kMostRings = 7;
// Share of its weight, or of its largest load, by which the load of a sleeper may change.
constexpr double kReload = 0.5;

// The rings of neighbours that wake with a body when another one hits it at `speed`.
std::uint32_t rings_of(float speed, float mass, float hit_mass) {
  speed *= lesser(greater(mass / hit_mass, 1.0f), 1000.0f);
  std::uint32_t n = 0;
  for (; speed > kDeeper && n < kMostRings; speed /= 2) ++n;
  return n;
}

// Whether a disc at `at` with radius `reach` touches a fixed shape.
bool touches(const LatticePoint& at, double reach, const StaticShape& shape, const StaticShapes& statics,
             const Lattice& lattice) {
  Vec2 way = lattice.steps(shape.p, at);
  double round = static_cast<double>(shape.radius);
  if (shape.segment) {
    const Vec2 along = lattice.steps(shape.p, shape.q);
    way = way - lesser(greater(dot(way, along) / dot(along, along), 0), 1) * along;
  } else if (shape.whole) {
    round = static_cast<double>(statics.hull(shape).reach);
  }
  return dot(way, way) <= (reach + round) * (reach + round);
}

// A sleeper goes out of the list.
void leave_list(BodyStore& bodies, Sleepers& sleepers, std::uint32_t id) {
  const std::uint32_t k = bodies.info[id].slot;
  sleepers.dropped += sleepers.list[k].touches;
  sleepers.list[k] = sleepers.list.back();
  bodies.info[sleepers.list[k].id].slot = k;
  sleepers.list.pop_back();
}

// Brings a body back into the columns, at rest where it lay.
void wake_one(const SleepSource& source, Sleepers& sleepers, std::uint32_t id) {
  BodyStore& bodies = source.population.bodies;
  const Sleeper s = sleepers.list[bodies.info[id].slot];
  // All room is made before anything changes: if there is none, the body stays asleep.
  bodies.reserve_slots(1);
  source.population.statics.make_room_to_leave(1, false);
  sleepers.recent.make_room_for_more(s.touches);
  leave_list(bodies, sleepers, id);
  source.population.statics.remove_sleeping(s.first_shape, s.pieces);
  for (std::uint32_t t = s.first_touch; t < s.first_touch + s.touches; ++t) sleepers.recent.add(sleepers.touches[t]);
  bodies.enter(id, s.at, s.angle);
  sleepers.mark_woken(id, s.at, s.angle);
  sleepers.woke = sleepers.changed = true;
  ++sleepers.changes;
}

// N s: with what the points of a touch press together. `mass` is that of discs where all have the same.
double impulse_of(const Touch& touch, float mass) {
  double sum = 0;
  for (std::uint32_t k = 0; k < touch.points; ++k) sum += static_cast<double>(touch.impulse[k]);
  return sum * static_cast<double>(touch.times(false, mass));
}

// Queues those that are stacked or joined with a body that woke.
void ask_joined_and_stacked(const SleepSource& source, Sleepers& sleepers, const Sleeper& woken, std::uint32_t rings) {
  if (woken.group != kNoSlot) {
    for (const Sleeper& s : sleepers.list) {
      if (s.group == woken.group) sleepers.queue.push_back({s.id, rings});
    }
  }
  if (source.joints.empty()) return;
  source.joints.each_joined(woken.id, [&](std::uint32_t other) {
    if (!is_world(other)) sleepers.queue.push_back({other, rings});
  });
}

// Queues those that are stacked with bodies that go: all of their groups.
void ask_stacked(Sleepers& sleepers, std::span<const std::uint32_t> going, const BodyStore& bodies) {
  std::vector<std::uint32_t>& groups = sleepers.roots;
  groups.clear();
  for (const std::uint32_t id : going) {
    const std::uint32_t group = sleepers.list[bodies.info[id].slot].group;
    if (group != kNoSlot) groups.push_back(group);
  }
  if (groups.empty()) return;
  sort_keys(groups.begin(), groups.end());
  for (const Sleeper& s : sleepers.list) {
    if (!s.goes && std::binary_search(groups.begin(), groups.end(), s.group)) {
      sleepers.queue.push_back({s.id, Waking::kAbove});
    }
  }
}

// Calls each(body) for the sleepers whose box a square of half width `reach`, m, meets.
template <class Each>
void each_sleeper_near(const SleepSource& source, Sleepers& sleepers, const LatticePoint& at, float reach,
                       const Each& each) {
  const StaticShapes& statics = source.population.statics;
  sleepers.found.clear();
  statics.near(at.x, at.y, kNear * reach, sleepers.found);
  for (const std::uint32_t shape : sleepers.found) {
    if (statics[shape].asleep) each(statics[shape].owner);
  }
}

void ask_around(const SleepSource& source, Sleepers& sleepers, const LatticePoint& at, float reach,
                std::uint32_t rings) {
  each_sleeper_near(source, sleepers, at, reach, [&](std::uint32_t id) { sleepers.queue.push_back({id, rings}); });
}

// Queues the sleepers that may lean on a body.
void ask_above(const SleepSource& source, Sleepers& sleepers, const Sleeper& of) {
  const BodyStore& bodies = source.population.bodies;
  const float reach = bodies.properties(of.id).radius;
  const Vec2 g = source.gravity;
  each_sleeper_near(source, sleepers, of.at, reach, [&](std::uint32_t id) {
    const Vec2 way = source.lattice.steps(of.at, sleepers.list[bodies.info[id].slot].at);
    const bool below = dot(way, g) > 0.1 * length_of(g) * static_cast<double>(reach);
    if (!below) sleepers.queue.push_back({id, Waking::kAbove});
  });
}

// Wakes the bodies of the queue, those that are stacked or joined with them, and rings of neighbours around them.
bool wake_queued(const SleepSource& source, Sleepers& sleepers) {
  BodyStore& bodies = source.population.bodies;
  std::vector<Waking>& queue = sleepers.queue;
  const std::size_t most_above = std::max(Sleepers::kMostAbove, 2 * queue.size());
  bool any = false;
  or_else([&] { queue.clear(); },
          [&] {
            for (std::size_t k = 0; k < queue.size(); ++k) {
              const Waking now = queue[k];
              if (bodies.info[now.id].place != Place::asleep) continue;
              const Sleeper self = sleepers.list[bodies.info[now.id].slot];
              if (self.goes) continue;
              if (!any) bodies.find_slots();
              wake_one(source, sleepers, now.id);
              if (!source.joints.empty()) source.joints.follow(now.id);
              any = true;
              ask_joined_and_stacked(source, sleepers, self, now.rings);
              if (now.rings == Waking::kAbove) {
                if (queue.size() <= most_above) ask_above(source, sleepers, self);
              } else if (now.rings != 0) {
                ask_around(source, sleepers, self.at, bodies.properties(now.id).radius, now.rings - 1);
              }
            }
            if (any) sleepers.tidy();
          });
  queue.clear();
  return any;
}

// The least gap, m, that the shape of a body may have now to a piece of fixed geometry from which it was apart when the
// hulls were looked at: what is left of that gap after all that the body moved and turned since.
double gap_left(const SleepSource& source, const ManifoldPair& pair) {
  const BodyStore& b = source.population.bodies;
  const double moved = length_of(source.lattice.way(pair.base, b.point(pair.b)));
  double turned = 0;
  if (!b.angle.empty()) {
    const Rotor now = rotor_of(b.angle[pair.b]), then = pair.turn_b;
    turned = length_of(Vec2{static_cast<double>(now.c - then.c), static_cast<double>(now.s - then.s)});
  }
  return static_cast<double>(pair.gap[0]) - moved - turned * static_cast<double>(b.radius[pair.b]);
}

}  // namespace

bool Sleep::wake_reached(const SleepSource& source, double dt) {
  const Population& population = source.population;
  const BodyStore& bodies = population.bodies;
  const auto frame_s = static_cast<float>(dt) * kClosing;
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != kNoSlot || contact.shape >= kWallLeft) return;
    const StaticShape& shape = population.statics[contact.shape];
    if (!shape.asleep || !shape.alive) return;
    const std::size_t i = contact.b;
    float gap = contact.gap;
    const float speed = population.speed_of(i), way = speed * frame_s;
    if (!shape.segment && !shape.whole) {
      const Vec2 between = source.lattice.steps(shape.p, bodies.point(i));
      const auto x = static_cast<float>(between.x), y = static_cast<float>(between.y);
      gap = std::sqrt(x * x + y * y) - bodies.radius[i] - shape.radius;
    } else {
      gap -= way;  // the gap is that of the start of the frame
    }
    const float near = way + Sleepers::ball(bodies.radius[i]);
    if (gap > near) return;
    if (contact.pair != nullptr && contact.pair->is_apart() && gap_left(source, *contact.pair) > near) return;
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
      ask_around(source, sleepers, bodies.point(i), bodies.radius[i] + speed * frame_s, 0);
    }
  }
  return wake_queued(source, sleepers);
}

bool Sleep::wake_reloaded(const SleepSource& source, double dt) {
  const BodyStore& bodies = source.population.bodies;
  const StaticShapes& statics = source.population.statics;
  const auto mass_of = [&](std::uint32_t slot) { return bodies.properties(bodies.id[slot]).mass; };
  if (source.contacts.manifolds.any()) source.contacts.manifolds.keep_impulses();
  std::vector<Press>& presses = sleepers.presses;
  presses.clear();
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != kNoSlot || contact.shape >= kWallLeft) return;
    const StaticShape& shape = statics[contact.shape];
    if (!shape.asleep || !shape.alive) return;
    const double force = impulse_of(contact.touch, mass_of(contact.b)) * source.substeps / dt;
    presses.push_back({touch_of(contact, bodies, statics).key, shape.owner, contact.b, contact.loaded ? force : 0});
  });
  // A body may touch several pieces of a sleeper. Total order: of two that are equal in all, either may be first.
  std::ranges::sort(presses, {}, [](const Press& of) { return std::pair(of.key, of.force); });
  for (std::size_t begin = 0, end = 0; begin < presses.size(); begin = end) {
    const Press& of = presses[begin];
    double change = 0;
    for (; end < presses.size() && presses[end].key == of.key; ++end) change += presses[end].force;
    const Sleeper& sleeper = sleepers.list[bodies.info[of.owner].slot];
    double load = static_cast<double>(bodies.properties(of.owner).mass) * length_of(source.gravity);
    for (std::uint32_t k = 0; k < sleeper.touches; ++k) {
      const Touch& kept = sleepers.touches[sleeper.first_touch + k];
      const double pressed = impulse_of(kept, mass_of(of.by)) / static_cast<double>(sleeper.substep);
      load = greater(load, pressed);
      if (kept.key == of.key) change -= pressed;
    }
    if (std::fabs(change) > kReload * load) sleepers.queue.push_back({of.owner, 0});
  }
  return wake_queued(source, sleepers);
}

void Sleep::keep_touches_of_woken(const SleepSource& source, bool impulses_valid) {
  if (!sleepers.woke) return;
  sleepers.woke = false;
  if (!impulses_valid) return;
  const Population& population = source.population;
  const StaticShapes& statics = population.statics;
  if (source.contacts.manifolds.any()) source.contacts.manifolds.keep_impulses();
  each_contact(source, [&](const SleepContact& contact) {
    if (contact.a != kNoSlot || !contact.loaded || contact.shape >= kWallLeft) return;
    if (!statics[contact.shape].asleep || statics[contact.shape].alive) return;
    sleepers.recent.add(touch_of(contact, population.bodies, statics));
  });
}

bool Sleep::disturb(const SleepSource& source, std::uint32_t id) {
  const bool woke = source.population.bodies.info[id].place == Place::asleep && wake_body(source, id);
  sleepers.mark_moving(id);
  return woke;
}

bool Sleep::disturb_neighbours(const SleepSource& source, std::uint32_t id) {
  const BodyStore& bodies = source.population.bodies;
  if (sleepers.empty() || bodies.kind(id).sensor) return false;
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) return disturb_at_fixed(source, id);
  const bool asleep = info.place == Place::asleep;
  if (!asleep && info.place != Place::moving) return false;
  sleepers.queue.push_back({id, 0});
  const LatticePoint at = asleep ? sleepers.list[info.slot].at : bodies.point(info.slot);
  ask_around(source, sleepers, at, bodies.properties(id).radius, Waking::kAbove);
  return wake_queued(source, sleepers);
}

bool Sleep::let_go(const SleepSource& source, std::span<const std::uint32_t> ids) {
  BodyStore& bodies = source.population.bodies;
  StaticShapes& statics = source.population.statics;
  const auto sleeper = [&](std::uint32_t id) -> Sleeper& { return sleepers.list[bodies.info[id].slot]; };
  statics.make_room_to_leave(ids.size(), false);
  // They are in nobody's way first, so that only those that stay are found.
  for (const std::uint32_t id : ids) sleeper(id).goes = true;
  if (2 * ids.size() > sleepers.list.size()) {
    statics.lift_all_sleeping();
    for (const Sleeper& s : sleepers.list) {
      if (!s.goes) statics.lay_back(s.first_shape, s.pieces);
    }
  } else {
    for (const std::uint32_t id : ids) statics.lift_sleeping(sleeper(id).first_shape, sleeper(id).pieces);
  }
  const auto stay = [&] {
    sleepers.queue.clear();
    for (const std::uint32_t id : ids) {
      Sleeper& s = sleeper(id);
      s.goes = false;
      statics.lay_back(s.first_shape, s.pieces);
    }
  };
  const bool woke = or_else(stay, [&] {
    if (sleepers.list.size() == ids.size()) return false;
    for (const std::uint32_t id : ids) {
      ask_around(source, sleepers, sleeper(id).at, bodies.properties(id).radius, Waking::kAbove);
    }
    ask_stacked(sleepers, ids, bodies);
    return wake_queued(source, sleepers);
  });
  for (const std::uint32_t id : ids) {
    const Sleeper& s = sleeper(id);
    statics.drop_lifted(s.first_shape, s.pieces);
    leave_list(bodies, sleepers, id);
  }
  sleepers.tidy();
  sleepers.changed = true;
  ++sleepers.changes;
  return woke;
}

bool Sleep::disturb_at_fixed(const SleepSource& source, std::uint32_t id) {
  if (sleepers.empty()) return false;
  const BodyStore& bodies = source.population.bodies;
  const StaticShapes& statics = source.population.statics;
  const std::uint32_t first = source.population.fixed[bodies.info[id].slot].first_shape;
  std::vector<std::uint32_t>& found = sleepers.found;  // pieces of sleepers, then places in the list
  found.clear();
  std::uint32_t end = first;
  for (; end < statics.size() && statics[end].owner == id && statics[end].alive; ++end) {
    statics.sleepers_near(end, 2 * double{kNear} * double{sleepers.widest}, found);
  }
  for (std::uint32_t& k : found) k = bodies.info[statics[k].owner].slot;
  sort_keys(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const std::uint32_t k : found) {
    const Sleeper& s = sleepers.list[k];
    const double reach = static_cast<double>(kNear * bodies.properties(s.id).radius);
    for (std::uint32_t piece = first; piece < end; ++piece) {
      if (!touches(s.at, reach, statics[piece], statics, source.lattice)) continue;
      sleepers.queue.push_back({s.id, Waking::kAbove});
      break;
    }
  }
  return wake_queued(source, sleepers);
}

bool Sleep::wake_body(const SleepSource& source, std::uint32_t id) {
  sleepers.queue.push_back({id, 0});
  return wake_queued(source, sleepers);
}

bool Sleep::wake_all(const SleepSource& source) {
  for (const Sleeper& s : sleepers.list) sleepers.queue.push_back({s.id, 0});
  // Total order: a body sleeps once, and the queue was empty.
  std::sort(sleepers.queue.begin(), sleepers.queue.end(), [](const Waking& a, const Waking& b) { return a.id < b.id; });
  return wake_queued(source, sleepers);
}

}  // namespace psim
