// How fast bodies move relative to the bodies around them, strip by strip. This bounds how much an impact within a
// step may change a velocity. In a world that falls here and rests there, it is small in most strips.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/pair_table.h"

namespace psim {

class StripSpeeds {
 public:
  explicit StripSpeeds(const Surroundings& s) : s_(s) {}

  /// Samples about 64 bodies of each strip, or, where masses differ (`uneven`: a heavy body may throw light ones), all of
  /// them and every large body, which may reach other strips within `time` seconds. O(bodies).
  void measure(const std::vector<Strip>& strips, bool uneven, double time);

  /// The speed of a strip and its neighbours, m/s: the r.m.s. speed about their mean velocity (where masses differ,
  /// about that of their centre of mass), or the speed of the fastest large body there if it is larger. Infinite for
  /// the group of large bodies.
  double at(std::size_t strip) const { return speed_[strip]; }

  /// How much faster the mean velocities of a strip and its neighbours differ than chance makes them, m/s: what a row
  /// that is stopped within the step is met with by the next one.
  double closing(std::size_t strip) const { return closing_[strip]; }

  std::size_t bytes() const { return bytes_of(stirs_, speed_, closing_); }

 private:
  struct Sum {
    double weight = 0;
    Vec2 momentum;
    double square = 0;
    void add(double w, Vec2 v) { add({w, w * v, w * dot(v, v)}); }
    void add(const Sum& o) {
      weight += o.weight;
      momentum = momentum + o.momentum;
      square += o.square;
    }
    Vec2 mean() const { return weight > 0 ? Vec2{momentum.x / weight, momentum.y / weight} : Vec2{}; }
    double spread(Vec2 about) const;
  };
  struct Box {  // a box in velocity space, m/s
    Vec2 low{1e300, 1e300}, high{-1e300, -1e300};
    void add(const Box& o);
    double farthest(Vec2 from) const;
  };
  struct Stir {
    Sum bodies, masses;
    Box heavy;                        // velocities of large and of immovable bodies
    std::int64_t low = 0, high = -1;  // lattice steps: the rows in which its bodies lie
    void look(const BodyStore& bodies, const Strip& strip, bool uneven);
  };

  void place_large(const Strip& large, double time);

  const Surroundings s_;
  std::vector<Stir> stirs_;
  std::vector<double> speed_, closing_;
};

}  // namespace psim
