// Chooses the cells that bodies are sorted into: a grid or a list of cells, their width, and which bodies are too large
// for them.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "lists/broad_phase.h"

namespace psim {
namespace {

// The most cells a body: more cells cost more in the prefix sum than they save in candidates (measured,
// docs/performance.md).
constexpr double kCellsABody = 1.5;
// If a grid leaves more candidates than this a body, a better split by size is looked for.
constexpr double kFewCandidates = 14;
// ns: the cost of comparing with a candidate, and the extra cost a body of a list of cells over a grid (measured,
// docs/decisions/008-sparse-worlds.md).
constexpr double kTest = 0.25, kListing = 5;
constexpr double kThin = 1000;       // a world with more squared radii of area a disc than this is large
constexpr std::uint32_t kFew = 256;  // fewer bodies than this cost little, whatever the search

// Histogram bins of reaches, a quarter of an octave each, from the highest bits of a float.
constexpr int kBinShift = 21;
constexpr std::size_t kBins = std::size_t{1} << (31 - kBinShift);

std::size_t bin_of(float reach) { return (std::bit_cast<std::uint32_t>(reach) & 0x7FFFFFFFu) >> kBinShift; }

double bin_end(std::size_t bin) {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>((bin + 1) << kBinShift)));
}

}  // namespace

// Returns the largest reach that cells are made for; bodies with a longer reach count as large. The split minimises
// the estimated number of comparisons: within the cells, and of each large body with the bodies under its box and
// with the other large bodies. `area` is the area that the bodies are spread over. Many large bodies must save
// more than a few, because the estimate for them is rough and their search is one strip for one thread.
double BroadPhase::choose_reach(double area) const {
  constexpr double kMany = 0.125, kWorthMany = 0.6;
  // Costs in comparisons: of a pair of large bodies; of finding the cells of one; of a row of cells.
  constexpr double kPair = 0.6, kFound = 500, kRow = 48;
  const double n = b_.count, most = static_cast<double>(all_.most);
  if (!(18 * most * most * n / area > kFewCandidates && n > 64)) return most;
  std::array<std::uint32_t, kBins> count{};
  for (std::uint32_t i = 0; i < b_.count; ++i) {
    if (b_.id[i] != kNoSlot) ++count[bin_of(b_.reach[i])];
  }
  double best = 1e300, above = 0, large_area = 0, large_reach = 0;
  double chosen = most;
  for (std::size_t bin = bin_of(static_cast<float>(most)) + 1; bin-- > 0;) {
    if (count[bin] == 0) continue;
    const double limit = std::min(bin_end(bin), most), small = n - above;
    const double large = above < LargeCells::kLeast ? kPair * above * above : kFound * above;
    const double cost = small * 18 * limit * limit * small / area +
                        (large_area + above * 4 * limit * limit) * small / area * 1.5 +
                        kRow * (large_reach / limit + 2 * above) + large;
    if (cost < (above > kMany * n ? kWorthMany * best : best)) {
      best = cost;
      chosen = limit;
    }
    const double here = count[bin];
    above += here;
    large_area += here * 8 * limit * limit;
    large_reach += here * limit;
  }
  return chosen;
}

void BroadPhase::set_reach(double reach) {
  most_ = static_cast<float>(reach);
  large_ = reach < static_cast<double>(all_.most) ? most_ : 1e30f;
}

// The least width of cells, m.
double BroadPhase::least_edge(double reach) const {
  return 2 * reach * 1.00001 + 4 * std::max(lattice_.pitch_x(), lattice_.pitch_y());
}

// Chooses the grid over the bodies' box: cells as wide as two reaches, or wider where bodies are sparse.
void BroadPhase::choose_grid() {
  const bool wraps = params_.periodic;
  const std::int32_t* const extent = all_.extent;
  const double px = lattice_.pitch_x(), py = lattice_.pitch_y();
  const double steps_x = wraps ? 0x1p32 : static_cast<double>(extent[2]) - extent[0] + 1;
  const double steps_y = wraps ? 0x1p32 : static_cast<double>(extent[3]) - extent[1] + 1;
  const double width = steps_x * px, height = steps_y * py;
  const double sum = 2 * static_cast<double>(all_.most);
  area_ = box_ = std::max(width, sum) * std::max(height, sum);
  const double reach = choose_reach(box_);
  set_reach(reach);
  const double edge = std::max(least_edge(reach), std::sqrt(width * height / (kCellsABody * b_.count + 64)));
  const double limit = 4 * kCellsABody * b_.count + 256;
  const auto cells = [&](double length) {
    return static_cast<std::int32_t>(std::clamp(std::floor(length / edge) + (wraps ? 0 : 1), 1.0, limit));
  };
  grid_ = Grid{};
  grid_.periodic = wraps;
  kernels::GridView& g = grid_.view;
  g.cols = cells(width);
  g.rows = cells(height);
  // In a long thin world the other axis bounds the number of cells.
  if (static_cast<double>(g.cols) * g.rows > limit) {
    g.cols = std::max(1, static_cast<std::int32_t>(limit / g.rows));
  }
  if (wraps && (g.cols < 3 || g.rows < 3)) {
    large_ = -1;  // too few cells to tell east from west: all bodies are compared with all
    g.cols = g.rows = 1;
  }
  grid_.cell_x = wraps ? width / g.cols : std::max(edge, width / g.cols);
  grid_.cell_y = wraps ? height / g.rows : std::max(edge, height / g.rows);
  if (!wraps) {
    g.mid_x = static_cast<std::int32_t>((static_cast<std::int64_t>(extent[0]) + extent[2]) / 2);
    g.mid_y = static_cast<std::int32_t>((static_cast<std::int64_t>(extent[1]) + extent[3]) / 2);
  }
  g.scale_x = static_cast<float>(px / grid_.cell_x);
  g.scale_y = static_cast<float>(py / grid_.cell_y);
  g.offset_x = static_cast<float>(g.cols) / 2;
  g.offset_y = static_cast<float>(g.rows) / 2;
  g.stride = static_cast<std::uint32_t>(g.cols) + 1;
  grid_.keys = (static_cast<std::uint32_t>(g.rows) + 1) * g.stride + 3;
}

