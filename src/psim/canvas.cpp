#include "canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace psim::cli {
namespace {

float srgb_to_linear(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

float linear_to_srgb(float l) {
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
}

// Fine enough that no two neighbouring sRGB values fall into one step.
constexpr std::size_t kToneSteps = 8192;

std::array<std::uint8_t, kToneSteps> make_tone_curve() {
  std::array<std::uint8_t, kToneSteps> curve{};
  for (std::size_t i = 0; i < kToneSteps; ++i) {
    const float linear = static_cast<float>(i) / static_cast<float>(kToneSteps - 1);
    curve[i] = static_cast<std::uint8_t>(std::lround(255 * linear_to_srgb(linear)));
  }
  return curve;
}

float clamp01(float v) { return std::clamp(v, 0.0f, 1.0f); }

}  // namespace

Colour from_srgb(std::uint32_t rgb) {
  const auto channel = [rgb](int shift) {
    return srgb_to_linear(static_cast<float>((rgb >> shift) & 0xff) / 255);
  };
  return {channel(16), channel(8), channel(0)};
}

Canvas::Canvas(int width, int height, Colour background)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background) {}

template <class Paint>
void Canvas::for_pixels(float x0, float y0, float x1, float y1, const Paint& paint) {
  // Clamped as floats: a figure far outside must not overflow an int.
  const auto w = static_cast<float>(width_), h = static_cast<float>(height_);
  const int left = static_cast<int>(std::clamp(std::floor(x0), 0.0f, w));
  const int right = static_cast<int>(std::clamp(std::ceil(x1), 0.0f, w));
  const int top = static_cast<int>(std::clamp(std::floor(y0), 0.0f, h));
  const int bottom = static_cast<int>(std::clamp(std::ceil(y1), 0.0f, h));
  for (int y = top; y < bottom; ++y) {
    Colour* const row = pixels_.data() + static_cast<std::ptrdiff_t>(y) * width_;
    for (int x = left; x < right; ++x) paint(row[x], x, y);
  }
}

void Canvas::fill_rect(float x0, float y0, float x1, float y1, Colour colour) {
  for_pixels(x0, y0, x1, y1, [&](Colour& pixel, int x, int y) {
    const auto px = static_cast<float>(x), py = static_cast<float>(y);
    const float covered_x = clamp01(std::min(x1, px + 1) - std::max(x0, px));
    const float covered_y = clamp01(std::min(y1, py + 1) - std::max(y0, py));
    pixel = mix(pixel, colour, covered_x * covered_y);
  });
}

template <class Distance>
void Canvas::solid(float x0, float y0, float x1, float y1, float inner, float outer, Colour colour,
                   const Distance& distance) {
  constexpr float kSmallest = 0.75f;  // painted no thinner than twice this, but fainter
  constexpr float kRimFrom = 3;       // pixels from which on the rim shows
  constexpr float kRimShare = 0.14f;  // of the inner radius
  constexpr float kWidestRim = 16;
  constexpr float kRimDarkening = 0.45f;
  const float grow = std::max(kSmallest - inner, 0.0f);
  const float weight = (inner / (inner + grow)) * (outer / (outer + grow));
  const float rim = inner < kRimFrom ? 0 : std::min(kRimShare * inner, kWidestRim);
  const float margin = grow + 0.5f;
  for_pixels(x0 - margin, y0 - margin, x1 + margin, y1 + margin, [&](Colour& pixel, int x, int y) {
    const float d = distance(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f) - grow;
    if (d >= 0.5f) return;
    const float dark = rim > 0 ? kRimDarkening * clamp01(d + rim + 0.5f) : 0;
    pixel = mix(pixel, mix(colour, Colour{}, dark), weight * clamp01(0.5f - d));
  });
}

void Canvas::disc(float cx, float cy, float radius, Colour colour) {
  solid(cx - radius, cy - radius, cx + radius, cy + radius, radius, radius, colour,
        [=](float x, float y) {
          const float dx = x - cx, dy = y - cy;
          return std::sqrt(dx * dx + dy * dy) - radius;
        });
}

