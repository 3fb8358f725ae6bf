#include "picture/picture_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

namespace psim::cli {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr Bounds kNothing{kFar, kFar, -kFar, -kFar};

void include(Bounds& box, const Bounds& other) {
  box = {std::min(box.xmin, other.xmin), std::min(box.ymin, other.ymin), std::max(box.xmax, other.xmax),
         std::max(box.ymax, other.ymax)};
}

bool is_empty(const Bounds& box) { return !(box.xmin <= box.xmax); }

Bounds point_at(Vec2 at) { return {at.x, at.y, at.x, at.y}; }

bool holds(const Bounds& box, const Bounds& other) {
  return box.xmin <= other.xmin && box.ymin <= other.ymin && box.xmax >= other.xmax && box.ymax >= other.ymax;
}

double longer_side(const Bounds& box) { return std::max({box.xmax - box.xmin, box.ymax - box.ymin, 1e-9}); }

Bounds grown(const Bounds& box, double by) { return {box.xmin - by, box.ymin - by, box.xmax + by, box.ymax + by}; }

Bounds box_of(const std::vector<Outline>& all) {
  Bounds box = kNothing;
  for (const Outline& line : all) {
    for (const Vec2& p : line.points) include(box, grown({p.x, p.y, p.x, p.y}, line.radius));
  }
  return box;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Look {
  const Scene& scene;
  const Moment& moment;
  const SceneShapes& shapes;

  bool has(std::size_t row, bool standing) const {
    return (moment.type[row] == BodyType::static_body) == standing && shapes.is_drawn(moment, row);
  }
  Bounds box(std::size_t row) const { return box_of(shapes.placed(moment, row)); }
  // A particle moves and is one spacing wide. Empty if its numbers are broken.
  Bounds box(const FluidParticleState& particle) const {
    if (particle.fluid >= scene.fluids.size() || !std::isfinite(particle.position.x + particle.position.y)) {
      return kNothing;
    }
    return grown(point_at(particle.position), scene.fluids[particle.fluid].fluid.spacing / 2);
  }
};

using Boxes = std::vector<Bounds>;
constexpr std::size_t kMostParticlesSeen = 4096;  // about: of more, some are asked where the fluids are

// Those of every stride-th body that moves and of particles, or of every stride-th body that stands.
Boxes sample(const Look& look, bool standing, std::size_t stride) {
  Boxes boxes;
  std::size_t count = 0;
  for (std::size_t row = 0; row < look.moment.size(); ++row) {
    if (look.has(row, standing) && count++ % stride == 0) boxes.push_back(look.box(row));
  }
  if (standing) return boxes;
  const std::vector<FluidParticleState>& particles = look.moment.particles;
  for (std::size_t k = 0; k < particles.size(); k += std::max<std::size_t>(particles.size() / kMostParticlesSeen, 1)) {
    const Bounds box = look.box(particles[k]);
    if (!is_empty(box)) boxes.push_back(box);
  }
  return boxes;
}

// How far bodies may be away and still count: one that was flung far would leave the others as dots.
Bounds neighbourhood(Boxes& boxes, bool open) {
  constexpr std::ptrdiff_t kPart = 8;            // one body of so many is left out on each side
  constexpr double kReachOpen = 3, kReach = 10;  // of the longer side of the others
  const std::ptrdiff_t skip = std::ssize(boxes) / kPart;
  if (skip == 0) return {-kFar, -kFar, kFar, kFar};
  const auto side = [&](double Bounds::*of, bool greatest) {
    const auto at = boxes.begin() + skip;
    std::nth_element(boxes.begin(), at, boxes.end(),
                     [&](const Bounds& a, const Bounds& b) { return greatest ? a.*of > b.*of : a.*of < b.*of; });
    return (*at).*of;
  };
  const Bounds most = {side(&Bounds::xmin, false), side(&Bounds::ymin, false), side(&Bounds::xmax, true),
                       side(&Bounds::ymax, true)};
  return grown(most, (open ? kReachOpen : kReach) * longer_side(most));
}

// The rectangle around all bodies of a kind, and of particles if they move, that lie there. Only those at its sides are looked at closely.
Bounds around_bodies(const Look& look, bool standing, const Bounds& there) {
  Bounds used = kNothing;
  for (std::size_t row = 0; row < look.moment.size(); ++row) {
    if (!look.has(row, standing)) continue;
    const Vec2 at{look.moment.x[row], look.moment.y[row]};
    if (holds(used, grown(point_at(at), look.shapes.reach(look.moment, row)))) continue;
    const Bounds box = look.box(row);
    if (holds(there, box)) include(used, box);
  }
  if (standing) return used;
  for (const FluidParticleState& particle : look.moment.particles) {
    const Bounds box = look.box(particle);
    if (!is_empty(box) && holds(there, box)) include(used, box);
  }
  return used;
}

// What stands near that which moves. In an open world, which has no walls to show, ground may reach far: then a part of
// it is enough.
void include_ground(const Look& look, Bounds& used) {
  constexpr double kWhole = 0.5, kPart = 0.25;  // of the longer side of what moves
  const Bounds whole = grown(used, kWhole * longer_side(used)), part = grown(used, kPart * longer_side(used));
  for (std::size_t row = 0; row < look.moment.size(); ++row) {
    if (!look.has(row, true)) continue;
    Bounds box = look.box(row);
    if (look.scene.world.boundary == Boundary::open && !holds(whole, box)) {
      box = {std::max(box.xmin, part.xmin), std::max(box.ymin, part.ymin), std::min(box.xmax, part.xmax),
             std::min(box.ymax, part.ymax)};
      if (box.xmin > box.xmax || box.ymin > box.ymax) continue;
    }
    include(used, box);
  }
}

// Joints and wells hold what moves.
void include_holds(const Look& look, Bounds& used) {
  constexpr double kFarthestWell = 1000;  // of the longer side
  const Bounds bodies = used, wells = grown(used, kFarthestWell * longer_side(used));
  for (const DrawnJoint& joint : look.shapes.joints()) {
    const auto ends = SceneShapes::ends_of(joint, look.moment);
    if (!ends || !(ends->moves[0] || ends->moves[1])) continue;
    const Bounds from = point_at(ends->anchor[0]), to = point_at(ends->anchor[1]);
    if (!holds(bodies, from) && !holds(bodies, to)) continue;
    include(used, from);
    include(used, to);
  }
  for (const Field& field : look.scene.world.fields) {
    const auto* well = std::get_if<WellField>(&field);
    if (well != nullptr && holds(wells, point_at(well->position))) include(used, point_at(well->position));
  }
}

// A few bodies alone do not fill a picture: what is around them shows how they move.
void make_room(const Boxes& boxes, Bounds& used) {
  constexpr double kLeast = 3;  // bodies side by side
  std::vector<double> widths, heights;
  for (const Bounds& box : boxes) {
    widths.push_back(box.xmax - box.xmin);
    heights.push_back(box.ymax - box.ymin);
  }
  const auto widen = [](double& min, double& max, double least) {
    const double more = std::max(least - (max - min), 0.0) / 2;
    min -= more;
    max += more;
  };
  widen(used.xmin, used.xmax, kLeast * median(std::move(widths)));
  widen(used.ymin, used.ymax, kLeast * median(std::move(heights)));
}

// The rectangle around what a picture should show. What is too far away is told from every stride-th body. Where nobody
// moves, it is around what stands.
Bounds used_part(const Look& look, std::size_t stride) {
  Boxes boxes = sample(look, false, stride);
  const bool moves = !boxes.empty();
  if (!moves) boxes = sample(look, true, stride);
  if (boxes.empty()) return kNothing;
  Bounds used = around_bodies(look, !moves, neighbourhood(boxes, look.scene.world.boundary == Boundary::open));
  if (is_empty(used)) return kNothing;
  include_holds(look, used);
  if (moves) include_ground(look, used);
  make_room(boxes, used);
  return used;
}

// The world, or on each axis what is used of it if that is far less. An open world has no sides that could be seen.
Bounds fitted(const Scene& scene, const Bounds& used) {
  const double much_less = scene.world.boundary == Boundary::open ? 1 : 0.6;
  Bounds view = scene.world.bounds;
  if (is_empty(used)) return view;
  const auto fit = [&](double used_min, double used_max, double& min, double& max) {
    if (used_max - used_min >= much_less * (max - min)) return;
    min = std::max(min, used_min);
    max = std::min(max, used_max);
  };
  fit(used.xmin, used.xmax, view.xmin, view.xmax);
  fit(used.ymin, used.ymax, view.ymin, view.ymax);
  return view;
}

constexpr double kMargin = 0.03;  // of the longer side, around the view

}  // namespace

Bounds view_of_all(const Scene& scene, const Moment& moment, const SceneShapes& shapes) {
  const Bounds view = fitted(scene, used_part({scene, moment, shapes}, 1));
  return grown(view, kMargin * longer_side(view));
}

const Bounds& FilmView::follow(const Moment& moment) {
  constexpr std::size_t kSample = 4096;
  constexpr double kNearSide = 0.02;  // of the longer side: who comes so near to the view's side widens it
  constexpr double kRoom = 0.15;      // by this much beyond
  constexpr double kFollow = 0.06;    // of the way a picture
  const std::size_t stride = std::max<std::size_t>(moment.size() / kSample, 1);
  const Bounds used = used_part({scene_, moment, shapes_}, stride);
  if (!begun_) {
    const Bounds view = fitted(scene_, used);
    wanted_ = view_ = grown(view, kMargin * longer_side(view));
    begun_ = true;
    return view_;
  }
  if (!is_empty(used)) {
    const double side = longer_side(used);
    const Bounds near = grown(used, kNearSide * side), room = grown(used, kRoom * side);
    const Bounds world = grown(scene_.world.bounds, kMargin * longer_side(fitted(scene_, used)));
    if (near.xmin < wanted_.xmin) include(wanted_, {std::max(room.xmin, world.xmin), kFar, -kFar, -kFar});
    if (near.ymin < wanted_.ymin) include(wanted_, {kFar, std::max(room.ymin, world.ymin), -kFar, -kFar});
    if (near.xmax > wanted_.xmax) include(wanted_, {kFar, kFar, std::min(room.xmax, world.xmax), -kFar});
    if (near.ymax > wanted_.ymax) include(wanted_, {kFar, kFar, -kFar, std::min(room.ymax, world.ymax)});
  }
  const auto follow = [](double& side, double to) { side += kFollow * (to - side); };
  follow(view_.xmin, wanted_.xmin);
  follow(view_.ymin, wanted_.ymin);
  follow(view_.xmax, wanted_.xmax);
  follow(view_.ymax, wanted_.ymax);
  return view_;
}

PictureCamera::PictureCamera(const Bounds& view, int width, int height)
    : scale_(std::min(width / (view.xmax - view.xmin), height / (view.ymax - view.ymin))),
      left_((view.xmin + view.xmax) / 2 - width / scale_ / 2),
      top_((view.ymin + view.ymax) / 2 + height / scale_ / 2) {}

PictureSize size_for(const Bounds& view, int long_side) {
  constexpr int kShortestSide = 240;
  const double across = view.xmax - view.xmin, up = view.ymax - view.ymin;
  const double scale = long_side / std::max(across, up);
  const auto side = [&](double metres) {
    return std::max(kShortestSide, static_cast<int>(std::lround(metres * scale)));
  };
  return {side(across), side(up)};
}

}  // namespace psim::cli
