#include "picture/picture_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace psim::cli {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr Bounds kNothing{kFar, kFar, -kFar, -kFar};

void include(Bounds& box, const Bounds& other) {
  box = {std::min(box.xmin, other.xmin), std::min(box.ymin, other.ymin), std::max(box.xmax, other.xmax),
         std::max(box.ymax, other.ymax)};
}

bool is_empty(const Bounds& box) { return !(box.xmin <= box.xmax); }

double longer_side(const Bounds& box) { return std::max({box.xmax - box.xmin, box.ymax - box.ymin, 1e-9}); }

Bounds grown(const Bounds& box, double by) { return {box.xmin - by, box.ymin - by, box.xmax + by, box.ymax + by}; }

Bounds box_of(const std::vector<Outline>& all) {
  Bounds box = kNothing;
  for (const Outline& line : all) {
    for (const Vec2& p : line.points) include(box, grown({p.x, p.y, p.x, p.y}, line.radius));
  }
  return box;
}

// The box that leaves out this share of the boxes on each side.
Bounds most_of(std::vector<Bounds>& boxes, double share) {
  if (boxes.empty()) return kNothing;
  const auto skip = static_cast<std::ptrdiff_t>(share * static_cast<double>(boxes.size()));
  const auto side = [&](double Bounds::*of, bool greatest) {
    const auto at = boxes.begin() + skip;
    std::nth_element(boxes.begin(), at, boxes.end(),
                     [&](const Bounds& a, const Bounds& b) { return greatest ? a.*of > b.*of : a.*of < b.*of; });
    return (*at).*of;
  };
  return {side(&Bounds::xmin, false), side(&Bounds::ymin, false), side(&Bounds::xmax, true), side(&Bounds::ymax, true)};
}

// The rectangle around bodies: of those that move every stride-th, less the strays on each side. In an
// open world, which has no walls to show, what stands still counts only as far as it is near what
// moves: ground may reach far.
Bounds used_part(const Scene& scene, const Moment& moment, const SceneShapes& shapes, std::size_t stride,
                 double strays) {
  constexpr double kNear = 0.5;  // of the longer side of what moves
  std::vector<Bounds> moving_boxes;
  Bounds standing = kNothing;
  std::size_t count = 0;
  for (std::size_t row = 0; row < moment.size(); ++row) {
    const bool stands = moment.type[row] == BodyType::static_body;
    if (!stands && count++ % stride != 0) continue;
    if (!shapes.is_drawn(moment, row)) continue;
    const Bounds box = box_of(shapes.placed(moment, row));
    if (stands) {
      include(standing, box);
    } else {
      moving_boxes.push_back(box);
    }
  }
  const Bounds moving = most_of(moving_boxes, strays);
  if (is_empty(moving) || is_empty(standing)) return is_empty(moving) ? standing : moving;
  if (scene.world.boundary == Boundary::open) {
    const Bounds near = grown(moving, kNear * longer_side(moving));
    standing = {std::max(standing.xmin, near.xmin), std::max(standing.ymin, near.ymin),
                std::min(standing.xmax, near.xmax), std::min(standing.ymax, near.ymax)};
  }
  Bounds used = moving;
  include(used, standing);
  return used;
}

// The world, or on each axis what is used of it if that is far less.
Bounds fitted(const Scene& scene, const Bounds& used) {
  constexpr double kMuchLess = 0.6;
  Bounds view = scene.world.bounds;
  if (is_empty(used)) return view;
  const auto fit = [](double used_min, double used_max, double& min, double& max) {
    if (used_max - used_min >= kMuchLess * (max - min)) return;
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
  const Bounds view = fitted(scene, used_part(scene, moment, shapes, 1, 0));
  return grown(view, kMargin * longer_side(view));
}

const Bounds& FilmView::follow(const Moment& moment) {
  constexpr std::size_t kSample = 4096;
  constexpr double kStrays = 0.0025;  // on each side
  constexpr double kNearSide = 0.02;  // of the longer side: who comes so near to the view's side widens it
  constexpr double kRoom = 0.15;      // by this much beyond
  constexpr double kFollow = 0.06;    // of the way a picture
  const std::size_t stride = std::max<std::size_t>(moment.size() / kSample, 1);
  const Bounds used = used_part(scene_, moment, shapes_, stride, kStrays);
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
