#include "window/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "window/palette.h"
#include "window/shaders.h"

namespace psim::view {
namespace {

constexpr std::size_t kTexels = 6;  // a kind, see shaders.h

// From the middle of a shape to its edge, metres.
double depth_of(const Kind& kind) {
  const std::size_t n = kind.points.size();
  if (n < 3) return kind.radius;
  Vec2 middle;
  for (const Vec2& p : kind.points) {
    middle = {middle.x + p.x / static_cast<double>(n), middle.y + p.y / static_cast<double>(n)};
  }
  double depth = kind.reach;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 p = kind.points[k], q = kind.points[(k + 1) % n];
    const double ux = q.x - p.x, uy = q.y - p.y;
    const double across = ux * (middle.y - p.y) - uy * (middle.x - p.x);
    depth = std::min(depth, std::fabs(across) / std::hypot(ux, uy));
  }
  return depth + kind.radius;
}

std::string body_shader(const char* rest) { return std::string(kBodyVertexHead) + rest; }

}  // namespace

Renderer::Renderer()
    : discs_(body_shader(kDiscVertex).c_str(), kDiscFragment),
      areas_(body_shader(kAreaVertex).c_str(), kAreaFragment),
      lines_(kLineVertex, kLineFragment) {
  body_array_.bind();
  for (GLuint k = 0; k < kColumns; ++k) {
    gl.BindBuffer(GL_ARRAY_BUFFER, columns_[k].id());
    body_array_.instanced(k, 1, k < 8 ? GL_FLOAT : k == 8 ? GL_UNSIGNED_BYTE : GL_UNSIGNED_INT);
  }
  gl.GenTextures(1, &kind_texture_);
  for (const Program* program : {&discs_, &areas_}) {
    program->use();
    gl.Uniform3fv(program->at("palette"), 9, palette().data());
  }
}

Renderer::~Renderer() { gl.DeleteTextures(1, &kind_texture_); }

void Renderer::upload(const BodyColumns& bodies, Colouring colouring) {
  bodies_ = bodies.size();
  if (bodies_ == 0) return;
  const Snapshot& s = *bodies.snapshot();
  // One column is what colours are of: the speed, or forces, strips and colours once they are there.
  const bool forces = colouring == Colouring::force && !bodies.forces().empty();
  const bool groups = colouring >= Colouring::strip;
  if (groups && bodies.groups().empty()) no_groups_.assign(bodies_, kNoGroup);
  const std::vector<float>& shown = forces                    ? bodies.forces()
                                    : !groups                 ? s.speed
                                    : bodies.groups().empty() ? no_groups_
                                                              : bodies.groups();
  const std::vector<float>* floats[] = {&s.x, &s.y, &s.x_prev, &s.y_prev, &s.angle, &s.angle_prev, &s.radius, &shown};
  find_parts(bodies);
  for (std::size_t k = 0; k < 8; ++k) upload_column(k, *floats[k], floats_);
  upload_column(8, s.asleep, bytes_);
  columns_[9].upload(std::span<const std::uint32_t>(part_rows_.empty() ? bodies.looks() : part_looks_));
  bodies_ += part_rows_.size();
  origin_ = s.origin;
  bright_ = bodies.bright(forces || colouring != Colouring::force ? colouring : Colouring::speed);
  upload_kinds(bodies.catalogue());
}

// Each part of a compound is drawn as a body of its own, behind the others.
void Renderer::find_parts(const BodyColumns& bodies) {
  part_rows_.clear();
  part_looks_.clear();
  const Catalogue& catalogue = *bodies.catalogue();
  if (!catalogue.has_compounds()) return;
  part_looks_ = bodies.looks();
  for (std::size_t row = 0; row < bodies.size(); ++row) {
    const std::uint32_t look = bodies.looks()[row];
    for (const std::uint32_t kind : catalogue.kinds()[look & kKindMask].parts) {
      part_rows_.push_back(static_cast<std::uint32_t>(row));
      part_looks_.push_back((look & ~kKindMask) | kind);
    }
  }
}

// `room` is scratch.
template <class T>
void Renderer::upload_column(std::size_t number, const std::vector<T>& column, std::vector<T>& room) {
  if (part_rows_.empty()) return columns_[number].upload(std::span<const T>(column));
  room.assign(column.begin(), column.end());
  for (const std::uint32_t row : part_rows_) room.push_back(column[row]);
  columns_[number].upload(std::span<const T>(room));
}

