// Times of many frames: exact mean, count and maximum, and percentiles.
//
// Up to kMostKept values are kept, so percentiles are exact for that many frames. Beyond, every
// second, then every fourth … value is kept: a run of a billion frames needs no more memory than
// one of a few hundred thousand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace psim::cli {

class Samples {
 public:
  static constexpr std::size_t kMostKept = 1 << 18;

  /// Makes room so that `add` allocates nothing in a run of `count` frames.
  void reserve(std::uint64_t count);
  void add(double value);

  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double max() const { return max_; }
  /// The smallest kept value that at least `percent` % of them do not exceed (nearest rank).
  double percentile(double percent) const;

 private:
  std::vector<double> kept_;
  std::uint64_t stride_ = 1;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double max_ = 0;
};

}  // namespace psim::cli
