// The search for candidate pairs: of each strip, and of the large bodies in pieces. Each search writes into room of its
// own; those whose room was too small get more, and run again.
#pragma once

#include <cstdint>
#include <vector>

#include "lists/broad_cells.h"
#include "lists/large_cells.h"
#include "lists/pair_table.h"

namespace psim {

class PairSearch {
 public:
  PairSearch(const Surroundings& s, const BroadCells& cells) : s_(s), cells_(cells), large_cells_(s.memory) {}

  /// Call when strips were cut: makes room for `pairs_a_body` pairs a body, 0: as many as at the last build, times
  /// `growth`.
  void begin(PairTable& table, double pairs_a_body, double growth);
  /// Runs the searches [begin, end). True when all are done; their number grows when a search ran out of room.
  bool run(PairTable& table, std::size_t begin, std::size_t end);
  /// Which slots hold kinematic bodies.
  const HeldBodies& held() const { return held_; }
  std::size_t searches() const { return searched_ + pending_.size(); }

  /// Expected work of a search: the number of bodies (of a strip, or some of the large ones), the pairs that each
  /// will have, and for large bodies the number of other large bodies that each is compared with.
  struct Work {
    double bodies = 0, pairs = 0;
    bool large = false;
    double others = 0;
  };
  Work work_of(std::size_t search, const PairTable& table) const;

  /// Appends the bodies within reach of a body at `built`, from the cells of the last build and from the large
  /// bodies; the body itself may be among them. False if the list is full.
  bool around(std::uint32_t body, kernels::PairList& list) const;

 private:
  friend class BroadPhase;  // describes it for saved states

  Strip& job(std::size_t n, PairTable& table) {
    const std::size_t strips = table.strips.size() - 1;
    return n < strips ? table.strips[n] : large_[n - strips];
  }
  double expected(std::size_t job, std::size_t strips) const;
  void give_room(PairTable& table, bool first);
  bool search(std::size_t n, PairTable& table);
  bool search_large(const Strip& piece, kernels::PairList& list) const;
  void join_large(PairTable& table);
  void note_pairs(const PairTable& table);

  const Surroundings s_;
  const BroadCells& cells_;
  LargeCells large_cells_;  // cells of the bodies that are not in the grid, if there are many
  HeldBodies held_;
  std::vector<Strip> large_;            // pieces of the large bodies
  std::vector<std::uint32_t> pending_;  // jobs still to be searched: strips, then pieces of the large bodies
  std::vector<std::uint8_t> full_;      // by job: its room was too small
  std::size_t searched_ = 0;            // number of searches before the pending ones
  bool scattered_ = false;              // the rooms of the large bodies' pieces do not lie side by side
  // Pairs a body at the last build: by strip, by piece of the large bodies, and of all large bodies.
  std::vector<double> pairs_a_body_, pairs_a_piece_;
  double pairs_a_large_ = 64;
};

/// The largest value of a strip and its neighbours in a list by strip; `otherwise` for strips that are not there.
inline double most_beside(std::size_t strip, std::size_t strips, const std::vector<double>& by_strip,
                          double otherwise) {
  double most = 0;
  for (std::size_t s = strip == 0 ? 0 : strip - 1; s <= strip + 1; ++s) {
    most = std::max(most, s < strips ? by_strip[s] : otherwise);
  }
  return most;
}

}  // namespace psim
