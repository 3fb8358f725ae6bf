// Two tables hold what equal bodies share: mass, radius and material, and the properties that few bodies have, such as
// a shape other than a disc. The tables own their entries; a body names the number of its entry.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/elementary.h"
#include "base/room.h"
#include "base/rotor.h"
#include "least.h"
#include "psim/desc.h"

namespace psim {

/// Restitution or friction as a float, which is no denormal.
inline float coefficient(double value) { return kernels::snapped(value); }

/// Returns what two materials give together.
inline float mixed(Mixing rule, float a, float b) {
  switch (rule) {
    case Mixing::min:
      return std::min(a, b);
    case Mixing::mean:
      return (a + b) / 2;
    case Mixing::product:
      return a * b;
    case Mixing::geometric:
      return std::sqrt(a * b);
    case Mixing::max:
      break;
  }
  return std::max(a, b);
}

/// Equal bodies share one entry: a million equal discs have a single one.
struct BodyProperties {
  float inv_mass = 0;  ///< 1/kg; 0: kinematic or static
  float mass = 0;      ///< kg
  float rim_gain = 0;  ///< r^2 / inertia, 1/kg; 0: the body does not turn
  float radius = 0;    ///< m: of the circle about the centre of mass that holds the body
  float gravity_scale = 1;
  float restitution = 0;            ///< where parts have their own: the largest
  float friction = 0;               ///< likewise
  std::uint32_t kind : 24 = 0;      ///< in BodyStore::kinds; 0: a plain disc that collides with all
  std::uint32_t type_bits : 8 = 0;  ///< a BodyType; bit-fields of one word have one type: MSVC packs no others
  BodyType type() const { return static_cast<BodyType>(type_bits); }
  friend bool operator==(const BodyProperties&, const BodyProperties&) = default;
};
static_assert(sizeof(BodyProperties) == 32);

/// The part of a body that a contact is at decides how it bounces and rubs.
struct Surface {
  float restitution = 0, friction = 0;
  float tangent_speed = 0;       ///< m/s: as Material has it
  float rolling_resistance = 0;  ///< likewise
  friend bool operator==(const Surface&, const Surface&) = default;
};

/// The PartTable keeps these of each part of a body whose parts differ, or have what only contacts of shapes know: a
/// surface that runs or resists rolling, or one that is solid from one side, or new contacts that the host is shown.
struct PartProperties {
  Surface surface;
  Filter filter;
  std::uint16_t sensor = 0;     ///< a flag
  std::uint16_t pre_solve = 0;  ///< a flag: the host is shown its new contacts
  float one_way_x = 0,
        one_way_y = 0;  ///< of length 1, or 0: solid from all sides; static: in world axes, else the body's
  std::uint32_t user_low = 0, user_high = 0;  ///< 64 bits of the host, of a body of several parts
  std::uint64_t user_data() const { return std::uint64_t{user_high} << 32 | user_low; }
  void set_user_data(std::uint64_t value) {
    user_low = static_cast<std::uint32_t>(value);
    user_high = static_cast<std::uint32_t>(value >> 32);
  }
  bool is_one_way() const { return one_way_x != 0 || one_way_y != 0; }
  /// Whether discs alone cannot have contacts with it.
  bool is_special() const {
    return surface.tangent_speed != 0 || surface.rolling_resistance != 0 || is_one_way() || pre_solve != 0;
  }
  friend bool operator==(const PartProperties&, const PartProperties&) = default;
};

/// A shape other than a disc, a filter, a mark as bullet or sensor. A plain disc that collides with all has entry 0.
struct BodyKind {
  std::uint32_t first_hull = 0;  ///< number of the first hull in the ShapeTable; 0: a plain disc
  std::uint32_t hull_count = 0;
  std::uint32_t first_part = 0;      ///< in the PartTable; 0: all parts have what the body has, and no more
  std::uint32_t part_count = 0;      ///< in the PartTable: the hulls come last, behind the parts of fixed pieces
  float centre_x = 0, centre_y = 0;  ///< m: centre of mass in the body's frame
  float inner = 0;                   ///< m: least distance from the centre to the surface
  float locked_gain = 0;             ///< 1/kg: the rim gain that the body would have if its angle were not locked
  Filter filter;                     ///< as `sensor`: the usual one where parts have their own
  bool bullet = false;
  bool sensor = false;
  bool one_way = false;     ///< a part of it is solid from one side
  bool restrained = false;  ///< Population::restraints has its damping and locks
  bool sleepless = false;   ///< it stays awake
  Locks locks;
  /// The number of a hull among the parts.
  std::uint32_t part_of_hull(std::uint32_t hull) const { return std::max(part_count, hull_count) - hull_count + hull; }
  friend bool operator==(const BodyKind&, const BodyKind&) = default;
};

/// The vector from a body's place to its centre of mass, m, when the body is turned by `angle`.
inline Vec2 arm_of(const BodyKind& kind, double angle) {
  if (kind.centre_x == 0 && kind.centre_y == 0) return {};
  return turned(sine_cosine(angle), {kind.centre_x, kind.centre_y});
}

/// Whether two bodies collide, by their filters.
inline bool meet(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

/// Entries by number, each with the number of its users. A new user whose value equals that of the entry taken last, or
/// of one of the first kSearched entries, shares the entry. An entry without users is used again. At most kMost + 1
/// entries.
template <class T, std::uint32_t kMost, std::size_t kSearched>
class SharedTable {
 public:
  std::size_t size() const { return list_.size(); }
  std::uint32_t users(std::uint32_t i) const { return list_[i].users; }
  const T& operator[](std::uint32_t i) const { return list_[i].value; }
  std::size_t bytes() const { return list_.capacity() * sizeof(Entry); }

  /// The number of the entry; kMost + 1 if there are too many.
  std::uint32_t acquire(const T& value) {
    const auto shares = [&](std::size_t i) { return list_[i].users != 0 && list_[i].value == value; };
    const auto add_user = [&](std::size_t i) {
      ++list_[i].users;
      return last_ = static_cast<std::uint32_t>(i);
    };
    if (last_ < list_.size() && shares(last_)) return add_user(last_);
    for (std::size_t i = 0; i < std::min(list_.size(), kSearched); ++i) {
      if (shares(i)) return add_user(i);
    }
    if (free_.empty()) {
      if (list_.size() > kMost) return kMost + 1;
      list_.reserve(roomier(list_));
      free_.reserve(list_.capacity());  // release() needs no memory
      free_.push_back(static_cast<std::uint32_t>(list_.size()));
      list_.emplace_back();
    }
    last_ = free_.back();
    free_.pop_back();
    list_[last_] = {value, 1};
    return last_;
  }
  void release(std::uint32_t i) {
    if (--list_[i].users == 0) free_.push_back(i);
  }
  /// For saved states: entries are free from `first` on, and sound(value, users).
  template <class Sound>
  void describe(class Archive& a, std::size_t first, const Sound& sound);

 protected:
  struct Entry {
    T value;
    std::uint32_t users = 1;
  };
  std::vector<Entry> list_;
  std::vector<std::uint32_t> free_;
  std::uint32_t last_ = 0;
};

class BodyPropertyTable : public SharedTable<BodyProperties, 0xFFFFFFFFu, 0> {
 public:
  /// The heaviest dynamic body over the lightest; 1 if there is none. O(entries).
  double mass_ratio() const {
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (const Entry& e : list_) {
      if (e.users == 0 || !(e.value.mass > 0)) continue;
      least = lesser(e.value.mass, least);
      most = greater(e.value.mass, most);
    }
    return most > 0 ? double{most} / least : 1;
  }
};

/// The number of an entry fits into 24 bits (BodyProperties::kind).
inline constexpr std::uint32_t kMostKinds = (1u << 24) - 1;

class BodyKindTable : public SharedTable<BodyKind, kMostKinds, 64> {
 public:
  BodyKindTable() { list_.resize(1); }

  std::uint32_t acquire(const BodyKind& kind) { return kind == BodyKind{} ? 0 : SharedTable::acquire(kind); }
  void release(std::uint32_t i) {
    if (i != 0) SharedTable::release(i);
  }
};

}  // namespace psim
