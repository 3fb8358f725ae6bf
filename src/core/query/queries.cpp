#include "query/queries.h"

#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "base/sort_keys.h"
#include "bodies/hull.h"

namespace psim {
namespace {

constexpr double kLargest = 1e100;  // m: larger numbers count as infinite

bool sane(double v) { return std::fabs(v) <= kLargest; }
bool sane(Vec2 p) { return sane(p.x) && sane(p.y); }

double nearest_copy(double at, double period) {
  if (!(period > 0)) return at;
  const double near = at - period * std::floor(at / period + 0.5);
  return std::fabs(near) <= period ? near : std::remainder(at, period);  // far away the product is rounded
}

struct Question {
  const QueryIndex& index;
  const Observed& world;
  const QueryFilter& filter;
  Vec2 period = world.period();  // m

  bool wants(std::uint32_t id) const {
    const BodyProperties& properties = world.bodies.properties(id);
    const BodyKind& kind = world.bodies.kinds[properties.kind];
    if (kind.sensor && !filter.sensors) return false;
    if ((kind.filter.category & filter.mask) == 0) return false;
    switch (properties.type) {
      case BodyType::dynamic_body:
        return filter.dynamic;
      case BodyType::kinematic_body:
        return filter.kinematic;
      case BodyType::static_body:
        break;
    }
    return filter.fixed;
  }

  // Calls each(part) for the grids that may hold wanted bodies.
  template <class Each>
  void parts(const Each& each) const {
    const std::size_t fixed = world.population.fixed.size();
    if (filter.fixed && fixed != 0) each(index.part(world, QueryIndex::kFixed));
    if ((filter.dynamic && world.bodies.living() != fixed) || (filter.kinematic && world.any_kinematic())) {
      each(index.part(world, QueryIndex::kMoving));
    }
    if (filter.dynamic && !world.sleep.sleepers.empty()) each(index.part(world, QueryIndex::kSleeping));
  }

  BodyId id(std::uint32_t index) const { return {index, world.bodies.info[index].generation}; }

  // A point in the coordinates of the grids. In a periodic world it is the copy nearest to the middle.
  Vec2 place(Vec2 p) const {
    const Vec2 centre = world.lattice.centre();
    return {nearest_copy(p.x - centre.x, period.x), nearest_copy(p.y - centre.y, period.y)};
  }
};

// Where a ray enters a body.
struct Entered {
  double at = 0;  // m
  std::uint32_t body = 0;
  Vec2 normal;
};

// The nearest comes first. Ties are broken so that the order depends on neither slots nor grids.
bool before(const Entered& a, const Entered& b) {
  if (a.at != b.at) return a.at < b.at;
  if (a.body != b.body) return a.body < b.body;
  return a.normal.x != b.normal.x ? a.normal.x < b.normal.x : a.normal.y < b.normal.y;
}

// A ray of `length` metres along u from `from`, in the coordinates of the grids.
struct Ray {
  Ray(const Question& q, Vec2 p, Vec2 to) : from(q.place(p)) {
    const Vec2 way = to - p;
    length = length_of(way);
    whole = length;
    if (!(length > 0)) return;
    u = {way.x / length, way.y / length};
    const Vec2 period = q.period;
    if (period.x > 0 && u.x != 0) length = std::fmin(length, period.x / std::fabs(u.x));
    if (period.y > 0 && u.y != 0) length = std::fmin(length, period.y / std::fabs(u.y));
  }

  RayHit answer(const Question& q, Vec2 p, const Entered& e) const {
    return {q.id(e.body), {p.x + e.at * u.x, p.y + e.at * u.y}, e.normal, whole > 0 ? e.at / whole : 0};
  }

  Vec2 from, u;
  double length = 0, whole = 0;  // m: how far the ray is followed, and how far the host asked
};

// Calls each(entered) for the pieces that a ray enters within `limit`, which `each` may lower.
template <class Each>
void cast(const Question& q, const Ray& ray, double& limit, const Each& each) {
  q.parts([&](const QueryIndex::Part& part) {
    const auto meet = [&](const QueryItem& item, Vec2 shift) {
      const Vec2 to{item.x + shift.x - ray.from.x, item.y + shift.y - ray.from.y};
      const double miss = to.x * ray.u.y - to.y * ray.u.x, r = static_cast<double>(item.radius);
      if (miss * miss > r * r) return;
      const RayEntry e = item.piece == QueryIndex::kDisc
                             ? enter(to, r, ray.u, limit)
                             : enter(QueryIndex::outline(q.world, part.pieces[item.piece], to), ray.u, limit);
      if (e.at >= 0 && e.at <= limit && q.wants(item.body)) each(Entered{e.at, item.body, e.normal});
    };
    if (ray.length > 0) {
      part.grid.along(ray.from, ray.u, limit, meet);
    } else {
      part.grid.in_box(ray.from, ray.from, meet);
    }
  });
}

// Gathers the bodies that have a point in common with one of several outlines.
class Gatherer {
 public:
  explicit Gatherer(const Question& q) : q_(q) {}

  /// Adds the bodies that meet an outline about `middle`. Its box has half the width and height `half`.
  void add(const Outline& shape, Vec2 middle, Vec2 half) {
    const Vec2 at = q_.place(middle);
    q_.parts([&](const QueryIndex::Part& part) {
      const auto meet = [&](const QueryItem& item, Vec2 shift) {
        const Vec2 to{item.x + shift.x - at.x, item.y + shift.y - at.y};
        const double r = static_cast<double>(item.radius);
        if (std::fabs(to.x) > half.x + r || std::fabs(to.y) > half.y + r) return;
        if (!q_.wants(item.body) || !psim::overlap(shape, QueryIndex::outline(q_.world, part, item, to))) return;
        ids_.push_back(item.body);
      };
      part.grid.in_box({at.x - half.x, at.y - half.y}, {at.x + half.x, at.y + half.y}, meet);
    });
  }

