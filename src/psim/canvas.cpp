#include "canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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

void Canvas::disc(float cx, float cy, float radius, Colour colour) {
  constexpr float kSmallest = 0.75f;  // painted no smaller than this, but fainter
  constexpr float kRimFrom = 3;       // pixels of radius from which on the rim shows
  constexpr float kRimShare = 0.14f;  // of the radius
  constexpr float kRimDarkening = 0.45f;
  const float r = std::max(radius, kSmallest);
  const float weight = (radius / r) * (radius / r);
  const float rim = radius < kRimFrom ? 0 : kRimShare * radius;
  const float inside = std::max(r - rim - 0.5f, 0.0f);
  const float outside = r + 0.5f;
  for_pixels(cx - outside, cy - outside, cx + outside, cy + outside,
             [&](Colour& pixel, int x, int y) {
               const float dx = static_cast<float>(x) + 0.5f - cx;
               const float dy = static_cast<float>(y) + 0.5f - cy;
               const float d2 = dx * dx + dy * dy;
               if (d2 >= outside * outside) return;
               if (d2 <= inside * inside) {
                 pixel = mix(pixel, colour, weight);
                 return;
               }
               const float d = std::sqrt(d2);
               const float dark = rim > 0 ? kRimDarkening * clamp01(d - inside) : 0;
               const float coverage = weight * clamp01(outside - d);
               pixel = mix(pixel, mix(colour, Colour{}, dark), coverage);
             });
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
