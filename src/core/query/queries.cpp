#include "query/queries.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"
#include "base/tasks.h"
#include "bodies/hull.h"
#include "query/question.h"

namespace psim {
namespace {

// A ray of `length` metres along u from `from`, in the coordinates of the grids.
struct Ray {
  Ray(const Question& q, Vec2 p, Vec2 to) : from(q.place(p)) {
    const Vec2 way = to - p;
    length = length_of(way);
    whole = length;
    if (!(length > 0)) return;
    u = {way.x / length, way.y / length};
    length = followed(q, u, length);
  }

  RayHit answer(const Question& q, Vec2 p, const Met& e) const {
    return {q.world.handle(e.body), p + e.at * u, e.where, whole > 0 ? e.at / whole : 0, e.part};
  }

  Vec2 from, u;
  double length = 0, whole = 0;  // m: how far the ray is followed, and how far the host asked
};

// Calls each(met) for the pieces that a ray enters within `limit`, which `each` may lower.
template <class Each>
void cast(const Question& q, const Ray& ray, double& limit, const Each& each) {
  q.parts([&](const QueryIndex::Part& part) {
    const auto meet = [&](const QueryItem& item, Vec2 shift) {
      const Vec2 to = item.seen_from(ray.from, shift);
      const double miss = cross(to, ray.u), r = wide(item.radius);
      if (miss * miss > r * r) return;
      const RayEntry e = item.piece == QueryIndex::kDisc
                             ? enter(to, r, ray.u, limit)
                             : enter(QueryIndex::outline(q.world, part, item, to), ray.u, limit);
      if (e.at >= 0 && e.at <= limit && q.wants(item) && q.meets(part, item, e.normal)) {
        each(Met{e.at, item.body, e.normal, item.part});
      }
    };
    if (ray.length > 0) {
      part.grid.along(ray.from, ray.u, limit, meet);
    } else {
      part.grid.in_box(ray.from, ray.from, meet);
    }
  });
}

}  // namespace

std::optional<RayHit> Queries::ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  if (!sane(from) || !sane(to)) return {};
  const Question q{index, world, filter};
  const Ray ray(q, from, to);
  std::optional<Met> best;
  double limit = ray.length;
  cast(q, ray, limit, [&](const Met& e) {
    if (best && !before(e, *best)) return;
    best = e;
    limit = e.at;
  });
  if (!best) return {};
  return ray.answer(q, from, *best);
}

std::size_t Queries::ray_cast_batch(std::span<const RayInput> rays, std::span<RayHit> hits,
                                    const QueryFilter& filter) const {
  if (hits.size() != rays.size()) return 0;
  const Question q{index, world, filter};
  q.parts([](const QueryIndex::Part&) {});  // made before the threads begin, which would wait for each other
  constexpr std::size_t kJobRays = 64;      // some tens of microseconds
  run_each(rays.size(), kJobRays, world.pool, [&](std::size_t k, std::size_t) {
    hits[k] = ray_cast(rays[k].from, rays[k].to, filter).value_or(RayHit{});
  });
  return static_cast<std::size_t>(
      std::count_if(hits.begin(), hits.end(), [](const RayHit& hit) { return hit.body != kNoBody; }));
}

std::vector<RayHit> Queries::ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const {
  if (!sane(from) || !sane(to)) return {};
  const Question q{index, world, filter};
  const Ray ray(q, from, to);
  std::vector<Met> all;
  double limit = ray.length;
  cast(q, ray, limit, [&](const Met& e) { all.push_back(e); });
  // Of all pieces and copies of a body the first counts. Total order, here and below: before() compares all members.
  std::sort(all.begin(), all.end(),
            [](const Met& a, const Met& b) { return a.body != b.body ? a.body < b.body : before(a, b); });
  const auto same = [](const Met& a, const Met& b) { return a.body == b.body; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  std::sort(all.begin(), all.end(), before);  // Total order: as above.
  std::vector<RayHit> out;
  out.reserve(all.size());
  for (const Met& e : all) out.push_back(ray.answer(q, from, e));
  return out;
}

std::vector<BodyId> Queries::overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const {
  HullSet hulls;
  std::string error;
  if (!sane(position) || !std::isfinite(angle) || !make_hulls(shape, false, hulls, error)) return {};
  const Question q{index, world, filter};
  const SineCosine turn = sine_cosine(angle);
  std::vector<std::uint32_t> ids;
  for (const Hull& hull : hulls.parts) {
    const Box box = box_of(outline_of(hull, turn, {}));
    const Vec2 middle = box.middle();
    const Outline part = outline_of(hull, turn, -1 * middle);
    q.gather(part, position + middle, box.high - middle + Vec2{part.radius, part.radius}, ids);
  }
  return q.answer(std::move(ids));
}

std::vector<BodyId> Queries::in_region(const Bounds& region, const QueryFilter& filter) const {
  const Vec2 low{region.xmin, region.ymin}, high{region.xmax, region.ymax};
  if (!sane(low) || !sane(high) || !(low.x <= high.x && low.y <= high.y)) return {};
  const Question q{index, world, filter};
  const Vec2 middle = Box{low, high}.middle();
  Vec2 half = high - middle;
  if (q.period.x > 0) half.x = lesser(q.period.x / 2, half.x);
  if (q.period.y > 0) half.y = lesser(q.period.y / 2, half.y);
  const Outline box{{-1 * half, {half.x, -half.y}, half, {-half.x, half.y}}, 4};
  std::vector<std::uint32_t> ids;
  q.gather(box, middle, half, ids);
  return q.answer(std::move(ids));
}

std::optional<ClosestHit> Queries::closest(Vec2 point, double reach, const QueryFilter& filter) const {
  if (!sane(point) || !sane(reach) || !(reach >= 0)) return {};
  const Question q{index, world, filter};
  const Vec2 at = q.place(point);
  std::optional<Met> best;
  q.parts([&](const QueryIndex::Part& part) {
    part.grid.around(at, reach, [&](const QueryItem& item, Vec2 shift) {
      const Vec2 to = item.seen_from(at, shift);
      const double r = wide(item.radius), far = reach + r;
      if (dot(to, to) > far * far * (1 + 1e-12)) return;
      const NearPoint n = item.piece == QueryIndex::kDisc ? near_point(to, r)
                                                          : near_point(QueryIndex::outline(q.world, part, item, to));
      const Met met{n.distance, item.body, n.point, item.part};
      if (met.at > reach || !q.wants(item) || (best && !before(met, *best))) return;
      best = met;
      reach = met.at;
    });
  });
  if (!best) return {};
  return ClosestHit{world.handle(best->body), point + best->where, best->at, best->part};
}

}  // namespace psim
