// The floating-point settings of a step, on the calling thread, from construction to destruction. The host's own
// settings come back at the end.
#pragma once

#include "base/machine.h"

namespace psim {

class FloatSettings {
 public:
  FloatSettings() : before_(float_settings()) { set_float_settings(kStepFloatSettings); }
  ~FloatSettings() { set_float_settings(before_); }
  FloatSettings(const FloatSettings&) = delete;
  FloatSettings& operator=(const FloatSettings&) = delete;

 private:
  std::uint32_t before_;
};

}  // namespace psim
