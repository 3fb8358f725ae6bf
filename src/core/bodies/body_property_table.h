// Mass, radius and material of bodies. The table owns them; a body names its entry (BodyInfo::properties).
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "psim/desc.h"

namespace psim {

/// Restitution or friction as a float. A step flushes denormals to zero (FloatSettings); this function does the same,
/// so that bodies with a coefficient above 0 are the same ones inside and outside of a step.
inline float coefficient(double value) {
  const auto as_float = static_cast<float>(value);
  return as_float < std::numeric_limits<float>::min() ? 0.0f : as_float;
}

/// Equal bodies share one entry of this table: a million equal discs have a single one.
struct BodyProperties {
  float inv_mass = 0;  ///< 1/kg; 0: kinematic or static
  float mass = 0;      ///< kg
  float rim_gain = 0;  ///< r^2 / inertia, 1/kg; 0: the body does not turn
  float radius = 0;    ///< m: of the circle about the centre of mass that holds the body
  float gravity_scale = 1;
  float restitution = 0;
  float friction = 0;
  std::uint32_t kind : 24 = 0;  ///< in BodyStore::kinds; 0: a plain disc that collides with all
  BodyType type : 8 = BodyType::dynamic_body;
  friend bool operator==(const BodyProperties&, const BodyProperties&) = default;
};
static_assert(sizeof(BodyProperties) == 32);

/// The properties in use. Bodies that are added one after another and are equal share an entry; an entry without users
/// is used again.
class BodyPropertyTable {
 public:
  template <class A>
  void describe(A& a, std::size_t kinds);  ///< for saved states
  std::size_t size() const { return list_.size(); }
  std::uint32_t users(std::uint32_t i) const { return list_[i].users; }

  const BodyProperties& operator[](std::uint32_t i) const { return list_[i].properties; }
  std::size_t bytes() const { return list_.capacity() * sizeof(Entry); }

  /// The heaviest dynamic body over the lightest; 1 if there is none. O(entries).
  double mass_ratio() const {
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (const Entry& e : list_) {
      if (e.users == 0 || !(e.properties.mass > 0)) continue;
      least = std::fmin(least, e.properties.mass);
      most = std::fmax(most, e.properties.mass);
    }
    return most > 0 ? static_cast<double>(most) / static_cast<double>(least) : 1;
  }

  std::uint32_t acquire(const BodyProperties& p) {
    if (last_ < list_.size() && list_[last_].users != 0 && list_[last_].properties == p) {
      ++list_[last_].users;
      return last_;
    }
    if (free_.empty()) {
      last_ = static_cast<std::uint32_t>(list_.size());
      list_.push_back({p, 1});
    } else {
      last_ = free_.back();
      free_.pop_back();
      list_[last_] = {p, 1};
    }
    return last_;
  }
  void release(std::uint32_t i) {
    if (--list_[i].users == 0) free_.push_back(i);
  }

 private:
  struct Entry {
    BodyProperties properties;
    std::uint32_t users = 0;
  };
  std::vector<Entry> list_;
  std::vector<std::uint32_t> free_;
  std::uint32_t last_ = 0;
};

}  // namespace psim
