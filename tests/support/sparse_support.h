// The broad phase alone, of worlds with much space between the bodies, and brute force beside it.
#pragma once

#include <gtest/gtest.h>

#include <set>

#include "base/machine.h"
#include "lists/broad_phase.h"
#include "support.h"

namespace psim::test {

inline constexpr double kHalf = 60e3;  ///< m: of most worlds here

struct Place {
  double x, y, radius;
};
using Places = std::vector<Place>;

/// The broad phase of a world, without the rest.
struct Broad {
  Broad(Bounds b, bool is_periodic, int threads = 1)
      : bounds(b), wraps(is_periodic), lattice(b, is_periodic), pool(threads) {}

  void add(const Places& places) {
    bodies.reserve_slots(places.size());
    for (const Place& p : places) {
      const LatticePoint at = lattice.to_lattice({p.x, p.y});
      const std::size_t slot = bodies.count++;
      bodies.pos[2 * slot] = at.x;
      bodies.pos[2 * slot + 1] = at.y;
      bodies.radius[slot] = static_cast<float>(p.radius);
      bodies.id[slot] = next_id++;
      mixed = mixed || p.radius != places[0].radius;
    }
  }

  void build(Isa isa = best_isa()) {
    BroadPhaseParams p;
    p.margin.skin = 0.05f;
    p.periodic = wraps;
    p.mixed_radii = true;
    p.walls = walls;
    p.bounds = {bounds.xmin - lattice.centre().x, bounds.ymin - lattice.centre().y, bounds.xmax - lattice.centre().x,
                bounds.ymax - lattice.centre().y};
    bodies.pad_tail();
    kernels = kernels_of(isa);
    broad.measure(p);
    broad.count();
    broad.move(0, broad.cells().moves());
    broad.open(table);
    broad.find_lists(table);
    broad.finish();
  }

  double distance(std::uint32_t i, std::uint32_t j) const {
    const double dx = wrap_sub(bodies.pos[2 * j], bodies.pos[2 * i]) * lattice.pitch_x();
    const double dy = wrap_sub(bodies.pos[2 * j + 1], bodies.pos[2 * i + 1]) * lattice.pitch_y();
    return std::hypot(dx, dy);
  }

  /// Every pair within reach is there once, and no other; strips and phases are
  /// as they must be.
  void expect_right() const {
    std::set<std::pair<std::uint32_t, std::uint32_t>> found;
    const std::size_t strips = table.strips.size();
    std::uint32_t next = 0;
    for (std::size_t s = 0; s < strips; ++s) {
      const Strip& strip = table.strips[s];
      ASSERT_EQ(strip.body_begin, next);
      next = strip.body_end;
      for (std::uint32_t p = strip.pair_begin; p < strip.pair_end; ++p) {
        const std::uint32_t i = table.owner[p], j = table.other[p];
        ASSERT_EQ(table.strip_of(i), s);
        ASSERT_TRUE(found.insert({std::min(i, j), std::max(i, j)}).second) << i << " " << j;
        if (s + 1 == strips) continue;  // large ones go alone
        const std::size_t other = table.strip_of(j), last = strips - 2;
        ASSERT_TRUE(other == s || other == s + 1 || (wraps && s == last && other == 0))
            << s << " " << other << " of " << strips;
        ASSERT_TRUE(other == s || (other + s) % 2 == 1 || last == 0);
        ASSERT_LT(j, table.large_begin);
      }
    }
    ASSERT_EQ(next, bodies.count);
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      for (std::uint32_t j = i + 1; j < bodies.count; ++j) {
        const double sum = double{bodies.reach[i]} + double{bodies.reach[j]};
        const double d = distance(i, j);
        if (std::fabs(d - sum) < 1e-5 * sum) continue;
        ASSERT_EQ(found.contains({i, j}), d < sum) << i << " " << j << " " << d << " of " << sum;
      }
    }
  }

  Bounds bounds;
  bool wraps;
  bool walls = false;
  bool mixed = false;
  Lattice lattice;
  MemoryMeter memory;
  BodyStore bodies{memory};
  StaticShapes shapes{memory, lattice};
  kernels::KernelTable kernels = kernels_of(best_isa());
  WorkerPool pool;
  KinematicBodies kinematics;
  MixingRules mixing;
  Material wall;
  BroadPhase broad{{memory, lattice, bodies, shapes, kernels, pool, kinematics, mixing, wall}};
  PairTable table{memory};
  std::uint32_t next_id = 0;
};

inline Bounds square(double half) { return {-half, -half, half, half}; }

/// n discs in a square about a place, overlapping as they may.
inline void cluster(Places& out, Random& random, Vec2 at, std::size_t n, double side, double radius = 0.5) {
  for (std::size_t k = 0; k < n; ++k) {
    out.push_back({at.x + random.uniform(-side / 2, side / 2), at.y + random.uniform(-side / 2, side / 2), radius});
  }
}

}  // namespace psim::test
