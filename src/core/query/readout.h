// What is read out of a world as a whole: its hash, its sums, its bodies as columns. All go by id, so that neither
// slots nor threads show. O(ids).
#pragma once

#include <cstdint>
#include <vector>

#include "psim/world.h"
#include "sleep/sleep.h"

namespace psim {

/// The bodies of a world, wherever they are.
struct BodySource {
  const Population& population;
  const Sleep& sleep;
  const Lattice& lattice;

  BodyState state_of(std::uint32_t id) const { return sleep.state_of(population, lattice, id); }
};

std::uint64_t state_hash(const BodySource& source);

/// Energy, momentum and angular momentum of all dynamic bodies.
Diagnostics sum_motion(const BodySource& source, const WorldDesc& desc);

/// The memory behind World::published.
class PublishedColumns {
 public:
  PublishedState fill(const BodySource& source);
  std::size_t bytes() const { return id_.capacity() * (4 + 1 + 7 * 8); }

 private:
  std::vector<std::uint32_t> id_;
  std::vector<double> x_, y_, angle_, vx_, vy_, omega_, radius_;
  std::vector<BodyType> type_;
};

}  // namespace psim
