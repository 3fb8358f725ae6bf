// Who falls asleep, who wakes, and why. Bodies that sleep are out of every loop; the rules are in
// docs/sleeping.md. Runs after a step, in frames that depend on nothing but their number.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "invariant.h"
#include "stage_timer.h"
#include "static_pieces.h"
#include "world_impl.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr float kClosing = 1.25f;  // frames of motion within which a body wakes what it will meet
constexpr float kTouching = 2;     // balls apart that count as touching
constexpr float kNear = 1.02f;     // of its reach: where a body's neighbours are looked for
constexpr float kDeeper = 0.25f;   // m/s: an impact twice as fast wakes one ring of neighbours more
constexpr std::uint32_t kMostRings = 7;

// In Sleepers::state, by slot.
constexpr std::uint8_t kCalm = 1, kBorne = 2, kDisturbed = 4, kChosen = 8;
constexpr std::uint8_t kLooselyCalm = 16, kBorneTwice = 32, kLooselyDisturbed = 64;

bool rests(std::uint8_t state) {
  return (state & (kCalm | kBorne | kDisturbed)) == (kCalm | kBorne);
}
bool rests_loosely(std::uint8_t state) {
  return (state & (kLooselyCalm | kBorneTwice | kLooselyDisturbed)) == (kLooselyCalm | kBorneTwice);
}

// A contact of discs, seen from outside.
struct Met {
  std::uint32_t a, b;    // slots; a: kNoSlot if it is fixed
  std::uint32_t shape;   // of a fixed one
  float gap;             // m, at the frame's start
  bool bears;            // it carries an impulse
  Touch touch;
};

// The points of a manifold along its edge, in an order that depends on neither side.
void order_points(const ManifoldPair& pair, Touch& touch) {
  const Manifold& m = pair.manifold;
  touch = Touch{};
  touch.points = static_cast<std::uint32_t>(std::max(m.count, 1));
  const bool flip = m.count == 2 && runs_backwards(m);
  for (int k = 0; k < m.count; ++k) {
    const int at = flip ? 1 - k : k;
    touch.impulse[k] = pair.impulse[at];
    touch.friction[k] = pair.friction[at];
  }
}

}  // namespace

// each(met): every contact of the present lists that has a body on it; none while a step under way over
// frames makes new ones.
template <class Each>
void World::Impl::each_contact(const Each& each) const {
  PSIM_ASSERT(!saved.missing && !saved.undone);
  if (!contacts_stand()) return;
  const bool rough = contacts.rough();
  Met met;
  for (std::size_t k = 0; k < table.strips.size(); ++k) {
    const Strip& s = table.strips[k];
    met.shape = kNoSlot;
    met.touch.per_mass = plan.model.model == kernels::Model::plain;
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      met.a = table.owner[p];
      met.b = table.other[p];
      if (bodies.id[met.a] == kNoSlot || bodies.id[met.b] == kNoSlot) continue;
      const std::size_t lane = table.contact[p];
      met.gap = contacts.gap[lane];
      met.touch.impulse[0] = contacts.impulse[lane];
      met.touch.friction[0] = rough ? contacts.friction[lane] : 0.0f;
      met.bears = met.touch.impulse[0] > 0;
      each(met);
    }
    met.a = kNoSlot;
    for (const SinglePair& single : table.singles[k]) {
      if (bodies.id[single.body] == kNoSlot) continue;
      met.b = single.body;
      met.shape = single.shape;
      const std::size_t lane = single.contact;
      met.gap = contacts.s_gap[lane];
      met.touch.impulse[0] = contacts.s_impulse[lane];
      met.touch.friction[0] = rough ? contacts.s_friction[lane] : 0.0f;
      met.bears = met.touch.impulse[0] > 0;
      each(met);
    }
    if (!plan.shapes || k >= manifolds.strip_count()) continue;
    for (const ManifoldPair& pair : manifolds.pairs_of(k)) {
      if (bodies.id[pair.b] == kNoSlot || (pair.a != kNoSlot && bodies.id[pair.a] == kNoSlot)) continue;
      met.a = pair.a;
      met.b = pair.b;
      met.shape = pair.shape;
      switch (pair.manifold.count) {
        case 2: met.gap = std::fmin(pair.gap[0], pair.gap[1]); break;
        case 1: met.gap = pair.gap[0]; break;
        default: met.gap = std::fmax(pair.margin, 0.0f);  // at least: nothing was found within it
      }
      met.bears = manifolds.closed(k, pair);
      order_points(pair, met.touch);
      each(met);
    }
    met.touch = Touch{};
  }
}

