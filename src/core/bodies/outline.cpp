// In: an outline. Out: convex polygons that are parts of a body, or what is wrong with the outline. Its triangles are
// joined to convex polygons after S. Hertel and K. Mehlhorn, "Fast triangulation of simple polygons", Foundations of
// Computation Theory (1983): each vertex that points inwards needs two cuts at most, so that the pieces are at most four
// times as many as the fewest possible, but for the limit on their vertices.
#include "psim/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>
#include <string_view>
#include <utility>

#include "base/elementary.h"
#include "base/machine.h"
#include "base/orientation.h"
#include "base/range_text.h"
#include "base/room.h"
#include "base/rotor.h"
#include "bodies/hull.h"
#include "bodies/triangulation.h"

namespace psim {
namespace {

constexpr double kStraightTurn = 1e-6;  // rad: a vertex with a smaller turn lies on the line of its neighbours
constexpr double kRepeated = 1e-10;     // of the way to the next vertex: one that is nearer to the last repeats it
constexpr std::size_t kMostAddedVertices = 2500;  // to long edges
constexpr double kLeastSize = 1e-100;  // m: smaller coordinates are 0, so that their products are no denormal numbers

/// The vertices of an outline that count, and the numbers that they had in it.
struct Ring {
  std::vector<Vec2> points;
  std::vector<std::size_t> numbers;

  std::size_t size() const { return points.size(); }
  std::size_t after(std::size_t k) const { return k + 1 < size() ? k + 1 : 0; }
  std::size_t before(std::size_t k) const { return k > 0 ? k - 1 : size() - 1; }
  int turn(std::size_t k) const { return side_of(points[before(k)], points[k], points[after(k)]); }
};

/// m: the longer side of the box around some points.
double extent_of(std::span<const Vec2> points) {
  Vec2 low = points[0], high = points[0];
  for (const Vec2 p : points) {
    low = {lesser(p.x, low.x), lesser(p.y, low.y)};
    high = {greater(p.x, high.x), greater(p.y, high.y)};
  }
  return greater(high.x - low.x, high.y - low.y);
}

std::string check_numbers(std::span<const Vec2> vertices, double radius) {
  if (vertices.size() < 3 || vertices.size() > kMostOutlineVertices) {
    return "an outline has 3 to " + std::to_string(kMostOutlineVertices) + " vertices, this one has " +
           std::to_string(vertices.size());
  }
  RangeCheck check;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    if (!limits::kCoordinate.contains(vertices[k]))
      return check("vertex " + std::to_string(k), vertices[k], limits::kCoordinate).error;
  }
  check("an outline's extent", extent_of(vertices), limits::kExtent);
  if (radius != 0) check("radius, where it is not 0,", radius, limits::kRadius);
  return check.error;
}

bool is_needless(Vec2 before, Vec2 here, Vec2 after) {
  const Vec2 u = here - before, v = after - here;
  const double in = length_of(u), out = length_of(v);
  if (in <= kRepeated * length_of(after - before)) return true;
  return dot(u, v) > 0 && std::fabs(cross(u, v)) <= kStraightTurn * in * out;
}

/// Leaves out vertices that repeat the one before them or lie on the line of their neighbours.
Ring without_needless(std::span<const Vec2> vertices) {
  const auto settled = [](double v) { return std::fabs(v) < kLeastSize ? 0 : v; };
  const std::size_t n = vertices.size();
  std::vector<Vec2> points;
  std::vector<std::size_t> before, after;
  for (std::size_t k = 0; k < n; ++k) {
    points.push_back({settled(vertices[k].x), settled(vertices[k].y)});
    before.push_back(k == 0 ? n - 1 : k - 1);
    after.push_back(k + 1 == n ? 0 : k + 1);
  }
  std::size_t left = n, at = 0;
  for (std::size_t kept = 0; kept < left && left > 2;) {  // in a row
    const std::size_t b = before[at], a = after[at];
    if (is_needless(points[b], points[at], points[a])) {
      after[b] = a;
      before[a] = b;
      --left;
      kept = 0;
      at = b;  // which may have become needless
    } else {
      ++kept;
      at = a;
    }
  }
  Ring ring;
  std::vector<std::size_t> numbers;
  for (std::size_t k = 0; k < left; ++k, at = after[at]) numbers.push_back(at);
  std::rotate(numbers.begin(), std::min_element(numbers.begin(), numbers.end()), numbers.end());
  for (const std::size_t k : numbers) ring.points.push_back(points[k]);
  ring.numbers = std::move(numbers);
  return ring;
}

/// Says where an outline crosses or touches itself; nothing where it does not.
class Crossings {
 public:
  explicit Crossings(const Ring& ring) : ring_(ring) {
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vec2 p = ring.points[k], q = ring.points[ring.after(k)];
      edges_.push_back({{lesser(p.x, q.x), lesser(p.y, q.y), greater(p.x, q.x), greater(p.y, q.y)}, k});
    }
  }

