#include "image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "canvas.h"
#include "png_write.h"

namespace psim::cli {
namespace {

constexpr int kLongSide = 1600;  // pixels
constexpr int kShortestSide = 240;
constexpr float kLineWidth = 3;

// The colours of the picture.
const Colour kOutside = from_srgb(0x0a0c10), kInside = from_srgb(0x12161d);
const Colour kWall = from_srgb(0x56616f), kSeam = from_srgb(0x2b323c);
const Colour kStatic = from_srgb(0x7d8794), kLine = from_srgb(0xb4bfcc),
             kWell = from_srgb(0xf2f4f7);

// Lightness rises evenly with speed, and hue turns from violet over green to yellow: the middle
// and upper part of viridis (S. van der Walt, N. Smith, 2015), whose darkest end would drown in
// the background.
const std::array kSpeedColours = {from_srgb(0x414487), from_srgb(0x355f8d), from_srgb(0x2a788e),
                                  from_srgb(0x21918c), from_srgb(0x22a884), from_srgb(0x44bf70),
                                  from_srgb(0x7ad151), from_srgb(0xbddf26), from_srgb(0xfde725)};

Colour speed_colour(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(kSpeedColours.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kSpeedColours.size() - 2);
  return mix(kSpeedColours[below], kSpeedColours[below + 1],
             static_cast<float>(at - static_cast<double>(below)));
}

bool is_drawn(const PublishedState& state, std::size_t row) {
  return state.radius[row] > 0 && std::isfinite(state.x[row]) && std::isfinite(state.y[row]);
}

// A body's own point in world coordinates.
Vec2 placed(const BodyDesc& body, Vec2 p) {
  const double c = std::cos(body.angle), s = std::sin(body.angle);
  return {body.position.x + c * p.x - s * p.y, body.position.y + s * p.x + c * p.y};
}

// Segments and chains are static, so the scene knows where they are.
std::vector<std::vector<Vec2>> polylines(const Scene& scene) {
  std::vector<std::vector<Vec2>> lines;
  for (const BodyDesc& body : scene.bodies) {
    std::vector<Vec2> line;
    if (const auto* segment = std::get_if<SegmentShape>(&body.shape)) {
      line = {placed(body, segment->p1), placed(body, segment->p2)};
    } else if (const auto* chain = std::get_if<ChainShape>(&body.shape)) {
      for (const Vec2& vertex : chain->vertices) line.push_back(placed(body, vertex));
      if (chain->loop && !line.empty()) line.push_back(line.front());
    }
    if (!line.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

void include(Bounds& box, double x, double y, double r) {
  box = {std::min(box.xmin, x - r), std::min(box.ymin, y - r), std::max(box.xmax, x + r),
         std::max(box.ymax, y + r)};
}

// The part of the world to show: axis by axis the whole, unless less than kMuchLess is in use.
Bounds choose_view(const Scene& scene, const PublishedState& state,
                   const std::vector<std::vector<Vec2>>& lines) {
  constexpr double kMuchLess = 0.6;
  constexpr double kMargin = 0.03;  // of the longer side, around the view
  const Bounds& world = scene.world.bounds;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds used{kFar, kFar, -kFar, -kFar};
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (is_drawn(state, row)) include(used, state.x[row], state.y[row], state.radius[row]);
  }
  for (const auto& line : lines) {
    for (const Vec2& p : line) include(used, p.x, p.y, 0);
  }
  Bounds view = world;
  if (used.xmin <= used.xmax) {
    const auto fit = [](double used_min, double used_max, double& min, double& max) {
      if (used_max - used_min >= kMuchLess * (max - min)) return;
      min = std::max(min, used_min);
      max = std::min(max, used_max);
    };
    fit(used.xmin, used.xmax, view.xmin, view.xmax);
    fit(used.ymin, used.ymax, view.ymin, view.ymax);
  }
  const double margin = kMargin * std::max({view.xmax - view.xmin, view.ymax - view.ymin, 1e-9});
  return {view.xmin - margin, view.ymin - margin, view.xmax + margin, view.ymax + margin};
}

// From metres to pixels.
struct Camera {
  double scale, left, top;
  float x(double metres) const { return static_cast<float>((metres - left) * scale); }
  float y(double metres) const { return static_cast<float>((top - metres) * scale); }
  float length(double metres) const { return static_cast<float>(metres * scale); }
};

// The speed that gets the brightest colour: nearly the fastest, so that one stray body does not
// leave the rest in the dark; at least what a fall by a tenth of a radius gives, so that a pile at
// rest looks at rest.
double bright_speed(const Scene& scene, const PublishedState& state) {
  constexpr double kPercentile = 0.995;
  std::vector<double> speeds;
  double radius_sum = 0;
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (!is_drawn(state, row) || state.type[row] == BodyType::static_body) continue;
    const double speed = std::hypot(state.vx[row], state.vy[row]);
    if (!std::isfinite(speed)) continue;
    speeds.push_back(speed);
    radius_sum += state.radius[row];
  }
  if (speeds.empty()) return 1;
  const auto at = static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(speeds.size() - 1));
  std::nth_element(speeds.begin(), speeds.begin() + at, speeds.end());
  const double gravity = std::hypot(scene.world.gravity.x, scene.world.gravity.y);
  const double radius = radius_sum / static_cast<double>(speeds.size());
  const double at_rest = std::sqrt(2 * gravity * 0.1 * radius);
  return std::max({speeds[static_cast<std::size_t>(at)], at_rest, 1e-12});
}

void paint_world(Canvas& canvas, const Camera& camera, const WorldDesc& world) {
  const float x0 = camera.x(world.bounds.xmin), x1 = camera.x(world.bounds.xmax);
  const float y0 = camera.y(world.bounds.ymax), y1 = camera.y(world.bounds.ymin);
  canvas.fill_rect(x0, y0, x1, y1, kInside);
  if (world.boundary == Boundary::open) return;
  const bool walls = world.boundary == Boundary::walls;
  const float width = walls ? 3.0f : 1.5f;
  const Colour colour = walls ? kWall : kSeam;
  canvas.fill_rect(x0 - width, y0 - width, x1 + width, y0, colour);
  canvas.fill_rect(x0 - width, y1, x1 + width, y1 + width, colour);
  canvas.fill_rect(x0 - width, y0, x0, y1, colour);
  canvas.fill_rect(x1, y0, x1 + width, y1, colour);
}

void paint_bodies(Canvas& canvas, const Camera& camera, const Scene& scene,
                  const PublishedState& state) {
  constexpr float kSpokeFrom = 7;  // pixels of radius from which on a disc shows how it is turned
  const double bright = bright_speed(scene, state);
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (!is_drawn(state, row)) continue;
    const bool fixed = state.type[row] == BodyType::static_body;
    const double share = std::hypot(state.vx[row], state.vy[row]) / bright;
    const Colour colour = fixed ? kStatic : speed_colour(std::isfinite(share) ? share : 1);
    const float x = camera.x(state.x[row]), y = camera.y(state.y[row]);
    const float r = camera.length(state.radius[row]);
    canvas.disc(x, y, r, colour);
    if (r < kSpokeFrom || fixed || !std::isfinite(state.angle[row])) continue;
    const auto c = static_cast<float>(std::cos(state.angle[row]));
    const auto s = static_cast<float>(std::sin(state.angle[row]));
    canvas.line(x + 0.35f * r * c, y - 0.35f * r * s, x + 0.78f * r * c, y - 0.78f * r * s,
                std::max(1.2f, 0.09f * r), mix(colour, Colour{}, 0.55f));
  }
}

void paint_wells(Canvas& canvas, const Camera& camera, const WorldDesc& world) {
  for (const Field& field : world.fields) {
    const auto* well = std::get_if<WellField>(&field);
    if (well == nullptr) continue;
    const float x = camera.x(well->position.x), y = camera.y(well->position.y);
    canvas.disc(x, y, 2, kWell);
    canvas.ring(x, y, 7, 1.2f, kWell);
  }
}

}  // namespace

