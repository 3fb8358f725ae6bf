// The numbers of a spring for steps of a length.
#include "joints/spring_row.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr double kMostLight = 0.5;  // of the mass of a body: what the springs of all its rows take away

// std::exp would tie the bits to a version of the library. This is the series of sinh, doubled.
double sinh_of(double x) {
  int doublings = 0;
  while (x > 0.5) {
    x /= 2;
    ++doublings;
  }
  const double z = x * x;
  double s = x + x * z * (1.0 / 6 + z * (1.0 / 120 + z * (1.0 / 5040 + z / 362880)));
  for (; doublings > 0; --doublings) s = 2 * s * std::sqrt(1 + s * s);
  return s;
}

// 1 - y cot y for y up to 1/2.
double less_than_one(double y) {
  const double z = y * y;
  return z *
         (1.0 / 3 + z * (1.0 / 45 + z * (2.0 / 945 + z * (1.0 / 4725 + z * (2.0 / 93555 + z * (1382.0 / 638512875))))));
}

// The share of the speed after a step with which friction of rate z over the step slows down as exp(-z): from 1/2, where
// z is small, to 1.
double end_share(double z) {
  if (z < 1e-2) return 0.5 + z / 12;
  if (z > 60) return 1 - 1 / z;
  const double s = sinh_of(z / 2);
  return 0.5 + 0.5 * std::sqrt(1 + s * s) / s - 1 / z;
}

}  // namespace

// The trapezoidal rule has rest where forces balance, but the wrong frequency. Exact for an oscillator is
//   p (x' - x) = h (v + v')/2,  p m (v' - v) = -h k (x + x')/2,  p = y cot y,  y = w h/2
// which keeps its energy, and rests where it should, for any p. With u = v/p it is the trapezoidal rule for a mass of
// p^2 m. A spring that h does not resolve (w h > 1) is damped: half of such motion is left after a step from w h = 2 on
// (Newmark's rule).
SpringRow spring_row(double stiffness, double damping, double mass, double h, std::uint32_t crowd) {
  SpringRow out;
  if (!(mass > 0) || !(stiffness > 0 || damping > 0)) return out;
  const double turn = std::sqrt(stiffness / mass) * h;
  const double room = kMostLight / std::max<std::uint32_t>(crowd, 1);
  const double less = lesser(less_than_one(lesser(turn, 1) / 2), 1 - std::sqrt(1 - room));
  const double lighter = mass * less * (2 - less);
  const double blur = lesser(greater(turn - 1, 0), 1) / 3, late = blur * blur / 2;
  const double pull = stiffness * h * h, friction = damping * h;
  const double end = end_share(friction / mass);
  out.push = stiffness * h;
  out.drag = pull * (0.25 + (blur - late) / 2 + late) + friction * end - lighter;
  out.lag = friction * (1 - 2 * end) - late * pull + 2 * lighter;
  out.light = mass * less;
  out.lighter = lighter;
  return out;
}

}  // namespace psim
