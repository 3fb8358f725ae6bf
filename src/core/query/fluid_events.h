// Which particles of fluids entered sensors in a step, and which left them.
#pragma once

#include <cstdint>
#include <vector>

#include "fluid/fluids.h"
#include "psim/events.h"
#include "query/observed.h"
#include "query/query_index.h"

namespace psim {

class FluidEventList {
 public:
  void describe(Archive& a, std::uint32_t ids);  ///< for saved states

  /// After the step. O(particles in the tiles that sensors reach into).
  void collect(const Observed& world, const QueryIndex& index, const Fluids& fluids);
  void clear() {
    begin.clear();
    end.clear();
  }
  std::size_t bytes() const { return bytes_of(begin, end, inside_, now_); }

  std::vector<FluidEvent> begin, end;

 private:
  void look(const Observed& world, const QueryIndex::Part& part, const Fluids& fluids);

  std::vector<FluidEvent> inside_, now_;  // who is in which sensor, in order, after the last step and after this one
};

}  // namespace psim
