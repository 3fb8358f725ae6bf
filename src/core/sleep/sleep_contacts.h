// Contacts as sleep sees them: those of discs and of shapes alike, by slot.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "bodies/body_store.h"
#include "sleep/sleep.h"

namespace psim {

/// Frames of its motion within which a body wakes what it will meet.
inline constexpr auto kClosing = static_cast<float>(kMarginFrames);

struct SleepContact {
  std::uint32_t a, b;                    ///< slots; a is kNoSlot where b touches a fixed shape
  std::uint32_t shape;                   ///< the fixed shape
  std::uint32_t part_a = 0, part_b = 0;  ///< of their bodies
  float gap;                             ///< m, at the start of the frame
  bool loaded;                           ///< the contact carries an impulse
  Touch touch;
  const ManifoldPair* pair = nullptr;  ///< of shapes
};

/// The points of a manifold along its edge, in an order that depends on neither side.
inline void order_points(const ManifoldPair& pair, Touch& touch) {
  const Manifold& m = pair.manifold;
  touch = Touch{};
  touch.points = static_cast<std::uint8_t>(std::max(m.count, 1));
  const bool flip = m.count == 2 && runs_backwards(m);
  for (int k = 0; k < m.count; ++k) {
    const int at = flip ? 1 - k : k;
    touch.impulse[k] = pair.impulse[at];
    touch.friction[k] = pair.friction[at];
  }
}

inline float gap_of(const ManifoldPair& pair) {
  if (pair.manifold.count != 0) return pair.least_gap();
  return greater(pair.margin, 0.0f);  // nothing was found within the margin: the gap is at least as wide
}

/// Calls each(contact) for the discs' contacts of a strip.
template <class Each>
void each_disc_contact(const SleepSource& source, std::size_t strip, const Each& each) {
  const BodyStore& bodies = source.population.bodies;
  const PairTable& table = source.table;
  const ContactStore& discs = source.contacts.discs;
  const bool rough = discs.model().rough();
  SleepContact contact;
  contact.touch.per_mass = source.per_mass;
  const auto tell = [&](std::size_t lane, const auto& gap, const auto& impulse, const auto& friction) {
    contact.gap = gap[lane];
    contact.touch.impulse[0] = impulse[lane];
    contact.touch.friction[0] = rough ? friction[lane] : 0.0f;
    contact.loaded = impulse[lane] > 0;
    each(contact);
  };
  contact.shape = kNoSlot;
  for (std::uint32_t p = table.strips[strip].pair_begin; p < table.strips[strip].pair_end; ++p) {
    contact.a = table.owner[p];
    contact.b = table.other[p];
    if (bodies.id[contact.a] == kNoSlot || bodies.id[contact.b] == kNoSlot) continue;
    tell(table.contact[p], discs.pairs.gap, discs.pairs.impulse, discs.pairs.friction);
  }
  contact.a = kNoSlot;
  for (const StaticPair& pair : table.static_contacts[strip]) {
    if (bodies.id[pair.body] == kNoSlot) continue;
    contact.b = pair.body;
    contact.shape = pair.shape;
    tell(pair.contact, discs.fixed.gap, discs.fixed.impulse, discs.fixed.friction);
  }
}

/// Calls each(contact) for the contacts of the present lists, in strips for which wanted(strip) is true. While a step
/// that is spread over frames makes new lists there are none.
template <class Each, class Wanted = decltype([](std::size_t) { return true; })>
void each_contact(const SleepSource& source, const Each& each, const Wanted& wanted = {}) {
  if (!source.contacts_stand) return;
  const BodyStore& bodies = source.population.bodies;
  const Manifolds& manifolds = source.contacts.manifolds;
  SleepContact contact;
  for (std::size_t k = 0; k < source.table.strips.size(); ++k) {
    if (!wanted(k)) continue;
    each_disc_contact(source, k, each);
    if (!source.with_manifolds || k >= manifolds.strip_count()) continue;
    for (const ManifoldPair& pair : manifolds.pairs_of(k)) {
      if (bodies.id[pair.b] == kNoSlot || (pair.a != kNoSlot && bodies.id[pair.a] == kNoSlot)) continue;
      contact.a = pair.a;
      contact.b = pair.b;
      contact.shape = pair.shape;
      contact.part_a = pair.part_a;
      contact.part_b = pair.part_b;
      contact.gap = gap_of(pair);
      contact.pair = &pair;
      contact.loaded = manifolds.closed(k, pair);
      order_points(pair, contact.touch);
      each(contact);
    }
  }
}

/// Calls each(visit) for every stack; visit(f) calls f(slot) for the bodies of its pairs that are wanted(slot). A body
/// may come twice.
template <class Wanted, class Each>
void each_stack(const SleepSource& source, const Wanted& wanted, const Each& each) {
  source.contacts.stacks.each_stack([&](std::span<const StackLink> links) {
    each([&](const auto& f) {
      for (const StackLink& link : links) {
        const ManifoldPair& pair = source.contacts.manifolds.pairs()[link.pair];
        for (const std::uint32_t slot : {pair.a, pair.b}) {
          if (slot != kNoSlot && wanted(slot)) f(slot);
        }
      }
    });
  });
}

/// What a contact carried, under its name.
inline Touch touch_of(const SleepContact& contact, const BodyStore& b, const StaticShapes& statics) {
  const std::uint32_t id = b.id[contact.b];
  Touch touch = contact.touch;
  const auto with = [&](std::uint32_t other, std::uint32_t part) {
    touch.key = pair_key(other, id);
    touch.parts = touch_parts(other, part, id, contact.part_b);
  };
  if (contact.a != kNoSlot) {
    with(b.id[contact.a], contact.part_a);
  } else if (contact.shape < kWallLeft && statics[contact.shape].asleep) {
    with(statics[contact.shape].owner, statics[contact.shape].part);
  } else {
    touch.key = fixed_key(id, contact.shape);
    touch.parts = {part_number(contact.part_b), 0};
  }
  return touch;
}

}  // namespace psim
