#include "picture/painter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <variant>

namespace psim::cli {
namespace {

constexpr double kLineWidth = 3;     // pixels
constexpr double kJointWidth = 1.2;  // pixels
constexpr float kSensorOpacity = 0.3f;

// The colours of the picture.
const Colour kOutside = from_srgb(0x0a0c10), kInside = from_srgb(0x12161d);
const Colour kWall = from_srgb(0x56616f), kSeam = from_srgb(0x2b323c);
const Colour kStatic = from_srgb(0x7d8794), kLine = from_srgb(0xb4bfcc), kWell = from_srgb(0xf2f4f7),
             kWater = from_srgb(0x2f6ea8), kJoint = from_srgb(0xd98e73);
const Colour kAsleep = from_srgb(0x59616e), kAwake = from_srgb(0xfab840), kStill = from_srgb(0x4d4d4d),
             kDynamic = from_srgb(0x66a6e6), kKinematic = from_srgb(0xe68073);

// Lightness rises evenly with speed, and hue turns from violet over green to yellow: the middle
// and upper part of viridis (S. van der Walt, N. Smith, 2015), whose darkest end would drown in
// the background.
const std::array kRamp = {from_srgb(0x414487), from_srgb(0x355f8d), from_srgb(0x2a788e),
                          from_srgb(0x21918c), from_srgb(0x22a884), from_srgb(0x44bf70),
                          from_srgb(0x7ad151), from_srgb(0xbddf26), from_srgb(0xfde725)};

// A hue, 0..1 once around from red over yellow, green and blue.
Colour wheel(double turns) {
  const auto channel = [turns](double from) {
    const double at = turns + from - std::floor(turns + from);
    return static_cast<std::uint32_t>(
        std::lround(255 * (0.225 + 0.7 * std::clamp(std::fabs(at * 6 - 3) - 1, 0.0, 1.0))));
  };
  return from_srgb(channel(0) << 16 | channel(2.0 / 3) << 8 | channel(1.0 / 3));
}

constexpr std::size_t kHues = 256;
std::array<Colour, kHues> make_hues() {
  std::array<Colour, kHues> hues{};
  for (std::size_t k = 0; k < kHues; ++k) hues[k] = wheel(static_cast<double>(k) / kHues);
  return hues;
}

Colour hue(double turns) {
  static const std::array<Colour, kHues> kWheel = make_hues();
  if (!std::isfinite(turns)) return kStill;
  const double part = turns - std::floor(turns);
  return kWheel[static_cast<std::size_t>(part * kHues) % kHues];
}

// Of strips and colours: those with neighbouring numbers have hues far apart, multiples of the golden section.
Colour group_hue(std::uint32_t group) { return hue(group * 0.6180339887498949); }

double nearly_greatest(std::vector<double>& values) {
  constexpr double kPercentile = 0.995;
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// Water at rest: a particle falls by a tenth of a spacing, and has the pressure of ten spacings of depth.
void add_fluids(const Scene& scene, const Moment& moment, double gravity, Brightest& most) {
  if (moment.particles.empty() || scene.fluids.empty()) return;
  std::vector<double> speeds, pressures;
  for (const FluidParticleState& p : moment.particles) {
    const double speed = std::hypot(p.velocity.x, p.velocity.y);
    if (std::isfinite(speed)) speeds.push_back(speed);
    if (std::isfinite(p.pressure)) pressures.push_back(p.pressure);
  }
  const FluidDesc& first = scene.fluids[0].fluid;
  most.fluid_speed = std::max({nearly_greatest(speeds), std::sqrt(0.2 * gravity * first.spacing), 1e-12});
  most.pressure = std::max({nearly_greatest(pressures), 10 * first.density * gravity * first.spacing, 1e-12});
}

}  // namespace

Colour ramp(double share) {
  if (!std::isfinite(share)) share = 1;
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(kRamp.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  return mix(kRamp[below], kRamp[below + 1], static_cast<float>(at - static_cast<double>(below)));
}

// A pile at rest: a body falls by a tenth of its radius, or turns so fast that its rim would.
Brightest brightest(const Scene& scene, const Moment& moment, const SceneShapes& shapes) {
  std::vector<double> speeds, spins, forces;
  double radius_sum = 0;
  for (std::size_t row = 0; row < moment.size(); ++row) {
    if (moment.type[row] == BodyType::static_body || !shapes.is_drawn(moment, row)) continue;
    const double speed = std::hypot(moment.vx[row], moment.vy[row]);
    if (!std::isfinite(speed + moment.omega[row])) continue;
    speeds.push_back(speed);
    spins.push_back(std::fabs(moment.omega[row]));
    if (!moment.force.empty() && std::isfinite(moment.force[row])) forces.push_back(moment.force[row]);
    radius_sum += moment.radius[row];
  }
  Brightest most;
  const double gravity = std::hypot(scene.world.gravity.x, scene.world.gravity.y);
  add_fluids(scene, moment, gravity, most);
  if (speeds.empty()) return most;
  const double radius = radius_sum / static_cast<double>(speeds.size());
  const double at_rest = std::sqrt(2 * gravity * 0.1 * radius);
  most.speed = std::max({nearly_greatest(speeds), at_rest, 1e-12});
  most.spin = std::max({nearly_greatest(spins), radius > 0 ? at_rest / radius : 0, 1e-12});
  most.force = std::max(nearly_greatest(forces), 1e-300);
  return most;
}

Painter::Painter(const Scene& scene, const PictureOptions& options)
    : scene_(scene),
      colouring_(options.colouring),
      fluid_style_(options.fluid_style),
      fluid_colouring_(options.fluid_colouring),
      shapes_(scene) {}

void Painter::paint(Canvas& canvas, const PictureCamera& camera, const Moment& moment, const Brightest& bright) const {
  canvas.clear(kOutside);
  paint_world(canvas, camera);
  paint_water(canvas, camera);
  paint_fluids(canvas, camera, moment, bright);
  paint_bodies(canvas, camera, moment, bright);
  paint_contacts(canvas, camera, moment);
  paint_joints(canvas, camera, moment);
  paint_wells(canvas, camera);
}

Colour Painter::colour_of(const Moment& moment, std::size_t row, const Brightest& bright) const {
  constexpr double kStillShare = 0.02;  // of the brightest speed: slower has no direction
  const BodyDesc& body = shapes_.of(moment.id[row]);
  if (moment.type[row] == BodyType::static_body) {
    const bool is_line =
        std::holds_alternative<ChainShape>(body.shape) || std::holds_alternative<SegmentShape>(body.shape);
    return is_line ? kLine : kStatic;
  }
  const double vx = moment.vx[row], vy = moment.vy[row];
  const double speed = std::sqrt(vx * vx + vy * vy) / bright.speed;
  Colour colour;
  switch (colouring_) {
    case Colouring::speed:
      colour = ramp(speed);
      break;
    case Colouring::direction:
      if (!std::isfinite(speed)) return kStill;
      colour = mix(kStill, hue(std::atan2(vy, vx) / (2 * std::numbers::pi)),
                   static_cast<float>(std::min(speed / kStillShare, 1.0)));
      break;
    case Colouring::sleep:
      return moment.asleep[row] ? kAsleep : kAwake;
    case Colouring::spin:
      colour = ramp(std::fabs(moment.omega[row]) / bright.spin);
      break;
    case Colouring::body:
      colour = group_hue(moment.id[row]);
      break;
    case Colouring::type:
      colour = body.type == BodyType::kinematic_body ? kKinematic : kDynamic;
      break;
    case Colouring::force:  // sleepers bear, too
      return ramp(moment.force.empty() ? 0 : moment.force[row] / bright.force);
    case Colouring::strip: {  // odd strips, whose turn comes second, are dark
      const std::uint32_t strip = moment.group[row];
      if (strip == kNoStrip) return moment.asleep[row] ? kAsleep : kStill;
      return mix(group_hue(strip), kInside, strip % 2 == 0 ? 0.0f : 0.6f);
    }
    case Colouring::solver: {  // dim, so that the contacts are seen
      const std::uint32_t most = moment.group[row];
      if (most == kNoColour) return moment.asleep[row] ? kAsleep : kStill;
      return mix(group_hue(most), kInside, 0.8f);
    }
  }
  return moment.asleep[row] ? mix(kAsleep, colour, 0.25f) : colour;
}

void Painter::paint_world(Canvas& canvas, const PictureCamera& camera) const {
  const Bounds& bounds = scene_.world.bounds;
  const Point low = camera.at({bounds.xmin, bounds.ymax}), high = camera.at({bounds.xmax, bounds.ymin});
  const bool walls = scene_.world.boundary == Boundary::walls;
  if (scene_.world.boundary != Boundary::open) {
    const double width = walls ? 3 : 1.5;
    canvas.background_rect(low.x - width, low.y - width, high.x + width, high.y + width, walls ? kWall : kSeam);
  }
  canvas.background_rect(low.x, low.y, high.x, high.y, kInside);
  if (scene_.world.boundary == Boundary::periodic) canvas.show_within(low.x, low.y, high.x, high.y);
}

// In a periodic world, a body that reaches over a side is seen at the other side, too.
// Water, behind the bodies.
void Painter::paint_water(Canvas& canvas, const PictureCamera& camera) const {
  for (const Field& field : scene_.world.fields) {
    const auto* water = std::get_if<BuoyancyField>(&field);
    if (water == nullptr) continue;
    const Point low = camera.at({water->region.xmin, water->region.ymin});
    const Point high = camera.at({water->region.xmax, water->region.ymax});
    const Point corners[] = {low, {high.x, low.y}, high, {low.x, high.y}};
    canvas.convex(corners, 0, kWater, 0.5f);
  }
}

void Painter::paint_bodies(Canvas& canvas, const PictureCamera& camera, const Moment& moment,
                           const Brightest& bright) const {
  const Bounds& world = scene_.world.bounds;
  const bool wraps = scene_.world.boundary == Boundary::periodic;
  const double across = world.xmax - world.xmin, up = world.ymax - world.ymin;
  for (std::size_t row = 0; row < moment.size(); ++row) {
    if (!shapes_.is_drawn(moment, row)) continue;
    const Colour colour = colour_of(moment, row, bright);
    if (!wraps) {
      paint_body(canvas, camera, moment, row, {}, colour);
      continue;
    }
    const double x = moment.x[row], y = moment.y[row], reach = shapes_.reach(moment, row);
    const auto is_seen = [reach](double at, double min, double max) { return at + reach > min && at - reach < max; };
    for (const double right : {-across, 0.0, across}) {
      if (!is_seen(x + right, world.xmin, world.xmax)) continue;
      for (const double above : {-up, 0.0, up}) {
        if (is_seen(y + above, world.ymin, world.ymax)) paint_body(canvas, camera, moment, row, {right, above}, colour);
      }
    }
  }
}

void Painter::paint_body(Canvas& canvas, const PictureCamera& camera, const Moment& moment, std::size_t row, Vec2 shift,
                         Colour colour) const {
  constexpr double kSpokeFrom = 7;  // pixels of radius from which on a disc shows how it is turned
  const BodyDesc& body = shapes_.of(moment.id[row]);
  const float opacity = body.sensor ? kSensorOpacity : 1;
  if (is_disc(body.shape)) {
    const Point at = camera.at({moment.x[row] + shift.x, moment.y[row] + shift.y});
    const double r = camera.length(moment.radius[row]);
    canvas.disc(at.x, at.y, r, colour, opacity);
    if (r < kSpokeFrom || moment.type[row] == BodyType::static_body) return;
    const double c = r * std::cos(moment.angle[row]), s = r * std::sin(moment.angle[row]);
    canvas.line({at.x + 0.35 * c, at.y - 0.35 * s}, {at.x + 0.78 * c, at.y - 0.78 * s}, std::max(1.2, 0.09 * r),
                mix(colour, Colour{}, 0.55f));
    return;
  }
  std::vector<Point> corners;
  for (const Outline& placed : shapes_.placed(moment, row)) {
    corners.clear();
    for (const Vec2& p : placed.points) corners.push_back(camera.at({p.x + shift.x, p.y + shift.y}));
    const std::size_t n = corners.size();
    if (n == 1) {
      canvas.disc(corners[0].x, corners[0].y, camera.length(placed.radius), colour, opacity);
    } else if (!placed.line) {
      canvas.convex(corners, camera.length(placed.radius), colour, opacity);
    }
    for (std::size_t k = placed.closed ? 0 : 1; placed.line && k < n; ++k) {
      canvas.line(corners[(k + n - 1) % n], corners[k], kLineWidth, colour);
    }
  }
}

// From the one body that moves through the contact to the other.
void Painter::paint_contacts(Canvas& canvas, const PictureCamera& camera, const Moment& moment) const {
  constexpr double kThinnest = 0.8, kThickest = 4, kOfRadius = 0.16;  // pixels; share
  for (const Moment::Link& link : moment.links) {
    const Colour colour = link.colour == kNoColour ? kStill : group_hue(link.colour);
    for (const std::uint32_t id : {link.a, link.b}) {
      const std::size_t row = id == kNoBody.index ? moment.size() : moment.row_of(id);
      if (row == moment.size() || moment.type[row] == BodyType::static_body) continue;
      const Vec2 way{link.point.x - moment.x[row], link.point.y - moment.y[row]};
      if (!(std::hypot(way.x, way.y) <= 2 * moment.radius[row])) continue;  // through the seam
      canvas.line(camera.at({moment.x[row], moment.y[row]}), camera.at(link.point),
                  std::clamp(kOfRadius * camera.length(moment.radius[row]), kThinnest, kThickest), colour);
    }
  }
}

// From anchor to anchor; where the anchors coincide, from the places of the bodies that move. In a periodic world a
// joint over a side is seen at both.
void Painter::paint_joints(Canvas& canvas, const PictureCamera& camera, const Moment& moment) const {
  const Bounds& world = scene_.world.bounds;
  const bool wraps = scene_.world.boundary == Boundary::periodic;
  const double across = world.xmax - world.xmin, up = world.ymax - world.ymin;
  const auto draw = [&](Vec2 from, Vec2 to) {
    const Vec2 over =
        wraps ? Vec2{across * std::round((to.x - from.x) / across), up * std::round((to.y - from.y) / up)} : Vec2{};
    canvas.line(camera.at(from), camera.at({to.x - over.x, to.y - over.y}), kJointWidth, kJoint);
    if (over.x == 0 && over.y == 0) return;
    canvas.line(camera.at({from.x + over.x, from.y + over.y}), camera.at(to), kJointWidth, kJoint);
  };
  for (const DrawnJoint& joint : shapes_.joints()) {
    const std::optional<JointEnds> ends = SceneShapes::ends_of(joint, moment);
    if (!ends) continue;
    draw(ends->anchor[0], ends->anchor[1]);
    if (joint.joint.type < JointType::revolute) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      if (ends->moves[side]) draw(ends->place[side], ends->anchor[side]);
    }
  }
}

void Painter::paint_wells(Canvas& canvas, const PictureCamera& camera) const {
  for (const Field& field : scene_.world.fields) {
    const auto* well = std::get_if<WellField>(&field);
    if (well == nullptr) continue;
    const Point at = camera.at(well->position);
    canvas.line(at, at, 4, kWell);
    canvas.ring(at.x, at.y, 7, 1.2, kWell);
  }
}

}  // namespace psim::cli
