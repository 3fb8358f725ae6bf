#include "surface/fluid_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace psim::cli {
namespace {

constexpr double kKernelReach = 1.5;               // spacings: radius of a kernel
constexpr double kFinest = 1.5, kCoarsest = 6;     // pixels: cells are no smaller and, if drawn large, no larger
constexpr double kLeastReach = 2;                  // cells
constexpr std::size_t kMostTouched = 52;           // nodes across a kernel
constexpr std::ptrdiff_t kMostNodes = 64'000'000;  // of a grid

// Half a spacing or, by factors of two, what is neither too fine nor too coarse to be seen.
double cell_for(double spacing, double pixel) {
  double cell = spacing / 2;
  while (cell > kCoarsest * pixel) cell /= 2;
  while (cell < kFinest * pixel) cell *= 2;
  return std::max(cell, spacing / 16);  // the kernel fits into kMostTouched
}

bool has_area(const Bounds& b) { return (b.xmin < b.xmax && b.ymin < b.ymax); }

Bounds widened(const Bounds& b, double by) { return {b.xmin - by, b.ymin - by, b.xmax + by, b.ymax + by}; }

Bounds shared_part(const Bounds& a, const Bounds& b) {
  return {std::max(a.xmin, b.xmin), std::max(a.ymin, b.ymin), std::min(a.xmax, b.xmax), std::min(a.ymax, b.ymax)};
}

Bounds box_around(std::span<const Vec2> places) {
  Bounds box{1e300, 1e300, -1e300, -1e300};
  for (const Vec2& at : places) {
    if (!std::isfinite(at.x + at.y)) continue;
    box = {std::min(box.xmin, at.x), std::min(box.ymin, at.y), std::max(box.xmax, at.x), std::max(box.ymax, at.y)};
  }
  return box;
}

// Adds kernels to the nodes. A kernel is a product: w(x) w(y), w(u) = (1 - (u / reach)^2)^3, nearly round.
//
// Weights are added four nodes at a time. Those beyond the kernel are 0, so that nodes behind it stay as they are;
// kSpare nodes behind the last row make room for them.
class Splat {
 public:
  static constexpr std::size_t kStep = 4, kSpare = kStep;

  Splat(FluidField& field, double spacing, double reach)
      : field_(field),
        reach_(static_cast<float>(reach / field.cell)),
        height_(static_cast<float>(35.0 / 32 * spacing / reach)),  // the integral of w is 32 / 35 reach
        per_cell_(1 / field.cell) {}

  void add(Vec2 at, float value) {
    float across[kMostTouched], up[kMostTouched];
    const Span columns = weigh((at.x - field_.origin.x) * per_cell_, field_.columns, across);
    const Span rows = weigh((at.y - field_.origin.y) * per_cell_, field_.rows, up);
    if (columns.first >= columns.end) return;
    const auto stride = static_cast<std::size_t>(field_.columns);
    const auto n = static_cast<std::size_t>(columns.end - columns.first);
    std::size_t start = static_cast<std::size_t>(rows.first) * stride + static_cast<std::size_t>(columns.first);
    for (int j = 0; j < rows.end - rows.first; ++j, start += stride) {
      add_row(field_.fullness.data() + start, across, up[j], n);
      if (!field_.value.empty()) add_row(field_.value.data() + start, across, up[j] * value, n);
    }
  }

 private:
  struct Span {
    int first, end;
  };
  static void add_row(float* nodes, const float* weights, float share, std::size_t n) {
    for (std::size_t i = 0; i < n; i += kStep) {
      for (std::size_t k = 0; k < kStep; ++k) nodes[i + k] += share * weights[i + k];
    }
  }

  Span weigh(double place, int nodes, float* weights) const {
    constexpr int kShift = 64;  // cells: places outside of the grid are positive with it, so that a cast rounds down
    const auto at = static_cast<float>(place);
    const int first = std::max(static_cast<int>(at - reach_ + kShift) - kShift + 1, 0);
    const int end = std::min(static_cast<int>(at + reach_ + kShift) - kShift + 1, nodes);
    if (first >= end) return {first, first};
    const auto n = static_cast<std::size_t>(end - first);
    const float per_reach = 1 / reach_, from = (static_cast<float>(first) - at) * per_reach;
    for (std::size_t k = 0; k < n; k += kStep) {
      for (std::size_t lane = 0; lane < kStep; ++lane) {
        const float u = from + static_cast<float>(static_cast<int>(k + lane)) * per_reach;
        const float w = std::max(1 - u * u, 0.0f);
        weights[k + lane] = height_ * w * w * w;
      }
    }
    if (end == nodes) std::fill(weights + n, weights + (n + kStep - 1) / kStep * kStep, 0.0f);
    return {first, end};
  }

