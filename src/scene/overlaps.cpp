// Discs lie in grids by size: level k holds radii in [2^k, 2^(k+1)) and has cells of 2^(k+2) m, so
// that what overlaps is in the same cell or beside it. A disc looks through its own level and those
// above, so that every pair is met from its smaller disc.
#include "overlaps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace psim {
namespace {

// A scene with more disc x segment tests than this is not tested against its segments.
constexpr double kMostSegmentTests = 2e8;

struct Entry {
  std::int64_t row, column;
  std::size_t disc;
  bool operator<(const Entry& b) const {
    return std::tie(row, column, disc) < std::tie(b.row, b.column, b.disc);
  }
};

struct Level {
  double cell = 1;
  std::vector<Entry> entries;  // by row, then column
};

std::int64_t cell_of(double x, double cell) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x / cell, -1e15, 1e15)));
}

void note(Overlaps& found, double depth, std::size_t disc, std::size_t other, bool segment) {
  ++found.count;
  if (depth <= found.depth) return;
  found.depth = depth;
  found.disc = disc;
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

}  // namespace

Overlaps find_overlaps(const std::vector<PlacedDisc>& discs,
                       const std::vector<PlacedSegment>& segments, double tolerance) {
  Overlaps found;
  const auto level_of = [](double radius) { return std::ilogb(radius); };
  std::map<int, Level> levels;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const PlacedDisc& d = discs[k];
    if (!(d.radius > 0) || !std::isfinite(d.x + d.y + d.radius)) continue;
    Level& level = levels[level_of(d.radius)];
    level.cell = std::ldexp(1.0, level_of(d.radius) + 2);
    level.entries.push_back({cell_of(d.y, level.cell), cell_of(d.x, level.cell), k});
  }
  for (auto& [exponent, level] : levels) std::sort(level.entries.begin(), level.entries.end());

  for (auto own = levels.begin(); own != levels.end(); ++own) {
    for (const Entry& entry : own->second.entries) {
      const PlacedDisc& a = discs[entry.disc];
      for (auto at = own; at != levels.end(); ++at) {
        const Level& level = at->second;
        const std::int64_t row = cell_of(a.y, level.cell), column = cell_of(a.x, level.cell);
        for (std::int64_t r = row - 1; r <= row + 1; ++r) {
          auto e =
              std::lower_bound(level.entries.begin(), level.entries.end(), Entry{r, column - 1, 0});
          for (; e != level.entries.end() && e->row == r && e->column <= column + 1; ++e) {
            const PlacedDisc& b = discs[e->disc];
            if ((at == own && e->disc <= entry.disc) || !(a.moves || b.moves)) continue;
            const double dx = a.x - b.x, dy = a.y - b.y, reach = a.radius + b.radius;
            if (dx * dx + dy * dy >= reach * reach) continue;
            const double depth = reach - std::sqrt(dx * dx + dy * dy);
            if (depth > tolerance) note(found, depth, entry.disc, e->disc, false);
          }
        }
      }
    }
  }
  if (static_cast<double>(discs.size()) * static_cast<double>(segments.size()) >
      kMostSegmentTests) {
    return found;
  }
  for (std::size_t k = 0; k < discs.size(); ++k) {
    if (!discs[k].moves) continue;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const double depth = discs[k].radius - distance_to(segments[s], discs[k].x, discs[k].y);
      if (depth > tolerance) note(found, depth, k, s, true);
    }
  }
  return found;
}

}  // namespace psim
