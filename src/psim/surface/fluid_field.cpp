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
class Splat {
 public:
  Splat(FluidField& field, double spacing, double reach)
      : field_(field),
        reach_(static_cast<float>(reach / field.cell)),
        height_(static_cast<float>(35.0 / 32 * spacing / reach)),  // the integral of w is 32 / 35 reach
        per_cell_(1 / field.cell) {}

  void add(Vec2 at, float value) {
    const auto x = static_cast<float>((at.x - field_.origin.x) * per_cell_);
    const auto y = static_cast<float>((at.y - field_.origin.y) * per_cell_);
    std::array<float, kMostTouched> across{}, up{};
    const Span columns = weigh(x, field_.columns, across), rows = weigh(y, field_.rows, up);
    for (int j = rows.first; j < rows.end; ++j) {
      const float share = up[static_cast<std::size_t>(j - rows.first)];
      const auto start = static_cast<std::size_t>(j) * static_cast<std::size_t>(field_.columns) +
                         static_cast<std::size_t>(columns.first);
      const auto n = static_cast<std::size_t>(std::max(columns.end - columns.first, 0));
      float* const fullness = field_.fullness.data() + start;
      for (std::size_t i = 0; i < n; ++i) fullness[i] += share * across[i];
      if (field_.value.empty()) continue;
      float* const values = field_.value.data() + start;
      for (std::size_t i = 0; i < n; ++i) values[i] += share * value * across[i];
    }
  }

 private:
  struct Span {
    int first, end;
  };
  Span weigh(float at, int nodes, std::array<float, kMostTouched>& weights) const {
    const int first = std::max(static_cast<int>(std::ceil(at - reach_)), 0);
    const int end = std::min(static_cast<int>(std::floor(at + reach_)) + 1, nodes);
    for (int k = first; k < end; ++k) {
      const float u = (static_cast<float>(k) - at) / reach_, w = std::max(1 - u * u, 0.0f);
      weights[static_cast<std::size_t>(k - first)] = height_ * w * w * w;
    }
    return {first, end};
  }

  FluidField& field_;
  float reach_;   // cells
  float height_;  // of w
  double per_cell_;
};

// Calls add(place) for a particle and for those that a wall mirrors, or that come from over a seam, within `part`.
template <class Add>
void with_images(Vec2 at, const FluidGrid& grid, const Bounds& part, const Add& add) {
  const Bounds& w = grid.world;
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
    if (!(ys[j] > part.ymin && ys[j] < part.ymax)) continue;
    for (std::size_t i = 0; i < nx; ++i) {
      if (xs[i] > part.xmin && xs[i] < part.xmax) add(Vec2{xs[i], ys[j]});
    }
  }
}

// Means over squares of 2 radius + 1 nodes a side, twice; nodes beyond the grid count as 0. Along rows by a running sum,
// then along columns by a running sum of rows.
class Blur {
 public:
  Blur(const FluidField& field, int radius)
      : columns_(static_cast<std::size_t>(field.columns)),
        rows_(static_cast<std::size_t>(field.rows)),
        radius_(static_cast<std::size_t>(radius)) {}

  void operator()(std::vector<float>& nodes) {
    for (int pass = 0; pass < 2; ++pass) {
      along_rows(nodes);
      along_columns(nodes);
    }
  }

 private:
  float share() const { return 1 / static_cast<float>(2 * radius_ + 1); }

  void along_rows(std::vector<float>& nodes) {
    // Zeros on both sides of a copy of the row: every sum has the same number of nodes.
    line_.assign(columns_ + 2 * radius_ + 1, 0.0f);
    for (std::size_t j = 0; j < rows_; ++j) {
      float* const row = nodes.data() + j * columns_;
      std::copy(row, row + columns_, line_.begin() + static_cast<std::ptrdiff_t>(radius_));
      double sum = 0;
      for (std::size_t i = 0; i < 2 * radius_; ++i) sum += static_cast<double>(line_[i]);
      for (std::size_t i = 0; i < columns_; ++i) {
        sum += static_cast<double>(line_[i + 2 * radius_]);
        row[i] = static_cast<float>(sum) * share();
        sum -= static_cast<double>(line_[i]);
      }
    }
  }

  void along_columns(std::vector<float>& nodes) {
    before_.assign(nodes.begin(), nodes.end());
    sums_.assign(columns_, 0.0);
    const auto add = [&](std::size_t j, double sign) {
      const float* const row = before_.data() + j * columns_;
      for (std::size_t i = 0; i < columns_; ++i) sums_[i] += sign * static_cast<double>(row[i]);
    };
    for (std::size_t j = 0; j < std::min(radius_, rows_); ++j) add(j, 1);
    for (std::size_t j = 0; j < rows_; ++j) {
      if (j + radius_ < rows_) add(j + radius_, 1);
      if (j > radius_) add(j - radius_ - 1, -1);
      float* const row = nodes.data() + j * columns_;
      for (std::size_t i = 0; i < columns_; ++i) row[i] = static_cast<float>(sums_[i]) * share();
    }
  }

  std::size_t columns_, rows_, radius_;
  std::vector<float> line_, before_;
  std::vector<double> sums_;
};

// Particles move in strings, with gaps between them within the fluid. Where the sum is high over some spacings around,
// there is fluid. A straight surface stays where it is and becomes smoother.
void close_gaps(FluidField& field, int radius) {
  constexpr float kWideEdge = 0.45f, kSlope = 1.6f;  // the mean around a node that makes it the surface
  Blur blur(field, radius);
  std::vector<float> wide(field.fullness);
  blur(wide);
  if (!field.value.empty()) blur(field.value);
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
  Bounds part = shared_part(widened(grid.shown, margin), widened(grid.world, margin));
  if (grid.boundary != Boundary::periodic) part = shared_part(part, widened(box_around(places), margin));
  if (!has_area(part) || places.empty() || !lay_grid(part, grid, cell, field)) return;
  const std::size_t nodes = static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows);
  field.fullness.assign(nodes, 0.0f);
  if (!values.empty()) field.value.assign(nodes, 0.0f);
  Splat splat(field, grid.spacing, reach);
  const Bounds near = widened(part, reach);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const float value = values.empty() ? 0 : values[k];
    with_images(places[k], grid, near, [&](Vec2 at) { splat.add(at, value); });
  }
  close_gaps(field, radius);
  if (cell <= grid.spacing / 2) return;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (at_place(field, places[k]) < kFluidEdge) field.lone.push_back(static_cast<std::uint32_t>(k));
  }
}

}  // namespace psim::cli
