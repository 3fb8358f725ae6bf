// Springs as rows of joints (docs/joints.md, Springs).
#pragma once

namespace psim {

struct SpringRow {
  double push = 0;  ///< k' h, N s/m or N m s
  double drag = 0;  ///< k' h^2 / 4 + c' h / 2, kg or kg m^2
};

/// The row for steps of h seconds. `mass`: the effective mass of the row, kg. With angles the units are N m, N m s and
/// kg m^2. Nothing without a mass or a spring.
SpringRow spring_row(double stiffness, double damping, double mass, double h);

}  // namespace psim
