#include "base/rotor.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace psim {

SineCosine sine_cosine(double angle) {
  // fmod is exact, so it is the same everywhere. It brings angles into the range of the reduction below.
  constexpr double kTurn = 6.283185307179586;
  if (std::fabs(angle) > 1e9) angle = std::fmod(angle, kTurn);

  // angle = n pi/2 + x, |x| <= pi/4 (Cody & Waite 1980). pi/2 is split into three parts; the first two have
  // 33 bits, so that their products with n are exact while |n| < 2^20.
  constexpr double kHalfPi1 = 1.57079632673412561417e+00;
  constexpr double kHalfPi2 = 6.07710050630396597660e-11;
  constexpr double kHalfPi3 = 2.02226624879595063154e-21;
  constexpr double kTwoOverPi = 6.36619772367581382433e-01;
  constexpr double kRound = 0x1.8p52;  // adding it rounds a number to an integer
  const double shifted = angle * kTwoOverPi + kRound;
  const double n = shifted - kRound;
  const std::uint64_t quadrant = std::bit_cast<std::uint64_t>(shifted) & 3;
  const double x = ((angle - n * kHalfPi1) - n * kHalfPi2) - n * kHalfPi3;

  // Taylor series; the first omitted term is below 1e-16 at pi/4.
  const double z = x * x;
  double sine = -1.0 / 1307674368000;  // 1/15!
  for (const double c : {1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6}) {
    sine = c + z * sine;
  }
  sine = x + x * z * sine;
  double cosine = 1.0 / 20922789888000;  // 1/16!
  for (const double c :
       {-1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320, -1.0 / 720, 1.0 / 24, -0.5}) {
    cosine = c + z * cosine;
  }
  cosine = 1 + z * cosine;

  const bool swapped = (quadrant & 1) != 0;
  const double s = swapped ? cosine : sine;
  const double c = swapped ? sine : cosine;
  return {(quadrant & 2) != 0 ? -s : s, ((quadrant + 1) & 2) != 0 ? -c : c};
}

}  // namespace psim
