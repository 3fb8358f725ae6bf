// How long hulls that move and turn stay apart: bounds for conservative advancement (Mirtich 1996).
#pragma once

#include "base/rotor.h"
#include "bodies/hull.h"

namespace psim {

/// The first time at which c t + a t^2 / 2 reaches a gap, c: speed, a >= 0: how fast it grows at most.
double time_to_close(double gap, double speed, double growth);

/// For how long no corner of a hull comes deeper, against the normal n, than `gap` below where the lowest one is now. The
/// hull, turned by `q`, comes at `closing` against n and turns at `turn`; speeds grow by `growth` at most, with turn^2
/// reach for what the rotation adds. Each corner has its own height and its own speed.
double time_above(const Hull& hull, SineCosine q, Vec2 n, double gap, double closing, double turn, double growth);

}  // namespace psim