void Canvas::convex(std::span<const Point> points, float radius, Colour colour) {
  if (points.empty()) return;
  const std::size_t n = points.size();
  Point low = points[0], high = points[0], middle;
  float area = 0, perimeter = 0;  // twice the area
  for (std::size_t k = 0; k < n; ++k) {
    const Point p = points[k], next = points[(k + 1) % n];
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    middle = {middle.x + p.x / static_cast<float>(n), middle.y + p.y / static_cast<float>(n)};
    perimeter += std::hypot(next.x - p.x, next.y - p.y);
    area +=
        (p.x - points[0].x) * (next.y - points[0].y) - (p.y - points[0].y) * (next.x - points[0].x);
  }
  const float side = area < 0 ? -1.0f : 1.0f;
  // To the polygon itself: the farthest of the edges' lines inside, the nearest edge outside.
  const auto to_polygon = [&](float x, float y) {
    float beyond = n < 3 ? 1.0f : -1e30f, near2 = 1e30f;
    for (std::size_t k = 0; k < n; ++k) {
      const Point p = points[k], q = points[(k + 1) % n];
      const float ux = q.x - p.x, uy = q.y - p.y, dx = x - p.x, dy = y - p.y;
      const float length2 = ux * ux + uy * uy;
      const float t = length2 > 0 ? clamp01((dx * ux + dy * uy) / length2) : 0;
      const float ex = dx - t * ux, ey = dy - t * uy;
      near2 = std::min(near2, ex * ex + ey * ey);
      if (n < 3 || !(length2 > 0)) continue;
      beyond = std::max(beyond, side * (dx * uy - dy * ux) / std::sqrt(length2));
    }
    return beyond <= 0 ? beyond : std::sqrt(near2);
  };
  const float inner = std::max(radius - to_polygon(middle.x, middle.y), 0.0f);
  if (!(inner > 0)) return;
  // That of a rectangle of the same area.
  const float covered = std::abs(area) / 2 + (perimeter + 3.14f * radius) * radius;
  const float outer = std::max(covered / (4 * inner), inner);
  solid(low.x - radius, low.y - radius, high.x + radius, high.y + radius, inner, outer, colour,
        [&](float x, float y) { return to_polygon(x, y) - radius; });
}

void Canvas::ring(float cx, float cy, float radius, float thickness, Colour colour) {
  const float half = thickness / 2;
  const float outside = radius + half + 0.5f;
  for_pixels(cx - outside, cy - outside, cx + outside, cy + outside,
             [&](Colour& pixel, int x, int y) {
               const float d =
                   std::hypot(static_cast<float>(x) + 0.5f - cx, static_cast<float>(y) + 0.5f - cy);
               pixel = mix(pixel, colour, clamp01(half + 0.5f - std::abs(d - radius)));
             });
}

void Canvas::line(float x0, float y0, float x1, float y1, float thickness, Colour colour) {
  const float half = thickness / 2;
  const float reach = half + 0.5f;
  const float ux = x1 - x0, uy = y1 - y0;
  const float length2 = ux * ux + uy * uy;
  // Row by row, only the stretch that the line can touch: a long slanted line is thin.
  const float top = std::min(y0, y1) - reach, bottom = std::max(y0, y1) + reach;
  const float first = std::max(std::floor(top), 0.0f);
  const float last = std::min(std::ceil(bottom), static_cast<float>(height_));
  for (float row = first; row < last; ++row) {
    float left = std::min(x0, x1), right = std::max(x0, x1);
    if (std::abs(uy) > 1) {
      const float xa = x0 + ux * (row - reach - y0) / uy;
      const float xb = x0 + ux * (row + 1 + reach - y0) / uy;
      left = std::max(left, std::min(xa, xb));
      right = std::min(right, std::max(xa, xb));
    }
    for_pixels(left - reach, row, right + reach, row + 1, [&](Colour& pixel, int x, int y) {
      const float px = static_cast<float>(x) + 0.5f - x0, py = static_cast<float>(y) + 0.5f - y0;
      const float t = length2 > 0 ? clamp01((px * ux + py * uy) / length2) : 0;
      const float d = std::hypot(px - t * ux, py - t * uy);
      pixel = mix(pixel, colour, clamp01(reach - d));
    });
  }
}

std::vector<std::uint8_t> Canvas::to_srgb() const {
  static const auto kToneCurve = make_tone_curve();
  const auto tone = [](float linear) {
    return kToneCurve[static_cast<std::size_t>(clamp01(linear) * (kToneSteps - 1) + 0.5f)];
  };
  std::vector<std::uint8_t> bytes;
  bytes.reserve(pixels_.size() * 3);
  for (const Colour& pixel : pixels_) {
    bytes.push_back(tone(pixel.r));
    bytes.push_back(tone(pixel.g));
    bytes.push_back(tone(pixel.b));
  }
  return bytes;
}

}  // namespace psim::cli
