// Chooses the cells that bodies are sorted into: a grid or a list of cells, their width, and which bodies are too large
// for them.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "lists/broad_cells.h"
#include "lists/large_cells.h"

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
double BroadCells::choose_reach(double area) const {
  constexpr double kMany = 0.125, kWorthMany = 0.6;
  // Costs in comparisons: of a pair of large bodies; of finding the cells of one; of a row of cells.
  constexpr double kPair = 0.6, kFound = 500, kRow = 48;
  const double n = s_.bodies.count, most = static_cast<double>(extent_.most);
  if (!(18 * most * most * n / area > kFewCandidates && n > 64)) return most;
  std::array<std::uint32_t, kBins> count{};
  for (std::uint32_t i = 0; i < s_.bodies.count; ++i) {
    if (s_.bodies.id[i] != kNoSlot) ++count[bin_of(s_.bodies.reach[i])];
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

void BroadCells::set_reach(double reach) {
  most_ = static_cast<float>(reach);
  large_ = reach < static_cast<double>(extent_.most) ? most_ : 1e30f;
}

// The least width of cells, m.
double BroadCells::least_edge(double reach) const {
  return 2 * reach * 1.00001 + 4 * std::max(s_.lattice.pitch_x(), s_.lattice.pitch_y());
}

// Chooses the grid over the bodies' box: cells as wide as two reaches, or wider where bodies are sparse.
void BroadCells::choose_grid(bool wraps) {
  const double pitch[2] = {s_.lattice.pitch_x(), s_.lattice.pitch_y()};
  double side[2];
  for (const int k : {0, 1}) side[k] = (wraps ? 0x1p32 : length(k) + 1) * pitch[k];
  const double sum = 2 * static_cast<double>(extent_.most);
  area_ = box_ = std::max(side[0], sum) * std::max(side[1], sum);
  const double reach = choose_reach(box_);
  set_reach(reach);
  const double wanted = kCellsABody * s_.bodies.count;
  const double edge = std::max(least_edge(reach), std::sqrt(side[0] * side[1] / (wanted + 64)));
  const double limit = 4 * wanted + 256;
  const auto cells = [&](double length) {
    return static_cast<std::int32_t>(std::clamp(std::floor(length / edge) + (wraps ? 0 : 1), 1.0, limit));
  };
  grid_ = Grid{};
  grid_.periodic = wraps;
  kernels::GridView& g = grid_.view;
  g.cols = cells(side[0]);
  g.rows = cells(side[1]);
  // In a long thin world the other axis bounds the number of cells.
  if (static_cast<double>(g.cols) * g.rows > limit) {
    g.cols = std::max(1, static_cast<std::int32_t>(limit / g.rows));
  }
  if (wraps && (g.cols < 3 || g.rows < 3)) {
    large_ = -1;  // too few cells to tell east from west: all bodies are compared with all
    g.cols = g.rows = 1;
  }
  const auto along = [&](int k, std::int32_t n, std::int32_t& mid, float& scale, float& offset) {
    double& cell = grid_.cell[k];
    cell = wraps ? side[k] / n : std::max(edge, side[k] / n);
    if (!wraps) mid = static_cast<std::int32_t>((std::int64_t{extent_.box[k]} + extent_.box[k + 2]) / 2);
    scale = static_cast<float>(pitch[k] / cell);
    offset = static_cast<float>(n) / 2;
  };
  along(0, g.cols, g.mid_x, g.scale_x, g.offset_x);
  along(1, g.rows, g.mid_y, g.scale_y, g.offset_y);
  g.stride = static_cast<std::uint32_t>(g.cols) + 1;
  grid_.keys = (static_cast<std::uint32_t>(g.rows) + 1) * g.stride + 3;
}

// The cost of the grid's cells beyond that of a list of cells, ns a body, for the given density around bodies.
double BroadCells::waste(double density) const {
  const double filled = s_.bodies.count / density;  // infinite if the density is not known
  if (large_ < 0 || !(box_ > 2 * filled)) return 0;
  const double tests = 4.5 * density * grid_.cell[0] * grid_.cell[1];
  if (kTest * tests < kListing / 2) return 0;
  const double edge = least_edge(choose_reach(filled));
  return kTest * (tests - 4.5 * density * edge * edge);
}

// Chooses the cells of the list. False if the world is too small for them.
bool BroadCells::choose_list(double density) {
  const double reach = choose_reach(s_.bodies.count / density), edge = least_edge(reach);
  const double steps[2] = {edge / s_.lattice.pitch_x(), edge / s_.lattice.pitch_y()};
  if (!list_.lay(extent_.box, steps, grid_.periodic, s_.bodies.count)) return false;
  set_reach(reach);
  return true;
}

// A grid is tried first. Whether it serves is known from the density of the last build, or, if the density may have
// changed, from a sample of how full its cells are.
void BroadCells::count(const BroadPhaseParams& params) {
  const double last_box = box_;
  const bool more = s_.bodies.count > sorted_ + sorted_ / 8;
  choose_grid(params.periodic);
  double density = density_;
  bool list = waste(density) > (listed_ ? kListing / 2 : kListing);
  if (!list) {
    sort_.count(grid_, large_);
    if (params.sample) tests_ = 0.5 * sort_.neighbours(grid_);
    if (!(density_ > 0) || box_ > 1.5 * last_box || more) {
      density = sort_.neighbours(grid_) / (9 * grid_.cell[0] * grid_.cell[1]);
      list = waste(density) > kListing;
    }
  }
  listed_ = list && choose_list(density);
  if (list && !listed_) sort_.count(grid_, large_);  // the world has too few cells for a list
  order();
}

void BroadCells::count_again() {
  if (!listed_) sort_.count(grid_, large_);
  order();
}

void BroadCells::order() {
  const std::size_t padded = kernels::round_up_block(s_.bodies.count);
  from_.reserve(padded);
  keys_.reserve(padded);
  if (!listed_) list_.forget();
  counted_ = listed_ ? list_.sort(large_, from_.data(), keys_.data()) : sort_.order(from_.data(), keys_.data());
}

bool BroadCells::move(bool mixed_radii, std::size_t begin, std::size_t end) {
  const bool last = end == moves();
  mover_.move(from_.data(), mixed_radii, begin * BodyMover::kPiece,
              std::min<std::size_t>(end * BodyMover::kPiece, counted_.all()));
  if (!last) return false;
  mover_.finish(mixed_radii, counted_.small + counted_.large);
  sorted_ = s_.bodies.count;
  return true;
}

double BroadCells::cell_area() const {
  if (!listed_) return grid_.cell[0] * grid_.cell[1];
  return list_.cell_steps(0) * s_.lattice.pitch_x() * list_.cell_steps(1) * s_.lattice.pitch_y();
}

void BroadCells::note_density() {
  if (!listed_) {
    density_ = sample_density();
    return;
  }
  density_ = std::max((list_.neighbours(keys_.data(), large_begin()) - 1) / (9 * cell_area()), sorted_ / box_);
  area_ = sorted_ / density_;
}

// About 64 bodies count the others in a square of 8 radii, among at most 60,000 bodies.
double BroadCells::area_about(double radius, double bounds) const {
  const BodyStore& b = s_.bodies;
  if (area_ > 0) return area_;
  if (b.count < kFew || b.count * radius * radius * kThin > bounds) return bounds;
  const std::uint32_t stride = std::max(1u, b.count / 64), skip = b.count / 60'000 + 1;
  const double half = 8 * radius;
  const double far_x = half / s_.lattice.pitch_x(), far_y = half / s_.lattice.pitch_y();
  double found = 0, samples = 0;
  for (std::size_t i = stride / 2; i < b.count; i += stride, samples += 1) {
    for (std::size_t j = 0; j < b.count; j += skip) {
      const double dx = wrap_sub(b.pos[2 * j], b.pos[2 * i]);
      const double dy = wrap_sub(b.pos[2 * j + 1], b.pos[2 * i + 1]);
      found += i != j && std::fabs(dx) < far_x && std::fabs(dy) < far_y ? skip : 0;
    }
  }
  const double density = found / (samples * 4 * half * half);
  return std::min(bounds, b.count / density);
}

// Samples the cells around every n-th body.
double BroadCells::sample_density() const {
  const std::uint32_t bodies = large_begin(), stride = std::max(1u, bodies / 2048), row = grid_.view.stride;
  double sum = 0, samples = 0;
  for (std::uint32_t i = 0; i < bodies; i += stride, samples += 1) {
    const std::uint32_t key = keys_[i];
    const std::uint32_t low = key < row ? key : key - row;
    const std::uint32_t high = key / row + 1 < static_cast<std::uint32_t>(grid_.view.rows) ? key + row : key;
    double found = 0, rows = 0;
    for (std::uint32_t k = low; k <= high; k += row, rows += 1) found += sort_.in_three(k);
    sum += found / rows;
  }
  return samples > 0 ? sum / samples / (3 * grid_.cell[0] * grid_.cell[1]) : 0;
}

}  // namespace psim
