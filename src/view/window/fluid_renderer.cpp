#include "window/fluid_renderer.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "window/fluid_shaders.h"
#include "window/palette.h"

namespace psim::view {
namespace {

std::string fragment(const char* rest) { return std::string(kFluidColour) + rest; }

void set_pair(const Program& program, const char* name, double x, double y) {
  gl.Uniform2f(program.at(name), static_cast<float>(x), static_cast<float>(y));
}

}  // namespace

FluidRenderer::FluidRenderer()
    : surface_(kSurfaceVertex, fragment(kSurfaceFragment).c_str()),
      particles_(kParticleVertex, fragment(kParticleFragment).c_str()) {
  gl.GenTextures(2, textures_);
  for (const GLuint texture : textures_) {
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  for (const Program* program : {&surface_, &particles_}) {
    program->use();
    gl.Uniform3fv(program->at("palette"), 9, palette().data());
  }
  disc_array_.bind();
  gl.BindBuffer(GL_ARRAY_BUFFER, discs_.id());
  static_assert(sizeof(FluidDrawing::Disc) == 3 * sizeof(float));
  disc_array_.instanced(0, 3, GL_FLOAT);
}

FluidRenderer::~FluidRenderer() { gl.DeleteTextures(2, textures_); }

void FluidRenderer::draw(const FluidDrawing& drawing, const Camera& camera, const WorldDesc& world) {
  for (const FluidDrawing::Part& part : drawing.parts()) {
    if (!part.discs.empty()) draw_discs(part, camera);
    if (!part.field.is_empty()) draw_surface(part, camera, world);
  }
}

void FluidRenderer::set_camera(const Program& program, const Camera& camera, std::uint32_t rgb) const {
  program.use();
  gl.Uniform1f(program.at("scale"), static_cast<float>(camera.pixels_per_metre()));
  set_pair(program, "window", camera.width(), camera.height());
  const float own[] = {static_cast<float>(rgb >> 16 & 0xFF) / 255, static_cast<float>(rgb >> 8 & 0xFF) / 255,
                       static_cast<float>(rgb & 0xFF) / 255};
  gl.Uniform3fv(program.at("own"), 1, own);
}

void FluidRenderer::upload(int unit, const std::vector<float>& nodes, const cli::FluidField& field) const {
  gl.ActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  gl.BindTexture(GL_TEXTURE_2D, textures_[unit]);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, field.columns, field.rows, 0, GL_RED, GL_FLOAT, nodes.data());
}

// The rectangle that the grid, the window and the world have in common.
void FluidRenderer::draw_surface(const FluidDrawing::Part& part, const Camera& camera, const WorldDesc& world) {
  const cli::FluidField& field = part.field;
  const Bounds shown = camera.shown(), &sides = world.bounds;
  const Vec2 origin = field.origin, centre = camera.centre();
  const Vec2 end{origin.x + field.cell * (field.columns - 1), origin.y + field.cell * (field.rows - 1)};
  const Vec2 low{std::max({origin.x, shown.xmin, sides.xmin}), std::max({origin.y, shown.ymin, sides.ymin})};
  const Vec2 high{std::min({end.x, shown.xmax, sides.xmax}), std::min({end.y, shown.ymax, sides.ymax})};
  if (!(low.x < high.x && low.y < high.y)) return;
  set_camera(surface_, camera, part.rgb);
  set_pair(surface_, "low", low.x - centre.x, low.y - centre.y);
  set_pair(surface_, "high", high.x - centre.x, high.y - centre.y);
  set_pair(surface_, "first", (low.x - origin.x) / field.cell, (low.y - origin.y) / field.cell);
  set_pair(surface_, "last", (high.x - origin.x) / field.cell, (high.y - origin.y) / field.cell);
  set_pair(surface_, "nodes", field.columns, field.rows);
  gl.Uniform1f(surface_.at("edge"), cli::kFluidEdge);
  gl.Uniform1i(surface_.at("by_value"), field.value.empty() ? 0 : 1);
  gl.Uniform1i(surface_.at("fullness"), 0);
  gl.Uniform1i(surface_.at("value"), 1);
  if (!field.value.empty()) upload(1, field.value, field);
  upload(0, field.fullness, field);
  nothing_.bind();
  gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, 1);
}

void FluidRenderer::draw_discs(const FluidDrawing::Part& part, const Camera& camera) {
  set_camera(particles_, camera, part.rgb);
  gl.Uniform1f(particles_.at("radius"), part.radius);
  discs_.upload(std::span<const FluidDrawing::Disc>(part.discs));
  disc_array_.bind();
  gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(part.discs.size()));
}

}  // namespace psim::view