  std::string find() {
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const Vec2 here = ring_.points[k];
      const bool back = dot(here - ring_.points[ring_.before(k)], ring_.points[ring_.after(k)] - here) < 0;
      if (back && ring_.turn(k) == 0) return say(ring_.before(k), k);
    }
    // Total order: edges have different numbers.
    std::ranges::sort(edges_, [](const Edge& a, const Edge& b) {
      return a.box.xmin != b.box.xmin ? a.box.xmin < b.box.xmin : a.number < b.number;
    });
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      const Edge& edge = edges_[k];
      for (std::size_t o = k + 1; o < edges_.size() && edges_[o].box.xmin <= edge.box.xmax; ++o) {
        const Edge& other = edges_[o];
        if (overlap(edge.box, other.box) && meet(edge.number, other.number)) return say(edge.number, other.number);
      }
    }
    return {};
  }

 private:
  struct Edge {
    Bounds box;
    std::size_t number;  // of its first vertex
  };

  // Of edges whose boxes overlap.
  bool meet(std::size_t k, std::size_t o) const {
    if (ring_.after(k) == o || ring_.after(o) == k) return false;  // in their common vertex alone
    const Vec2 a = ring_.points[k], b = ring_.points[ring_.after(k)];
    const Vec2 c = ring_.points[o], d = ring_.points[ring_.after(o)];
    return side_of(a, b, c) * side_of(a, b, d) <= 0 && side_of(c, d, a) * side_of(c, d, b) <= 0;
  }

  std::string say(std::size_t k, std::size_t o) const {
    if (k > o) std::swap(k, o);
    const auto edge = [&](std::size_t n) {
      return "from vertex " + std::to_string(ring_.numbers[n]) + " to vertex " +
             std::to_string(ring_.numbers[ring_.after(n)]);
    };
    return "an outline must not cross or touch itself; its edges " + edge(k) + " and " + edge(o) + " do";
  }

  const Ring& ring_;
  std::vector<Edge> edges_;
};

void make_counter_clockwise(Ring& ring) {
  const auto less = [](Vec2 a, Vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; };
  const auto corner = std::min_element(ring.points.begin(), ring.points.end(), less) - ring.points.begin();
  if (ring.turn(static_cast<std::size_t>(corner)) > 0) return;
  std::ranges::reverse(ring.points);
  std::ranges::reverse(ring.numbers);
}

/// Joins the triangles of an outline to convex pieces.
class Joiner {
 public:
  Joiner(const Ring& ring, const Triangulation& mesh)
      : ring_(ring), mesh_(mesh), gone_(mesh.from.size()), corners_(mesh.from.size() / 3, 3) {
    for (std::uint32_t triangle = 0; triangle < corners_.size(); ++triangle) joined_.push_back(triangle);
    for (std::uint32_t edge = 0; edge < mesh.from.size(); ++edge) {
      next_.push_back(Triangulation::next(edge));
      previous_.push_back(Triangulation::previous(edge));
    }
  }

  /// Diagonals of thin triangles go first, which are the least welcome as pieces.
  void run() {
    std::vector<std::pair<double, std::uint32_t>> diagonals;
    for (std::uint32_t edge = 0; edge < mesh_.from.size(); ++edge) {
      const std::uint32_t twin = mesh_.twin[edge];
      if (twin != Triangulation::kNone && edge < twin)
        diagonals.emplace_back(lesser(sharpness_at(edge), sharpness_at(twin)), edge);
    }
    std::ranges::sort(diagonals);  // Total order: diagonals have different numbers.
    for (const auto& [least, edge] : diagonals) {
      try_to_join(edge);
    }
  }

  /// The vertices of each piece, counter-clockwise from the first of the outline.
  std::vector<std::vector<std::uint32_t>> pieces() {
    std::vector<std::vector<std::uint32_t>> all;
    for (std::uint32_t edge = 0; edge < mesh_.from.size(); ++edge) {
      if (gone_[edge]) continue;
      std::vector<std::uint32_t>& piece = all.emplace_back();
      for (std::uint32_t at = edge; !gone_[at]; at = next_[at]) {
        gone_[at] = true;
        if (turn(previous_[at], at) != 0) piece.push_back(mesh_.from[at]);
      }
      std::rotate(piece.begin(), std::min_element(piece.begin(), piece.end()), piece.end());
    }
    return all;
  }

 private:
  Vec2 at(std::uint32_t edge) const { return ring_.points[mesh_.from[edge]]; }
  double sharpness_at(std::uint32_t edge) const {
    const std::vector<std::uint32_t>& from = mesh_.from;
    return sharpness(ring_.points, from[edge], from[Triangulation::next(edge)], from[Triangulation::previous(edge)]);
  }
  // Which way a piece turns that has one half-edge behind the other.
  int turn(std::uint32_t in, std::uint32_t out) const { return side_of(at(in), at(out), at(next_[out])); }

