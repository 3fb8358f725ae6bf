#include "canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "outline.h"

namespace psim::cli {
namespace {

constexpr double kRimFrom = 3;  // pixels from the middle to the edge from which on the rim shows
constexpr double kRimShare = 0.14;  // of that depth
constexpr double kWidestRim = 16;   // pixels
constexpr float kRimDarkening = 0.45f;
constexpr float kNothing = 1e-6f;  // a share that rounding leaves

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

double rim_of(double depth) {
  return depth < kRimFrom ? 0 : std::min(kRimShare * depth, kWidestRim);
}

// From the middle of a convex polygon to its nearest side.
double depth_of(std::span<const Point> polygon) {
  const std::size_t n = polygon.size();
  if (n < 3) return 0;
  Point middle;
  for (const Point& p : polygon) {
    middle = {middle.x + p.x / static_cast<double>(n), middle.y + p.y / static_cast<double>(n)};
  }
  double depth = 1e30;
  for (std::size_t k = 0; k < n; ++k) {
    const Point p = polygon[k], q = polygon[(k + 1) % n];
    const double ux = q.x - p.x, uy = q.y - p.y, length = std::hypot(ux, uy);
    if (!(length > 0)) continue;
    depth = std::min(depth, std::fabs(ux * (middle.y - p.y) - uy * (middle.x - p.x)) / length);
  }
  return depth;
}

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
      background_(background),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void Canvas::background_rect(double x0, double y0, double x1, double y1, Colour colour) {
  rects_.push_back({x0, y0, x1, y1, colour});
}

void Canvas::clear(Colour background) {
  background_ = background;
  rects_.clear();
  std::fill(pixels_.begin(), pixels_.end(), Light{});
}

bool Canvas::begin(double x0, double y0, double x1, double y1, bool has_rim) {
  box_ = pixel_box(x0, y0, x1, y1, width_, height_);
  if (box_.is_empty()) return false;
  outer_.begin(box_);
  if (has_rim) inner_.begin(box_);
  return true;
}

void Canvas::paint(const Look& look) {
  for (int y = box_.top; y < box_.bottom; ++y) {
    const Coverage::Row row = outer_.take_row(y);
    const Coverage::Row inside = look.has_rim ? inner_.take_row(y) : Coverage::Row{};
    Light* const pixels = pixels_.data() + static_cast<std::ptrdiff_t>(y) * width_ + row.left;
    const std::ptrdiff_t shift = row.left - inside.left;
    for (std::size_t i = 0; i < row.shares.size(); ++i) {
      const float share = row.shares[i] * look.opacity;
      if (share <= kNothing) continue;
      Light light = look.light;
      if (look.has_rim) {
        const auto at = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + shift);
        const float within = at < inside.shares.size() ? inside.shares[at] * look.opacity : 0;
        light = look.rim + (look.light - look.rim) * std::min(within / share, 1.0f);
      }
      // What was there gives way by as much as does not fit beside it; what is laid over hides all
      // alike.
      Light& pixel = pixels[i];
      float stays = 1;
      if (!look.shares) {
        stays = 1 - share;
      } else if (pixel[3] + share > 1) {
        stays = (1 - share) / pixel[3];
      }
      pixel = pixel * stays + light * share;
    }
  }
}

void Canvas::disc(double x, double y, double radius, Colour colour, float opacity) {
  if (!(radius > 0)) return;
  const double rim = rim_of(radius);
  const double reach = radius + 0.1;  // the outline's corners lie outside of the circle
  if (!begin(x - reach, y - reach, x + reach, y + reach, rim > 0)) return;
  outer_.polygon(unit_circle(radius), {x, y}, radius);
  if (rim > 0) inner_.polygon(unit_circle(radius - rim), {x, y}, radius - rim);
  paint(
      {light_of(colour), light_of(mix(colour, {}, kRimDarkening)), opacity, rim > 0, opacity == 1});
}

void Canvas::convex(std::span<const Point> points, double radius, Colour colour, float opacity) {
  radius = std::max(radius, 0.0);
  round_outline(points, radius, outline_);
  const double rim = rim_of(depth_of(points) + radius);
  if (!begin_outline(rim > 0)) return;
  outer_.polygon(outline_);
  if (rim > radius) {
    shrink(points, rim - radius, outline_);
    inner_.polygon(outline_);
  } else if (rim > 0) {
    round_outline(points, radius - rim, outline_);
    inner_.polygon(outline_);
  }
  paint(
      {light_of(colour), light_of(mix(colour, {}, kRimDarkening)), opacity, rim > 0, opacity == 1});
}

bool Canvas::begin_outline(bool has_rim) {
  if (outline_.size() < 3) return false;
  const auto [left, right] = std::ranges::minmax(outline_, {}, &Point::x);
  const auto [top, bottom] = std::ranges::minmax(outline_, {}, &Point::y);
  return begin(left.x, top.y, right.x, bottom.y, has_rim);
}

void Canvas::line(Point from, Point to, double thickness, Colour colour) {
  const Point ends[] = {from, to};
  round_outline(ends, thickness / 2, outline_);
  if (!begin_outline(false)) return;
  outer_.polygon(outline_);
  paint({light_of(colour), Light{}, 1, false, false});
}

void Canvas::ring(double x, double y, double radius, double thickness, Colour colour) {
  const double outside = radius + thickness / 2, inside = radius - thickness / 2;
  const double reach = outside + 0.1;
  if (!begin(x - reach, y - reach, x + reach, y + reach, false)) return;
  outer_.polygon(unit_circle(outside), {x, y}, outside);
  if (inside > 0) {
    const std::span<const Point> circle = unit_circle(inside);
    outline_.assign(circle.rbegin(), circle.rend());  // the other way round: a hole
    outer_.polygon(outline_, {x, y}, inside);
  }
  paint({light_of(colour), Light{}, 1, false, false});
}

void Canvas::background_row(int y, std::vector<Colour>& row) const {
  std::fill(row.begin(), row.end(), background_);
  const auto overlap = [](double low, double high, int pixel) {
    return std::clamp(std::min(high, pixel + 1.0) - std::max(low, static_cast<double>(pixel)), 0.0,
                      1.0);
  };
  for (const Rect& rect : rects_) {
    const double high = overlap(rect.y0, rect.y1, y);
    if (high == 0) continue;
    const PixelBox box = pixel_box(rect.x0, 0, rect.x1, 1, width_, 1);
    for (int x = box.left; x < box.right; ++x) {
      Colour& pixel = row[static_cast<std::size_t>(x)];
      pixel = mix(pixel, rect.colour, static_cast<float>(high * overlap(rect.x0, rect.x1, x)));
    }
  }
}

// Pixels that no figure touches are those of the background's row, and most rows of it are alike.
void Canvas::to_srgb(std::vector<std::uint8_t>& bytes) const {
  static const auto kToneCurve = make_tone_curve();
  using Steps = std::int32_t __attribute__((vector_size(16)));
  const auto write = [](std::uint8_t* out, Light light) {
    constexpr std::int32_t kLast = kToneSteps - 1;
    const auto steps = __builtin_convertvector(light * static_cast<float>(kLast) + 0.5f, Steps);
    for (int k = 0; k < 3; ++k)
      out[k] = kToneCurve[static_cast<std::size_t>(std::min(steps[k], kLast))];
  };
  const auto columns = static_cast<std::size_t>(width_);
  bytes.resize(pixels_.size() * 3);
  std::vector<Colour> row(columns);
  std::vector<Light> behind(columns);
  std::vector<std::uint8_t> row_bytes(3 * columns);
  std::vector<double> heights, heights_before;  // of each rectangle in the row
  for (int y = 0; y < height_; ++y) {
    heights.clear();
    for (const Rect& rect : rects_) {
      heights.push_back(std::clamp(rect.y1, y + 0.0, y + 1.0) -
                        std::clamp(rect.y0, y + 0.0, y + 1.0));
    }
    if (y == 0 || heights != heights_before) {
      background_row(y, row);
      for (std::size_t x = 0; x < columns; ++x) {
        behind[x] = light_of(row[x]);
        write(row_bytes.data() + 3 * x, behind[x]);
      }
      heights.swap(heights_before);
    }
    const Light* const pixels = pixels_.data() + static_cast<std::size_t>(y) * columns;
    std::uint8_t* const out = bytes.data() + 3 * static_cast<std::size_t>(y) * columns;
    std::copy(row_bytes.begin(), row_bytes.end(), out);
    for (std::size_t x = 0; x < columns; ++x) {
      const Light light = pixels[x];
      if (light[3] <= kNothing) continue;
      write(out + 3 * x, light + behind[x] * (1 - std::min(light[3], 1.0f)));
    }
  }
}

}  // namespace psim::cli
