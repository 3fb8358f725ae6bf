#include "window/overlays.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "place/shape_size.h"

namespace psim::view {
namespace {

constexpr std::uint32_t kWall = rgba(0x56616f), kSeam = rgba(0x2b323c), kGrid = rgba(0xffffff, 0.07),
                        kLineBody = rgba(0xb4bfcc), kMovingLine = rgba(0x7ad151), kJoint = rgba(0xd98e73),
                        kTouch = rgba(0xff5d6c, 0.8), kPoint = rgba(0xffe9ec), kHit = rgba(0xffe08a),
                        kWell = rgba(0xf2f4f7), kTrail = rgba(0xffffff, 0.35);

// 1, 2 or 5 times a power of ten, so that lines are kLeastGap pixels apart or more.
double grid_step(double pixels_per_metre) {
  constexpr double kLeastGap = 48;
  const double least = kLeastGap / pixels_per_metre;
  const double unit = std::pow(10, std::floor(std::log10(least)));
  for (const double times : {1.0, 2.0, 5.0}) {
    if (times * unit >= least) return times * unit;
  }
  return 10 * unit;
}

void add_circle(LineBatch& lines, Vec2 centre, double radius, std::uint32_t colour) {
  constexpr int kSides = 24;
  for (int k = 0; k < kSides; ++k) {
    const double a = 6.283185307179586 * k / kSides, b = 6.283185307179586 * (k + 1) / kSides;
    lines.add({centre.x + radius * std::cos(a), centre.y + radius * std::sin(a)},
              {centre.x + radius * std::cos(b), centre.y + radius * std::sin(b)}, 1.3f, colour);
  }
}

}  // namespace

std::uint32_t group_rgba(std::uint32_t group) {
  constexpr double kGolden = 0.61803398875, kGrey = 0.75, kHue = 0.7;
  const auto channel = [&](double from) {
    const double turns = group * kGolden + from, at = turns - std::floor(turns);
    const double pure = std::clamp(std::fabs(6 * at - 3) - 1, 0.0, 1.0);
    return static_cast<std::uint32_t>(std::lround(255 * (kGrey + kHue * (pure - kGrey))));
  };
  return rgba(channel(0) << 16 | channel(2.0 / 3) << 8 | channel(1.0 / 3));
}

void Overlays::note(const Status& status) {
  constexpr std::size_t kMostHits = 5000;
  if (!status.touches) return;
  for (const HitEvent& hit : status.touches->hits) recent_.push_back({hit, status.frame});
  while (recent_.size() > kMostHits) recent_.pop_front();
}

void Overlays::build(const Status& status, const BodyColumns& bodies, const Camera& camera, float alpha,
                     const History& history, std::size_t back, const OverlayChoice& choice, Colouring colouring) {
  below.begin(camera);
  above.begin(camera);
  const WorldDesc& world = status.world->desc();
  add_world(world, camera, choice.grid);
  add_wells(back > 0 ? *history.wells(back) : *status.wells, camera);
  if (bodies.size() == 0) return;
  if (choice.trails) add_trails(history, back, world, bodies);
  add_line_bodies(bodies, alpha);
  if (choice.joints) add_joints(*status.joints, world, bodies, alpha);
  if (back > 0 || !status.touches) return;  // known for the newest frame only
  if (choice.contacts) {
    add_contacts(status.touches->contacts, bodies, camera, alpha, colouring == Colouring::solver);
  }
  if (choice.hits) add_hits(bodies, camera, status.frame);
}

void Overlays::add_world(const WorldDesc& world, const Camera& camera, bool grid) {
  const Bounds& b = world.bounds;
  if (grid) {
    const Bounds shown = camera.shown();
    const double step = grid_step(camera.pixels_per_metre());
    for (double x = std::ceil(shown.xmin / step) * step; x <= shown.xmax; x += step) {
      below.add({x, shown.ymin}, {x, shown.ymax}, 1, kGrid);
    }
    for (double y = std::ceil(shown.ymin / step) * step; y <= shown.ymax; y += step) {
      below.add({shown.xmin, y}, {shown.xmax, y}, 1, kGrid);
    }
  }
  if (world.boundary != Boundary::open) {
    const std::uint32_t colour = world.boundary == Boundary::walls ? kWall : kSeam;
    const Vec2 corners[] = {{b.xmin, b.ymin}, {b.xmax, b.ymin}, {b.xmax, b.ymax}, {b.xmin, b.ymax}};
    for (int k = 0; k < 4; ++k) below.add(corners[k], corners[(k + 1) % 4], 3, colour);
  }
}

void Overlays::add_wells(const std::vector<Vec2>& wells, const Camera& camera) {
  for (const Vec2 place : wells) {
    for (const double pixels : {7.0, 2.0}) add_circle(above, place, pixels / camera.pixels_per_metre(), kWell);
  }
}

void Overlays::add_line_bodies(const BodyColumns& bodies, float alpha) {
  for (const std::uint32_t row : bodies.line_rows()) {
    const std::uint32_t look = bodies.looks()[row];
    const std::vector<Kind>& kinds = bodies.catalogue()->kinds();
    const Vec2 at = bodies.place(row, alpha);
    const double angle = bodies.angle(row, alpha);
    const auto add = [&](const Kind& kind) {
      const std::size_t n = kind.points.size();
      if (!kind.line || n == 0) return;
      Vec2 from = to_world(kind.points[kind.loop ? n - 1 : 0], at, angle);
      for (std::size_t k = kind.loop ? 0 : 1; k < n; ++k) {
        const Vec2 to = to_world(kind.points[k], at, angle);
        below.add(from, to, 2.5f, (look & kStaticBit) != 0 ? kLineBody : kMovingLine);
        from = to;
      }
    };
    const Kind& all = kinds[look & kKindMask];
    add(all);
    for (const std::uint32_t part : all.parts) add(kinds[part]);
  }
}

// From anchor to anchor; where the anchors coincide, from the places of the bodies that move.
void Overlays::add_joints(const std::vector<JointLook>& joints, const WorldDesc& world, const BodyColumns& bodies,
                          float alpha) {
  const bool wraps = world.boundary == Boundary::periodic;
  const Bounds& b = world.bounds;
  const auto line = [&](Vec2 from, Vec2 to) {
    if (wraps &&
        (std::fabs(to.x - from.x) > (b.xmax - b.xmin) / 2 || std::fabs(to.y - from.y) > (b.ymax - b.ymin) / 2)) {
      return;  // not across the seam
    }
    above.add(from, to, 1.4f, kJoint);
  };
  for (const JointLook& joint : joints) {
    const std::uint32_t body[] = {joint.a, joint.b};
    const Vec2 local[] = {joint.anchor_a, joint.anchor_b};
    Vec2 place[2], anchor[2];
    bool there = true, moves[2] = {};
    for (const int side : {0, 1}) {
      anchor[side] = local[side];
      if (body[side] == kWorldSide) continue;
      const std::size_t row = bodies.row_of(body[side]);
      there = there && row != bodies.size();
      if (row == bodies.size()) continue;
      place[side] = bodies.place(row, alpha);
      anchor[side] = to_world(local[side], place[side], bodies.angle(row, alpha));
      moves[side] = (bodies.looks()[row] & kStaticBit) == 0;
    }
    if (!there) continue;
    line(anchor[0], anchor[1]);
    if (joint.type < JointType::revolute) continue;
    for (const int side : {0, 1}) {
      if (moves[side]) line(place[side], anchor[side]);
    }
  }
}

// A dot, and a line along the normal to both sides: the longer the more force, from a fifth of the smaller body's
// radius to all of it. Moves with the picture of whoever is drawn.
void Overlays::add_contacts(const std::vector<ContactLook>& contacts, const BodyColumns& bodies, const Camera& camera,
                            float alpha, bool by_colour) {
  constexpr float kWidth = 1.6f, kColouredWidth = 3;                         // pixels
  constexpr double kLeast = 0.2, kMostPixels = 40, kDot = 2, kDotFrom = 12;  // share; pixels
  const Bounds shown = camera.shown();
  const double scale = camera.pixels_per_metre();
  float most = 0;
  for (const ContactLook& c : contacts) most = std::max(most, c.force);
  for (const ContactLook& c : contacts) {
    if (c.point.x < shown.xmin || c.point.x > shown.xmax || c.point.y < shown.ymin || c.point.y > shown.ymax) {
      continue;
    }
    Vec2 p = c.point;
    double radius = kMostPixels / scale;
    bool first = true;
    for (const std::uint32_t id : {c.a, c.b}) {
      const std::size_t row = bodies.row_of(id);
      if (row == bodies.size() || (bodies.looks()[row] & kStaticBit) != 0) continue;
      radius = std::min(radius, static_cast<double>(bodies.snapshot()->radius[row]));
      if (!std::exchange(first, false)) continue;
      const Vec2 now = bodies.place(row, 1), then = bodies.place(row, alpha);
      p = {p.x + (then.x - now.x), p.y + (then.y - now.y)};
    }
    const double share = most > 0 ? std::sqrt(static_cast<double>(c.force / most)) : 0;
    const double half = radius * (kLeast + (1 - kLeast) * share);
    const double nx = static_cast<double>(c.nx), ny = static_cast<double>(c.ny);
    const std::uint32_t colour = !by_colour ? kTouch : c.colour == kNoColour ? kLineBody : group_rgba(c.colour);
    above.add({p.x - half * nx, p.y - half * ny}, {p.x + half * nx, p.y + half * ny},
              by_colour ? kColouredWidth : kWidth, colour);
    if (radius * scale < kDotFrom) continue;
    const double dot = kDot / scale;
    above.add({p.x - dot, p.y}, {p.x + dot, p.y}, static_cast<float>(2 * kDot), kPoint);
  }
}

// A line along the normal, as long as the smaller body, which may be gone since.
void Overlays::add_hits(const BodyColumns& bodies, const Camera& camera, std::uint64_t frame) {
  constexpr std::uint64_t kFrames = 20;
  constexpr double kMostPixels = 16, kLeastPixels = 3;
  while (!recent_.empty() && recent_.front().frame + kFrames < frame) recent_.pop_front();
  for (const Hit& hit : recent_) {
    const double age = static_cast<double>(frame - hit.frame) / kFrames;
    double length = kMostPixels;
    for (const BodyId id : {hit.event.a, hit.event.b}) {
      const std::size_t row = id == kNoBody ? bodies.size() : bodies.row_of(id.index);
      if (row == bodies.size() || (bodies.looks()[row] & kStaticBit) != 0) continue;
      const double across = 2 * static_cast<double>(bodies.snapshot()->radius[row]);
      length = std::min(length, std::max(across * camera.pixels_per_metre(), kLeastPixels));
    }
    length /= camera.pixels_per_metre();
    const Vec2 p = hit.event.point, n = hit.event.normal;
    const auto opacity = static_cast<std::uint32_t>(255 * std::max(1 - age, 0.0));
    const std::uint32_t colour = (kHit & 0x00FFFFFFu) | opacity << 24;
    above.add({p.x - n.x * length / 2, p.y - n.y * length / 2}, {p.x + n.x * length / 2, p.y + n.y * length / 2}, 2,
              colour);
  }
}

void Overlays::add_trails(const History& history, std::size_t back, const WorldDesc& world, const BodyColumns& bodies) {
  constexpr std::size_t kMostBodies = 1000, kFrames = 48;
  const Bounds& b = world.bounds;
  const double far = std::min(b.xmax - b.xmin, b.ymax - b.ymin) / 2;
  const std::size_t end = std::min(history.size(), back + kFrames);
  if (end < back + 2) return;
  const std::size_t stride = std::max<std::size_t>(bodies.size() / kMostBodies, 1);
  for (std::size_t k = back; k + 1 < end; ++k) {
    const Snapshot& now = history.at(k);
    const Snapshot& before = history.at(k + 1);
    const std::size_t n = std::min({bodies.size(), now.id.size(), before.id.size()});
    const double fade = 1 - static_cast<double>(k - back) / kFrames;
    const auto opacity = static_cast<std::uint32_t>((kTrail >> 24) * fade);
    const std::uint32_t colour = (kTrail & 0x00FFFFFFu) | opacity << 24;
    for (std::size_t row = 0; row < n; row += stride) {
      if (now.id[row] != before.id[row] || (bodies.looks()[row] & kStaticBit) != 0) continue;
      const Vec2 from{before.origin.x + static_cast<double>(before.x[row]),
                      before.origin.y + static_cast<double>(before.y[row])};
      const Vec2 to{now.origin.x + static_cast<double>(now.x[row]), now.origin.y + static_cast<double>(now.y[row])};
      if (std::fabs(to.x - from.x) > far || std::fabs(to.y - from.y) > far) continue;
      below.add(from, to, 1.2f, colour);
    }
  }
}

}  // namespace psim::view
