#include "place/placement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "base/rotor.h"
#include "number_text.h"
#include "place/random.h"
#include "place/shape_size.h"

namespace psim {
namespace {

// A cell that is too small by rounding only still holds its body.
constexpr double kRounding = 1e-9;
// Jitter stops this fraction of the gap short, so that rounding cannot close it.
constexpr double kShortOfContact = 1 - 1e-6;
// Random placement keeps this much more than the sum of the radii between centres.
constexpr double kApart = 1 + 1e-6;
// Darts a body, on average, before a random group is said not to fit. Discs of one size thrown until
// none fits cover 0.547 of the region; 200 darts a disc reach 0.52.
constexpr std::uint64_t kDartsPerBody = 200;
constexpr std::uint64_t kDartsAtLeast = 20000;
// Ids are 32 bits.
constexpr std::uint64_t kMostBodies = std::numeric_limits<std::uint32_t>::max();

enum Stream : std::uint64_t { kX, kY, kRadius, kVelocityX, kVelocityY };

double pick_radius(const GroupDesc& g, const RandomStream& random, std::uint64_t k) {
  const double spread = g.radius_max - g.radius_min;
  return spread > 0 ? g.radius_min + spread * random.unit(k) : g.radius_min;
}

void place_on_lattice(const GroupDesc& g, const LatticePlan& plan, PlacedGroup& out) {
  const bool hex = g.layout == Layout::hex;
  const RandomStream jitter_x(g.seed, kX), jitter_y(g.seed, kY);
  const double jitter = g.jitter * kShortOfContact;
  std::uint64_t k = 0;
  for (std::uint64_t row = 0; row < plan.rows; ++row) {
    const double y = g.region.ymin + (static_cast<double>(row) + 0.5) * plan.cell_y;
    const double shift = hex && row % 2 == 1 ? 1.0 : 0.5;
    for (std::uint64_t column = 0; column < plan.columns && k < g.count; ++column, ++k) {
      out.x[k] = g.region.xmin + (static_cast<double>(column) + shift) * plan.cell_x;
      out.y[k] = y;
      if (!(jitter > 0)) continue;
      // A body that stays in its cell meets no other.
      const double r = out.radius[k];
      out.x[k] += jitter_x.plus_minus_one(k) * (jitter * std::max(plan.cell_x / 2 - r, 0.0));
      out.y[k] += jitter_y.plus_minus_one(k) * (jitter * std::max(plan.cell_y / 2 - r, 0.0));
    }
  }
}

// Centres on the ellipse that touches the sides of the region, counter-clockwise from its right end. The steps of the
// angle are equal.
void place_on_ring(const GroupDesc& g, PlacedGroup& out) {
  const double step = 2 * std::numbers::pi / static_cast<double>(g.count);
  const Vec2 middle{(g.region.xmin + g.region.xmax) / 2, (g.region.ymin + g.region.ymax) / 2};
  const Vec2 half{(g.region.xmax - g.region.xmin) / 2, (g.region.ymax - g.region.ymin) / 2};
  for (std::size_t k = 0; k < out.x.size(); ++k) {
    const SineCosine turn = sine_cosine(static_cast<double>(k) * step);
    out.x[k] = middle.x + half.x * turn.cosine;
    out.y[k] = middle.y + half.y * turn.sine;
  }
}

// Whether neighbours on a ring, whose bodies are placed, do not overlap.
bool fits_ring(const PlacedGroup& placed, std::string& error) {
  const std::size_t n = placed.x.size();
  for (std::size_t k = 0; k < n && n > 1; ++k) {
    const std::size_t next = k + 1 < n ? k + 1 : 0;
    const double apart = length_of(Vec2{placed.x[next] - placed.x[k], placed.y[next] - placed.y[k]});
    const double bodies = placed.radius[k] + placed.radius[next];
    if (apart * (1 + kRounding) >= bodies) continue;
    error = "bodies " + std::to_string(k) + " and " + std::to_string(next) + " of the ring are " + number_text(apart) +
            " m apart, less than their radii, " + number_text(bodies) +
            " m: make the region larger, or radius or count smaller";
    return false;
  }
  return true;
}

bool fits_lattice(const GroupDesc& g, const LatticePlan& plan, std::string& error) {
  const double body = 2 * g.radius_max;
  const double cell = std::min(plan.cell_x, plan.cell_y);
  if (cell * (1 + kRounding) >= body) return true;
  const double width = g.region.xmax - g.region.xmin, height = g.region.ymax - g.region.ymin;
  // Growing the region alike keeps the columns, so this is enough.
  const double grow = body / cell;
  error = "a cell of the lattice is " + number_text(plan.cell_x) + " x " + number_text(plan.cell_y) + " m (" +
          std::to_string(plan.columns) + " columns, " + std::to_string(plan.rows) + " rows), smaller than a body of " +
          number_text(body) + " m: make the region at least " + round_up_text(width * grow) + " x " +
          round_up_text(height * grow) + " m, or radius at most " + round_down_text(cell / 2) + ", or count smaller";
  return false;
}

// Bodies placed so far, by the cell that holds their centre. A cell is as wide as the largest body,
// so what touches a body is in its own or one of the eight cells around.
class DartBoard {
 public:
  DartBoard(const Bounds& region, double radius_max, const PlacedGroup& placed)
      : placed_(placed), xmin_(region.xmin), ymin_(region.ymin) {
    const double width = region.xmax - region.xmin, height = region.ymax - region.ymin;
    const double n = static_cast<double>(placed.x.size());
    // No more than about four cells a body.
    cell_ = std::max(2 * radius_max * kApart, std::sqrt(width * height / (4 * n + 64)));
    cell_ = std::max({cell_, width / (4 * n + 64), height / (4 * n + 64)});
    columns_ = static_cast<std::size_t>(width / cell_) + 1;
    rows_ = static_cast<std::size_t>(height / cell_) + 1;
    first_.assign(columns_ * rows_, kNone);
    next_.assign(placed.x.size(), kNone);
  }