void write_image(AtomicFile& file, const Scene& scene, const PublishedState& state) {
  const auto lines = polylines(scene);
  const Bounds view = choose_view(scene, state, lines);
  const double across = view.xmax - view.xmin, up = view.ymax - view.ymin;
  const double scale = kLongSide / std::max(across, up);
  const auto side = [scale](double metres) {
    return std::max(kShortestSide, static_cast<int>(std::lround(metres * scale)));
  };
  Canvas canvas(side(across), side(up), kOutside);
  // A view narrower than the shortest picture stands in its middle.
  const Camera camera{scale, (view.xmin + view.xmax) / 2 - canvas.width() / scale / 2,
                      (view.ymin + view.ymax) / 2 + canvas.height() / scale / 2};

  paint_world(canvas, camera, scene.world);
  paint_bodies(canvas, camera, scene, state);
  for (const auto& line : lines) {
    for (std::size_t i = 1; i < line.size(); ++i) {
      canvas.line(camera.x(line[i - 1].x), camera.y(line[i - 1].y), camera.x(line[i].x),
                  camera.y(line[i].y), kLineWidth, kLine);
    }
  }
  paint_wells(canvas, camera, scene.world);
  write_png(file, canvas.width(), canvas.height(), canvas.to_srgb());
}

}  // namespace psim::cli
