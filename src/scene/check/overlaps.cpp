// Bodies lie in grids by the size of the circle that holds them: level k holds radii in
// [2^k, 2^(k+1)) and has cells of 2^(k+2) m, so that what overlaps is in the same cell or beside it.
// A body looks through its own level and those above, so that every pair is met from its smaller one.
#include "check/overlaps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace psim {
namespace {

// A scene with more body x segment tests than this is not tested against its segments.
constexpr double kMostSegmentTests = 2e8;

struct Entry {
  std::int64_t row, column;
  std::size_t body;
  bool operator<(const Entry& b) const { return std::tie(row, column, body) < std::tie(b.row, b.column, b.body); }
};

struct Level {
  double cell = 1;
  std::vector<Entry> entries;  // by row, then column
};

std::int64_t cell_of(double x, double cell) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x / cell, -1e15, 1e15)));
}

void note(Overlaps& found, double depth, std::size_t body, std::size_t other, bool segment) {
  ++found.count;
  if (depth <= found.depth) return;
  found.depth = depth;
  found.body = body;
  found.other = other;
  found.other_is_segment = segment;
}

double distance_to(const PlacedSegment& s, double x, double y) {
  const double ex = s.q.x - s.p.x, ey = s.q.y - s.p.y;
  const double length2 = ex * ex + ey * ey;
  double t = 0;
  if (length2 > 0) t = std::clamp(((x - s.p.x) * ex + (y - s.p.y) * ey) / length2, 0.0, 1.0);
  const double dx = x - (s.p.x + t * ex), dy = y - (s.p.y + t * ey);
  return std::sqrt(dx * dx + dy * dy);
}

// What a hull of a body has.
PartProperties has(const PlacedBody& body, std::size_t hull) {
  return body.parts ? (*body.parts)[body.hulls->part[hull]] : PartProperties{{}, body.filter, 0};
}

bool collide(const PartProperties& a, const PartProperties& b) {
  return a.sensor == 0 && b.sensor == 0 && meet(a.filter, b.filter);
}

HullSet disc_hulls(double radius) {
  HullSet set;
  set.parts.resize(1);
  set.parts[0].count = 1;
  set.parts[0].radius = static_cast<float>(radius);
  finish_hull(set.parts[0]);
  return set;
}

// How deep two bodies whose circles overlap are in each other; negative if they are apart.
double depth_of(const PlacedBody& a, const PlacedBody& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  if (!a.parts && !b.parts && !meet(a.filter, b.filter)) return -1;
  if (!a.hulls && !b.hulls) return a.radius + b.radius - std::sqrt(dx * dx + dy * dy);
  const HullSet of_a = a.hulls ? HullSet{} : disc_hulls(a.radius);
  const HullSet of_b = b.hulls ? HullSet{} : disc_hulls(b.radius);
  double depth = -1;
  const std::vector<Hull>&hulls_a = (a.hulls ? *a.hulls : of_a).parts, &hulls_b = (b.hulls ? *b.hulls : of_b).parts;
  for (std::size_t i = 0; i < hulls_a.size(); ++i) {
    for (std::size_t k = 0; k < hulls_b.size(); ++k) {
      if (!collide(has(a, i), has(b, k))) continue;
      const Nearest gap =
          nearest(hulls_a[i], a.turn, hulls_b[k], b.turn, static_cast<float>(dx), static_cast<float>(dy));
      depth = std::max(depth, -static_cast<double>(gap.distance));
    }
  }
  return depth;
}

double depth_of(const PlacedBody& a, const PlacedSegment& s) {
  if (!a.parts && !meet(a.filter, s.filter)) return -1;
  const double gap = distance_to(s, a.x, a.y);
  if (!a.hulls || gap >= a.radius) return a.radius - gap;
  const Vec2 middle{(s.p.x + s.q.x) / 2, (s.p.y + s.q.y) / 2};
  PlacedBody line{middle.x, middle.y, 0, 0, 0, 0};
  line.filter = s.filter;
  auto hulls = std::make_shared<HullSet>();
  std::string error;
  const SegmentShape shape{{s.p.x - middle.x, s.p.y - middle.y}, {s.q.x - middle.x, s.q.y - middle.y}};
  if (!make_hulls(shape, true, *hulls, error)) return -1;
  line.hulls = std::move(hulls);
  return depth_of(a, line);
}

}  // namespace

Overlaps find_overlaps(const std::vector<PlacedBody>& bodies, const std::vector<PlacedSegment>& segments,
                       double tolerance, const MayOverlap& may_overlap) {
  Overlaps found;
  const auto level_of = [](double radius) { return std::ilogb(radius); };
  std::map<int, Level> levels;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const PlacedBody& d = bodies[k];
    if (!(d.radius > 0) || !std::isfinite(d.x + d.y + d.radius)) continue;
    Level& level = levels[level_of(d.radius)];
    level.cell = std::ldexp(1.0, level_of(d.radius) + 2);
    level.entries.push_back({cell_of(d.y, level.cell), cell_of(d.x, level.cell), k});
  }
  // Total order: a body has one entry.
  for (auto& [exponent, level] : levels) std::sort(level.entries.begin(), level.entries.end());

  for (auto own = levels.begin(); own != levels.end(); ++own) {
    for (const Entry& entry : own->second.entries) {
      const PlacedBody& a = bodies[entry.body];
      for (auto at = own; at != levels.end(); ++at) {
        const Level& level = at->second;
        const std::int64_t row = cell_of(a.y, level.cell), column = cell_of(a.x, level.cell);
        for (std::int64_t r = row - 1; r <= row + 1; ++r) {
          auto e = std::lower_bound(level.entries.begin(), level.entries.end(), Entry{r, column - 1, 0});
          for (; e != level.entries.end() && e->row == r && e->column <= column + 1; ++e) {
            const PlacedBody& b = bodies[e->body];
            if ((at == own && e->body <= entry.body) || !(a.moves || b.moves)) continue;
            const double dx = a.x - b.x, dy = a.y - b.y, reach = a.radius + b.radius;
            if (dx * dx + dy * dy >= reach * reach) continue;
            if (may_overlap(a.id, b.id)) continue;
            const double depth = depth_of(a, b);
            if (depth > tolerance) note(found, depth, entry.body, e->body, false);
          }
        }
      }
    }
  }
  if (static_cast<double>(bodies.size()) * static_cast<double>(segments.size()) > kMostSegmentTests) {
    return found;
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (!bodies[k].moves) continue;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const double depth = depth_of(bodies[k], segments[s]);
      if (depth <= tolerance || may_overlap(bodies[k].id, segments[s].owner)) continue;
      note(found, depth, k, s, true);
    }
  }
  return found;
}

}  // namespace psim
