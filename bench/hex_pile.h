// A hexagonal block of discs and the contacts between neighbours, about three a disc, laid out as
// the engine does: row by row, in strips of some hundred bodies, in each strip by greedy colour,
// each colour in blocks of 8 lanes that share no body. Lanes left over are padding that does
// nothing: two resting dummies beyond the bodies.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures.h"

namespace psim::bench {

struct HexPile : Discs {
  /// `spacing` (m) between neighbouring centres, velocities uniform in +-`speed` (m/s) on each axis.
  HexPile(std::uint32_t n, double spacing, double speed);

  std::size_t lanes() const { return std::size_t{blocks_of_contacts} * kernels::kBlock; }
  bool is_contact(std::size_t lane) const { return rsum[lane] > 0; }
  kernels::ContactView contacts();

  std::uint32_t contact_count = 0;
  std::uint32_t blocks_of_contacts = 0;
  // By lane; neutral in padding.
  Column<std::uint32_t> body{meter};
  Column<float> nx{meter}, ny{meter}, gap{meter}, impulse{meter}, rsum{meter}, mass{meter}, wa{meter}, wb{meter},
      mu{meter}, friction{meter}, tmass{meter}, qa{meter}, qb{meter}, e{meter}, impact{meter}, start{meter};

 private:
  struct Pair {
    std::uint32_t a, b;
  };
  std::vector<Pair> pairs_of_rows(std::uint32_t row_begin, std::uint32_t row_end) const;
  void lay_out(const std::vector<std::vector<Pair>>& strips);
  void fill_lane(std::size_t lane, Pair pair);
  void pad_lane(std::size_t lane, std::uint32_t dummy);

  std::uint32_t columns_;
};

}  // namespace psim::bench
