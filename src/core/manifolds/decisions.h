// What the host decided of contacts (World::set_pre_solve). A decision lasts while the parts stay near each other.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "manifolds/manifold_pair.h"

namespace psim {

/// Names the contact of two parts, whatever moves their bodies, and whether or not they sleep. The lower id comes first.
/// A wall has the id kNoSlot, and its number is that of the part.
struct ContactName {
  std::uint32_t a = 0, b = 0, part_a = 0, part_b = 0;
  friend auto operator<=>(const ContactName&, const ContactName&) = default;

  static ContactName of(std::uint32_t id, std::uint32_t part, std::uint32_t other, std::uint32_t other_part) {
    if (id < other) return {id, other, part, other_part};
    return {other, id, other_part, part};
  }
};
/// The name of a pair. Pieces of one static part share it.
inline ContactName name_of(const PairName& pair, const StaticShapes& statics) {
  if (pair.of_wall()) return {pair.id_b, kNoSlot, pair.part_b, pair.shape};
  return ContactName::of(pair.id_a, pair.of_piece() ? statics[pair.shape].part : pair.part_a, pair.id_b, pair.part_b);
}

struct Decision {
  ContactName name;
  bool through = false;  ///< the parts go through each other
  bool changed = false;  ///< the contact has `surface` instead of what its two sides give
  bool seen = false;     ///< scratch of Decisions::keep_seen
  Surface surface;
};

class Decisions {
 public:
  bool empty() const { return list_.empty(); }
  std::size_t size() const { return list_.size(); }
  /// Null, if nothing was decided.
  const Decision* find(const ContactName& name) const;
  /// What a contact has instead of what its sides give; null if it has that.
  const Surface* surface_of(const ContactName& name) const {
    const Decision* const d = list_.empty() ? nullptr : find(name);
    return d != nullptr && d->changed ? &d->surface : nullptr;
  }
  /// Marks a decision whose parts are still near each other; false if there is none.
  bool see(const ContactName& name);
  /// Drops those that were not seen since the last time, unless one of the bodies sleeps.
  void keep_seen(const BodyStore& bodies);
  /// Adding so many more allocates nothing.
  void make_room(std::size_t more) { list_.reserve(list_.size() + more); }
  /// Adds decisions that are not there, in the order of their names.
  void add(std::span<const Decision> decided);
  /// Drops those of a body.
  void forget(std::uint32_t id);
  void clear() { list_.clear(); }
  std::size_t bytes() const { return list_.capacity() * sizeof(Decision); }
  void describe(class Archive& a, const BodyStore& bodies);  ///< for saved states

 private:
  std::vector<Decision> list_;  // by name
};

}  // namespace psim
