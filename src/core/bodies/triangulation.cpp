#include "bodies/triangulation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/elementary.h"
#include "base/orientation.h"
#include "base/rotor.h"

namespace psim {
namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;

/// Cuts off ears, triangles of three vertices in a row that hold no other vertex, until nothing is left. Every simple
/// polygon has two (G. H. Meisters, "Polygons have ears", American Mathematical Monthly 82, 1975).
class EarClipper {
 public:
  explicit EarClipper(const std::vector<Vec2>& points)
      : points_(points),
        previous_(points.size()),
        next_(points.size()),
        across_(points.size(), kNone),
        place_(points.size(), kNone),
        ear_(points.size()),
        left_(points.size()) {
    const auto n = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t v = 0; v < n; ++v) {
      previous_[v] = v == 0 ? n - 1 : v - 1;
      next_[v] = v + 1 == n ? 0 : v + 1;
    }
    for (std::uint32_t v = 0; v < n; ++v) {
      if (convex(v)) continue;
      place_[v] = static_cast<std::uint32_t>(blunt_.size());
      blunt_.push_back({points_[v], v});
    }
    for (std::uint32_t v = 0; v < n; ++v) renew(v);
  }

  Triangulation run() {
    for (std::size_t k = 0; k < queue_.size() && left_ > 2; ++k) {
      if (ear_[queue_[k]]) clip(queue_[k]);
    }
    return std::move(mesh_);
  }

 private:
  struct Corner {
    Vec2 at;
    std::uint32_t vertex;
  };

  bool convex(std::uint32_t v) const { return side_of(points_[previous_[v]], points_[v], points_[next_[v]]) > 0; }

  // If there is any vertex in the triangle, then one whose angle is half a turn or more.
  bool is_ear(std::uint32_t v) const {
    const std::uint32_t before = previous_[v], after = next_[v];
    const Vec2 a = points_[before], b = points_[v], c = points_[after];
    const Bounds box{lesser(lesser(a.x, b.x), c.x), lesser(lesser(a.y, b.y), c.y), greater(greater(a.x, b.x), c.x),
                     greater(greater(a.y, b.y), c.y)};
    return std::ranges::none_of(blunt_, [&](const Corner& other) {
      return contains(box, other.at) && other.vertex != before && other.vertex != after &&
             side_of(a, b, other.at) >= 0 && side_of(b, c, other.at) >= 0 && side_of(c, a, other.at) >= 0;
    });
  }

  // Finds whether a vertex, whose neighbours have changed, is an ear.
  void renew(std::uint32_t v) {
    ear_[v] = false;
    if (!convex(v)) return;
    if (place_[v] != kNone) {
      place_[blunt_.back().vertex] = place_[v];
      blunt_[std::exchange(place_[v], kNone)] = blunt_.back();
      blunt_.pop_back();
    }
    ear_[v] = is_ear(v);
    if (ear_[v]) queue_.push_back(v);
  }

  void clip(std::uint32_t v) {
    const std::uint32_t before = previous_[v], after = next_[v];
    const auto edge = static_cast<std::uint32_t>(mesh_.from.size());
    mesh_.from.insert(mesh_.from.end(), {before, v, after});
    mesh_.twin.insert(mesh_.twin.end(), 3, kNone);
    mesh_.join(edge, across_[before]);
    mesh_.join(edge + 1, across_[v]);
    if (left_ == 3) mesh_.join(edge + 2, across_[after]);
    across_[before] = edge + 2;
    next_[before] = after;
    previous_[after] = before;
    ear_[v] = false;
    --left_;
    renew(before);
    renew(after);
  }

  const std::vector<Vec2>& points_;
  std::vector<std::uint32_t> previous_, next_;  // of the polygon that is left
  std::vector<std::uint32_t> across_;           // half-edge beyond the edge from a vertex to its next one
  std::vector<std::uint32_t> place_;            // of a vertex in blunt_
  std::vector<Corner> blunt_;                   // vertices whose angle is half a turn or more
  std::vector<bool> ear_;
  std::vector<std::uint32_t> queue_;  // ears and former ears, first come, first served
  std::size_t left_;
  Triangulation mesh_;
};

/// Turns diagonals (Lawson) where that raises the least angle of the two triangles: in the end the triangulation is
/// Delaunay. Each turn raises the sorted list of all least angles, as rounded as they are, so that the turns end.
class Flipper {
 public:
  Flipper(Triangulation& mesh, const std::vector<Vec2>& points) : mesh_(mesh), points_(points) {}

  void run() {
    for (std::size_t edge = mesh_.from.size(); edge-- > 0;) pending_.push_back(static_cast<std::uint32_t>(edge));
    while (!pending_.empty()) {
      const std::uint32_t edge = pending_.back();
      pending_.pop_back();
      if (mesh_.twin[edge] != kNone && improves(edge)) flip(edge);
    }
  }

 private:
  bool improves(std::uint32_t edge) const {
    const std::uint32_t twin = mesh_.twin[edge];
    const std::uint32_t a = mesh_.from[edge], b = mesh_.from[twin];
    const std::uint32_t c = mesh_.from[Triangulation::previous(edge)], d = mesh_.from[Triangulation::previous(twin)];
    if (side_of(points_[a], points_[d], points_[c]) <= 0 || side_of(points_[b], points_[c], points_[d]) <= 0)
      return false;
    return lesser(least(a, d, c), least(b, c, d)) > lesser(least(a, b, c), least(b, a, d));
  }

  double least(std::uint32_t a, std::uint32_t b, std::uint32_t c) const { return sharpness(points_, a, b, c); }

  // The diagonal from a to b becomes one from c to d: of the triangles of both, a b c and b a d, a d c and b c d.
  void flip(std::uint32_t edge) {
    const std::uint32_t twin = mesh_.twin[edge], c_edge = Triangulation::next(edge), d_edge = Triangulation::next(twin);
    const std::uint32_t beyond_ad = mesh_.twin[d_edge], beyond_bc = mesh_.twin[c_edge];
    mesh_.from[c_edge] = mesh_.from[Triangulation::previous(twin)];
    mesh_.from[d_edge] = mesh_.from[Triangulation::previous(edge)];
    mesh_.join(edge, beyond_ad);
    mesh_.join(twin, beyond_bc);
    mesh_.join(c_edge, d_edge);
    for (const std::uint32_t e : {edge, Triangulation::previous(edge), twin, Triangulation::previous(twin)}) {
      pending_.push_back(e);
    }
  }

  Triangulation& mesh_;
  const std::vector<Vec2>& points_;
  std::vector<std::uint32_t> pending_;
};

}  // namespace

double sharpness(const std::vector<Vec2>& points, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  const Vec2 u = points[b] - points[a], v = points[c] - points[a];
  const double x = length_of(u), y = length_of(v), z = length_of(points[c] - points[b]);
  const double longest = greater(greater(x, y), z), middle = greater(lesser(x, y), lesser(greater(x, y), z));
  return std::fabs(cross(u, v)) / (longest * middle);
}

Triangulation triangulate(const std::vector<Vec2>& points) {
  Triangulation mesh = EarClipper(points).run();
  Flipper(mesh, points).run();
  return mesh;
}

}  // namespace psim