  FluidField& field_;
  float reach_;   // cells
  float height_;  // of w
  double per_cell_;
};

struct Reached {
  Bounds all;     // metres: particles there reach nodes of the grid
  Bounds inside;  // those there reach nodes without images
};

// Calls add(place) for a particle and for those that a wall mirrors, or that come from over a seam, where they reach the
// grid.
template <class Add>
void with_images(Vec2 at, const FluidGrid& grid, const Reached& part, const Add& add) {
  const Bounds &w = grid.world, &inside = part.inside;
  if (at.x > inside.xmin && at.x < inside.xmax && at.y > inside.ymin && at.y < inside.ymax) return add(at);
  const double across = w.xmax - w.xmin, up = w.ymax - w.ymin;
  std::array<double, 3> xs{at.x}, ys{at.y};
  std::size_t nx = 1, ny = 1;
  if (grid.boundary == Boundary::periodic) {
    xs = {at.x, at.x - across, at.x + across};
    ys = {at.y, at.y - up, at.y + up};
    nx = ny = 3;
  } else if (grid.boundary == Boundary::walls) {
    xs = {at.x, 2 * w.xmin - at.x, 2 * w.xmax - at.x};
    ys = {at.y, 2 * w.ymin - at.y, 2 * w.ymax - at.y};
    nx = ny = 3;
  }
  for (std::size_t j = 0; j < ny; ++j) {
    if (!(ys[j] > part.all.ymin && ys[j] < part.all.ymax)) continue;
    for (std::size_t i = 0; i < nx; ++i) {
      if (xs[i] > part.all.xmin && xs[i] < part.all.xmax) add(Vec2{xs[i], ys[j]});
    }
  }
}

// Means over squares of 2 radius + 1 nodes a side, twice; nodes beyond the grid count as 0. `room` is scratch.
void blur(std::vector<float>& nodes, const FluidField& field, int radius, std::vector<float>& room) {
  const auto columns = static_cast<std::size_t>(field.columns), rows = static_cast<std::size_t>(field.rows);
  const auto reach = static_cast<std::size_t>(radius), width = 2 * reach + 1;
  const float share = 1 / static_cast<float>(width * width);
  std::vector<float> line(columns + 2 * reach, 0.0f);  // a row with zeros on both sides
  room.resize(nodes.size());
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t j = 0; j < rows; ++j) {
      const float* const from = nodes.data() + j * columns;
      float* const to = room.data() + j * columns;
      std::copy(from, from + columns, line.begin() + radius);
      std::fill(to, to + columns, 0.0f);
      for (std::size_t d = 0; d < width; ++d) {
        for (std::size_t i = 0; i < columns; ++i) to[i] += line[i + d];
      }
    }
    for (std::size_t j = 0; j < rows; ++j) {
      float* const to = nodes.data() + j * columns;
      std::fill(to, to + columns, 0.0f);
      const std::size_t first = j > reach ? j - reach : 0, end = std::min(j + reach + 1, rows);
      for (std::size_t k = first; k < end; ++k) {
        const float* const from = room.data() + k * columns;
        for (std::size_t i = 0; i < columns; ++i) to[i] += from[i];
      }
      for (std::size_t i = 0; i < columns; ++i) to[i] *= share;
    }
  }
}

// Particles move in strings, with gaps between them within the fluid. Where the sum is high over some spacings around,
// there is fluid. A straight surface stays where it is and becomes smoother.
void close_gaps(FluidField& field, int radius) {
  constexpr float kWideEdge = 0.45f, kSlope = 1.6f;  // the mean around a node that makes it the surface
  std::vector<float>& wide = field.scratch[0];
  wide = field.fullness;
  blur(wide, field, radius, field.scratch[1]);
  if (!field.value.empty()) blur(field.value, field, radius, field.scratch[1]);
  for (std::size_t k = 0; k < field.value.size(); ++k) field.value[k] /= std::max(wide[k], 1e-6f);
  for (std::size_t k = 0; k < wide.size(); ++k) {
    field.fullness[k] = std::max(field.fullness[k], kFluidEdge + kSlope * (wide[k] - kWideEdge));
  }
}