namespace {

std::uint64_t key_of(const Met& met, const BodyStore& b, const StaticShapes& shapes) {
  const std::uint32_t id = b.id[met.b];
  if (met.a != kNoSlot) return TouchKey::bodies(b.id[met.a], id);
  if (met.shape < kWallLeft && shapes[met.shape].asleep) {
    return TouchKey::bodies(shapes[met.shape].owner, id);
  }
  return TouchKey::fixed(id, met.shape);
}

}  // namespace

// After a step: wakes what moving bodies are about to meet; and, in its frames, lets fall asleep what
// rests.
void World::Impl::rest(double dt, StepReport& report) {
  if (bodies.count == bodies.dead) return;
  const StageTimer timer(report, tracer, Stage::sleep);
  if (!sleepers.empty()) wake_reached(dt);
  if (steps % Sleepers::kWatchFrames != 0) return;
  if (!sleepers.watch(bodies, lattice, pool)) return;
  room_for_sleepers();
  if (steps % (2 * Sleepers::kWatchFrames) == 0) choose_sleepers(dt);
}

// For the first that fall asleep: as many as there are, or do so in one step. O(bodies) with shapes.
void World::Impl::room_for_sleepers() {
  if (!sleepers.empty() || sleepers.has_room(bodies)) return;
  const std::uint32_t most = std::min(bodies.count - bodies.dead, Sleepers::kMostAtOnce);
  std::uint32_t pieces = plan.shapes ? 0 : most, hulls = 0;
  std::size_t longest = 1;
  for (std::uint32_t i = 0; plan.shapes && i < bodies.count && pieces < Sleepers::kMostAtOnce; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const Make& make = bodies.make(bodies.id[i]);
    std::uint32_t mine = make.hull_count == 0 ? 1 : 0;
    for (std::uint32_t h = 0; h < make.hull_count; ++h) {
      const int corners = bodies.hulls[make.first_hull + h].count;
      mine += corners > 2 ? static_cast<std::uint32_t>(corners) + 1 : 1;
      hulls += corners > 2;
    }
    pieces += mine;
    longest = std::max<std::size_t>(longest, mine);
  }
  sleepers.make_room(bodies, most, !joints.empty());
  sleepers.pieces.reserve(longest);
  shapes.make_room(pieces, hulls);
}

