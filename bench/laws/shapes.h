// Random shapes and materials, and simple measures of shapes.
#pragma once

#include <vector>

#include "draw.h"
#include "psim/desc.h"
#include "psim/world.h"

namespace psim::laws {

/// Metres: the farthest point of a shape from the place of its body.
double reach_of(const Shape& shape);
/// Metres: about half of the least width.
double inner_of(const Shape& shape);
/// Metres: where the parts of a body are; of one that is no compound, its place.
std::vector<Vec2> places_of(const Shape& shape, const BodyState& state);
/// m^2; 0 for lines.
double area_of(const Shape& shape);

/// A disc, box, polygon, capsule or rounded box that reaches about r metres.
Shape draw_shape(Draw& draw, double r);
/// A shape with corners or flat sides.
Shape draw_cornered(Draw& draw, double r);
/// Two to four shapes as one body that reaches about r metres.
Shape draw_compound(Draw& draw, double r);
Material draw_material(Draw& draw);
Material elastic();
/// What does not bounce.
Material draw_dull(Draw& draw);

}  // namespace psim::laws
