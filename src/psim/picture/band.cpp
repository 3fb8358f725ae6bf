#include "picture/band.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "picture/outline.h"

namespace psim::cli {
namespace {

constexpr double kRimFrom = 3;      // pixels from the middle to the edge from which on the rim shows
constexpr double kRimShare = 0.14;  // of that depth
constexpr double kWidestRim = 16;   // pixels
constexpr float kRimDarkening = 0.45f;
constexpr float kRoundingShare = 1e-6f;  // a share that rounding leaves

float linear_to_srgb(float l) { return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f; }

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

const std::array<std::uint8_t, kToneSteps>& tone_curve() {
  static const auto kCurve = make_tone_curve();
  return kCurve;
}

double rim_of(double depth) { return depth < kRimFrom ? 0 : std::min(kRimShare * depth, kWidestRim); }

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

// The share of a pixel's row or column that lies between two heights or widths.
double overlap(double low, double high, int pixel) {
  return std::clamp(std::min(high, pixel + 1.0) - std::max(low, static_cast<double>(pixel)), 0.0, 1.0);
}

}  // namespace

void Band::begin_picture(int width, int height, const Figures& figures, const Backdrop& backdrop) {
  width_ = width;
  height_ = height;
  figures_ = &figures;
  backdrop_ = &backdrop;
  tones_ = tone_curve().data();
  heights_before_.clear();
  behind_.clear();
}

void Band::draw(int top, int bottom, std::span<const std::uint32_t> numbers, std::uint8_t* rgb) {
  top_ = top;
  bottom_ = bottom;
  const auto rows = static_cast<std::size_t>(bottom - top), columns = static_cast<std::size_t>(width_);
  if (pixels_.size() < rows * columns) pixels_.resize(rows * columns);
  touched_.assign(rows, {width_, 0});
  for (const std::uint32_t number : numbers) {
    const Figure& figure = figures_->all[number];
    switch (figure.kind) {
      case FigureKind::disc:
        paint_disc(figure);
        break;
      case FigureKind::convex:
        paint_convex(figure);
        break;
      case FigureKind::line:
        paint_line(figure);
        break;
      case FigureKind::ring:
        paint_ring(figure);
        break;
      case FigureKind::field:
        paint_field(figure);
        break;
    }
  }
  for (int y = top; y < bottom; ++y, rgb += 3 * columns) finish_row(y, rgb);
}

bool Band::begin(double x0, double y0, double x1, double y1, bool has_rim) {
  box_ = pixel_box(x0, y0, x1, y1, width_, height_);
  const int first = std::max(box_.top, top_), end = std::min(box_.bottom, bottom_);
  if (box_.is_empty() || first >= end) return false;
  outer_.begin(box_, first, end);
  if (has_rim) inner_.begin(box_, first, end);
  box_.top = first;
  box_.bottom = end;
  return true;
}

bool Band::begin_outline(bool has_rim) {
  if (outline_.size() < 3) return false;
  const auto [left, right] = std::ranges::minmax(outline_, {}, &Point::x);
  const auto [top, bottom] = std::ranges::minmax(outline_, {}, &Point::y);
  return begin(left.x, top.y, right.x, bottom.y, has_rim);
}

Band::Look Band::look_of(const Figure& figure, bool has_rim) {
  return {light_of(figure.colour), light_of(mix(figure.colour, {}, kRimDarkening)), figure.opacity, has_rim,
          figure.opacity == 1};
}

void Band::paint_disc(const Figure& figure) {
  const auto [x, y] = figure.centre;
  const double radius = figure.radius, rim = rim_of(radius);
  const double reach = radius + 0.1;  // the outline's corners lie outside of the circle
  if (!begin(x - reach, y - reach, x + reach, y + reach, rim > 0)) return;
  outer_.polygon(unit_circle(radius), {x, y}, radius);
  if (rim > 0) inner_.polygon(unit_circle(radius - rim), {x, y}, radius - rim);
  paint(look_of(figure, rim > 0));
}

void Band::paint_convex(const Figure& figure) {
  const std::span<const Point> points = figures_->corners_of(figure);
  const double radius = figure.radius;
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
  paint(look_of(figure, rim > 0));
}

void Band::paint_line(const Figure& figure) {
  round_outline(figures_->corners_of(figure), figure.radius, outline_);
  if (!begin_outline(false)) return;
  outer_.polygon(outline_);
  paint({light_of(figure.colour), Light{}, 1, false, false});
}

void Band::paint_ring(const Figure& figure) {
  const auto [x, y] = figure.centre;
  const double reach = figure.radius + 0.1;
  if (!begin(x - reach, y - reach, x + reach, y + reach, false)) return;
  outer_.polygon(unit_circle(figure.radius), {x, y}, figure.radius);
  if (figure.hole > 0) {
    const std::span<const Point> circle = unit_circle(figure.hole);
    outline_.assign(circle.rbegin(), circle.rend());  // the other way round: a hole
    outer_.polygon(outline_, {x, y}, figure.hole);
  }
  paint({light_of(figure.colour), Light{}, 1, false, false});
}

// What was there gives way by as much as does not fit beside it; what is laid over hides all alike.
inline void Band::put(Light& pixel, Light light, float share, bool shares) {
  float stays = 1;
  if (!shares) {
    stays = 1 - share;
  } else if (pixel[3] + share > 1) {
    stays = (1 - share) / pixel[3];
  }
  pixel = pixel * stays + light * share;
}

void Band::paint_field(const Figure& figure) {
  const FieldArea& area = figures_->fields[figure.first_corner];
  const double right = area.corner.x + area.cell * (area.columns - 1);
  const double top = area.corner.y - area.cell * (area.rows - 1);
  box_ = pixel_box(std::max(area.corner.x, area.low.x), std::max(top, area.low.y), std::min(right, area.high.x),
                   std::min(area.corner.y, area.high.y), width_, height_);
  if (box_.left >= box_.right) return;
  for (int y = std::max(box_.top, top_); y < std::min(box_.bottom, bottom_); ++y) {
    const double up = std::clamp((area.corner.y - (y + 0.5)) / area.cell, 0.0, area.rows - 1.0);
    const auto below = std::min(static_cast<std::size_t>(up), static_cast<std::size_t>(area.rows - 2));
    const auto part = static_cast<float>(up - static_cast<double>(below));
    const auto columns = static_cast<std::size_t>(area.columns);
    const std::size_t low = below * columns, high = low + columns;
    numbers_.resize(columns);
    slopes_.resize(columns);
    for (std::size_t i = 0; i < columns; ++i) {
      slopes_[i] = area.numbers[high + i] - area.numbers[low + i];
      numbers_[i] = area.numbers[low + i] + part * slopes_[i];
    }
    tints_.resize(area.colours.empty() ? 0 : columns);
    for (std::size_t i = 0; i < tints_.size(); ++i) {
      tints_[i] = light_of(mix(area.colours[low + i], area.colours[high + i], part));
    }
    paint_field_row(area, figure.colour, y);
  }
}

// The share of a pixel is taken from how far its middle is from the edge, by the steepness there.
void Band::paint_field_row(const FieldArea& area, Colour colour, int y) {
  constexpr float kDeep = 0.35f, kPale = 0.25f;  // beyond the edge the colour is the area's own; share of white at it
  const double rows = overlap(area.low.y, area.high.y, y);
  const auto per_cell = static_cast<float>(1 / area.cell);
  const Light white = light_of({1, 1, 1}), own = light_of(colour);
  Light* const pixels = pixels_.data() + static_cast<std::ptrdiff_t>(y - top_) * width_;
  Touched& touched = touched_[static_cast<std::size_t>(y - top_)];
  touched = {std::min(touched.left, box_.left), std::max(touched.right, box_.right)};
  for (int x = box_.left; x < box_.right; ++x) {
    const double along = std::clamp((x + 0.5 - area.corner.x) / area.cell, 0.0, area.columns - 1.0);
    const auto i = std::min(static_cast<std::size_t>(along), static_cast<std::size_t>(area.columns - 2));
    const auto part = static_cast<float>(along - static_cast<double>(i));
    const float right = numbers_[i + 1] - numbers_[i], up = slopes_[i] + part * (slopes_[i + 1] - slopes_[i]);
    const float beyond = numbers_[i] + part * right - area.edge;
    const float steep = std::sqrt(right * right + up * up) * per_cell;
    float share = beyond > steep ? 1.0f : std::clamp(0.5f + beyond / std::max(steep, 1e-12f), 0.0f, 1.0f);
    share *= static_cast<float>(rows * overlap(area.low.x, area.high.x, x));
    if (share <= kRoundingShare) continue;
    if (!tints_.empty()) {
      put(pixels[x], tints_[i] + (tints_[i + 1] - tints_[i]) * part, share, true);
      continue;
    }
    const float pale = kPale * std::clamp(1 - beyond / kDeep, 0.0f, 1.0f);
    put(pixels[x], own + (white - own) * pale, share, true);
  }
}

void Band::paint(const Look& look) {
  for (int y = box_.top; y < box_.bottom; ++y) {
    const Coverage::Row row = outer_.take_row(y);
    const Coverage::Row inside = look.has_rim ? inner_.take_row(y) : Coverage::Row{};
    if (row.shares.empty()) continue;
    Touched& touched = touched_[static_cast<std::size_t>(y - top_)];
    touched = {std::min(touched.left, row.left),
               std::max(touched.right, row.left + static_cast<int>(row.shares.size()))};
    Light* const pixels = pixels_.data() + static_cast<std::ptrdiff_t>(y - top_) * width_ + row.left;
    const std::ptrdiff_t shift = row.left - inside.left;
    for (std::size_t i = 0; i < row.shares.size(); ++i) {
      const float share = row.shares[i] * look.opacity;
      if (share <= kRoundingShare) continue;
      Light light = look.light;
      if (look.has_rim) {
        const auto at = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + shift);
        const float within = at < inside.shares.size() ? inside.shares[at] * look.opacity : 0;
        light = look.rim + (look.light - look.rim) * std::min(within / share, 1.0f);
      }
      put(pixels[i], light, share, look.shares);
    }
  }
}

