// Random scenes by kind. All bodies stand in `bodies`, so that a body's id is its place there.
#pragma once

#include "draw.h"
#include "psim/scene.h"

namespace psim::laws {

/// Open space of 1000 m, 1/60 s a frame, nobody sleeps.
Scene space(bool gravity);

BodyDesc body_of(Shape shape, Vec2 at, const Material& material);
BodyDesc fixed_of(Shape shape, Vec2 at, const Material& material);
/// With a random angle and turning at up to +-spin rad/s.
BodyDesc mover_of(Draw& draw, Shape shape, Vec2 at, double speed, double spin, const Material& material);

/// Ground between x = -20 and 20 (flat, sloping, a hill, a valley, a random line), as a chain, as segments, and where
/// it is flat as boxes or one polygon.
void add_terrain(Draw& draw, Scene& scene, const Material& material);

/// One body over a terrain.
Scene one_on_terrain(Draw& draw);
/// One body on a joint that holds it to a static one.
Scene one_on_a_joint(Draw& draw);
/// One of the two.
Scene one_mover(Draw& draw);
/// Two bodies that meet, without gravity and walls.
Scene two_that_meet(Draw& draw);

/// A pen from -6 to 6 m of boxes, a chain or walls.
void add_pen(Draw& draw, Scene& scene, const Material& material);
/// Bodies that start without overlap in a pen, at up to `speed` m/s.
void fill_pen(Draw& draw, Scene& scene, int count, double speed, bool discs_only, const Material* material);

/// Tree of bodies on rods, ropes, springs, pins, welds and slides, hung up or free; they do not collide.
Scene jointed(Draw& draw);

}  // namespace psim::laws