// Bodies that rest, that something bears, and that touch nothing that moves.
void World::Impl::choose_sleepers(double dt) {
  Column<std::uint8_t>& state = sleepers.state();
  state.reserve(kernels::round_up_block(bodies.count));
  const std::uint32_t needed = Sleepers::needed(dt), long_needed = Sleepers::needed(dt, true);
  std::size_t calm = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    state[i] = 0;
    const std::uint32_t id = bodies.id[i];
    if (id == kNoSlot) continue;
    if (sleepers.calm(id) >= needed) state[i] |= kCalm;
    if (sleepers.calm(id, true) >= long_needed && bodies.surface(id).friction == 0) state[i] |= kLooselyCalm;
    calm += state[i] != 0;
    const bool still = bodies.vel[2 * std::size_t{i}] == 0 && bodies.vel[2 * std::size_t{i} + 1] == 0 &&
                       (bodies.spin.empty() || bodies.spin[i] == 0);
    if (still) state[i] |= kBorne;
  }
  if (calm == 0) return;
  const auto bear = [&](std::uint32_t i) { state[i] |= (state[i] & kBorne) != 0 ? kBorneTwice : kBorne; };
  each_contact([&](const Met& met) {
    if (met.bears) {
      bear(met.b);
      if (met.a != kNoSlot) bear(met.a);
    }
    if (met.a == kNoSlot) return;
    // Gaps are those of the frame's start: they may close in this one or the next.
    const float near = kTouching * Sleepers::ball(std::fmin(bodies.radius[met.a], bodies.radius[met.b])) +
                       2 * kClosing * static_cast<float>(dt) * (speed_of(met.a) + speed_of(met.b));
    if (!met.bears && met.gap > near) return;
    for (const auto& [i, other] : {std::pair{met.a, met.b}, std::pair{met.b, met.a}}) {
      if ((state[i] & kCalm) == 0) state[other] |= kDisturbed;
      if ((state[i] & kLooselyCalm) == 0) state[other] |= kLooselyDisturbed;
    }
  });
  const auto may = [&](std::uint32_t i) {
    return (rests(state[i]) || rests_loosely(state[i])) && bodies.surface(bodies.id[i]).inv_mass > 0;
  };
  columns.each_column([&](const auto& each_pair_of) {  // nor do parts of a column: it is solved as one
    bool all = true;
    const auto visit = [&](const auto& each) {
      each_pair_of([&](std::uint32_t index) {
        const ManifoldPair& pair = manifolds.pairs()[index];
        for (const std::uint32_t slot : {pair.a, pair.b}) {
          if (slot != kNoSlot && bodies.id[slot] != kNoSlot && bodies.surface(bodies.id[slot]).inv_mass > 0) each(slot);
        }
      });
    };
    visit([&](std::uint32_t slot) { all = all && may(slot); });
    if (!all) visit([&](std::uint32_t slot) { state[slot] |= kDisturbed | kLooselyDisturbed; });
  });
  if (!joints.empty()) keep_joined_awake(state, may);
  const std::uint32_t awake = bodies.count - bodies.dead;
  std::uint32_t chosen = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) chosen += may(i);
  // New lists for a few are not worth it, unless nobody else comes along.
  const bool patient = steps % (16 * Sleepers::kWatchFrames) != 0;
  if (chosen == 0 || (awake > 256 && chosen < awake / 32 && patient)) return;
  std::uint32_t pieces = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (!may(i)) continue;
    const Make& make = bodies.make(bodies.id[i]);
    if (pieces >= Sleepers::kMostAtOnce && joints.empty()) break;
    pieces += make.hull_count == 0 ? 1 : 5 * make.hull_count;
    state[i] |= kChosen;
  }
  fall_asleep();
}

// What is joined sleeps together or not at all.
template <class May>
void World::Impl::keep_joined_awake(Column<std::uint8_t>& state, const May& may) {
  bodies.find_slots();
  std::vector<std::uint32_t>& root = sleepers.roots;
  root.resize(bodies.id_count);
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) root[id] = id;
  const auto find = [&](std::uint32_t id) {
    while (root[id] != id) id = root[id] = root[root[id]];
    return id;
  };
  const auto mobile = [&](std::uint32_t id) {
    return bodies.info[id].place == Place::moving && bodies.surface(id).inv_mass > 0;
  };
  joints.each_pair([&](std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t id : {a, b}) {  // a joint bears
      if (bodies.info[id].place == Place::moving) state[bodies.info[id].slot] |= kBorne;
    }
    if (mobile(a) && mobile(b)) {
      const std::uint32_t p = find(a), q = find(b);
      root[std::max(p, q)] = std::min(p, q);
      return;
    }
    // On a kinematic body that moves.
    for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
      if (mobile(one) && bodies.info[other].place == Place::moving &&
          (state[bodies.info[other].slot] & kCalm) == 0) {
        state[bodies.info[one].slot] |= kDisturbed | kLooselyDisturbed;
      }
    }
  });
  std::vector<std::uint8_t>& wakeful = sleepers.wakeful;
  wakeful.assign(bodies.id_count, 0);
  joints.each_pair([&](std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t id : {a, b}) {
      if (mobile(id) && !may(bodies.info[id].slot)) wakeful[find(id)] = 1;
    }
  });
  joints.each_pair([&](std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t id : {a, b}) {
      if (mobile(id) && wakeful[find(id)] != 0) {
        state[bodies.info[id].slot] |= kDisturbed | kLooselyDisturbed;
      }
    }
  });
}

