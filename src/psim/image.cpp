#include "image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

#include "canvas.h"
#include "links.h"
#include "png_write.h"
#include "shape_size.h"

namespace psim::cli {
namespace {

constexpr int kLongSide = 1600;  // pixels
constexpr int kShortestSide = 240;
constexpr float kLineWidth = 3;

// The colours of the picture.
const Colour kOutside = from_srgb(0x0a0c10), kInside = from_srgb(0x12161d);
const Colour kWall = from_srgb(0x56616f), kSeam = from_srgb(0x2b323c);
const Colour kStatic = from_srgb(0x7d8794), kLine = from_srgb(0xb4bfcc),
             kWell = from_srgb(0xf2f4f7), kJoint = from_srgb(0xd98e73);

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

// What the scene says of the rows of a state.
class Shapes {
 public:
  explicit Shapes(const Scene& scene) : bodies_(scene), known_(scene.body_count()) {}

  bool is_drawn(const PublishedState& state, std::size_t row) const {
    return state.id[row] < known_ && std::isfinite(state.x[row]) && std::isfinite(state.y[row]) &&
           std::isfinite(state.angle[row]);
  }
  const BodyDesc& of(std::uint32_t id) const { return bodies_.desc_of(id); }
  /// The points that span a body as it stands, and the radius around them.
  Outline placed(const PublishedState& state, std::size_t row) const {
    const BodyDesc& body = of(state.id[row]);
    if (is_disc(body.shape)) return {{{state.x[row], state.y[row]}}, state.radius[row]};
    Outline line = outline(body.shape);
    for (Vec2& p : line.points) p = to_world(p, {state.x[row], state.y[row]}, state.angle[row]);
    return line;
  }

