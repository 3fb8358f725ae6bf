// What all questions share: which bodies are wanted, in which grids they are, and the order of what is met.
#pragma once

#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "base/sort_keys.h"
#include "query/query_index.h"

namespace psim {

inline bool sane(double v) {
  constexpr double kLargest = 1e100;  // m: larger numbers count as infinite
  return std::fabs(v) <= kLargest;
}
inline bool sane(Vec2 p) { return sane(p.x) && sane(p.y); }

struct Question {
  const QueryIndex& index;
  const Observed& world;
  const QueryFilter& filter;
  Vec2 period = world.period();  // m

  bool wants(const QueryItem& item) const {
    const BodyProperties& properties = world.bodies.properties(item.body);
    const BodyKind& kind = world.bodies.kinds[properties.kind];
    if (!filter.sensors && world.bodies.is_sensor(kind, item.part)) return false;
    const Filter& has = world.bodies.filter_of(kind, item.part);
    if ((has.category & filter.mask) == 0) return false;
    if (filter.category != 0xFFFFFFFFu && (has.mask & filter.category) == 0) return false;
    if (item.body == filter.ignore.index && world.handle(item.body) == filter.ignore) return false;
    if (properties.type() == BodyType::static_body) return filter.fixed;
    return properties.type() == BodyType::dynamic_body ? filter.dynamic : filter.kinematic;
  }
  /// Whether an item is met where it has this normal, which is zero where the question starts in it.
  bool meets(const QueryIndex::Part& part, const QueryItem& item, Vec2 normal) const {
    if (filter.enter_only && normal == Vec2{}) return false;
    if (!filter.one_way) return true;
    const Vec2 way = one_way(part, item);
    return way == Vec2{} || dot(normal, way) > Manifolds::kSolidSide;
  }
  /// In world axes: what comes against it meets this item; zero: what comes from anywhere.
  Vec2 one_way(const QueryIndex::Part& part, const QueryItem& item) const;

  /// Calls each(part) for the grids that may hold wanted bodies.
  template <class Each>
  void parts(const Each& each) const {
    const std::size_t fixed = world.population.fixed.size();
    if (filter.fixed && fixed != 0) each(index.part(world, QueryIndex::kFixed));
    if ((filter.dynamic && world.bodies.living() != fixed) || (filter.kinematic && world.any_kinematic())) {
      each(index.part(world, QueryIndex::kMoving));
    }
    if (filter.dynamic && !world.sleep.sleepers.empty()) each(index.part(world, QueryIndex::kSleeping));
  }

  /// A point in the coordinates of the grids.
  Vec2 place(Vec2 p) const { return nearest_copy(p - world.lattice.centre(), period); }

  /// Appends the bodies that meet an outline about `middle`. Its box has half the width and height `half`.
  void gather(const Outline& shape, Vec2 middle, Vec2 half, std::vector<std::uint32_t>& ids) const;
  /// All that were gathered, each once, ordered by id.
  std::vector<BodyId> answer(std::vector<std::uint32_t> ids) const;
};

/// A body that is met.
struct Met {
  double at = 0;  ///< m: how far away
  std::uint32_t body = 0;
  Vec2 where;  ///< the normal where a ray enters; or the point that is nearest
  std::uint32_t part = 0;
};

/// The nearest comes first. Ties are broken so that the order depends on neither slots nor grids.
inline bool before(const Met& a, const Met& b) {
  return std::tie(a.at, a.body, a.where.x, a.where.y, a.part) < std::tie(b.at, b.body, b.where.x, b.where.y, b.part);
}

/// How far a way of `length` metres along u is followed in a periodic world: for one length of the world along each axis.
inline double followed(const Question& q, Vec2 u, double length) {
  if (q.period.x > 0 && u.x != 0) length = lesser(q.period.x / std::fabs(u.x), length);
  if (q.period.y > 0 && u.y != 0) length = lesser(q.period.y / std::fabs(u.y), length);
  return length;
}

}  // namespace psim
