// Impulses of contacts by name, for the moments in which a contact changes its place: one of its sides fell asleep or
// woke, so that a pair of bodies becomes a contact with fixed geometry, or the other way round.
//
// In: contacts when bodies fall asleep or wake (sleep/). Out: impulses for the contacts that are laid out next
// (ContactStore, Manifolds). O(1) a touch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bodies/static_shapes.h"

namespace psim {

/// Names the contact of a body and a piece of fixed geometry. That of two bodies has the pair_key() of their ids.
inline std::uint64_t fixed_key(std::uint32_t body, std::uint32_t shape) {
  return std::uint64_t{1} << 63 | std::uint64_t{body} << 32 | shape;
}

/// The number of a part as 16 bits: from the 65,535th on all parts of a body count as one.
inline std::uint16_t part_number(std::uint32_t part) {
  return static_cast<std::uint16_t>(part < 0xFFFF ? part : 0xFFFF);
}

/// Which parts of their bodies touch: of the one that the key names first, and of the other. Two bodies of many parts may
/// have a contact for each two of them.
struct TouchParts {
  std::uint16_t first = 0, second = 0;
  friend bool operator==(TouchParts, TouchParts) = default;
};
/// The parts of two bodies that touch.
inline TouchParts touch_parts(std::uint32_t id_a, std::uint32_t part_a, std::uint32_t id_b, std::uint32_t part_b) {
  if (id_b < id_a) return {part_number(part_b), part_number(part_a)};
  return {part_number(part_a), part_number(part_b)};
}

/// What one contact carried. Shapes that touch along an edge have two points, in their order along the edge.
struct Touch {
  std::uint64_t key = 0;
  float impulse[2] = {}, friction[2] = {};  ///< N s; N s / kg if `per_mass`
  TouchParts parts;
  std::uint8_t points = 1;
  bool per_mass = false;  ///< contact lanes divide by the mass where all discs have the same

  /// The factor that converts the impulses to the wanted unit. `mass` is the mass of the disc.
  float times(bool wanted_per_mass, float mass) const {
    return per_mass == wanted_per_mass ? 1.0f : per_mass ? mass : 1 / mass;
  }

  bool of_fixed() const { return key >> 63 != 0; }
  bool same(const Touch& o) const { return key == o.key && parts == o.parts; }
  /// The lower id of two bodies; or the body that touches fixed geometry.
  std::uint32_t first() const { return static_cast<std::uint32_t>(key >> 32) & 0x7FFFFFFFu; }
  /// The higher id of two bodies; or the number of the fixed shape.
  std::uint32_t second() const { return static_cast<std::uint32_t>(key); }
};
static_assert(sizeof(Touch) == 32);

/// Touches by key and parts. Sleeping fills it; the next layout of the contacts reads it; then it is cleared.
class TouchMemory {
 public:
  void add(const Touch& touch);
  const Touch* find(std::uint64_t key, TouchParts parts = {}) const;
  bool empty() const { return list_.empty(); }
  const std::vector<Touch>& all() const { return list_; }
  void clear();
  /// Makes room: adding up to `touches` of them allocates nothing.
  void make_room(std::size_t touches);
  /// Makes room for so many more, if there is none.
  void make_room_for_more(std::size_t touches);
  std::size_t bytes() const { return list_.capacity() * sizeof(Touch) + slot_.capacity() * 4; }

 private:
  static constexpr std::uint32_t kFree = 0xFFFFFFFFu;
  std::size_t place_of(std::uint64_t key, TouchParts parts) const;
  void rehash(std::size_t size);

  std::vector<Touch> list_;
  std::vector<std::uint32_t> slot_;  // open addressing: places in list_, or kFree
};

}  // namespace psim
