// The numbers of a spring for steps of a length.
#include "joints/spring_row.h"

#include <cmath>

#include "base/rotor.h"

namespace psim {
namespace {

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

}  // namespace

// The implicit midpoint rule moves an oscillator of stiffness k', damping c' exactly as one of
// frequency w and damping rate r moves in reality, if the roots s' = (2/h) tanh(s h/2) belong to
// them (bilinear transform, frequencies warped beforehand; Tustin 1947). With q^2 = w^2 - r^2,
//   k'/m = 4/h^2 (S + Q)/(1 + S - Q),  c'/m = 4/h sinh(a) cosh(a)/(1 + S - Q)
//   a = r h/2,  S = sinh^2 a,  Q = sin^2(q h/2)
// A spring that h does not resolve (w h > 1) is damped, critically from w h = 2 on. Undamped it would gain energy from
// rotation and from other joints.
SpringRow spring_row(double stiffness, double damping, double mass, double h) {
  SpringRow out;
  if (!(mass > 0) || !(stiffness > 0 || damping > 0)) return out;
  const double w = std::sqrt(stiffness / mass);
  const double r = std::fmax(damping / (2 * mass), w * std::fmin(std::fmax(w * h - 1, 0), 1));
  const double a = r * h / 2;
  double k = 0, c = 0;  // h^2/4 k'/m, h/4 c'/m
  if (w > r) {
    const double s = sinh_of(a), q = sine_cosine(std::sqrt(w * w - r * r) * h / 2).sine;
    const double below = 1 + s * s - q * q;
    k = (s * s + q * q) / below;
    c = s * std::sqrt(1 + s * s) / below;
  } else {  // overdamped: Q = -sinh^2 b
    const double b = std::sqrt(r * r - w * w) * h / 2;
    const double less = a + b > 0 ? w * w * h * h / 4 / (a + b) : 0;  // a - b
    const double t = sinh_of(std::fmin(less, 30.0));
    if (a < 15) {
      const double s = sinh_of(a), sb = sinh_of(b);
      const double below = 1 + s * s + sb * sb;
      k = sinh_of(a + b) * t / below;
      c = s * std::sqrt(1 + s * s) / below;
    } else {
      k = t / std::sqrt(1 + t * t);
      c = (1 + k) / 2;
    }
  }
  out.push = 4 * mass * k / h;
  out.drag = mass * (k + 2 * c);
  return out;
}

}  // namespace psim
