// Questions of a shape: what it meets on its way, and what is near it.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "base/elementary.h"
#include "base/rotor.h"
#include "bodies/hull.h"
#include "geometry/turning.h"
#include "psim/limits.h"
#include "query/queries.h"
#include "query/question.h"

namespace psim {
namespace {

// The hulls of a shape about its own origin; none if the shape is refused. Those of discs and capsules need no memory.
class ShapeHulls {
 public:
  explicit ShapeHulls(const Shape& shape) {
    if (const auto* disc = std::get_if<DiscShape>(&shape); disc != nullptr && limits::kRadius.contains(disc->radius)) {
      one_ = disc_hull(static_cast<float>(disc->radius));
      hulls_ = {&one_, 1};
    } else if (const auto* capsule = std::get_if<CapsuleShape>(&shape); capsule != nullptr && take(*capsule)) {
      hulls_ = {&one_, 1};
    } else if (std::string error; make_hulls(shape, false, set_, error)) {
      hulls_ = set_.parts;
    }
  }
  ShapeHulls(const ShapeHulls&) = delete;
  ShapeHulls& operator=(const ShapeHulls&) = delete;

  std::span<const Hull> list() const { return hulls_; }

 private:
  // False for what make_hulls has to look at.
  bool take(const CapsuleShape& s) {
    if (!limits::kCoordinate.contains(s.p1) || !limits::kCoordinate.contains(s.p2)) return false;
    if (!limits::kRadius.contains(s.radius) || !(length_of(s.p2 - s.p1) > 1e-3 * s.radius)) return false;
    one_.count = 2;
    one_.set_vertex(0, s.p1);
    one_.set_vertex(1, s.p2);
    one_.radius = static_cast<float>(s.radius);
    return one_.vertex(0) != one_.vertex(1);
  }

  Hull one_;
  HullSet set_;
  std::span<const Hull> hulls_;
};

// A convex shape on its way, and the first body that it meets.
class ShapeCast {
 public:
  ShapeCast(const Question& q, Vec2 from, double angle, Vec2 way, double rotation)
      : q_(q), from_(from), angle_(angle), rotation_(rotation), way_(way), whole_(length_of(way)) {
    scale_ = whole_ > 0 ? whole_ : 1;
    if (whole_ > 0) u_ = {way.x / whole_, way.y / whole_};
    limit_ = whole_ > 0 ? followed(q, u_, whole_) : (rotation != 0 ? 1 : 0);
  }

  void follow(const Hull& hull) {
    const Outline own = outline_of(hull, {}, {});
    const Turning turning{own, angle_, rotation_, {}, way_};
    const bool turns = turning.turns();
    Outline mine = outline_of(hull, sine_cosine(angle_), {});
    // What turns does so about its origin; else the middle of the box is nearer to all of it.
    const Vec2 middle = turns ? Vec2{} : box_of(mine).middle();
    mine = outline_of(hull, sine_cosine(angle_), -1 * middle);
    double reach = 0;
    for (int k = 0; k < mine.count; ++k) reach = greater(length_of(mine.v[k]), reach);
    reach += mine.radius;
    const Vec2 start = q_.place(from_ + middle);
    q_.parts([&](const QueryIndex::Part& part) {
      const auto meet = [&](const QueryItem& item, Vec2 shift) {
        const Vec2 to = item.seen_from(start, shift);
        const double far = (reach + wide(item.radius)) * (1 + 1e-12);
        const double miss = whole_ > 0 ? cross(to, u_) : length_of(to);
        if (std::fabs(miss) > far || !q_.wants(item)) return;
        const Outline other = QueryIndex::outline(q_.world, part, item, to);
        RayEntry e;
        if (turns) {
          e = touch_turning(turning, {other}, limit_ / scale_);
          e.at *= scale_;
        } else {
          e = enter(difference(mine, other), u_, limit_);
        }
        if (!(e.at >= 0 && e.at <= limit_) || !q_.meets(part, item, e.normal)) return;
        const Met met{e.at, item.body, e.normal, item.part};
        if (found_ && !before(met, best_)) return;
        found_ = true;
        best_ = met;
        limit_ = met.at;
        base_ = from_ + middle;
        mine_ = turns ? turning.outline_at(met.at / scale_) : mine;
        if (!turns) {
          for (int k = 0; k < mine_.count; ++k) mine_.v[k] = mine_.v[k] + met.at * u_;
        }
        other_ = other;
      };
      if (whole_ > 0) {
        part.grid.along(start, u_, limit_, meet, reach);
      } else {
        part.grid.in_box(start - Vec2{reach, reach}, start + Vec2{reach, reach}, meet);
      }
    });
  }

