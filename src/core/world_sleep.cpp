// Who falls asleep. Bodies that sleep are out of every loop; the rules are in docs/sleeping.md. Runs after a step, in
// frames that depend on nothing but their number. Who wakes is in world_wake.cpp.
#include <algorithm>
#include <cmath>

#include "contact_visit.h"
#include "stage_timer.h"
#include "static_pieces.h"
#include "world_impl.h"

namespace psim {
namespace {

constexpr float kTouching = 2;  // balls apart that count as touching

// In Sleepers::state, by slot.
constexpr std::uint8_t kCalm = 1, kBorne = 2, kDisturbed = 4, kChosen = 8;
constexpr std::uint8_t kLooselyCalm = 16, kBorneTwice = 32, kLooselyDisturbed = 64;

bool rests(std::uint8_t state) {
  return (state & (kCalm | kBorne | kDisturbed)) == (kCalm | kBorne);
}
bool rests_loosely(std::uint8_t state) {
  return (state & (kLooselyCalm | kBorneTwice | kLooselyDisturbed)) == (kLooselyCalm | kBorneTwice);
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

// For the first that fall asleep, as many as there are or kRoomAhead. O(bodies) with shapes.
void World::Impl::room_for_sleepers() {
  if (!sleepers.empty() || sleepers.has_room(bodies)) return;
  const std::uint32_t most = std::min(bodies.count - bodies.dead, Sleepers::kRoomAhead);
  std::uint32_t pieces = plan.shapes ? 0 : most, hulls = 0;
  std::size_t longest = 1;
  for (std::uint32_t i = 0; plan.shapes && i < bodies.count && pieces < Sleepers::kRoomAhead; ++i) {
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
  // New lists for a few are not worth it, unless nobody else comes along.
  const std::uint32_t awake = bodies.count - bodies.dead;
  const bool patient = awake > 256 && steps % (16 * Sleepers::kWatchFrames) != 0;
  const auto few = [&](std::size_t n) { return n == 0 || (patient && n < awake / 32); };
  if (few(calm)) return;
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
  std::size_t chosen = 0;
  for (std::uint32_t i = 0; i < bodies.count; ++i) chosen += may(i);
  if (few(chosen)) return;
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
  const auto any_in = [&](std::size_t strip) {
    const Strip& s = table.strips[strip];
    return std::any_of(state.data() + s.body_begin, state.data() + s.body_end, [](std::uint8_t of) { return (of & kChosen) != 0; });
  };
  const bool any_large = !table.strips.empty() && any_in(table.strips.size() - 1);  // asked for every strip
  const auto theirs = [&](std::size_t strip) { return any_large || table.any_beside(strip, any_in); };
  each_contact([&](const Met& met) {
    for (const std::uint32_t slot : {met.a, met.b}) {
      if (!asleep(slot)) continue;
      Sleeper& s = sleepers.list[number(slot)];
      s.depth = std::fmax(s.depth, -met.gap);
      if (met.bears) ++s.touches;
    }
  }, theirs);
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
  }, theirs);
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
    list[0].shape = lone_piece(s.at, s.id, surface);
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
  sleepers.spoil_pack(k);
}

}  // namespace psim