void Band::write(std::uint8_t* out, Light light) const {
  constexpr std::int32_t kLast = kToneSteps - 1;
  const Int4 steps = to_int(light * static_cast<float>(kLast) + 0.5f);
  for (int k = 0; k < 3; ++k) out[k] = tones_[static_cast<std::size_t>(std::min(steps[k], kLast))];
}

// Most rows of the background are alike: it is made anew where a rectangle begins or ends.
void Band::look_behind(int y) {
  heights_.clear();
  for (const Backdrop::Rect& rect : backdrop_->rects) {
    heights_.push_back(std::clamp(rect.y1, y + 0.0, y + 1.0) - std::clamp(rect.y0, y + 0.0, y + 1.0));
  }
  if (!behind_.empty() && heights_ == heights_before_) return;
  heights_.swap(heights_before_);
  std::vector<Colour> row(static_cast<std::size_t>(width_), backdrop_->colour);
  for (const Backdrop::Rect& rect : backdrop_->rects) {
    const double high = overlap(rect.y0, rect.y1, y);
    if (high == 0) continue;
    const PixelBox box = pixel_box(rect.x0, 0, rect.x1, 1, width_, 1);
    for (int x = box.left; x < box.right; ++x) {
      Colour& pixel = row[static_cast<std::size_t>(x)];
      pixel = mix(pixel, rect.colour, static_cast<float>(high * overlap(rect.x0, rect.x1, x)));
    }
  }
  behind_.resize(row.size());
  behind_rgb_.resize(3 * row.size());
  for (std::size_t x = 0; x < row.size(); ++x) {
    behind_[x] = light_of(row[x]);
    write(behind_rgb_.data() + 3 * x, behind_[x]);
  }
}

