#include "picture/canvas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "picture/parallel.h"

namespace psim::cli {
namespace {

constexpr int kBandRows = 64;  // docs/pictures.md

float srgb_to_linear(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }

}  // namespace

Colour from_srgb(std::uint32_t rgb) {
  const auto channel = [rgb](int shift) { return srgb_to_linear(static_cast<float>((rgb >> shift) & 0xff) / 255); };
  return {channel(16), channel(8), channel(0)};
}

Canvas::Canvas(int width, int height, Colour background)
    : width_(width),
      height_(height),
      backdrop_{background, {}, {}},
      in_band_(static_cast<std::size_t>((height + kBandRows - 1) / kBandRows)) {}

void Canvas::clear(Colour background) {
  backdrop_.colour = background;
  backdrop_.rects.clear();
  backdrop_.window.reset();
  figures_.all.clear();
  figures_.corners.clear();
  figures_.fields.clear();
  for (auto& numbers : in_band_) numbers.clear();
}

void Canvas::background_rect(double x0, double y0, double x1, double y1, Colour colour) {
  backdrop_.rects.push_back({x0, y0, x1, y1, colour});
}

void Canvas::show_within(double x0, double y0, double x1, double y1) { backdrop_.window = {x0, y0, x1, y1, {}}; }

void Canvas::note(const Figure& figure, double x0, double y0, double x1, double y1) {
  const PixelBox box = pixel_box(x0, y0, x1, y1, width_, height_);
  if (box.is_empty()) return;
  const auto number = static_cast<std::uint32_t>(figures_.all.size());
  for (int band = box.top / kBandRows; band * kBandRows < box.bottom; ++band) {
    in_band_[static_cast<std::size_t>(band)].push_back(number);
  }
  figures_.all.push_back(figure);
}

void Canvas::note(Figure figure, std::span<const Point> corners) {
  if (corners.empty()) return;
  figure.first_corner = static_cast<std::uint32_t>(figures_.corners.size());
  figure.corners = static_cast<std::uint16_t>(corners.size());
  figures_.corners.insert(figures_.corners.end(), corners.begin(), corners.end());
  const auto [left, right] = std::ranges::minmax(corners, {}, &Point::x);
  const auto [top, bottom] = std::ranges::minmax(corners, {}, &Point::y);
  const double reach = 1.26 * figure.radius + 0.1;  // the corners of round outlines lie outside, most of all a square's
  note(figure, left.x - reach, top.y - reach, right.x + reach, bottom.y + reach);
}

void Canvas::disc(double x, double y, double radius, Colour colour, float opacity) {
  if (!(radius > 0)) return;
  const double reach = radius + 0.1;
  note({{x, y}, radius, 0, colour, opacity, 0, 0, FigureKind::disc}, x - reach, y - reach, x + reach, y + reach);
}

void Canvas::convex(std::span<const Point> points, double radius, Colour colour, float opacity) {
  note({{}, std::max(radius, 0.0), 0, colour, opacity, 0, 0, FigureKind::convex}, points);
}

void Canvas::line(Point from, Point to, double thickness, Colour colour) {
  const Point ends[] = {from, to};
  note({{}, thickness / 2, 0, colour, 1, 0, 0, FigureKind::line}, ends);
}

void Canvas::ring(double x, double y, double radius, double thickness, Colour colour) {
  const double outside = radius + thickness / 2, reach = outside + 0.1;
  note({{x, y}, outside, radius - thickness / 2, colour, 1, 0, 0, FigureKind::ring}, x - reach, y - reach, x + reach,
       y + reach);
}

void Canvas::field(FieldArea area, Colour colour) {
  if (area.columns < 2 || area.rows < 2) return;
  const Point corner = area.corner;
  const double right = corner.x + area.cell * (area.columns - 1), top = corner.y - area.cell * (area.rows - 1);
  Figure figure{{}, 0, 0, colour, 1, 0, 0, FigureKind::field};
  figure.first_corner = static_cast<std::uint32_t>(figures_.fields.size());
  const Point low{std::max(corner.x, area.low.x), std::max(top, area.low.y)};
  const Point high{std::min(right, area.high.x), std::min(corner.y, area.high.y)};
  figures_.fields.push_back(std::move(area));
  note(figure, low.x, low.y, high.x, high.y);
}

void Canvas::to_srgb(std::vector<std::uint8_t>& bytes, int threads) {
  const std::size_t row = 3 * static_cast<std::size_t>(width_);
  bytes.resize(row * static_cast<std::size_t>(height_));
  if (bands_.size() < static_cast<std::size_t>(threads)) bands_.resize(static_cast<std::size_t>(threads));
  for (Band& band : bands_) band.begin_picture(width_, height_, figures_, backdrop_);
  share_out(in_band_.size(), threads, [&](std::size_t number, std::size_t worker) {
    const int top = static_cast<int>(number) * kBandRows;
    bands_[worker].draw(top, std::min(top + kBandRows, height_), in_band_[number],
                        bytes.data() + static_cast<std::size_t>(top) * row);
  });
}

}  // namespace psim::cli