  bool is_free(double x, double y, double radius) const {
    const std::size_t column = column_of(x), row = row_of(y);
    for (std::size_t r = row - (row > 0); r <= std::min(row + 1, rows_ - 1); ++r) {
      for (std::size_t c = column - (column > 0); c <= std::min(column + 1, columns_ - 1); ++c) {
        for (std::uint32_t k = first_[r * columns_ + c]; k != kNone; k = next_[k]) {
          const double dx = placed_.x[k] - x, dy = placed_.y[k] - y;
          const double reach = (placed_.radius[k] + radius) * kApart;
          if (dx * dx + dy * dy < reach * reach) return false;
        }
      }
    }
    return true;
  }

  void put(std::uint32_t k) {
    std::uint32_t& head = first_[row_of(placed_.y[k]) * columns_ + column_of(placed_.x[k])];
    next_[k] = head;
    head = k;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::size_t column_of(double x) const {
    return std::min(static_cast<std::size_t>(std::max(x - xmin_, 0.0) / cell_), columns_ - 1);
  }
  std::size_t row_of(double y) const {
    return std::min(static_cast<std::size_t>(std::max(y - ymin_, 0.0) / cell_), rows_ - 1);
  }

  const PlacedGroup& placed_;
  double xmin_, ymin_, cell_ = 1;
  std::size_t columns_ = 1, rows_ = 1;
  std::vector<std::uint32_t> first_, next_;
};

bool does_not_fit(const GroupDesc& g, std::uint64_t placed, double covered, std::string& error) {
  error = "only " + std::to_string(placed) + " of " + std::to_string(g.count) +
          " bodies found room (they would cover " + round_up_text(100 * covered) +
          " % of the region; random placement reaches about 50 %): make the region larger, count or "
          "radius smaller, or layout \"lattice\"";
  return false;
}

bool place_at_random(const GroupDesc& g, PlacedGroup& out, std::string& error) {
  const double width = g.region.xmax - g.region.xmin, height = g.region.ymax - g.region.ymin;
  if (std::min(width, height) * (1 + kRounding) < 2 * g.radius_max) {
    error = "a region of " + number_text(width) + " x " + number_text(height) + " m is smaller than a body of " +
            number_text(2 * g.radius_max) + " m: make the region larger or radius smaller";
    return false;
  }
  double area = 0;
  for (const double r : out.radius) area += std::numbers::pi * r * r;
  const double covered = area / (width * height);
  if (covered > 1) return does_not_fit(g, 0, covered, error);

  const RandomStream random_x(g.seed, kX), random_y(g.seed, kY);
  DartBoard board(g.region, g.radius_max, out);
  const std::uint64_t darts = kDartsPerBody * g.count + kDartsAtLeast;
  std::uint64_t dart = 0;
  for (std::uint64_t k = 0; k < g.count; ++k) {
    const double r = out.radius[k];
    const double free_x = std::max(width - 2 * r, 0.0), free_y = std::max(height - 2 * r, 0.0);
    for (;; ++dart) {
      if (dart == darts) return does_not_fit(g, k, covered, error);
      out.x[k] = g.region.xmin + r + free_x * random_x.unit(dart);
      out.y[k] = g.region.ymin + r + free_y * random_y.unit(dart);
      if (board.is_free(out.x[k], out.y[k], r)) break;
    }
    ++dart;
    board.put(static_cast<std::uint32_t>(k));
  }
  return true;
}

// Length n, or 1 for all alike, or empty for `otherwise`.
bool take_column(const std::vector<double>& given, const char* name, std::size_t n, double otherwise,
                 std::vector<double>& out, std::string& error) {
  if (given.size() > 1 && given.size() != n) {
    error = std::string(name) + " has " + std::to_string(given.size()) + " entries, and x has " + std::to_string(n) +
            ": one for each body, or one for all";
    return false;
  }
  if (given.size() == n) {
    out = given;
  } else {
    out.assign(n, given.empty() ? otherwise : given[0]);
  }
  return true;
}

bool place_explicit(const GroupDesc& g, PlacedGroup& out, std::string& error) {
  if (g.y.size() != g.x.size()) {
    error = "y has " + std::to_string(g.y.size()) + " entries, and x has " + std::to_string(g.x.size()) +
            ": one for each body";
    return false;
  }
  out.x = g.x;
  out.y = g.y;
  return take_column(g.radius, "radius", g.x.size(), g.radius_min, out.radius, error) &&
         take_column(g.vx, "vx", g.x.size(), g.velocity.x, out.vx, error) &&
         take_column(g.vy, "vy", g.x.size(), g.velocity.y, out.vy, error);
}

bool is_sound(const GroupDesc& g, std::string& error) {
  const Bounds& b = g.region;
  if (g.count > kMostBodies) {
    error = "count " + std::to_string(g.count) + " is too many: at most " + std::to_string(kMostBodies);
  } else if (!(b.xmin < b.xmax && b.ymin < b.ymax && std::isfinite(b.xmax - b.xmin) &&
               std::isfinite(b.ymax - b.ymin))) {
    error = "region has no area: [xmin, ymin, xmax, ymax] with xmin < xmax and ymin < ymax";
  } else if (!(g.radius_min > 0 && g.radius_max >= g.radius_min && std::isfinite(g.radius_max))) {
    error = "radius is one number > 0, or [smallest, largest] of such";
  } else if (!(g.jitter >= 0 && g.jitter <= 1)) {
    error = "jitter is " + number_text(g.jitter) + ": 0 to 1";
  } else {
    return true;
  }
  return false;
}

std::optional<PlacedGroup> place_discs(const GroupDesc& group, std::string& error) {
  PlacedGroup out;
  if (group.layout == Layout::explicit_list) {
    if (!place_explicit(group, out, error)) return std::nullopt;
  } else {
    if (!is_sound(group, error)) return std::nullopt;
    if (group.count == 0) return out;
    const auto n = static_cast<std::size_t>(group.count);
    const bool random = group.layout == Layout::random, ring = group.layout == Layout::ring;
    LatticePlan plan;
    if (!random && !ring) {
      plan = plan_lattice(group.count, group.region, group.layout == Layout::hex);
      if (!fits_lattice(group, plan, error)) return std::nullopt;
    }
    const RandomStream random_radius(group.seed, kRadius);
    out.x.resize(n);
    out.y.resize(n);
    out.radius.resize(n);
    for (std::size_t k = 0; k < n; ++k) out.radius[k] = pick_radius(group, random_radius, k);
    out.vx.assign(n, group.velocity.x);
    out.vy.assign(n, group.velocity.y);
    if (ring) {
      place_on_ring(group, out);
      if (!fits_ring(out, error)) return std::nullopt;
    } else if (!random) {
      place_on_lattice(group, plan, out);
    } else if (!place_at_random(group, out, error)) {
      return std::nullopt;
    }
  }
  if (group.velocity_spread > 0) {
    const RandomStream random_vx(group.seed, kVelocityX), random_vy(group.seed, kVelocityY);
    for (std::size_t k = 0; k < out.x.size(); ++k) {
      out.vx[k] += group.velocity_spread * random_vx.plus_minus_one(k);
      out.vy[k] += group.velocity_spread * random_vy.plus_minus_one(k);
    }
  }
  return out;
}

}  // namespace

LatticePlan plan_lattice(std::uint64_t count, const Bounds& region, bool hex) {
  const double width = region.xmax - region.xmin, height = region.ymax - region.ymin;
  const double n = static_cast<double>(count);
  // Without kRounding a square region whose width and height differ in the last bit would get a
  // column too many.
  const double columns = std::ceil(std::sqrt(n * (width / height)) * (1 - kRounding));
  LatticePlan plan;
  plan.columns = static_cast<std::uint64_t>(std::clamp(columns, 1.0, n));
  plan.rows = (count + plan.columns - 1) / plan.columns;
  const bool shifted = hex && plan.rows > 1;
  plan.cell_x = width / (static_cast<double>(plan.columns) + (shifted ? 0.5 : 0.0));
  plan.cell_y = height / static_cast<double>(plan.rows);
  return plan;
}

GroupDesc seeded_group(const Scene& scene, std::size_t k) {
  GroupDesc group = scene.groups[k];
  group.seed = mix_seeds(group.seed, scene.seed);
  return group;
}

std::optional<PlacedGroup> place_group(const GroupDesc& given, std::string& error) {
  if (is_disc(given.body.shape)) return place_discs(given, error);
  GroupDesc circles = given;
  circles.body.shape = DiscShape{};
  circles.radius_min = circles.radius_max = bounding_radius(given.body.shape);
  circles.radius = {circles.radius_max};
  return place_discs(circles, error);
}

}  // namespace psim
