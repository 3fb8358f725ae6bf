// The floating-point settings of a step, on the calling thread.
#pragma once

#include <xmmintrin.h>

#include "tasks.h"

namespace psim {

// Round to nearest, denormals are zero (they cost twenty times as much and mean nothing here), no
// traps; whatever the host had comes back at the end.
class FloatSettings {
 public:
  FloatSettings() : before_(_mm_getcsr()) { _mm_setcsr(kMxcsr); }
  ~FloatSettings() { _mm_setcsr(before_); }
  FloatSettings(const FloatSettings&) = delete;
  FloatSettings& operator=(const FloatSettings&) = delete;

 private:
  unsigned before_;
};

}  // namespace psim
