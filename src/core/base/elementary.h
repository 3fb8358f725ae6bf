// Functions that C libraries compute differently from one platform to another, as polynomials of our own. Sums, products,
// quotients and square roots are alike everywhere, and so are these.
#pragma once

namespace psim {

/// a < b ? a : b and a > b ? a : b, as lanes have them: b where both are equal, as zeros of two signs are, and where one
/// is a NaN. fmin and fmax leave the zero to the compiler.
constexpr double lesser(double a, double b) { return a < b ? a : b; }
constexpr double greater(double a, double b) { return a > b ? a : b; }
constexpr float lesser(float a, float b) { return a < b ? a : b; }
constexpr float greater(float a, float b) { return a > b ? a : b; }

/// e^x to a relative error of 2e-16; 0 below x = -708, infinity above 709.7.
double exponential(double x);

/// e^x - 1 to a relative error of 5e-16, also where x is small.
double exponential_less_one(double x);

/// x^y of a normal number x > 0, to a relative error of 2e-13 where the result is a normal number.
double power(double x, double y);

/// The natural logarithm, to a relative error of 2e-16, of a normal number x > 0; minus infinity for 0 and less.
double logarithm(double x);

}  // namespace psim
