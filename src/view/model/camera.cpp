#include "model/camera.h"

#include <algorithm>

namespace psim::view {
namespace {

constexpr double kMargin = 1.06;
constexpr double kLeastScale = 1e-6, kMostScale = 1e7;

}  // namespace

void Camera::resize(int width, int height) {
  width_ = std::max(width, 1);
  height_ = std::max(height, 1);
}

void Camera::fit(const Bounds& part, int width, int height, int covered) {
  resize(width, height);
  const double across = std::max(part.xmax - part.xmin, 1e-6) * kMargin;
  const double up = std::max(part.ymax - part.ymin, 1e-6) * kMargin;
  scale_ = std::clamp(std::min((width_ - covered) / across, height_ / up), kLeastScale, kMostScale);
  centre_ = {(part.xmin + part.xmax) / 2 - covered / (2 * scale_), (part.ymin + part.ymax) / 2};
}

void Camera::pan(double dx, double dy) { centre_ = {centre_.x - dx / scale_, centre_.y + dy / scale_}; }

void Camera::zoom_at(double px, double py, double factor) {
  const Vec2 before = to_world(px, py);
  scale_ = std::clamp(scale_ * factor, kLeastScale, kMostScale);
  const Vec2 after = to_world(px, py);
  centre_ = {centre_.x + before.x - after.x, centre_.y + before.y - after.y};
}

Vec2 Camera::to_world(double px, double py) const {
  return {centre_.x + (px - width_ / 2.0) / scale_, centre_.y - (py - height_ / 2.0) / scale_};
}

Vec2 Camera::to_screen(Vec2 place) const {
  return {width_ / 2.0 + (place.x - centre_.x) * scale_, height_ / 2.0 - (place.y - centre_.y) * scale_};
}

Bounds Camera::shown() const {
  const Vec2 low = to_world(0, height_), high = to_world(width_, 0);
  return {low.x, low.y, high.x, high.y};
}

}  // namespace psim::view
