// Functions that C libraries compute differently from one platform to another, as polynomials of our own. Sums, products,
// quotients and square roots are alike everywhere, and so are these.
#pragma once

namespace psim {

/// e^x to a relative error of 2e-16; 0 below x = -708, infinity above 709.7.
double exponential(double x);

/// e^x - 1 to a relative error of 5e-16, also where x is small.
double exponential_less_one(double x);

/// The natural logarithm, to a relative error of 2e-16, of a normal number x > 0; minus infinity for 0 and less.
double logarithm(double x);

}  // namespace psim
