// How fast bodies move against those around them, strip by strip: what an impact within a step may change a
// body's velocity by. Where a world falls here and rests there, that is little in most strips.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "body_store.h"
#include "pair_table.h"
#include "worker_pool.h"

namespace psim {

class StripSpeeds {
 public:
  struct Settings {
    bool uneven = false;    ///< a heavy body may throw light ones: masses count
    bool periodic = false;  ///< the last strip meets the first
    double pitch_y = 1;     ///< m of a lattice step
    double time = 0;        ///< s, of a step: how far large bodies come
  };

  /// Looks at some 64 bodies of a strip, or at all where masses differ, and at every large one. O(bodies).
  void measure(const BodyStore& bodies, const std::vector<Strip>& strips, const Settings& settings,
               WorkerPool& pool);

  /// Of a strip and its neighbours, m/s: r.m.s. about their common velocity, where masses differ about that of their
  /// centre of mass, or that of the fastest large body about, if it is more. Infinite for the large bodies' group.
  double at(std::size_t strip) const { return speed_[strip]; }

  std::size_t bytes() const {
    return stirs_.capacity() * sizeof(Stir) +
           (low_.capacity() + high_.capacity()) * sizeof(std::int64_t) + speed_.capacity() * sizeof(double);
  }

 private:
  struct Sum {
    double weight = 0, x = 0, y = 0, square = 0;
    void add(double w, double vx, double vy) {
      weight += w;
      x += w * vx;
      y += w * vy;
      square += w * (vx * vx + vy * vy);
    }
    void add(const Sum& o) {
      weight += o.weight;
      x += o.x;
      y += o.y;
      square += o.square;
    }
    Vec2 mean() const { return weight > 0 ? Vec2{x / weight, y / weight} : Vec2{}; }
    double spread(Vec2 about) const;
  };
  struct Box {  // of velocities, m/s
    double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
    void add(double x, double y);
    void add(const Box& o);
    double farthest(Vec2 from) const;
  };
  struct Stir {
    Sum bodies, masses;
    Box heavy;                            // large bodies, and those that nothing moves
    std::int64_t low = 0, high = -1;      // lattice steps up: where its bodies lie
  };

  void look(const BodyStore& bodies, const Strip& strip, Stir& out) const;
  void place_large(const BodyStore& bodies, const Strip& large);

  Settings settings_;
  std::vector<Stir> stirs_;
  std::vector<std::int64_t> low_, high_;  // of a strip and all after it, of it and all before: both ascend
  std::vector<double> speed_;
};

}  // namespace psim