  // The triangle that stands for the piece to the left of a half-edge.
  std::uint32_t piece_at(std::uint32_t edge) {
    std::uint32_t triangle = edge / 3;
    while (joined_[triangle] != triangle) triangle = joined_[triangle] = joined_[joined_[triangle]];
    return triangle;
  }

  // Takes out a diagonal whose pieces are a convex one together, with not too many corners. A vertex between two edges
  // on a line is no corner.
  void try_to_join(std::uint32_t edge) {
    const std::uint32_t twin = mesh_.twin[edge], piece = piece_at(edge), other = piece_at(twin);
    const int here = turn(previous_[edge], next_[twin]), there = turn(previous_[twin], next_[edge]);
    const int corners = corners_[piece] + corners_[other] - 4 + here + there;
    if (here < 0 || there < 0 || corners > kMostPolygonVertices) return;
    link(previous_[edge], next_[twin]);
    link(previous_[twin], next_[edge]);
    gone_[edge] = gone_[twin] = true;
    joined_[other] = piece;
    corners_[piece] = corners;
  }

  void link(std::uint32_t edge, std::uint32_t next) {
    next_[edge] = next;
    previous_[next] = edge;
  }

  const Ring& ring_;
  const Triangulation& mesh_;
  std::vector<std::uint32_t> next_, previous_;  // around the piece of a half-edge
  std::vector<bool> gone_;
  std::vector<std::uint32_t> joined_;  // of a triangle: itself, or one that it has been joined to
  std::vector<int> corners_;           // of the piece that a triangle stands for
};

ShapePart part_of(const Ring& ring, const std::vector<std::uint32_t>& piece, bool alone, double radius) {
  ShapePart part;
  if (!alone) part.position = ring.points[piece[0]];
  PolygonShape polygon;
  polygon.radius = radius;
  for (const std::uint32_t k : piece) polygon.vertices.push_back(ring.points[k] - part.position);
  part.shape = std::move(polygon);
  return part;
}

/// What the engine has against a piece.
std::string check_piece(const Ring& ring, const std::vector<std::uint32_t>& piece, const ShapePart& part) {
  HullSet unused;
  std::string error;
  if (make_hulls(shape_of(part), false, unused, error)) return {};
  std::string names;
  for (std::size_t k = 0; k < piece.size(); ++k) {
    names += (k == 0 ? "" : k + 1 == piece.size() ? " and " : ", ") + std::to_string(ring.numbers[piece[k]]);
  }
  return "the outline's piece of vertices " + names + ": " + error;
}

/// The pieces of an outline that is counter-clockwise and does not touch itself.
std::vector<ShapePart> cut_ring(const Ring& ring, double radius, std::string& error) {
  error.clear();
  const Triangulation mesh = triangulate(ring.points);
  Joiner joiner(ring, mesh);
  joiner.run();
  const std::vector<std::vector<std::uint32_t>> pieces = joiner.pieces();
  std::vector<ShapePart> parts;
  for (const std::vector<std::uint32_t>& piece : pieces) {
    parts.push_back(part_of(ring, piece, pieces.size() == 1, radius));
    error = check_piece(ring, piece, parts.back());
    if (!error.empty()) return {};
  }
  return parts;
}

/// Cuts edges that are longer than `most` metres into equal ones. Nothing, if that makes too many vertices.
Ring with_short_edges(const Ring& ring, double most) {
  Ring out;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vec2 from = ring.points[k], way = ring.points[ring.after(k)] - from;
    const double count = greater(std::ceil(length_of(way) / most), 1.0);
    if (static_cast<double>(out.size()) + count > static_cast<double>(ring.size() + kMostAddedVertices)) return {};
    for (double n = 0; n < count; ++n) {
      out.points.push_back(from + (n / count) * way);
      out.numbers.push_back(ring.numbers[k]);
    }
  }
  return out;
}

std::vector<ShapePart> cut(std::span<const Vec2> vertices, double radius, std::string& error) {
  error = check_numbers(vertices, radius);
  if (!error.empty()) return {};
  Ring ring = without_needless(vertices);
  error = ring.size() < 3 ? "an outline must have an area" : Crossings(ring).find();
  if (!error.empty()) return {};
  make_counter_clockwise(ring);
  std::vector<ShapePart> parts = cut_ring(ring, radius, error);
  // Many short edges far from the ends of a long one leave only thin triangles, unless the long one has vertices, too.
  for (double share = 8; !error.empty() && share <= 512; share *= 8) {
    const Ring finer = with_short_edges(ring, extent_of(ring.points) / share);
    if (finer.size() == 0 || !Crossings(finer).find().empty()) break;
    std::string still;
    parts = cut_ring(finer, radius, still);
    if (still.empty()) error.clear();
  }
  return parts;
}

}  // namespace

std::vector<ShapePart> cut_outline(std::span<const Vec2> vertices, double radius, std::string& error) try {
  const FloatSettings settings;
  return cut(vertices, radius, error);
} catch (const std::bad_alloc&) {
  ran_out_of_memory() = true;
  error = "no room";  // so short a text is held in place
  return {};
}

}  // namespace psim
