// A spring as a row of a joint (docs/joints.md, Springs).
#pragma once

namespace psim {

struct SpringRow {
  double push = 0;  ///< k' h, N s/m or N m s
  double drag = 0;  ///< k' h^2 / 4 + c' h / 2, kg or kg m^2
};

/// The row of a spring of stiffness k, N/m, and damping c, N s/m, for substeps of h seconds. `mass`, kg, is the
/// effective mass of the row. With angles the units are N m, N m s and kg m^2.
SpringRow spring_row(double stiffness, double damping, double mass, double h);

}  // namespace psim
