#include "broad_phase.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>

#include "invariant.h"
#include "tasks.h"

namespace psim {
namespace {

using kernels::kBlock;

// Cells a body at most: more cost more in the prefix sum than they save in candidates (measured,
// docs/performance.md).
constexpr double kCellsABody = 1.5;
// A grid that leaves more candidates than this a body looks for a better split by size.
constexpr double kFewCandidates = 14;
// ns: to look at a candidate, and what a list of cells costs a body more than a grid (measured,
// docs/decisions/008-sparse-worlds.md).
constexpr double kTest = 0.25, kListing = 5;
constexpr double kThin = 1000;  // squares of a radius, of a disc, that make a world a large one
constexpr std::uint32_t kFew = 256;  // bodies that cost little however they are looked for

// Bodies a strip: small enough for many strips a thread, large enough for full blocks.
std::uint32_t strip_bodies(std::uint32_t n) {
  return std::clamp<std::uint32_t>(n / 192, 128, 1024);
}

// A list a strip, with room for the usual few so that warm steps do not allocate.
void make_singles(PairTable& table, std::size_t strips) {
  if (table.singles.size() >= strips) return;
  const std::size_t before = table.singles.size();
  table.singles.resize(strips);
  table.found.resize(strips);
  for (std::size_t s = before; s < strips; ++s) table.singles[s].reserve(64);
}

}  // namespace

bool BroadPhase::lists_serve(BodyStore& b, float time, const kernels::KernelTable& k,
                             WorkerPool& pool) {
  const std::uint32_t blocks = b.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  kernels::StreamParams p;
  p.pitch_x = static_cast<float>(lattice_->pitch_x());
  p.pitch_y = static_cast<float>(lattice_->pitch_y());
  std::atomic<bool> serve{true};
  const kernels::BodyView view = b.view();
  pool.run(tasks, [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    if (!serve.load(std::memory_order_relaxed)) return;  // the answer is known
    const float age = k.list_age(view, b.built.data(), b.radius.data(), b.reach.data(), p, time,
                                 r.begin, r.end);
    if (!(age <= 0)) serve.store(false, std::memory_order_relaxed);
  });
  return serve.load();
}

namespace {

// Of reaches: a quarter of an octave each, by a float's highest bits.
constexpr int kBinShift = 21;
constexpr std::size_t kBins = std::size_t{1} << (31 - kBinShift);

std::size_t bin_of(float reach) { return (std::bit_cast<std::uint32_t>(reach) & 0x7FFFFFFFu) >> kBinShift; }

double bin_end(std::size_t bin) {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>((bin + 1) << kBinShift)));
}

}  // namespace

