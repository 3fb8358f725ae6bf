// Sine and cosine by polynomials of our own, because those of C libraries differ from one platform to another.
#pragma once

namespace psim {

struct SineCosine {
  double sine = 0, cosine = 1;
};

/// Sine and cosine of a finite angle in radians, to about 1e-12 for |angle| < 1e6.
SineCosine sine_cosine(double angle);

}  // namespace psim
