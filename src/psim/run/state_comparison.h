// Where two courses of states part: bit by bit, body by body. Signed zeros are alike, as in the
// state hash; NaN is compared by its bits like every other number. O(bodies) a frame.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "psim/world.h"

namespace psim::cli {

inline constexpr std::array<std::string_view, 6> kStateFields = {"x", "y", "angle", "vx", "vy", "omega"};
inline constexpr std::size_t kFirstVelocityField = 3;

/// One frame of every body, by ascending id.
struct StateView {
  std::span<const std::uint32_t> id;
  std::array<std::span<const double>, kStateFields.size()> fields;
};

StateView view_of(const PublishedState& state);

/// The first number that differs, or the first body that only one side has.
struct FirstDifference {
  std::uint64_t frame = 0;
  std::uint32_t body = 0;
  std::optional<std::size_t> field;  ///< index into kStateFields; none: one side lacks the body
  double a = 0, b = 0;
  bool only_in_a = false;
};

/// "body 3 vx: 1 (0x3ff0000000000000) against 2 (0x4000000000000000)"; `a` and `b` name the sides.
std::string difference_text(const FirstDifference& first, std::string_view a, std::string_view b);

class StateComparison {
 public:
  struct Largest {
    double difference = 0;  ///< infinite where only one of the two is finite
    std::uint64_t frame = 0;
    std::uint32_t body = 0;
  };

  /// Compares a frame; true if it is the same on both sides.
  bool add(std::uint64_t frame, const StateView& a, const StateView& b);

  std::uint64_t differing_frames() const { return differing_frames_; }
  std::uint64_t differing_bodies() const { return differing_bodies_; }
  const std::optional<FirstDifference>& first() const { return first_; }
  /// Whether velocities differed, and not places alone, in the first frame that differs.
  bool motion_differs_at_first() const { return motion_differs_at_first_; }
  /// By field.
  const std::array<Largest, kStateFields.size()>& largest() const { return largest_; }

 private:
  void note(const FirstDifference& difference);
  bool same_body(std::uint64_t frame, const StateView& a, std::size_t row_a, const StateView& b, std::size_t row_b);
  void mark(std::uint32_t body);

  std::optional<FirstDifference> first_;
  bool motion_differs_at_first_ = false;
  std::uint64_t differing_frames_ = 0, differing_bodies_ = 0;
  static constexpr std::uint32_t kChunk = 1 << 16;
  std::map<std::uint32_t, std::bitset<kChunk>> marked_;  // by id / kChunk: ids may be anything
  std::array<Largest, kStateFields.size()> largest_;
};

}  // namespace psim::cli
