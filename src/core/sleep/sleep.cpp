#include "sleep/sleep.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "bodies/static_pieces.h"
#include "sleep/sleep_contacts.h"

namespace psim {
namespace {

// The bodies of a stack wake together: each gets the lowest id of its stack.
void group_stacks(const SleepSource& source, Sleepers& sleepers) {
  const BodyStore& bodies = source.population.bodies;
  const auto chosen = [&](std::uint32_t slot) { return sleepers.chosen(slot); };
  each_stack(source, chosen, [&](const auto& visit) {
    std::uint32_t group = kNoSlot;
    visit([&](std::uint32_t slot) { group = std::min(group, bodies.id[slot]); });
    visit([&](std::uint32_t slot) { sleepers.list[bodies.info[bodies.id[slot]].slot].group = group; });
  });
}

// Keeps what the contacts of the chosen bodies carry: counts the touches of each body, then writes them in runs.
void keep_touches(const SleepSource& source, Sleepers& sleepers, std::size_t first) {
  const Population& population = source.population;
  const PairTable& table = source.table;
  const auto chosen = [&](std::uint32_t slot) { return slot != kNoSlot && sleepers.chosen(slot); };
  const auto any_in = [&](std::size_t strip) {
    std::uint32_t slot = table.strips[strip].body_begin;
    while (slot != table.strips[strip].body_end && !chosen(slot)) ++slot;
    return slot != table.strips[strip].body_end;
  };
  const bool any_large = !table.strips.empty() && any_in(table.strips.size() - 1);  // every strip may touch these
  const auto theirs = [&](std::size_t strip) { return any_large || table.any_beside(strip, any_in); };
  const auto each_side = [&](const SleepContact& contact, const auto& each) {
    for (const std::uint32_t slot : {contact.a, contact.b}) {
      if (chosen(slot)) each(sleepers.list[population.bodies.info[population.bodies.id[slot]].slot]);
    }
  };
  const auto count = [&](const SleepContact& contact) {
    if (contact.loaded) each_side(contact, [](Sleeper& s) { ++s.touches; });
  };
  each_contact(source, count, theirs);
  auto next = static_cast<std::uint32_t>(sleepers.touches.size());
  for (Sleeper& s : std::span(sleepers.list).subspan(first)) {
    s.first_touch = next;
    next += s.touches;
    s.touches = 0;
  }
  sleepers.touches.resize(next);
  const auto write = [&](const SleepContact& contact) {
    if (!contact.loaded || !(chosen(contact.a) || chosen(contact.b))) return;
    const Touch touch = touch_of(contact, population.bodies, population.statics);
    each_side(contact, [&](Sleeper& s) { sleepers.touches[s.first_touch + s.touches++] = touch; });
    if (contact.a != kNoSlot && chosen(contact.a) != chosen(contact.b)) sleepers.recent.add(touch);
  };
  each_contact(source, write, theirs);
}

// A sleeper becomes fixed geometry.
void become_fixed(const SleepSource& source, std::vector<Piece>& list, Sleeper& s) {
  const BodyStore& bodies = source.population.bodies;
  const BodyProperties& properties = bodies.properties(s.id);
  const BodyKind& kind = bodies.kinds[properties.kind];
  if (kind.hull_count == 0) {
    list.resize(1);
    list[0].shape = lone_piece(s.at, s.id, properties);
  } else {
    list.clear();
    Pieces pieces(source.lattice.to_world(s.at), s.angle, source.lattice, list);
    for (std::uint32_t h = 0; h < kind.hull_count; ++h) {
      const std::size_t first = list.size();
      pieces.solid(bodies.hulls[kind.first_hull + h]);
      const std::uint32_t part = kind.part_of_hull(h);
      Pieces::mark(std::span(list).subspan(first), part, bodies.part_of(properties, part));
    }
    for (Piece& piece : list) piece.shape.owner = s.id;
  }
  s.pieces = static_cast<std::uint32_t>(list.size());
  s.first_shape = source.population.statics.add_sleeping(list);
}

// Takes the chosen bodies, the last ones of the list, out of the columns and stands them among the fixed shapes.
void fall_asleep(const SleepSource& source, Sleepers& sleepers, std::size_t first, double dt) {
  BodyStore& bodies = source.population.bodies;
  if (source.contacts.manifolds.any()) source.contacts.manifolds.keep_impulses();
  group_stacks(source, sleepers);
  keep_touches(source, sleepers, first);
  for (std::uint32_t slot = 0; slot < bodies.count; ++slot) {
    if (sleepers.chosen(slot)) bodies.id[slot] = kNoSlot;
  }
  if (first == 0) sleepers.widest = 0;
  for (Sleeper& s : std::span(sleepers.list).subspan(first)) {
    s.substep = static_cast<float>(dt / source.substeps);
    sleepers.widest = greater(bodies.properties(s.id).radius, sleepers.widest);
    become_fixed(source, sleepers.pieces, s);
    if (!source.joints.empty()) source.joints.follow(s.id);
  }
  bodies.dead += static_cast<std::uint32_t>(sleepers.list.size() - first);
  if (bodies.dead == bodies.count) bodies.count = bodies.dead = bodies.listed = 0;  // nobody is awake
  sleepers.changed = true;
  ++sleepers.changes;
}

}  // namespace

bool Sleep::step(const SleepSource& source, std::uint64_t steps, double dt) {
  bool woke = !sleepers.empty() && wake_reached(source, dt);
  if (steps % Sleepers::kWatchFrames != 0) return woke;
  woke = (!woke && !sleepers.empty() && wake_reloaded(source, dt)) || woke;
  if (!sleepers.watch()) return woke;
  make_room(source);
  if (steps % (2 * Sleepers::kWatchFrames) != 0) return woke;
  const std::size_t before = sleepers.list.size();
  if (!choose(source, steps, dt)) return woke;
  fall_asleep(source, sleepers, before, dt);
  sleepers.leaving = false;
  return true;
}

void Sleep::make_room(const SleepSource& source) {
  const BodyStore& bodies = source.population.bodies;
  if (!sleepers.empty() || sleepers.has_room()) return;
  const std::uint32_t most = std::min(bodies.awake(), Sleepers::kRoomAhead);
  std::uint32_t pieces = source.with_manifolds ? 0 : most, hulls = 0;
  std::size_t longest = 1;
  for (std::uint32_t i = 0; source.with_manifolds && i < bodies.count && pieces < Sleepers::kRoomAhead; ++i) {
    if (bodies.id[i] == kNoSlot) continue;
    const BodyKind& kind = bodies.kind(bodies.id[i]);
    const PieceCount mine = pieces_of(bodies, kind);
    hulls += mine.hulls;
    pieces += mine.pieces;
    longest = std::max<std::size_t>(longest, mine.pieces);
  }
  sleepers.make_room(most, !source.joints.empty());
  sleepers.pieces.reserve(longest);
  source.population.statics.make_room(pieces, hulls);
}

BodyState Sleep::state_of(const Population& population, const Lattice& lattice, std::uint32_t id) const {
  const BodyStore& bodies = population.bodies;
  bodies.find_slots();
  if (bodies.info[id].place != Place::asleep) return population.state_of(id);
  const Sleeper& sleeper = sleepers.list[bodies.info[id].slot];
  const Vec2 place = lattice.to_world(sleeper.at) - arm_of(bodies.kind(id), sleeper.angle);
  BodyState s = population.bare_state(id);
  s.x = place.x, s.y = place.y;
  s.angle = sleeper.angle;
  return s;
}

}  // namespace psim
