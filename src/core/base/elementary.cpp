#include "base/elementary.h"

#include <bit>
#include <cfloat>
#include <cstdint>
#include <limits>

static_assert(FLT_EVAL_METHOD == 0, "floats and doubles must be computed as such, not as longer numbers");
static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

namespace psim {
namespace {

// ln 2 in two parts; products of the first one with whole numbers below 2^20 are exact.
constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
constexpr double kRound = 0x1.8p52;  // adding it rounds a number to an integer
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// 2^n for -1022 <= n <= 1023.
double power_of_two(std::int64_t n) { return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52); }

// (e^x - 1 - x) / x^2 for |x| <= 0.35: its Taylor series. The first term that is left out is below 1e-17.
double exponential_tail(double x) {
  double sum = 1;
  for (int k = 15; k > 2; --k) sum = 1 + x / k * sum;
  return 0.5 * sum;
}

}  // namespace

// x = n ln 2 + r, |r| <= ln 2 / 2 (Cody & Waite 1980).
double exponential(double x) {
  if (!(x > -708)) return x == x ? 0 : x;
  if (x > 709.7) return kInfinity;
  const double n = (x * 1.4426950408889634 + kRound) - kRound;
  const double high = x - n * kLn2High, low = n * kLn2Low, r = high - low;
  const double part = 1 + (high - (low - r * r * exponential_tail(r)));
  const auto whole = static_cast<std::int64_t>(n);
  return power_of_two(whole / 2) * part * power_of_two(whole - whole / 2);
}

double power(double x, double y) { return exponential(y * logarithm(x)); }

double exponential_less_one(double x) {
  if (x > -0.35 && x < 0.35) return x + x * x * exponential_tail(x);
  return exponential(x) - 1;
}

// x = 2^n m with m near 1, and ln m = 2 artanh f for f = (m - 1) / (m + 1), |f| < 0.172.
double logarithm(double x) {
  if (!(x > 0)) return x == x ? -kInfinity : x;
  if (x == kInfinity) return x;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  auto n = static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023);
  double m = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFu) | 0x3FF0000000000000u);
  if (m > 1.4142135623730951) {
    m /= 2;
    n += 1;
  }
  const double less = m - 1, f = less / (2 + less), z = f * f;
  double sum = 0;
  for (int k = 21; k > 1; k -= 2) sum = z * (1.0 / k + sum);
  const double square = 0.5 * less * less;  // 2 f = less - f less: the sum is added to what is exact
  const double small = f * (square + 2 * sum);
  return n * kLn2High + (less - (square - (small + n * kLn2Low)));
}

}  // namespace psim