void Renderer::upload_kinds(const std::shared_ptr<const Catalogue>& catalogue) {
  if (catalogue_ == catalogue) return;
  catalogue_ = catalogue;
  has_areas_ = catalogue->has_areas();
  const std::vector<Kind>& kinds = catalogue->kinds();
  std::vector<std::array<float, 4>> texels(kinds.size() * kTexels);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const Kind& kind = kinds[k];
    if (kind.line || kind.points.empty()) continue;  // no points: not drawn as an area
    std::array<float, 4>* const texel = texels.data() + k * kTexels;
    const auto f = [](double v) { return static_cast<float>(v); };
    texel[0] = {f(static_cast<double>(kind.points.size())), f(kind.radius), f(depth_of(kind)), 0};
    const auto [left, right] = std::ranges::minmax(kind.points, {}, &Vec2::x);
    const auto [low, high] = std::ranges::minmax(kind.points, {}, &Vec2::y);
    texel[1] = {f(left.x), f(low.y), f(right.x), f(high.y)};
    for (std::size_t p = 0; p < std::min<std::size_t>(kind.points.size(), 8); ++p) {
      texel[2 + p / 2][2 * (p % 2)] = f(kind.points[p].x);
      texel[2 + p / 2][2 * (p % 2) + 1] = f(kind.points[p].y);
    }
  }
  kind_buffer_.upload(std::span<const std::array<float, 4>>(texels));
  gl.BindTexture(GL_TEXTURE_BUFFER, kind_texture_);
  gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, kind_buffer_.id());
}

void Renderer::upload(const LineBatch& below, const LineBatch& above) {
  below_count_ = below.lines().size();
  above_count_ = above.lines().size();
  joined_.assign(below.lines().begin(), below.lines().end());
  joined_.insert(joined_.end(), above.lines().begin(), above.lines().end());
  if (!joined_.empty()) line_buffer_.upload(std::span<const LineInstance>(joined_));
}

void Renderer::clear(int width, int height) {
  gl.Viewport(0, 0, width, height);
  gl.ClearColor(0.071f, 0.086f, 0.114f, 1);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
}

void Renderer::draw_bodies(const Camera& camera, float alpha, Colouring colouring) {
  if (bodies_ == 0) return;
  if (has_areas_) draw(areas_, camera, alpha, colouring);
  draw(discs_, camera, alpha, colouring);
}

void Renderer::draw(const Program& program, const Camera& camera, float alpha, Colouring colouring) {
  program.use();
  gl.Uniform1f(program.at("alpha"), alpha);
  gl.Uniform2f(program.at("shift"), static_cast<float>(origin_.x - camera.centre().x),
               static_cast<float>(origin_.y - camera.centre().y));
  gl.Uniform1f(program.at("scale"), static_cast<float>(camera.pixels_per_metre()));
  gl.Uniform2f(program.at("window"), static_cast<float>(camera.width()), static_cast<float>(camera.height()));
  gl.Uniform1i(program.at("colouring"), static_cast<int>(colouring));
  gl.Uniform1f(program.at("bright"), bright_);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_BUFFER, kind_texture_);
  if (&program == &areas_) gl.Uniform1i(program.at("kinds"), 0);
  body_array_.bind();
  gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(bodies_));
}

void Renderer::draw_lines(const Camera& camera, std::size_t first, std::size_t count) {
  if (count == 0) return;
  lines_.use();
  gl.Uniform1f(lines_.at("scale"), static_cast<float>(camera.pixels_per_metre()));
  gl.Uniform2f(lines_.at("window"), static_cast<float>(camera.width()), static_cast<float>(camera.height()));
  line_array_.bind();
  gl.BindBuffer(GL_ARRAY_BUFFER, line_buffer_.id());
  const std::size_t at = first * sizeof(LineInstance);
  constexpr auto kStride = static_cast<GLsizei>(sizeof(LineInstance));
  line_array_.instanced(0, 4, GL_FLOAT, kStride, at + offsetof(LineInstance, ax));
  line_array_.instanced(1, 1, GL_FLOAT, kStride, at + offsetof(LineInstance, width));
  line_array_.instanced(2, 4, GL_UNSIGNED_BYTE, kStride, at + offsetof(LineInstance, colour), true);
  gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count));
}

}  // namespace psim::view
