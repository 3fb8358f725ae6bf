// Springs as rows of joints (docs/joints.md, Springs).
#pragma once

#include <cstdint>

namespace psim {

/// The impulse of a step is -push C - drag (v0 + v') - lag v0, with v0 and v' the speeds of the row before and after it.
struct SpringRow {
  double push = 0;     ///< k h, N s/m or N m s
  double drag = 0;     ///< kg or kg m^2
  double lag = 0;      ///< kg or kg m^2
  double light = 0;    ///< kg or kg m^2: by how much less mass the row has
  double lighter = 0;  ///< the same twice: in steps
};

/// The row for steps of h seconds. `mass`: the effective mass of the row, kg. With angles the units are N m, N m s and
/// kg m^2. `crowd`: the most springs at one of its bodies. Nothing without a mass or a spring.
SpringRow spring_row(double stiffness, double damping, double mass, double h, std::uint32_t crowd);

}  // namespace psim