// The cost of the grid's cells beyond that of a list of cells, ns a body, for the given density around bodies.
double BroadPhase::waste(double density) const {
  const double filled = b_.count / density;  // infinite if the density is not known
  if (large_ < 0 || !(box_ > 2 * filled)) return 0;
  const double tests = 4.5 * density * grid_.cell_x * grid_.cell_y;
  if (kTest * tests < kListing / 2) return 0;
  const double edge = least_edge(choose_reach(filled));
  return kTest * (tests - 4.5 * density * edge * edge);
}

// Chooses the cells of the list. False if the world is too small for them.
bool BroadPhase::choose_cells(double density) {
  const double reach = choose_reach(b_.count / density), edge = least_edge(reach);
  const double steps[2] = {edge / lattice_.pitch_x(), edge / lattice_.pitch_y()};
  if (!sort_.listed().lay(all_.extent, steps, params_.periodic, b_.count)) return false;
  set_reach(reach);
  return true;
}

// Chooses the cells and finds the cell of each body. A grid is tried first. Whether it serves is known from the
// density of the last build, or, if the density may have changed, from a sample of how full its cells are.
void BroadPhase::count() {
  const double last_box = box_;
  const bool more = b_.count > sorted_ + sorted_ / 8;
  choose_grid();
  double density = density_;
  bool list = waste(density) > (listed_ ? kListing / 2 : kListing);
  if (!list) {
    sort_.count(grid_, large_);
    if (params_.sample) tests_ = 0.5 * sort_.neighbours(grid_);
    if (!(density_ > 0) || box_ > 1.5 * last_box || more) {
      density = sort_.neighbours(grid_) / (9 * grid_.cell_x * grid_.cell_y);
      list = waste(density) > kListing;
    }
  }
  listed_ = list && choose_cells(density);
  if (list && !listed_) sort_.count(grid_, large_);  // the world has too few cells for a list
}

double BroadPhase::tests() const {
  if (!listed_ && tests_ > 0) return tests_;
  if (!listed_) return 4.5 * density_ * grid_.cell_x * grid_.cell_y;
  const CellList& cells = sort_.listed();
  return 4.5 * density_ * cells.cell_steps(0) * lattice_.pitch_x() * cells.cell_steps(1) * lattice_.pitch_y();
}

// About 64 bodies count the others in a square of 8 radii, among at most 60,000 bodies.
double BroadPhase::area_about(double radius, double bounds) const {
  if (area_ > 0) return area_;
  if (b_.count < kFew || b_.count * radius * radius * kThin > bounds) return bounds;
  const std::uint32_t stride = std::max(1u, b_.count / 64), skip = b_.count / 60'000 + 1;
  const double half = 8 * radius;
  const double far_x = half / lattice_.pitch_x(), far_y = half / lattice_.pitch_y();
  double found = 0, samples = 0;
  for (std::size_t i = stride / 2; i < b_.count; i += stride, samples += 1) {
    for (std::size_t j = 0; j < b_.count; j += skip) {
      const double dx = wrap_sub(b_.pos[2 * j], b_.pos[2 * i]);
      const double dy = wrap_sub(b_.pos[2 * j + 1], b_.pos[2 * i + 1]);
      found += i != j && std::fabs(dx) < far_x && std::fabs(dy) < far_y ? skip : 0;
    }
  }
  const double density = found / (samples * 4 * half * half);
  return std::min(bounds, b_.count / density);
}

// Samples the cells around every n-th body.
double BroadPhase::sample_density(std::uint32_t bodies) const {
  const std::uint32_t stride = std::max(1u, bodies / 2048), row = grid_.view.stride;
  const std::uint32_t* const start = sort_.start();
  double sum = 0, samples = 0;
  for (std::uint32_t i = 0; i < bodies; i += stride, samples += 1) {
    const std::uint32_t key = sort_.keys()[i];
    const std::uint32_t low = key < row ? key : key - row;
    const std::uint32_t high = key / row + 1 < static_cast<std::uint32_t>(grid_.view.rows) ? key + row : key;
    double found = 0, rows = 0;
    for (std::uint32_t k = low; k <= high; k += row, rows += 1) {
      found += start[k + 2] - start[static_cast<std::ptrdiff_t>(k) - 1];
    }
    sum += found / rows;
  }
  return samples > 0 ? sum / samples / (3 * grid_.cell_x * grid_.cell_y) : 0;
}

}  // namespace psim
