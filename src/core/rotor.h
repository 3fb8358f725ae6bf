// Sine and cosine by our own polynomials: the library's differ from one build to another.
#pragma once

namespace psim {

struct SineCosine {
  double sine = 0, cosine = 1;
};

/// Of any finite angle in radians, to about 1e-12 for |angle| < 1e6.
SineCosine sine_cosine(double angle);

}  // namespace psim
