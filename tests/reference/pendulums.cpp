#include "pendulums.h"

#include <cmath>
#include <cstddef>

namespace reference {
namespace {

/// The Runge-Kutta method of fourth order, in `steps` steps.
template <std::size_t N, class Slope>
std::array<double, N> runge_kutta(std::array<double, N> y, double time, int steps, const Slope& slope) {
  const double h = time / steps;
  const auto ahead = [&](const std::array<double, N>& k, double s) {
    std::array<double, N> z = y;
    for (std::size_t i = 0; i < N; ++i) z[i] += s * k[i];
    return z;
  };
  for (int n = 0; n < steps; ++n) {
    const auto k1 = slope(y);
    const auto k2 = slope(ahead(k1, h / 2));
    const auto k3 = slope(ahead(k2, h / 2));
    const auto k4 = slope(ahead(k3, h));
    for (std::size_t i = 0; i < N; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
  return y;
}

}  // namespace

double pendulum_period(double length, double angle, double g) {
  return 4 * std::sqrt(length / g) * std::comp_ellint_1(std::sin(angle / 2));
}

DoublePendulum::State DoublePendulum::slope(const State& y) const {
  const double d = y[0] - y[1], lever = length * centre;
  const double m00 = inertia + centre * centre + length * length;
  const double m11 = inertia + centre * centre, m01 = lever * std::cos(d);
  const double f0 = -lever * std::sin(d) * y[3] * y[3] - (centre + length) * g * std::sin(y[0]);
  const double f1 = lever * std::sin(d) * y[2] * y[2] - centre * g * std::sin(y[1]);
  const double det = m00 * m11 - m01 * m01;
  return {y[2], y[3], (m11 * f0 - m01 * f1) / det, (m00 * f1 - m01 * f0) / det};
}

DoublePendulum::State DoublePendulum::after(double time, State start) const {
  return runge_kutta(start, time, 20000, [this](const State& y) { return slope(y); });
}

double chain_sag(int links, double link, double span) {
  // Weights below the middle in units of one; pull: horizontal, in the same units.
  const auto load = [links](int k) { return 0.5 * (links - 1) - k; };
  double low = 1e-6, high = 1e6;
  for (int n = 0; n < 200; ++n) {
    const double pull = std::sqrt(low * high);
    double width = 0;
    for (int k = 0; k < links; ++k) width += link * pull / std::hypot(pull, load(k));
    (width < span ? low : high) = pull;
  }
  double sag = 0;
  for (int k = 0; k < links / 2; ++k) sag += link * load(k) / std::hypot(low, load(k));
  return sag;
}

}  // namespace reference
