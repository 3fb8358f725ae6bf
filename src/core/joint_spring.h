// A spring as a row of a joint: docs/joints.md, Springs.
#pragma once

namespace psim {

struct SpringRow {
  double push = 0;  ///< k' h, N s/m or N m s
  double drag = 0;  ///< k' h^2 / 4 + c' h / 2, kg or kg m^2
};

/// Of stiffness k, N/m, damping c, N s/m, and a row of `mass`, kg, for substeps of h seconds; or with
/// angles, N m, N m s and kg m^2.
SpringRow spring_row(double stiffness, double damping, double mass, double h);

}  // namespace psim
