#include "report/samples.h"

#include <algorithm>
#include <cmath>

namespace psim::cli {

void Samples::reserve(std::uint64_t count) {
  kept_.reserve(static_cast<std::size_t>(std::min<std::uint64_t>(count, kMostKept)));
}

void Samples::add(double value) {
  if (count_ % stride_ == 0) {
    if (kept_.size() == kMostKept) {
      for (std::size_t i = 0; i < kMostKept / 2; ++i) kept_[i] = kept_[2 * i];
      kept_.resize(kMostKept / 2);
      stride_ *= 2;
    }
    if (count_ % stride_ == 0) kept_.push_back(value);
  }
  ++count_;
  sum_ += value;
  max_ = std::max(max_, value);
}

double Samples::percentile(double percent) const {
  if (kept_.empty()) return 0;
  std::vector<double> values = kept_;
  const double rank = std::ceil(percent / 100 * static_cast<double>(values.size()));
  const auto at = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

}  // namespace psim::cli