  std::optional<ShapeCastHit> answer() const {
    if (!found_) return {};
    const Vec2 normal = best_.where;
    const Vec2 point = normal == Vec2{} ? from_ : base_ + nearest_point(mine_, other_, normal);
    return ShapeCastHit{q_.world.handle(best_.body), point, normal, best_.at / scale_, best_.part};
  }

 private:
  const Question& q_;
  const Vec2 from_;
  const double angle_, rotation_;
  const Vec2 way_;
  const double whole_;  // m: all of the way
  double scale_ = 1;    // m: by which a share of the way is a length; 1 where there is no way
  double limit_ = 0;    // m: how far the way is followed
  Vec2 u_;              // of length 1, along the way
  bool found_ = false;
  Met best_;
  Vec2 base_;             // what the two outlines are relative to
  Outline mine_, other_;  // where they touch
};

bool comes_before(const NearHit& a, const NearHit& b) {
  const auto key = [](const NearHit& h) {
    return std::tie(h.distance, h.body.index, h.normal.x, h.normal.y, h.point.x, h.point.y, h.part);
  };
  return key(a) < key(b);
}

// Puts a hit at its place among the first `count`, as long as there is room.
void insert(const NearHit& hit, std::size_t count, std::span<NearHit> found) {
  std::size_t k = std::min(count, found.size());
  if (k == found.size() && (k == 0 || !comes_before(hit, found[--k]))) return;
  for (; k > 0 && comes_before(hit, found[k - 1]); --k) found[k] = found[k - 1];
  found[k] = hit;
}

}  // namespace

std::optional<ShapeCastHit> Queries::shape_cast(const Shape& shape, Vec2 from, double angle, Vec2 translation,
                                                double rotation, const QueryFilter& filter) const {
  if (!sane(from) || !sane(translation) || !std::isfinite(angle)) return {};
  if (!(std::fabs(rotation) <= kMostRotation)) return {};
  const ShapeHulls hulls(shape);
  const Question q{index, world, filter};
  ShapeCast cast(q, from, angle, translation, rotation);
  for (const Hull& hull : hulls.list()) cast.follow(hull);
  return cast.answer();
}

std::size_t Queries::nearby(const Shape& shape, Vec2 position, double angle, double reach, std::span<NearHit> found,
                            const QueryFilter& filter) const {
  if (!sane(position) || !std::isfinite(angle) || !sane(reach) || !(reach >= 0)) return 0;
  const ShapeHulls hulls(shape);
  const Question q{index, world, filter};
  std::size_t count = 0;
  for (const Hull& hull : hulls.list()) {
    const SineCosine turn = sine_cosine(angle);
    const Box box = box_of(outline_of(hull, turn, {}));
    const Vec2 middle = box.middle();
    const Outline mine = outline_of(hull, turn, -1 * middle);
    const double around = mine.radius + reach;
    const Vec2 half = box.high - middle + Vec2{around, around}, at = q.place(position + middle);
    q.parts([&](const QueryIndex::Part& part) {
      part.grid.in_box(at - half, at + half, [&](const QueryItem& item, Vec2 shift) {
        const Vec2 to = item.seen_from(at, shift);
        const double r = wide(item.radius);
        if (std::fabs(to.x) > half.x + r || std::fabs(to.y) > half.y + r || !q.wants(item)) return;
        const Outline other = QueryIndex::outline(q.world, part, item, to);
        const Gap gap = gap_between(mine, other);
        if (!(gap.distance <= reach) || !q.meets(part, item, gap.normal)) return;
        const Vec2 point = position + middle + nearest_point(mine, other, gap.normal);
        const bool one_way = q.one_way(part, item) != Vec2{};
        insert({q.world.handle(item.body), point, gap.normal, gap.distance, one_way, item.part}, count, found);
        ++count;
      });
    });
  }
  return count;
}

}  // namespace psim
