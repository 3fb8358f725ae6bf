// How fast impacts within a step may make bodies, against those around them. In a world that falls here and rests there,
// it is little in most places: what moves alike hits nobody.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/pair_table.h"

namespace psim {

/// Strip by strip, where masses are alike (docs/decisions/013-slack-by-strip.md).
class StripSpeeds {
 public:
  explicit StripSpeeds(const Surroundings& s) : s_(s) {}

  /// Samples about 64 bodies of each strip. O(strips).
  void measure(const std::vector<Strip>& strips);

  /// The speed of a strip and its neighbours, m/s: the r.m.s. speed about their mean velocity. Infinite for the group of
  /// large bodies.
  double at(std::size_t strip) const { return speed_[strip]; }

  /// How much faster the mean velocities of a strip and its neighbours differ than chance makes them, m/s: what a row
  /// that is stopped within the step is met with by the next one.
  double closing(std::size_t strip) const { return closing_[strip]; }

  std::size_t bytes() const { return bytes_of(sums_, speed_, closing_); }

 private:
  struct Sum {  // over the bodies of a strip
    double bodies = 0;
    Vec2 velocity;
    double square = 0;
    void add(const Sum& o) {
      bodies += o.bodies;
      velocity = velocity + o.velocity;
      square += o.square;
    }
    Vec2 mean() const { return bodies > 0 ? Vec2{velocity.x / bodies, velocity.y / bodies} : Vec2{}; }
    double spread() const;
  };
  struct Box {  // a box in velocity space, m/s
    Vec2 low{1e300, 1e300}, high{-1e300, -1e300};
    void add(Vec2 v);
    double across() const { return length_of(high - low); }
  };

  Sum look(const Strip& strip) const;

  const Surroundings s_;
  std::vector<Sum> sums_;
  std::vector<double> speed_, closing_;
};

/// By what is near a body, where masses differ: a heavy body may throw light ones. Near are the bodies of few segments, which
/// are runs of slots of a strip, bodies side by side in a row; two are beside each other if a pair of lists joins them
/// (docs/decisions/032-slack-by-segment.md).
class SegmentSpeeds {
 public:
  explicit SegmentSpeeds(const Surroundings& s) : s_(s), reach_(s.memory) {}

  /// Finds the largest difference of two velocities, m/s, among the bodies of each segment and of those within kHops of
  /// it, by the pairs of `table`. O(bodies + pairs).
  void measure(const PairTable& table);
  /// The difference that counts for a body of a strip.
  double at(std::size_t strip, std::uint32_t slot) const { return boxes_[segment_of(strip, slot)].across(); }

  /// Fills reach(), by slot: the radius of each body and half of the way that it may go because of impacts, m. The speed
  /// for that is kGain times the difference, and `most` at most, m/s; `time` in seconds. O(bodies).
  void find_reach(double most, double time);
  const float* reach() const { return reach_.data(); }

  /// Makes room for so many bodies.
  void spare(std::size_t bodies);
  /// Gives the memory back, where masses do not differ any more.
  void release();
  std::size_t bytes() const;  ///< without columns
  std::size_t column_bytes() const { return reach_.bytes(); }

 private:
  static constexpr std::uint32_t kSegment = 4;  // slots; a large body is a segment of its own
  // The row that strikes first stops the rows after it.
  static constexpr int kHops = 2;
  // A light body bounces off a heavy one with up to twice the speed at which they met.
  static constexpr double kGain = 2;

  // A box in velocity space as {-low x, -low y, high x, high y}, m/s: four maxima join two.
  struct Box {
    float side[4];
    void add(const Box& o) {
      for (int k = 0; k < 4; ++k) side[k] = side[k] > o.side[k] ? side[k] : o.side[k];
    }
    double across() const;
  };
  struct Edge {
    std::uint32_t a = 0, b = 0;
  };
  struct Run {  // the bodies of a strip; a segment has 2^shift of them
    std::uint32_t begin = 0, end = 0, segment = 0;
    int shift = 0;
    std::uint32_t bodies() const { return 1u << shift; }
    bool has(std::uint32_t slot) const { return slot - begin < end - begin; }
    std::uint32_t of(std::uint32_t slot) const { return segment + ((slot - begin) >> shift); }
  };
  struct Part {
    Run run;
    std::vector<Edge> edges;
  };

  std::uint32_t segment_of(std::size_t strip, std::uint32_t slot) const { return parts_[strip].run.of(slot); }
  void cut(const PairTable& table);
  void find_boxes(const Run& run);
  void find_edges(const PairTable& table, std::size_t strip);

  const Surroundings s_;
  std::vector<Part> parts_;        // by strip
  std::vector<Box> boxes_, next_;  // by segment
  Column<float> reach_;
};

}  // namespace psim