 private:
  SceneBodies bodies_;
  std::uint64_t known_;
};

void include(Bounds& box, double x, double y, double r) {
  box = {std::min(box.xmin, x - r), std::min(box.ymin, y - r), std::max(box.xmax, x + r),
         std::max(box.ymax, y + r)};
}

bool is_empty(const Bounds& box) { return !(box.xmin <= box.xmax); }

// The rectangle around all bodies. In an open world, which has no walls to show, what stands still
// counts only as far as it is near what moves: ground may reach far.
Bounds used_part(const Scene& scene, const PublishedState& state, const Shapes& shapes) {
  constexpr double kNear = 0.5;  // of the longer side of what moves
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds moving{kFar, kFar, -kFar, -kFar}, standing = moving;
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (!shapes.is_drawn(state, row)) continue;
    const Outline line = shapes.placed(state, row);
    Bounds& box = state.type[row] == BodyType::static_body ? standing : moving;
    for (const Vec2& p : line.points) include(box, p.x, p.y, line.radius);
  }
  if (is_empty(moving) || is_empty(standing)) return is_empty(moving) ? standing : moving;
  if (scene.world.boundary == Boundary::open) {
    const double near = kNear * std::max(moving.xmax - moving.xmin, moving.ymax - moving.ymin);
    standing = {
        std::max(standing.xmin, moving.xmin - near), std::max(standing.ymin, moving.ymin - near),
        std::min(standing.xmax, moving.xmax + near), std::min(standing.ymax, moving.ymax + near)};
  }
  return {std::min(moving.xmin, standing.xmin), std::min(moving.ymin, standing.ymin),
          std::max(moving.xmax, standing.xmax), std::max(moving.ymax, standing.ymax)};
}

// The part of the world to show: axis by axis the whole, unless less than kMuchLess is in use.
Bounds choose_view(const Scene& scene, const PublishedState& state, const Shapes& shapes) {
  constexpr double kMuchLess = 0.6;
  constexpr double kMargin = 0.03;  // of the longer side, around the view
  const Bounds& world = scene.world.bounds;
  const Bounds used = used_part(scene, state, shapes);
  Bounds view = world;
  if (!is_empty(used)) {
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
double bright_speed(const Scene& scene, const PublishedState& state, const Shapes& shapes) {
  constexpr double kPercentile = 0.995;
  std::vector<double> speeds;
  double radius_sum = 0;
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (!shapes.is_drawn(state, row) || state.type[row] == BodyType::static_body) continue;
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

void paint_lines(Canvas& canvas, const Camera& camera, const Outline& line, bool loop,
                 Colour colour) {
  const std::size_t n = line.points.size();
  for (std::size_t k = loop ? 0 : 1; k < n; ++k) {
    const Vec2 from = line.points[(k + n - 1) % n], to = line.points[k];
    canvas.line(camera.x(from.x), camera.y(from.y), camera.x(to.x), camera.y(to.y), kLineWidth,
                colour);
  }
}

void paint_disc(Canvas& canvas, const Camera& camera, const PublishedState& state, std::size_t row,
                Colour colour) {
  constexpr float kSpokeFrom = 7;  // pixels of radius from which on a disc shows how it is turned
  const float x = camera.x(state.x[row]), y = camera.y(state.y[row]);
  const float r = camera.length(state.radius[row]);
  canvas.disc(x, y, r, colour);
  if (r < kSpokeFrom || state.type[row] == BodyType::static_body) return;
  const auto c = static_cast<float>(std::cos(state.angle[row]));
  const auto s = static_cast<float>(std::sin(state.angle[row]));
  canvas.line(x + 0.35f * r * c, y - 0.35f * r * s, x + 0.78f * r * c, y - 0.78f * r * s,
              std::max(1.2f, 0.09f * r), mix(colour, Colour{}, 0.55f));
}

void paint_bodies(Canvas& canvas, const Camera& camera, const Scene& scene,
                  const PublishedState& state, const Shapes& shapes) {
  const double bright = bright_speed(scene, state, shapes);
  std::vector<Point> corners;
  for (std::size_t row = 0; row < state.id.size(); ++row) {
    if (!shapes.is_drawn(state, row)) continue;
    const BodyDesc& body = shapes.of(state.id[row]);
    const auto* chain = std::get_if<ChainShape>(&body.shape);
    const bool line = chain || std::holds_alternative<SegmentShape>(body.shape);
    const double share = std::hypot(state.vx[row], state.vy[row]) / bright;
    Colour colour = speed_colour(std::isfinite(share) ? share : 1);
    if (state.type[row] == BodyType::static_body) colour = line ? kLine : kStatic;
    if (body.sensor) colour = mix(kInside, colour, 0.3f);
    if (is_disc(body.shape)) {
      paint_disc(canvas, camera, state, row, colour);
      continue;
    }
    const Outline placed = shapes.placed(state, row);
    if (line) {
      paint_lines(canvas, camera, placed, chain && chain->loop, colour);
      continue;
    }
    corners.clear();
    for (const Vec2& p : placed.points) corners.push_back({camera.x(p.x), camera.y(p.y)});
    canvas.convex(corners, camera.length(placed.radius), colour);
  }
}

// From anchor to anchor; where the anchors coincide, from the places of the bodies that move.
void paint_joints(Canvas& canvas, const Camera& camera, const Scene& scene,
                  const PublishedState& state) {
  constexpr float kWidth = 1.2f;
  const auto row_of = [&](std::uint64_t id) {
    const auto at = std::lower_bound(state.id.begin(), state.id.end(), id);
    const bool found = at != state.id.end() && *at == id;
    return static_cast<std::size_t>(found ? at - state.id.begin()
                                          : state.id.end() - state.id.begin());
  };
  const Bounds& world = scene.world.bounds;
  const auto draw = [&](Vec2 from, Vec2 to) {
    // Not across the seam.
    if (scene.world.boundary == Boundary::periodic &&
        (std::fabs(to.x - from.x) > (world.xmax - world.xmin) / 2 ||
         std::fabs(to.y - from.y) > (world.ymax - world.ymin) / 2)) {
      return;
    }
    canvas.line(camera.x(from.x), camera.y(from.y), camera.x(to.x), camera.y(to.y), kWidth, kJoint);
  };
  for (const SceneJoint& joint : all_joints(scene)) {
    const std::size_t a = row_of(joint.a), b = row_of(joint.b);
    if (a == state.id.size() || b == state.id.size()) continue;
    const Vec2 place_a{state.x[a], state.y[a]}, place_b{state.x[b], state.y[b]};
    const Vec2 anchor_a = to_world(joint.joint.anchor_a, place_a, state.angle[a]);
    const Vec2 anchor_b = to_world(joint.joint.anchor_b, place_b, state.angle[b]);
    if (!std::isfinite(anchor_a.x + anchor_a.y + anchor_b.x + anchor_b.y)) continue;
    draw(anchor_a, anchor_b);
    if (joint.joint.type < JointType::revolute) continue;
    if (state.type[a] != BodyType::static_body) draw(place_a, anchor_a);
    if (state.type[b] != BodyType::static_body) draw(place_b, anchor_b);
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
  const Shapes shapes(scene);
  const Bounds view = choose_view(scene, state, shapes);
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
  paint_bodies(canvas, camera, scene, state, shapes);
  paint_joints(canvas, camera, scene, state);
  paint_wells(canvas, camera, scene.world);
  write_png(file, canvas.width(), canvas.height(), canvas.to_srgb());
}

}  // namespace psim::cli
