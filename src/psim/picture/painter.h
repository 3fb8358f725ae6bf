// Paints a scene at one moment: the world's sides, fluids, bodies by id, joints, wells.
#pragma once

#include <vector>

#include "options/picture_options.h"
#include "picture/canvas.h"
#include "picture/picture_view.h"
#include "picture/scene_shapes.h"

namespace psim::cli {

/// What gets the brightest colour, m/s, rad/s and N: nearly the most of the bodies that move, so that a stray does
/// not leave the rest in the dark, and at least so much that what rests looks at rest.
struct Brightest {
  double speed = 1, spin = 1, force = 1;
  double fluid_speed = 1, pressure = 1;  ///< m/s and N/m, of particles
};
Brightest brightest(const Scene& scene, const Moment& moment, const SceneShapes& shapes);

/// Dark violet to yellow for 0 to 1; what is not finite is yellow.
Colour ramp(double share);

class Painter {
 public:
  /// Reads the scene as long as it lives.
  Painter(const Scene& scene, const PictureOptions& options);

  /// Paints over whatever the canvas holds. Costs about 0.3 microseconds a disc of 3 pixels (docs/pictures.md).
  void paint(Canvas& canvas, const PictureCamera& camera, const Moment& moment, const Brightest& bright) const;

  const SceneShapes& shapes() const { return shapes_; }

 private:
  struct OneFluid;

  Colour colour_of(const Moment& moment, std::size_t row, const Brightest& bright) const;
  void paint_world(Canvas& canvas, const PictureCamera& camera) const;
  void paint_bodies(Canvas& canvas, const PictureCamera& camera, const Moment& moment, const Brightest& bright) const;
  void paint_body(Canvas& canvas, const PictureCamera& camera, const Moment& moment, std::size_t row, Vec2 shift,
                  Colour colour) const;
  void paint_contacts(Canvas& canvas, const PictureCamera& camera, const Moment& moment) const;
  void paint_joints(Canvas& canvas, const PictureCamera& camera, const Moment& moment) const;
  void paint_water(Canvas& canvas, const PictureCamera& camera) const;
  void paint_fluids(Canvas& canvas, const PictureCamera& camera, const Moment& moment, const Brightest& bright) const;
  void paint_surface(Canvas& canvas, const PictureCamera& camera, const OneFluid& fluid) const;
  void paint_particles(Canvas& canvas, const PictureCamera& camera, const OneFluid& fluid) const;
  void paint_wells(Canvas& canvas, const PictureCamera& camera) const;

  const Scene& scene_;
  Colouring colouring_;
  FluidStyle fluid_style_;
  FluidColouring fluid_colouring_;
  SceneShapes shapes_;
};

}  // namespace psim::cli
