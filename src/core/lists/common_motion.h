// Finds the motion that discs which lie close have in common. A heap that sways moves by metres while hardly a disc moves
// against its neighbours: lists of who may meet last as long as that is little.
//
// The bodies' box is cut into regions, squares of the lattice. In a region that is packed, what its bodies moved since the
// lists were made is on average its way, and how they move its velocity; a region that is not moves as those beside it
// that are. Lists know a body at a place (BodyStore::built), which tells its region:
//   position = place + way of the region + rest.
// Two bodies that no list names had places of |a - b| >= reach_a + reach_b. So they are apart while for each of them
//   |rest| + half of what the ways of its region and of one beside it differ by
//     + (the same of velocities) time <= reach - radius.
// Regions that are not side by side may differ by half of an edge; if they differ by more, the lists end. What is fixed
// does not move along: from there bodies get some more margin, their `room`.
// docs/decisions/031-common-motion.md
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"

namespace psim {

class CommonMotion {
 public:
  /// Tells update() where bodies may meet something that does not move; fixed shapes it knows.
  struct Fixed {
    bool walls = false;
    Bounds bounds;  ///< of the world, about the centre of the lattice, m
  };

  explicit CommonMotion(const Surroundings& s) : s_(s), b_(s.bodies) {}

  /// Cuts regions of at least `edge` metres where the bodies are. False if these would be too many: then bodies have
  /// nothing in common. O(bodies).
  bool cut(double edge);
  void stop() { grid_ = {}; }
  bool on() const { return grid_.columns != 0; }

  /// Finds ways and velocities, for lists that know the bodies at `places` (records). `beside`: how far bodies may go
  /// towards what is fixed, m. False if they go too far for these lists. O(bodies).
  bool update(const std::int32_t* places, const Fixed& fixed, double beside);
  /// Sets `beside` alone. O(regions).
  void find_room(const Fixed& fixed, double beside);

  /// How much of its margin a body uses within `time` seconds more, m, if lists know it at `place`.
  float use(std::uint32_t slot, const std::int32_t* place, float time) const;
  /// How fast it uses up its margin among other bodies, m/s.
  float speed(std::uint32_t slot, const std::int32_t* place) const;
  /// Where lists are to know a body from now on, so that it uses hardly any of its margin. `place`: where they knew it.
  void find_place(std::uint32_t slot, std::int32_t* place) const;
  /// Lists know a body at another place.
  void move_member(const std::int32_t* from, const std::int32_t* to);
  /// Lists know the bodies at other places.
  void forget_members() { counted_ = false; }

  void describe(class Archive& a);  ///< for saved states; the rest follows from the bodies
  std::size_t bytes() const { return bytes_of(regions_, sums_); }

 private:
  struct Grid {
    std::uint32_t shift[2] = {};          // a region's edges are 2^shift lattice steps
    std::int32_t low[2] = {};             // lattice steps: where the first one begins
    std::uint32_t columns = 0, rows = 0;  // 0: bodies have nothing in common
  };
  struct Region {
    std::int32_t x = 0, y = 0;     // its way, lattice steps
    float vx = 0, vy = 0;          // m/s
    float apart = 0, parting = 0;  // m, m/s: half of what it differs by from those beside it
    float room = 0;                // m: how far beyond its margin a body may go, for what is fixed
    std::uint32_t members = 0;
    bool packed = false;
  };
  struct Sum {
    std::int64_t x = 0, y = 0;
    double vx = 0, vy = 0, area = 0;
    std::uint32_t n = 0;
  };

  static std::uint32_t along(std::uint32_t shift) { return 1u << (32 - shift); }
  double edge(int axis) const;
  double shorter_edge() const;
  std::size_t most_regions() const;
  std::size_t index_of(const std::int32_t* place) const;
  Vec2 way_of(const Region& r) const { return s_.lattice.metres(r.x, r.y); }
  template <class Each>
  void each_beside(std::size_t region, const Each& each) const;
  void count(const std::int32_t* places);
  void find_means(const std::int32_t* places);
  void spread();
  void compare();
  bool serve() const;

  const Surroundings s_;
  const BodyStore& b_;
  Grid grid_;
  std::vector<Region> regions_;  // by row; the last one is all that is outside
  std::vector<Sum> sums_;
  double differ_ = 0;  // m: the most that two ways differ by
  bool counted_ = false;
};

}  // namespace psim
