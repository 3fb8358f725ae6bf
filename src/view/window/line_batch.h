// Lines of a frame, gathered for one draw call.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/camera.h"

namespace psim::view {

/// 0xAABBGGRR, as bytes R, G, B, A in memory.
constexpr std::uint32_t rgba(std::uint32_t rgb, double opacity = 1) {
  return (rgb >> 16 & 0xFF) | (rgb & 0xFF00) | (rgb & 0xFF) << 16 | static_cast<std::uint32_t>(opacity * 255) << 24;
}

struct LineInstance {
  float ax, ay, bx, by;  ///< metres from the middle of the window
  float width;           ///< pixels
  std::uint32_t colour;
};

class LineBatch {
 public:
  void begin(const Camera& camera) {
    lines_.clear();
    shown_ = camera.shown();
    centre_ = camera.centre();
  }
  /// What lies beside the window is left out.
  void add(Vec2 a, Vec2 b, float width, std::uint32_t colour) {
    if ((a.x < shown_.xmin && b.x < shown_.xmin) || (a.x > shown_.xmax && b.x > shown_.xmax) ||
        (a.y < shown_.ymin && b.y < shown_.ymin) || (a.y > shown_.ymax && b.y > shown_.ymax)) {
      return;
    }
    lines_.push_back({static_cast<float>(a.x - centre_.x), static_cast<float>(a.y - centre_.y),
                      static_cast<float>(b.x - centre_.x), static_cast<float>(b.y - centre_.y), width, colour});
  }
  std::span<const LineInstance> lines() const { return lines_; }

 private:
  std::vector<LineInstance> lines_;
  Bounds shown_;
  Vec2 centre_;
};

}  // namespace psim::view