  /// All that were gathered, ordered by id.
  std::vector<BodyId> answer() {
    sort_keys(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    std::vector<BodyId> out;
    out.reserve(ids_.size());
    for (const std::uint32_t id : ids_) out.push_back(q_.id(id));
    return out;
  }

 private:
  const Question& q_;
  std::vector<std::uint32_t> ids_;
};

// A hull about the middle of its box.
struct Boxed {
  Outline outline;
  Vec2 middle, half;

  Boxed(const Hull& hull, Vec2 turn) : outline(outline_of(hull, turn, {})) {
    const Box box = box_of(outline);
    middle = box.middle();
    half = {box.high.x - middle.x + outline.radius, box.high.y - middle.y + outline.radius};
    for (std::int32_t k = 0; k < outline.count; ++k) {
      outline.v[k] = {outline.v[k].x - middle.x, outline.v[k].y - middle.y};
    }
  }
};

}  // namespace

std::optional<RayHit> Queries::ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  if (!sane(from) || !sane(to)) return {};
  const Question q{index, world, filter};
  const Ray ray(q, from, to);
  std::optional<Entered> best;
  double limit = ray.length;
  cast(q, ray, limit, [&](const Entered& e) {
    if (best && !before(e, *best)) return;
    best = e;
    limit = e.at;
  });
  if (!best) return {};
  return ray.answer(q, from, *best);
}

std::vector<RayHit> Queries::ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  if (!sane(from) || !sane(to)) return {};
  const Question q{index, world, filter};
  const Ray ray(q, from, to);
  std::vector<Entered> all;
  double limit = ray.length;
  cast(q, ray, limit, [&](const Entered& e) { all.push_back(e); });
  // Of all pieces and copies of a body the first counts. Total order, here and below: before() compares all members.
  std::sort(all.begin(), all.end(),
            [](const Entered& a, const Entered& b) { return a.body != b.body ? a.body < b.body : before(a, b); });
  const auto same = [](const Entered& a, const Entered& b) { return a.body == b.body; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  std::sort(all.begin(), all.end(), before);  // Total order: as above.
  std::vector<RayHit> out;
  out.reserve(all.size());
  for (const Entered& e : all) out.push_back(ray.answer(q, from, e));
  return out;
}

std::vector<BodyId> Queries::overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const {
  HullSet hulls;
  std::string error;
  if (!sane(position) || !std::isfinite(angle) || !make_hulls(shape, false, hulls, error)) return {};
  const Question q{index, world, filter};
  Gatherer found(q);
  const SineCosine turn = sine_cosine(angle);
  for (const Hull& hull : hulls.parts) {
    const Boxed part(hull, {turn.cosine, turn.sine});
    found.add(part.outline, {position.x + part.middle.x, position.y + part.middle.y}, part.half);
  }
  return found.answer();
}

std::vector<BodyId> Queries::in_region(const Bounds& region, const QueryFilter& filter) const {
  const Vec2 low{region.xmin, region.ymin}, high{region.xmax, region.ymax};
  if (!sane(low) || !sane(high) || !(low.x <= high.x && low.y <= high.y)) return {};
  const Question q{index, world, filter};
  const Vec2 middle{low.x / 2 + high.x / 2, low.y / 2 + high.y / 2};
  Vec2 half{high.x - middle.x, high.y - middle.y};
  if (q.period.x > 0) half.x = std::fmin(half.x, q.period.x / 2);
  if (q.period.y > 0) half.y = std::fmin(half.y, q.period.y / 2);
  Outline box;
  box.count = 4;
  box.v[0] = {-half.x, -half.y};
  box.v[1] = {half.x, -half.y};
  box.v[2] = {half.x, half.y};
  box.v[3] = {-half.x, half.y};
  Gatherer found(q);
  found.add(box, middle, half);
  return found.answer();
}

std::optional<ClosestHit> Queries::closest(Vec2 point, double reach, const QueryFilter& filter) const {
  if (!sane(point) || !sane(reach) || !(reach >= 0)) return {};
  const Question q{index, world, filter};
  const Vec2 at = q.place(point);
  std::optional<NearPoint> best;
  std::uint32_t body = 0;
  q.parts([&](const QueryIndex::Part& part) {
    part.grid.around(at, reach, [&](const QueryItem& item, Vec2 shift) {
      const Vec2 to{item.x + shift.x - at.x, item.y + shift.y - at.y};
      const double r = static_cast<double>(item.radius), far = reach + r;
      if (to.x * to.x + to.y * to.y > far * far * (1 + 1e-12)) return;
      const NearPoint n = item.piece == QueryIndex::kDisc
                              ? near_point(to, r)
                              : near_point(QueryIndex::outline(q.world, part.pieces[item.piece], to));
      if (n.distance > reach || !q.wants(item.body)) return;
      if (best && n.distance == best->distance) {  // at equal distance the lowest id comes first, then the lowest point
        if (item.body > body) return;
        const Vec2 p = n.point, o = best->point;
        if (item.body == body && (p.x != o.x ? p.x > o.x : p.y >= o.y)) return;
      }
      best = n;
      body = item.body;
      reach = n.distance;
    });
  });
  if (!best) return {};
  return ClosestHit{q.id(body), {point.x + best->point.x, point.y + best->point.y}, best->distance};
}

}  // namespace psim