// The largest reach that cells are made for: that of all but large bodies. It splits by estimated
// candidates: within the cells, and of each large body against the bodies under its box and the
// other large ones. `area` is what the bodies are spread over.
double BroadPhase::choose_reach(const BodyStore& b, double most, double area) const {
  constexpr double kPair = 0.6, kFound = 500, kRow = 48;  // tests: of two large bodies; to find one's cells; of a row
  const double n = b.count;
  if (!(18 * most * most * n / area > kFewCandidates && n > 64)) return most;
  std::array<std::uint32_t, kBins> count{};
  for (std::uint32_t i = 0; i < b.count; ++i) {
    if (b.id[i] != kNoSlot) ++count[bin_of(b.reach[i])];
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
    if (cost < best) {
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

void BroadPhase::set_reach(double reach, float most) {
  most_ = static_cast<float>(reach);
  large_ = reach < static_cast<double>(most) ? most_ : 1e30f;
}

// Least width of cells, m.
double BroadPhase::least_edge(double reach) const {
  return 2 * reach * 1.00001 + 4 * std::max(lattice_->pitch_x(), lattice_->pitch_y());
}

// The grid over the bodies' box: cells as wide as two reaches, or wider where it is sparse.
void BroadPhase::choose_grid(const BodyStore& b, const BroadPhaseParams& p,
                             const std::int32_t extent[4], float most) {
  const double n = b.count;
  const double px = lattice_->pitch_x(), py = lattice_->pitch_y();
  const double steps_x = p.periodic ? 0x1p32 : static_cast<double>(extent[2]) - extent[0] + 1;
  const double steps_y = p.periodic ? 0x1p32 : static_cast<double>(extent[3]) - extent[1] + 1;
  const double width = steps_x * px, height = steps_y * py;
  const double sum = 2 * static_cast<double>(most);
  area_ = box_ = std::max(width, sum) * std::max(height, sum);
  const double reach = choose_reach(b, static_cast<double>(most), box_);
  set_reach(reach, most);
  const double edge = std::max(least_edge(reach),
                               std::sqrt(width * height / (kCellsABody * n + 64)));
  const auto cells = [&](double length) {
    const double c = p.periodic ? std::floor(length / edge) : std::floor(length / edge) + 1;
    return static_cast<std::int32_t>(std::clamp(c, 1.0, 4.0 * kCellsABody * n + 256));
  };
  grid_ = Grid{};
  grid_.periodic = p.periodic;
  kernels::GridView& g = grid_.view;
  g.cols = cells(width);
  g.rows = cells(height);
  // A long thin world: the other axis bounds the number of cells.
  const double limit = 4 * kCellsABody * n + 256;
  if (static_cast<double>(g.cols) * g.rows > limit) {
    g.cols = std::max(1, static_cast<std::int32_t>(limit / g.rows));
  }
  if (p.periodic && (g.cols < 3 || g.rows < 3)) {
    large_ = -1;  // too few cells to tell east from west: all bodies against all
    g.cols = g.rows = 1;
  }
  grid_.cell_x = p.periodic ? width / g.cols : std::max(edge, width / g.cols);
  grid_.cell_y = p.periodic ? height / g.rows : std::max(edge, height / g.rows);
  if (p.periodic) {
    g.mid_x = g.mid_y = 0;
  } else {
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

// ns a body that the grid's cells cost beyond those of a list, if `density` is that around the bodies.
double BroadPhase::waste(const BodyStore& b, float most, double density) const {
  const double filled = b.count / density;  // inf: nothing is known
  if (large_ < 0 || !(box_ > 2 * filled)) return 0;
  const double tests = 4.5 * density * grid_.cell_x * grid_.cell_y;
  if (kTest * tests < kListing / 2) return 0;
  const double edge = least_edge(choose_reach(b, static_cast<double>(most), filled));
  return kTest * (tests - 4.5 * density * edge * edge);
}

// Lays the list's cells. False if the world is too small for them.
bool BroadPhase::choose_cells(const BodyStore& b, const BroadPhaseParams& p,
                              const std::int32_t extent[4], float most, double density) {
  const double reach = choose_reach(b, static_cast<double>(most), b.count / density);
  const double edge = least_edge(reach);
  const double steps[2] = {edge / lattice_->pitch_x(), edge / lattice_->pitch_y()};
  if (!sort_.listed().lay(extent, steps, p.periodic, b.count)) return false;
  set_reach(reach, most);
  return true;
}

// Chooses cells and finds each body's. A grid is tried first: the density of the last build tells if it
// would do, and where that may have changed a look at how full its cells are.
void BroadPhase::count(const BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool) {
  const Measure& all = all_;
  const double last_box = box_;
  const bool more = b.count > sorted_ + sorted_ / 8;
  choose_grid(b, params_, all.extent, all.most);
  double density = density_;
  bool list = waste(b, all.most, density) > (listed_ ? kListing / 2 : kListing);
  if (!list) {
    sort_.count(b, grid_, large_, k, pool);
    if (params_.sample) tests_ = 0.5 * sort_.neighbours(b, grid_);
    if (!(density_ > 0) || box_ > 1.5 * last_box || more) {
      density = sort_.neighbours(b, grid_) / (9 * grid_.cell_x * grid_.cell_y);
      list = waste(b, all.most, density) > kListing;
    }
  }
  listed_ = list && choose_cells(b, params_, all.extent, all.most, density);
  if (list && !listed_) sort_.count(b, grid_, large_, k, pool);  // a world of few cells
}

// Sorts the bodies into their cells.
void BroadPhase::move(BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table,
                      std::size_t begin, std::size_t end) {
  if (!listed_) {
    const std::uint32_t small = sort_.move(b, params_.mixed_radii, begin, end, pool);
    if (end != sort_.moves()) return;
    table.large_begin = small;
    density_ = sample_density(small);
  } else {
    table.large_begin = sort_.sort(b, large_, params_.mixed_radii, pool);
    const CellList& cells = sort_.listed();
    const double cell = cells.cell_steps(0) * lattice_->pitch_x() * cells.cell_steps(1) *
                        lattice_->pitch_y();
    density_ = std::max((cells.neighbours(sort_.keys(), table.large_begin) - 1) / (9 * cell),
                        b.count / box_);
    area_ = b.count / density_;
  }
  sorted_ = b.count;
  if (chained_) {
    next_origin_.resize(b.count);
    for (std::size_t i = 0; i < b.count; ++i) {
      const std::uint32_t at = from()[i];
      next_origin_[i] = at < origin_.size() ? origin_[at] : kNoSlot;
    }
    origin_.swap(next_origin_);
  }
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) { place(b, params_.ahead, k, stream_range(t, blocks)); });
  open_lists(b, pool, table, false);
}

// Cuts the rows into strips of about equal numbers of bodies. O(rows), of a list O(strips log cells).
void BroadPhase::cut_strips(const BodyStore& b, PairTable& table) const {
  table.strips.clear();
  const std::uint32_t target = strip_bodies(b.count);
  if (listed_) {
    cut_listed_rows(target, table);
  } else {
    cut_rows(target, table);
  }
  // Across a periodic seam the last strip meets the first: their phases must differ.
  if (grid_.periodic && table.strips.size() % 2 == 1 && table.strips.size() > 1) {
    const Strip last = table.strips.back();
    table.strips.pop_back();
    table.strips.back().row_end = last.row_end;
    table.strips.back().body_end = last.body_end;
  }
  Strip large;
  large.body_begin = table.large_begin;
  large.body_end = b.count;
  table.strips.push_back(large);
}

void BroadPhase::cut_rows(std::uint32_t target, PairTable& table) const {
  const std::uint32_t* start = sort_.start();
  const std::uint32_t stride = grid_.view.stride;
  const auto rows = static_cast<std::uint32_t>(grid_.view.rows);
  std::uint32_t row = 0;
  while (row < rows && large_ > 0) {
    Strip s;
    s.row_begin = row;
    s.body_begin = start[row * stride];
    do {
      ++row;
    } while (row < rows && start[row * stride] - s.body_begin < target);
    s.row_end = row;
    s.body_end = start[row * stride];
    table.strips.push_back(s);
  }
}

void BroadPhase::cut_listed_rows(std::uint32_t target, PairTable& table) const {
  const CellList& cells = sort_.listed();
  for (std::uint32_t begin = 0; begin < table.large_begin;) {
    const std::uint32_t last = std::min(begin + target, table.large_begin) - 1;
    Strip s;
    s.body_begin = begin;
    s.body_end = cells.first(cells.find(cells.row(sort_.keys()[last] / 4) + 1, 0));
    table.strips.push_back(s);
    begin = s.body_end;
  }
}

double BroadPhase::tests() const {
  if (!listed_ && tests_ > 0) return tests_;
  if (!listed_) return 4.5 * density_ * grid_.cell_x * grid_.cell_y;
  const CellList& cells = sort_.listed();
  return 4.5 * density_ * cells.cell_steps(0) * lattice_->pitch_x() * cells.cell_steps(1) * lattice_->pitch_y();
}

// Writes into `built` where the bodies are looked at.
void BroadPhase::place(BodyStore& b, float ahead, const kernels::KernelTable& k, BlockRange r) const {
  if (ahead == 0) {
    std::copy(b.pos.data() + std::size_t{r.begin} * 2 * kBlock,
              b.pos.data() + std::size_t{r.end} * 2 * kBlock,
              b.built.data() + std::size_t{r.begin} * 2 * kBlock);
    return;
  }
  kernels::StreamParams p;
  p.inv_pitch_x = static_cast<float>(1 / lattice_->pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / lattice_->pitch_y());
  k.look_ahead(b.view(), p, ahead, b.built.data(), r.begin, r.end);
}

// Some 64 bodies count others in a square of 8 radii, among 60,000 at most.
double BroadPhase::area_about(const BodyStore& b, double radius, double bounds) const {
  if (area_ > 0) return area_;
  if (b.count < kFew || b.count * radius * radius * kThin > bounds) return bounds;
  const std::uint32_t stride = std::max(1u, b.count / 64), skip = b.count / 60'000 + 1;
  const double half = 8 * radius;
  const double far_x = half / lattice_->pitch_x(), far_y = half / lattice_->pitch_y();
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

// From the cell of every n-th body and its neighbours.
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

void BroadPhase::build(BodyStore& b, StaticShapes& shapes, const BroadPhaseParams& p,
                       const kernels::KernelTable& k, WorkerPool& pool, PairTable& table) {
  measure(b, shapes, p, k, pool);
  count(b, k, pool);
  move(b, k, pool, table, 0, moves());
  find_lists(b, shapes, k, pool, table);
  finish(b, k, pool);
}

void BroadPhase::build_again(BodyStore& b, StaticShapes& shapes, const kernels::KernelTable& k,
                             WorkerPool& pool, PairTable& table) {
  fixed_ = shapes.any();
  move_again(b, k, pool, table);
  find_lists(b, shapes, k, pool, table);
}

void BroadPhase::count_again(const BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool) {
  if (!listed_) sort_.count(b, grid_, large_, k, pool);
}

void BroadPhase::move_again(BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool,
                            PairTable& table) {
  count_again(b, k, pool);
  table.large_begin = listed_ ? sort_.sort(b, large_, params_.mixed_radii, pool)
                              : sort_.move(b, params_.mixed_radii, pool);
  open_lists(b, pool, table, true);
}

void BroadPhase::find_lists(BodyStore& b, const StaticShapes& shapes, const kernels::KernelTable& k,
                            WorkerPool& pool, PairTable& table) {
  std::size_t done = 0;
  do {
    const std::size_t all = searches();
    search(b, k, pool, table, done, all);
    done = all;
  } while (done != searches());
  find_near(b, shapes, pool, table, 0, nears());
}

// How far bodies reach, and their box.
void BroadPhase::measure(BodyStore& b, StaticShapes& shapes, const BroadPhaseParams& p,
                         const kernels::KernelTable& k, WorkerPool& pool) {
  params_ = p;
  shapes.build_grid();
  fixed_ = shapes.any();
  b.reach.reserve(kernels::round_up_block(b.count));
  b.built.reserve(2 * kernels::round_up_block(b.count));
  const kernels::BodyView view = b.view();
  const std::uint32_t blocks = b.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  std::vector<Measure>& measures = measures_;
  measures.resize(tasks);
  pool.run(tasks, [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    Measure& m = measures[t];
    m.most = k.reaches(view, b.radius.data(), p.margin, b.reach.data(), r.begin, r.end);
    place(b, p.ahead, k, r);
    const std::int32_t* at = b.built.data() + 2 * std::size_t{r.begin} * kBlock;
    m.extent[0] = m.extent[2] = at[0];
    m.extent[1] = m.extent[3] = at[1];
    k.extent(b.built.data(), m.extent, r.begin, r.end);
  });
  pad_reach_ = next_pad_reach_;
  if (b.count % kBlock != 0) next_pad_reach_ = b.reach[b.count];
  all_ = measures[0];
  for (const Measure& m : measures) {
    all_.most = std::max(all_.most, m.most);
    all_.extent[0] = std::min(all_.extent[0], m.extent[0]);
    all_.extent[1] = std::min(all_.extent[1], m.extent[1]);
    all_.extent[2] = std::max(all_.extent[2], m.extent[2]);
    all_.extent[3] = std::max(all_.extent[3], m.extent[3]);
  }
}

// Bodies lie in cell order: strips, and room for their pairs, as many as guessed before if `again`.
void BroadPhase::open_lists(BodyStore& b, WorkerPool& pool, PairTable& table, bool again) {
  // Padding goes with the last body, and may go as far. In a small world it may go as far as it might have in the
  // lists before these: they are cheap there, and fresh ones round less (docs/decisions/009-lists-that-last.md).
  for (std::size_t i = b.count; i < kernels::round_up_block(b.count); ++i) {
    b.built[2 * i] = b.built[2 * std::size_t{b.count - 1}];
    b.built[2 * i + 1] = b.built[2 * std::size_t{b.count - 1} + 1];
    b.reach[i] = b.count < kSmallWorld ? pad_reach_ : b.reach[b.count - 1];
  }
  table.body_count = b.count;
  table.renewed_begin = PairTable::kNoneRenewed;
  table.first.reserve(std::size_t{b.count} + 1);
  cut_strips(b, table);
  const std::size_t strips = table.strips.size();
  make_singles(table, strips);
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    std::fill(b.linked.data() + std::size_t{r.begin} * kBlock,
              b.linked.data() + std::size_t{r.end} * kBlock,
              params_.link_all ? std::uint8_t{0xFF} : std::uint8_t{0});
  });
  if (!again) {
    if (params_.outer > 0)
      pairs_a_body_.assign(strips - 1, 2 * params_.outer * params_.outer * density_);
    for (double& pairs : pairs_a_body_) pairs *= params_.growth;
    for (double& pairs : pairs_a_piece_) pairs *= params_.growth;
  }
  cut_large(table);
  large_cells_.build(b.built.data(), b.reach.data(), table.large_begin, b.count, *lattice_);
  pending_.resize(strips - 1 + large_pieces_.size());
  std::iota(pending_.begin(), pending_.end(), 0u);
  full_.assign(pending_.size(), 0);
  searched_ = 0;
  give_room(table);
}

// Lists for one step look at bodies where they will be: now where they are.
void BroadPhase::finish(BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool) const {
  if (params_.ahead == 0) return;
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) { place(b, 0, k, stream_range(t, blocks)); });
}

