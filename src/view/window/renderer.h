// Draws a frame with OpenGL: discs in one call, polygons and capsules in one, lines in one.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/body_columns.h"
#include "model/camera.h"
#include "window/gl.h"
#include "window/line_batch.h"

namespace psim::view {

class Renderer {
 public:
  Renderer();
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Hands the columns to the GPU, and what colours need.
  void upload(const BodyColumns& bodies, Colouring colouring);
  void upload(const LineBatch& below, const LineBatch& above);

  void clear(int width, int height);
  void draw_bodies(const Camera& camera, float alpha, Colouring colouring);
  void draw_below(const Camera& camera) { draw_lines(camera, 0, below_count_); }
  void draw_above(const Camera& camera) { draw_lines(camera, below_count_, above_count_); }

 private:
  static constexpr std::size_t kColumns = 10;
  void draw(const Program& program, const Camera& camera, float alpha, Colouring colouring);
  void draw_lines(const Camera& camera, std::size_t first, std::size_t count);
  void find_parts(const BodyColumns& bodies);
  template <class T>
  void upload_column(std::size_t number, const std::vector<T>& column, std::vector<T>& room);
  void upload_kinds(const std::shared_ptr<const Catalogue>& catalogue);

  Program discs_, areas_, lines_;
  VertexArray body_array_, line_array_;
  Buffer columns_[kColumns], line_buffer_, kind_buffer_;
  GLuint kind_texture_ = 0;
  std::vector<LineInstance> joined_;
  std::vector<float> no_groups_;
  std::vector<std::uint32_t> part_rows_, part_looks_;  // of parts of compounds; looks of all rows before them, too
  std::vector<float> floats_;                          // scratch
  std::vector<std::uint8_t> bytes_;                    // scratch
  std::size_t bodies_ = 0, below_count_ = 0, above_count_ = 0;
  std::shared_ptr<const Catalogue> catalogue_;  // of the kinds on the GPU
  bool has_areas_ = false;
  Vec2 origin_;
  float bright_ = 1;  // of the colouring
};

}  // namespace psim::view