// What figures put into a row stays as far as the window covers the pixels.
void Band::hide_outside(const Backdrop::Rect& window, int y, const Touched& touched) {
  const double rows = overlap(window.y0, window.y1, y);
  Light* const pixels = pixels_.data() + static_cast<std::ptrdiff_t>(y - top_) * width_;
  for (int x = touched.left; x < touched.right; ++x) {
    const double share = rows * overlap(window.x0, window.x1, x);
    if (share < 1) pixels[x] = pixels[x] * static_cast<float>(share);
  }
}

// Pixels that no figure touches are those of the background's row.
void Band::finish_row(int y, std::uint8_t* out) {
  look_behind(y);
  std::copy(behind_rgb_.begin(), behind_rgb_.end(), out);
  const Touched touched = touched_[static_cast<std::size_t>(y - top_)];
  Light* const pixels = pixels_.data() + static_cast<std::ptrdiff_t>(y - top_) * width_;
  if (backdrop_->window) hide_outside(*backdrop_->window, y, touched);
  for (int x = touched.left; x < touched.right; ++x) {
    const Light light = pixels[x];
    if (light[3] <= kRoundingShare) continue;
    write(out + 3 * x, light + behind_[static_cast<std::size_t>(x)] * (1 - std::min(light[3], 1.0f)));
  }
  if (touched.left < touched.right) std::fill(pixels + touched.left, pixels + touched.right, Light{});
}

}  // namespace psim::cli