void BroadPhase::keep_origin() {
  if (!chained_) origin_.assign(from(), from() + sorted_);
  chained_ = true;
}

void BroadPhase::select(BodyStore& b, float time, const std::vector<float>& slack, bool link_all,
                        const PairTable& candidates, PairTable& table,
                        const kernels::KernelTable& k, WorkerPool& pool, std::size_t begin,
                        std::size_t end) {
  if (begin == 0) {
    table.first.reserve(std::size_t{candidates.body_count} + 1);
    picked_owner_.reserve(candidates.owner.capacity());
    picked_other_.reserve(candidates.other.capacity());
    table.body_count = candidates.body_count;
    table.renewed_begin = PairTable::kNoneRenewed;
    table.large_begin = candidates.large_begin;
    table.strips.assign(candidates.strips.begin(), candidates.strips.end());
    make_singles(table, table.strips.size());
    const std::uint32_t blocks = b.blocks();
    pool.run(stream_tasks(blocks), [&](std::size_t t) {
      const BlockRange r = stream_range(t, blocks);
      std::fill(b.linked.data() + std::size_t{r.begin} * kBlock,
                b.linked.data() + std::size_t{r.end} * kBlock,
                link_all ? std::uint8_t{0xFF} : std::uint8_t{0});
    });
  }
  const kernels::BodyView view = b.view();
  kernels::PairSelection selection;
  selection.owner = candidates.owner.data();
  selection.other = candidates.other.data();
  selection.radius = b.radius.data();
  selection.pitch_x = static_cast<float>(lattice_->pitch_x());
  selection.pitch_y = static_cast<float>(lattice_->pitch_y());
  selection.time = time;
  pool.run(end - begin, [&](std::size_t n) {
    Strip& s = table.strips[begin + n];
    kernels::PairSelection mine = selection;
    mine.slack = slack[begin + n];
    mine.out_owner = picked_owner_.data() + s.pair_begin;
    mine.out_other = picked_other_.data() + s.pair_begin;
    s.pair_end = s.pair_begin + k.select_pairs(view, mine, s.pair_begin, s.pair_end);
  });
  if (end != table.strips.size()) return;
  std::uint32_t total = 0;
  for (const Strip& s : table.strips) total += s.pair_end - s.pair_begin;
  table.owner.reserve_loosely(total);
  table.other.reserve_loosely(total);
  table.pair_room = total;
  total = 0;
  for (Strip& s : table.strips) {  // tight: what is not selected takes no room
    const std::uint32_t n = s.pair_end - s.pair_begin;
    s.pair_begin = total;
    s.pair_end = total += n;
  }
}

void BroadPhase::pack(BodyStore& b, const PairTable& candidates, PairTable& table, WorkerPool& pool,
                      std::size_t begin, std::size_t end) {
  pool.run(end - begin, [&](std::size_t n) {
    const std::size_t index = begin + n;
    const Strip& s = table.strips[index];
    const std::uint32_t from = candidates.strips[index].pair_begin;
    std::copy_n(picked_owner_.data() + from, s.pair_end - s.pair_begin,
                table.owner.data() + s.pair_begin);
    std::copy_n(picked_other_.data() + from, s.pair_end - s.pair_begin,
                table.other.data() + s.pair_begin);
    // Where each body's pairs begin: bodies without any begin where the next one does.
    std::uint32_t i = s.body_begin;
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      for (const std::uint32_t owner = table.owner[p]; i <= owner; ++i) table.first[i] = p;
    }
    for (; i < s.body_end; ++i) table.first[i] = s.pair_end;
    table.singles[index].assign(candidates.singles[index].begin(), candidates.singles[index].end());
    link(b, table, index);
  });
  if (end == table.strips.size()) table.mark_strips();
}

}  // namespace psim