// Takes the chosen bodies out of the columns and stands them among the fixed shapes.
void World::Impl::fall_asleep() {
  const Column<std::uint8_t>& state = sleepers.state();
  if (manifolds.any()) manifolds.keep_impulses(pool);
  bodies.find_slots();
  const auto first = static_cast<std::uint32_t>(sleepers.list.size());
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if ((state[i] & kChosen) == 0) continue;
    Sleeper s;
    s.at = {bodies.pos[2 * std::size_t{i}], bodies.pos[2 * std::size_t{i} + 1],
            bodies.disp[2 * std::size_t{i}], bodies.disp[2 * std::size_t{i} + 1]};
    s.angle = bodies.angle.empty() ? 0 : bodies.angle[i];
    s.id = bodies.id[i];
    s.loose = !rests(state[i]);
    sleepers.list.push_back(s);
  }
  sleepers.number.resize(std::max<std::size_t>(sleepers.number.size(), bodies.count));
  const auto number = [&](std::uint32_t slot) {  // in the list; the id still leads to the slot
    return sleepers.number[slot];
  };
  for (std::uint32_t k = first; k < sleepers.list.size(); ++k) {
    sleepers.number[bodies.info[sleepers.list[k].id].slot] = k;
  }
  columns.each_column([&](const auto& each_pair_of) {
    std::uint32_t group = kNoSlot;
    const auto visit = [&](const auto& each) {
      each_pair_of([&](std::uint32_t index) {
        for (const std::uint32_t slot : {manifolds.pairs()[index].a, manifolds.pairs()[index].b}) {
          if (slot != kNoSlot && (state[slot] & kChosen) != 0) each(sleepers.list[number(slot)]);
        }
      });
    };
    visit([&](const Sleeper& s) { group = std::min(group, s.id); });
    visit([&](Sleeper& s) { s.group = group; });
  });
  // What they bear: counted, then written run by run.
  const auto asleep = [&](std::uint32_t slot) { return slot != kNoSlot && (state[slot] & kChosen) != 0; };
  each_contact([&](const Met& met) {
    for (const std::uint32_t slot : {met.a, met.b}) {
      if (!asleep(slot)) continue;
      Sleeper& s = sleepers.list[number(slot)];
      s.depth = std::fmax(s.depth, -met.gap);
      if (met.bears) ++s.touches;
    }
  });
  auto next = static_cast<std::uint32_t>(sleepers.touches.size());
  for (std::uint32_t k = first; k < sleepers.list.size(); ++k) {
    Sleeper& s = sleepers.list[k];
    s.first_touch = next;
    next += s.touches;
    s.touches = 0;
  }
  sleepers.touches.resize(next);
  each_contact([&](const Met& met) {
    if (!met.bears || !(asleep(met.a) || asleep(met.b))) return;
    Touch touch = met.touch;
    touch.key = key_of(met, bodies, shapes);
    for (const std::uint32_t slot : {met.a, met.b}) {
      if (!asleep(slot)) continue;
      Sleeper& s = sleepers.list[number(slot)];
      sleepers.touches[s.first_touch + s.touches++] = touch;
    }
    if (met.a != kNoSlot && asleep(met.a) != asleep(met.b)) sleepers.recent.add(touch);
  });
  for (std::uint32_t k = first; k < sleepers.list.size(); ++k) lie_down(k);
  bodies.dead += static_cast<std::uint32_t>(sleepers.list.size()) - first;
  bodies.asleep += sleepers.list.size() - first;
  if (bodies.dead == bodies.count) {  // nobody is left
    bodies.count = bodies.dead = 0;
    impulses_valid = false;
  }
  spoil_lists();
  sleepers.changed = true;
  if (!joints.empty()) joints.follow_sleep(bodies);
  queries.forget_sleeping();
  queries.forget_moving();
}

// The k-th sleeper becomes fixed geometry.
void World::Impl::lie_down(std::uint32_t k) {
  Sleeper& s = sleepers.list[k];
  BodyInfo& info = bodies.info[s.id];
  bodies.id[info.slot] = kNoSlot;
  info.place = Place::asleep;
  bodies.roster_changed = true;
  info.slot = k;
  const Surface& surface = bodies.surface(s.id);
  const Make& make = bodies.makes[surface.make];
  std::vector<Piece>& list = sleepers.pieces;
  if (make.hull_count == 0) {
    list.resize(1);
    list[0].shape = StaticShape{};
    list[0].shape.p = s.at;
    list[0].shape.radius = surface.radius;
  } else {
    Pieces pieces(lattice.to_world(s.at.x, s.at.y, s.at.dx, s.at.dy), s.angle, lattice, list);
    for (std::uint32_t h = 0; h < make.hull_count; ++h) pieces.solid(bodies.hulls[make.first_hull + h]);
  }
  for (Piece& piece : list) {
    piece.shape.owner = s.id;
    piece.shape.restitution = surface.restitution;
    piece.shape.friction = surface.friction;
  }
  s.shapes = static_cast<std::uint32_t>(list.size());
  s.first_shape = shapes.lay_down(list.data(), s.shapes);
}

