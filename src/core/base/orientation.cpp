// After J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", Discrete &
// Computational Geometry 18 (1997): rounded arithmetic where its error cannot change the sign, else a sum of doubles that
// is exact.
#include "base/orientation.h"

#include <cmath>
#include <cstddef>

namespace psim {
namespace {

/// A number as the sum of doubles that do not overlap, from the least to the largest.
class ExactSum {
 public:
  void add_product(double a, double b) {
    // Veltkamp and Dekker: both factors as sums of halves, whose products are exact.
    const double high = a * b, a_big = big_half(a), b_big = big_half(b), a_small = a - a_big, b_small = b - b_big;
    add(a_small * b_small - (((high - a_big * b_big) - a_small * b_big) - a_big * b_small));
    add(high);
  }

  int sign() const {
    for (std::size_t k = count_; k-- > 0;) {
      if (terms_[k] != 0) return terms_[k] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  static double big_half(double v) {
    const double scaled = 0x8000001p0 * v;  // 2^27 + 1
    return scaled - (scaled - v);
  }

  void add(double carry) {
    for (std::size_t k = 0; k < count_; ++k) {
      const double sum = carry + terms_[k], part = sum - carry;
      terms_[k] = (carry - (sum - part)) + (terms_[k] - part);
      carry = sum;
    }
    terms_[count_++] = carry;
  }

  double terms_[12] = {};
  std::size_t count_ = 0;
};

}  // namespace

int side_of(Vec2 a, Vec2 b, Vec2 c) {
  const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x), difference = left - right;
  const double error = (3 + 16 * 0x1p-53) * 0x1p-53 * (std::fabs(left) + std::fabs(right));
  if (std::fabs(difference) > error) return difference > 0 ? 1 : -1;
  if (error == 0) return 0;  // points in a row or column, or in one place
  ExactSum sum;
  sum.add_product(a.x, b.y);
  sum.add_product(-a.y, b.x);
  sum.add_product(b.x, c.y);
  sum.add_product(-b.y, c.x);
  sum.add_product(c.x, a.y);
  sum.add_product(-c.y, a.x);
  return sum.sign();
}

}  // namespace psim