float at_place(const FluidField& field, Vec2 place) {
  const double x = (place.x - field.origin.x) / field.cell, y = (place.y - field.origin.y) / field.cell;
  if (!(x >= 0 && y >= 0 && x < field.columns - 1 && y < field.rows - 1)) return 1;
  const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
  const auto fx = static_cast<float>(x - static_cast<double>(i)), fy = static_cast<float>(y - static_cast<double>(j));
  const float* const low = field.fullness.data() + j * static_cast<std::size_t>(field.columns) + i;
  const float* const high = low + field.columns;
  return (1 - fy) * (low[0] + fx * (low[1] - low[0])) + fy * (high[0] + fx * (high[1] - high[0]));
}

// Lays the grid over the part: nodes are whole multiples of the cell from the middle of the world, whatever is shown.
bool lay_grid(const Bounds& part, const FluidGrid& grid, double cell, FluidField& field) {
  const Vec2 middle{(grid.world.xmin + grid.world.xmax) / 2, (grid.world.ymin + grid.world.ymax) / 2};
  const double left = std::floor((part.xmin - middle.x) / cell), low = std::floor((part.ymin - middle.y) / cell);
  const double columns = std::ceil((part.xmax - middle.x) / cell) - left + 1;
  const double rows = std::ceil((part.ymax - middle.y) / cell) - low + 1;
  if (!(columns * rows <= static_cast<double>(kMostNodes))) return false;
  field.origin = {middle.x + cell * left, middle.y + cell * low};
  field.cell = cell;
  field.columns = static_cast<int>(columns);
  field.rows = static_cast<int>(rows);
  return true;
}

// Where a fluid within the box may be seen, `margin` around it. Along an axis on which it comes near the seam of a
// periodic world, that is all of the world.
Bounds wet_part(const Bounds& box, const FluidGrid& grid, double margin) {
  const Bounds world = widened(grid.world, margin);
  Bounds wet = widened(box, margin);
  const bool wraps = grid.boundary == Boundary::periodic;
  if (wraps && !(wet.xmin > grid.world.xmin && wet.xmax < grid.world.xmax)) {
    wet.xmin = world.xmin;
    wet.xmax = world.xmax;
  }
  if (wraps && !(wet.ymin > grid.world.ymin && wet.ymax < grid.world.ymax)) {
    wet.ymin = world.ymin;
    wet.ymax = world.ymax;
  }
  return shared_part(wet, world);
}

}  // namespace

std::uint32_t fluid_rgb(FluidId fluid) {
  constexpr std::array<std::uint32_t, 6> kColours = {0x2f7fd0, 0xd08a2e, 0x3fa06b, 0xb0558c, 0x8678d8, 0xb9b04a};
  return kColours[fluid % kColours.size()];
}

void make_fluid_field(std::span<const Vec2> places, std::span<const float> values, const FluidGrid& grid,
                      FluidField& field) {
  field.fullness.clear();
  field.value.clear();
  field.lone.clear();
  const double cell = cell_for(grid.spacing, grid.pixel);
  const double reach = std::max(kKernelReach * grid.spacing, kLeastReach * cell);
  const int radius =
      std::max(static_cast<int>(std::lround(grid.spacing / cell)), 1);  // a mean over two spacings, twice
  const double margin = reach + (2 * radius + 1) * cell;
  const Bounds part = shared_part(widened(grid.shown, margin), wet_part(box_around(places), grid, margin));
  if (!has_area(part) || places.empty() || !lay_grid(part, grid, cell, field)) return;
  const std::size_t nodes = static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows);
  field.fullness.assign(nodes + Splat::kSpare, 0.0f);
  if (!values.empty()) field.value.assign(nodes + Splat::kSpare, 0.0f);
  Splat splat(field, grid.spacing, reach);
  // An image lies beyond a side: what is farther from all sides than the grid and a kernel reach over them has none.
  const Bounds near = widened(part, reach);
  const Reached reached{near,
                        shared_part(near, widened(grid.world, grid.boundary == Boundary::open ? 0 : -margin - reach))};
  for (std::size_t k = 0; k < places.size(); ++k) {
    const float value = values.empty() ? 0 : values[k];
    with_images(places[k], grid, reached, [&](Vec2 at) { splat.add(at, value); });
  }
  field.fullness.resize(nodes);
  field.value.resize(values.empty() ? 0 : nodes);
  close_gaps(field, radius);
  if (cell <= grid.spacing / 2) return;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (at_place(field, places[k]) < kFluidEdge) field.lone.push_back(static_cast<std::uint32_t>(k));
  }
}

}  // namespace psim::cli
