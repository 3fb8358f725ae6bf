// Which slots hold kinematic bodies. Pairs of two of them are no contacts, since neither body can be moved; in heaps of
// kinematic bodies they would be most of all pairs.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"
#include "views.h"

namespace psim {

class HeldBodies {
 public:
  /// Call when the bodies lie in cell order. O(bodies) if there are at least two kinematic ones, else O(1).
  void find(const Surroundings& s) {
    held_.clear();
    if (s.kinematics.size() < 2) return;
    s.bodies.find_slots();
    held_.resize(s.bodies.count);
    count_ = s.kinematics.size();
    for (const auto& [id, velocity] : s.kinematics) held_[s.bodies.info[id].slot] = 1;
  }
  /// Whether any of the slots [begin, end) is held.
  bool any(std::uint32_t begin, std::uint32_t end) const {
    return !held_.empty() && std::find(held_.begin() + begin, held_.begin() + end, 1) != held_.begin() + end;
  }
  /// The share of the pairs of all bodies that is left without those of two held ones.
  double share_of_pairs() const {
    if (held_.empty()) return 1;
    const double share = static_cast<double>(count_) / static_cast<double>(held_.size());
    return 1 - share * share;
  }
  bool at(std::uint32_t slot) const { return !held_.empty() && held_[slot] != 0; }
  /// Takes the held partners of a held body, whose pairs are the last ones of the list, out of it.
  void drop_pairs(std::uint32_t body, kernels::PairList& list) const {
    if (!at(body)) return;
    std::uint32_t kept = list.first[body];
    for (std::uint32_t p = kept; p < list.count; ++p) {
      list.owner[kept] = list.owner[p];
      list.other[kept] = list.other[p];
      kept += held_[list.other[p]] == 0;
    }
    list.count = kept;
  }

 private:
  std::size_t count_ = 0;
  std::vector<std::uint8_t> held_;  // by slot; empty if no two are held
};

}  // namespace psim
