// Draws fluids with OpenGL: for each a rectangle with the grid of its surface as a texture, and discs.
#pragma once

#include <memory>
#include <vector>

#include "model/camera.h"
#include "model/fluid_drawing.h"
#include "window/gl.h"

namespace psim::view {

class FluidRenderer {
 public:
  FluidRenderer();
  ~FluidRenderer();
  FluidRenderer(const FluidRenderer&) = delete;
  FluidRenderer& operator=(const FluidRenderer&) = delete;

  /// Hands the parts to the GPU and draws them, one after the other.
  void draw(const FluidDrawing& drawing, const Camera& camera, const WorldDesc& world);

 private:
  void set_camera(const Program& program, const Camera& camera, std::uint32_t rgb) const;
  void draw_surface(const FluidDrawing::Part& part, const Camera& camera, const WorldDesc& world);
  void draw_discs(const FluidDrawing::Part& part, const Camera& camera);
  void upload(int unit, const std::vector<float>& nodes, const cli::FluidField& field) const;

  Program surface_, particles_;
  VertexArray nothing_, disc_array_;
  Buffer discs_;
  GLuint textures_[2] = {};  // fullness, value
};

}  // namespace psim::view
