// The last part of the broad phase: bodies near walls and fixed shapes.
#pragma once

#include <cstdint>
#include <vector>

#include "lists/broad_cells.h"
#include "lists/pair_table.h"

namespace psim {

class NearSearch {
 public:
  NearSearch(const Surroundings& s, const BroadPhaseParams& params, const BroadCells& cells)
      : s_(s), params_(params), cells_(cells) {}

  /// A piece of the search: a strip, or some of its bodies if each one must query the fixed shapes.
  struct Piece {
    std::uint32_t strip = 0, begin = 0, end = 0;  // bodies
  };
  /// Cuts the pieces.
  void begin(const PairTable& table);
  /// Finds the walls and fixed shapes near the bodies of pieces [begin, end) and, if it `links`, marks the bodies of strips
  /// that are complete as linked. True with the last.
  bool run(PairTable& table, bool links, std::size_t begin, std::size_t end);
  std::size_t pieces() const { return pieces_.size(); }
  const Piece& piece(std::size_t k) const { return pieces_[k]; }

  /// Expected number of fixed shapes near a body of a strip.
  double expected(std::size_t strip) const;
  /// Number of pairs of a body and a fixed shape or wall at the last build.
  std::size_t pairs() const { return pairs_; }

  /// Appends the walls and fixed shapes within a body's reach to `out`.
  void near_body(std::uint32_t body, std::vector<std::uint32_t>& found, std::vector<StaticPair>& out) const;

 private:
  friend class BroadPhase;  // describes it for saved states

  double common_way() const;
  bool nothing_near(std::uint32_t begin, std::uint32_t end) const;
  void search(const Piece& piece, PairTable& table) const;

  const Surroundings s_;
  const BroadPhaseParams& params_;
  const BroadCells& cells_;
  std::vector<Piece> pieces_;
  std::vector<double> near_a_body_;  // by strip: fixed shapes near a body at the last build
  std::size_t pairs_ = 0;
};

/// Marks the bodies of a strip's pairs and contacts with fixed shapes as linked.
void link_strip(const PairTable& table, std::size_t strip, std::uint8_t* linked);

}  // namespace psim
