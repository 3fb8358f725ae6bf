// Continuous collision: a body that moved far for its size in a step is put back to where it was half its inner radius
// deep in something. Contacts foresee what is near; this finds what a body would have jumped over. Discs collide with
// fixed geometry through their own contacts, at any speed (docs/solver.md).
//
// In: the motion of the step (disp, angle_change). Out: the same motion, cut at the first impact. Velocities stay, and
// the contact of the next step answers them. A body that is slow for its size costs a comparison.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "lists/pair_table.h"
#include "manifolds/contacts.h"

namespace psim {

class Continuous {
 public:
  auto fields() { return std::tie(looked_); }  ///< for saved states

  /// Cuts the motion of fast shapes at fixed geometry, and of `bullets` (ids) at other moving bodies.
  /// Returns how many motions were cut at fixed geometry. O(shapes), plus the shapes along the ways of fast ones.
  std::uint32_t stop(const Contacts& contacts, const PairTable& table, const std::vector<std::uint32_t>& bullets,
                     bool filters);
  /// The number of fixed shapes that the last stop() tested against fast bodies.
  std::uint64_t looked() const { return looked_; }
  /// The number of bodies whose ways the last stop() looked at.
  std::uint32_t fast() const { return fast_count_; }

  void release() { give_back(jobs_, fast_); }
  std::size_t bytes() const {
    std::size_t sum = bytes_of(jobs_, fast_);
    for (const Job& job : jobs_) sum += bytes_of(job.near);
    return sum;
  }

 private:
  struct Job {
    std::vector<std::uint32_t> near;  // scratch: the fixed shapes near the way of a body
    std::uint32_t fast = 0, looks = 0, cut = 0;
  };

  void stop_bullets(const Contacts& contacts, const PairTable& table, const std::vector<std::uint32_t>& bullets);

  std::vector<Job> jobs_;
  std::vector<std::uint8_t> fast_;  // by slot: the body is a fast bullet
  std::uint64_t looked_ = 0;
  std::uint32_t fast_count_ = 0;
};

}  // namespace psim