// One body back into the columns, at rest where it lay.
void World::Impl::wake_one(std::uint32_t id) {
  BodyInfo& info = bodies.info[id];
  const std::uint32_t k = info.slot;
  const Sleeper s = sleepers.list[k];
  sleepers.list[k] = sleepers.list.back();
  bodies.info[sleepers.list[k].id].slot = k;
  sleepers.list.pop_back();
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
  sleepers.mark_woken(id, s.at.x, s.at.y);
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

std::string World::why_awake(BodyId id) const {
  if (!is_valid(id)) return "there is no such body";
  impl_->settle_lists();
  return impl_->why_awake(id.index);
}

// In the order in which choose_sleepers asks.
std::string World::Impl::why_awake(std::uint32_t id) const {
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) return "it is static";
  if (info.place == Place::frozen) return "it is frozen: its numbers were broken";
  if (info.place == Place::asleep) return "it sleeps";
  if (!desc.sleeping) return "awake: sleeping is off in this world";
  if (!(bodies.surface(id).inv_mass > 0)) return "awake: kinematic bodies never sleep";
  bodies.find_slots();
  const std::size_t slot = info.slot;
  const auto moves = [&](std::size_t i) {
    return !sleepers.watching() ||
           (sleepers.moves(bodies, lattice, i, false) && sleepers.moves(bodies, lattice, i, true));
  };
  char line[160];
  if (moves(slot)) {
    const double vx = static_cast<double>(bodies.vel[2 * slot]), vy = static_cast<double>(bodies.vel[2 * slot + 1]);
    std::snprintf(line, sizeof line, "awake: it moves, at %.3g m/s: it left a ball of %.3g m in the last %d frames",
                  std::sqrt(vx * vx + vy * vy), static_cast<double>(Sleepers::ball(bodies.radius[slot])),
                  static_cast<int>(Sleepers::kWatchFrames));
    return line;
  }
  const std::uint32_t needed = Sleepers::needed(desc.dt), long_needed = Sleepers::needed(desc.dt, true);
  const double watch = static_cast<double>(Sleepers::kWatchFrames) * desc.dt;
  const auto rested = [&](std::uint32_t body) {
    return sleepers.calm(body) >= needed ||
           (sleepers.calm(body, true) >= long_needed && bodies.surface(body).friction == 0);
  };
  if (!rested(id)) {
    std::snprintf(line, sizeof line, "awake: it has rested for %.2f s of %.2f s", sleepers.calm(id) * watch,
                  needed * watch);
    return line;
  }
  std::uint32_t restless = kNoSlot, joined = kNoSlot;
  bool borne = bodies.vel[2 * slot] == 0 && bodies.vel[2 * slot + 1] == 0;
  each_contact([&](const Met& met) {
    if (met.a != slot && met.b != slot) return;
    borne = borne || met.bears;
    const std::uint32_t other = met.a == slot ? met.b : met.a;
    if (other != kNoSlot && !rested(bodies.id[other])) restless = std::min(restless, bodies.id[other]);
  });
  joints.each_joined(id, [&](std::uint32_t other) {
    borne = true;
    if (bodies.info[other].place == Place::moving && !rested(other)) joined = std::min(joined, other);
  });
  if (restless != kNoSlot) return "awake: it touches body " + std::to_string(restless) + ", which moves or did so of late";
  if (joined != kNoSlot) return "awake: it is joined to body " + std::to_string(joined) + ", which moves or did so of late";
  if (!borne) return "awake: it drifts, and nothing bears it";
  return "awake: it rests, and falls asleep with what it touches and is joined to, a share of the awake at a time";
}

}  // namespace psim
