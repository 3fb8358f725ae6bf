#include "broad_phase.h"

#include <algorithm>
#include <array>
#include <atomic>
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

// Picks the grid: cells as wide as two reaches of all but the large bodies, or wider where the
// world is sparse. `large_` splits by estimated candidates: within the grid, and of each large body
// against the bodies under its box and the other large ones.
void BroadPhase::choose_grid(const BodyStore& b, const BroadPhaseParams& p,
                             const std::int32_t extent[4], float most) {
  const double n = b.count;
  const double px = lattice_->pitch_x(), py = lattice_->pitch_y();
  const double steps_x = p.periodic ? 0x1p32 : static_cast<double>(extent[2]) - extent[0] + 1;
  const double steps_y = p.periodic ? 0x1p32 : static_cast<double>(extent[3]) - extent[1] + 1;
  const double width = steps_x * px, height = steps_y * py;
  const double sum = 2 * static_cast<double>(most);
  const double area = std::max(width, sum) * std::max(height, sum);
  area_ = area;
  double reach = static_cast<double>(most);
  large_ = 1e30f;
  if (18 * reach * reach * n / area > kFewCandidates && n > 64) {
    constexpr int kBins = 96;  // a quarter of an octave each, from the largest down
    std::array<double, kBins> count{};
    for (std::uint32_t i = 0; i < b.count; ++i) {
      if (b.id[i] == kNoSlot) continue;
      const double ratio = static_cast<double>(most) / static_cast<double>(b.reach[i]);
      int bin = 0;
      for (double step = 1.189207115002721; bin < kBins - 1 && ratio >= step;
           step *= 1.189207115002721) {
        ++bin;
      }
      count[static_cast<std::size_t>(bin)] += 1;
    }
    double best = 1e300, above = 0, large_area = 0, limit = static_cast<double>(most);
    double chosen = limit;
    for (const double here : count) {
      const double small = n - above;
      const double cost = small * 18 * limit * limit * small / area +
                          (large_area + above * 4 * limit * limit) * small / area * 1.5 +
                          above * above / 16 + above * 8;
      if (cost < best) {
        best = cost;
        chosen = limit;
      }
      above += here;
      large_area += here * 8 * limit * limit;
      limit /= 1.189207115002721;
    }
    if (chosen < static_cast<double>(most)) {
      reach = chosen * 1.0001;
      large_ = static_cast<float>(reach);
    }
  }
  most_ = static_cast<float>(reach);
  const double edge = std::max(2 * reach * 1.00001 + 4 * std::max(px, py),
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

// Cuts the rows into strips of about equal numbers of bodies. O(rows).
void BroadPhase::cut_strips(const BodyStore& b, PairTable& table) {
  table.strips.clear();
  const std::uint32_t* start = sort_.start();
  const std::uint32_t stride = grid_.view.stride;
  const auto rows = static_cast<std::uint32_t>(grid_.view.rows);
  const std::uint32_t target = strip_bodies(b.count);
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

kernels::PairRow BroadPhase::row_view(const BodyStore& b, std::uint32_t row) const {
  kernels::PairRow v;
  v.pos = b.built.data();
  v.reach = b.reach.data();
  v.key = sort_.keys();
  v.start = sort_.start();
  v.pitch_x = static_cast<float>(lattice_->pitch_x());
  v.pitch_y = static_cast<float>(lattice_->pitch_y());
  const auto stride = static_cast<std::int32_t>(grid_.view.stride);
  v.next_row = stride;
  if (grid_.periodic) {
    if (row + 1 == static_cast<std::uint32_t>(grid_.view.rows)) {
      v.next_row = -stride * (grid_.view.rows - 1);
    }
    v.seam_first = row * grid_.view.stride;
    v.seam_last = v.seam_first + static_cast<std::uint32_t>(grid_.view.cols) - 1;
  }
  return v;
}

bool BroadPhase::search_strip(const BodyStore& b, const kernels::KernelTable& k, std::size_t index,
                              PairTable& table) const {
  Strip& s = table.strips[index];
  kernels::PairList list;
  list.owner = table.owner.data();
  list.other = table.other.data();
  list.first = table.first.data();
  list.count = s.pair_begin;
  list.capacity = s.pair_end;
  const std::uint32_t* start = sort_.start();
  for (std::uint32_t row = s.row_begin; row < s.row_end; ++row) {
    const std::uint32_t begin = start[row * grid_.view.stride];
    const std::uint32_t end = start[(row + 1) * grid_.view.stride];
    if (begin == end) continue;
    if (!k.find_pairs(row_view(b, row), begin, end, list)) return false;
  }
  s.pair_end = list.count;
  return true;
}

// Large bodies against the grid's bodies under their box, and against each other.
bool BroadPhase::search_large(const BodyStore& b, const kernels::KernelTable& k,
                              PairTable& table) const {
  Strip& s = table.strips.back();
  kernels::PairList list;
  list.owner = table.owner.data();
  list.other = table.other.data();
  list.first = table.first.data();
  list.count = s.pair_begin;
  list.capacity = s.pair_end;
  const kernels::PairRow view = row_view(b, 0);
  const std::uint32_t* start = sort_.start();
  const kernels::GridView& g = grid_.view;
  for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) {
    table.first[i] = list.count;
    if (list.count + kBlock > list.capacity) return false;
    if (table.large_begin != 0) {
      const double reach = static_cast<double>(b.reach[i]) + static_cast<double>(most_);
      const auto span = [](std::int32_t at, std::int32_t mid, float scale, float offset,
                           double cells, std::int32_t n, bool periodic, std::int64_t out[2]) {
        const double c = static_cast<double>(wrap_sub(at, mid)) * static_cast<double>(scale) +
                         static_cast<double>(offset);
        out[0] = static_cast<std::int64_t>(std::floor(c - cells - 0.01));
        out[1] = static_cast<std::int64_t>(std::floor(c + cells + 0.01));
        if (!periodic) {
          out[0] = std::clamp<std::int64_t>(out[0], 0, n - 1);
          out[1] = std::clamp<std::int64_t>(out[1], 0, n - 1);
        } else if (out[1] - out[0] >= n) {
          out[0] = 0;
          out[1] = n - 1;
        }
      };
      std::int64_t cols[2], rows[2];
      span(b.built[2 * i], g.mid_x, g.scale_x, g.offset_x, reach / grid_.cell_x, g.cols,
           grid_.periodic, cols);
      span(b.built[2 * i + 1], g.mid_y, g.scale_y, g.offset_y, reach / grid_.cell_y, g.rows,
           grid_.periodic, rows);
      for (std::int64_t r = rows[0]; r <= rows[1]; ++r) {
        const auto row = static_cast<std::uint32_t>((r % g.rows + g.rows) % g.rows);
        const std::uint32_t base = row * g.stride;
        const auto run = [&](std::int64_t c0, std::int64_t c1) {
          return k.find_near(view, i, start[base + static_cast<std::uint32_t>(c0)],
                             start[base + static_cast<std::uint32_t>(c1) + 1], list);
        };
        bool ok = true;
        if (cols[0] < 0) {
          ok = run(cols[0] + g.cols, g.cols - 1) && run(0, cols[1]);
        } else if (cols[1] >= g.cols) {
          ok = run(0, cols[1] - g.cols) && run(cols[0], g.cols - 1);
        } else {
          ok = run(cols[0], cols[1]);
        }
        if (!ok) return false;
      }
    }
    if (!k.find_near(view, i, i + 1, b.count, list)) return false;
  }
  s.pair_end = list.count;
  return true;
}

// Pairs that a strip will have a body, by what it and its neighbours had at the last build.
double BroadPhase::expected_pairs(std::size_t strip) const {
  double most = 0;
  for (std::size_t s = strip == 0 ? 0 : strip - 1; s <= strip + 1; ++s) {
    most = std::max(most, s < pairs_a_body_.size() ? pairs_a_body_[s] : 1.0);
  }
  return 1.15 * most;
}

// Every strip writes its pairs into room of its own; those whose room was too small get more at the
// end of the list. Where the guess was wrong for many, all begin again.
void BroadPhase::search(const BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool,
                        PairTable& table) {
  const std::size_t strips = table.strips.size();
  std::vector<std::uint32_t>& pending = pending_;
  pending.resize(strips);
  full_.assign(strips, 0);
  std::uint32_t room = 0;
  double large_room = pairs_a_large_;
  for (double more = 1; !pending.empty(); more *= 1.5) {
    if (pending.size() > strips / 8) {
      pending.resize(strips);
      std::iota(pending.begin(), pending.end(), 0u);
      room = 0;
    }
    for (const std::uint32_t s : pending) {
      Strip& strip = table.strips[s];
      const double each = s + 1 == strips ? large_room : expected_pairs(s);
      const double own = more * (each * (strip.body_end - strip.body_begin) + 64) + kBlock;
      strip.pair_begin = room;
      room += static_cast<std::uint32_t>(own);
      strip.pair_end = room;
    }
    table.owner.reserve_loosely(room + kBlock);
    table.other.reserve_loosely(room + kBlock);
    pool.run(pending.size(), [&](std::size_t n) {
      const std::uint32_t s = pending[n];
      full_[s] = s + 1 == strips ? !search_large(b, k, table) : !search_strip(b, k, s, table);
    });
    std::erase_if(pending, [&](std::uint32_t s) { return full_[s] == 0; });
  }
  table.pair_room = room;
  pairs_a_body_.resize(strips - 1);
  for (std::size_t s = 0; s < strips; ++s) {
    const Strip& strip = table.strips[s];
    const double each = static_cast<double>(strip.pair_end - strip.pair_begin) /
                        std::max(strip.body_end - strip.body_begin, 1u);
    if (s + 1 < strips) {
      pairs_a_body_[s] = each;
    } else {
      pairs_a_large_ = std::max(16.0, 1.25 * each);
    }
  }
}

void BroadPhase::link(BodyStore& b, const PairTable& table, std::size_t index) const {
  const Strip& s = table.strips[index];
  const auto mark = [&](std::uint32_t slot) {
    std::atomic_ref<std::uint8_t>(b.linked[slot]).store(0xFF, std::memory_order_relaxed);
  };
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    mark(table.owner[p]);
    mark(table.other[p]);
  }
  for (const SinglePair& pair : table.singles[index]) mark(pair.body);
}

// Walls: only bodies in rows and columns that a wall can reach are looked at. Fixed shapes: every
// body asks their grid.
void BroadPhase::find_singles(BodyStore& b, const StaticShapes& shapes, const BroadPhaseParams& p,
                              std::size_t index, PairTable& table) const {
  std::vector<SinglePair>& out = table.singles[index];
  out.clear();
  const Strip& s = table.strips[index];
  const double px = lattice_->pitch_x(), py = lattice_->pitch_y();
  // What stands still moves against the common velocity too.
  const double common_x = static_cast<double>(p.margin.common_x),
               common_y = static_cast<double>(p.margin.common_y);
  const double extra = std::sqrt(common_x * common_x + common_y * common_y) *
                       static_cast<double>(p.margin.time);
  std::vector<std::uint32_t>& found = table.found[index];
  const auto look = [&](std::uint32_t i) {
    const double reach = static_cast<double>(b.reach[i]) + extra;
    const std::int32_t* at = b.built.data() + 2 * std::size_t{i};
    if (p.walls) {
      const double x = at[0] * px, y = at[1] * py;
      if (x - reach < p.bounds.xmin) out.push_back({i, kWallLeft, 0});
      if (x + reach > p.bounds.xmax) out.push_back({i, kWallRight, 0});
      if (y - reach < p.bounds.ymin) out.push_back({i, kWallBottom, 0});
      if (y + reach > p.bounds.ymax) out.push_back({i, kWallTop, 0});
    }
    if (shapes.any()) {
      found.clear();
      shapes.near(at[0], at[1], static_cast<float>(reach), found);
      for (const std::uint32_t shape : found) out.push_back({i, shape, 0});
    }
  };
  const bool large_group = index + 1 == table.strips.size();
  if (large_group || shapes.any()) {
    for (std::uint32_t i = s.body_begin; i < s.body_end; ++i) look(i);
    return;
  }
  if (!p.walls) return;
  const kernels::GridView& g = grid_.view;
  const auto cell = [](double at, double pitch, std::int32_t mid, double edge, float offset) {
    return (at - mid * pitch) / edge + static_cast<double>(offset);
  };
  const double reach = static_cast<double>(most_) + extra;
  const double low_row = cell(p.bounds.ymin + reach, py, g.mid_y, grid_.cell_y, g.offset_y) + 0.01;
  const double high_row = cell(p.bounds.ymax - reach, py, g.mid_y, grid_.cell_y, g.offset_y) - 0.01;
  const double low_col = cell(p.bounds.xmin + reach, px, g.mid_x, grid_.cell_x, g.offset_x) + 0.01;
  const double high_col = cell(p.bounds.xmax - reach, px, g.mid_x, grid_.cell_x, g.offset_x) - 0.01;
  const std::uint32_t* start = sort_.start();
  for (std::uint32_t row = s.row_begin; row < s.row_end; ++row) {
    const std::uint32_t base = row * g.stride;
    const std::uint32_t begin = start[base], end = start[base + g.stride];
    if (row <= low_row || row + 1 > high_row) {
      for (std::uint32_t i = begin; i < end; ++i) look(i);
      continue;
    }
    std::uint32_t left = begin, right = end;
    if (low_col >= 0) {
      const double c = std::fmin(std::floor(low_col) + 1, g.cols);
      left = start[base + static_cast<std::uint32_t>(c)];
    }
    if (high_col < g.cols) {
      const double c = std::fmax(std::floor(high_col), 0);
      right = std::max(left, start[base + static_cast<std::uint32_t>(c)]);
    }
    for (std::uint32_t i = begin; i < left; ++i) look(i);
    for (std::uint32_t i = right; i < end; ++i) look(i);
  }
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
  shapes.build_grid();
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
  Measure all = measures[0];
  for (const Measure& m : measures) {
    all.most = std::max(all.most, m.most);
    all.extent[0] = std::min(all.extent[0], m.extent[0]);
    all.extent[1] = std::min(all.extent[1], m.extent[1]);
    all.extent[2] = std::max(all.extent[2], m.extent[2]);
    all.extent[3] = std::max(all.extent[3], m.extent[3]);
  }
  choose_grid(b, p, all.extent, all.most);
  table.large_begin = sort_.sort(b, grid_, large_, p.mixed_radii, k, pool);
  density_ = sample_density(table.large_begin);
  table.body_count = b.count;
  table.first.reserve(std::size_t{b.count} + 1);
  cut_strips(b, table);
  make_singles(table, table.strips.size());

  const std::size_t strips = table.strips.size();
  const std::uint32_t stream_blocks = b.blocks();
  pool.run(stream_tasks(stream_blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, stream_blocks);
    std::fill(b.linked.data() + std::size_t{r.begin} * kBlock,
              b.linked.data() + std::size_t{r.end} * kBlock,
              p.link_all ? std::uint8_t{0xFF} : std::uint8_t{0});
    place(b, p.ahead, k, r);
  });
  if (p.outer > 0) pairs_a_body_.assign(strips - 1, 2 * p.outer * p.outer * density_);
  search(b, k, pool, table);
  pool.run(strips, [&](std::size_t s) {
    find_singles(b, shapes, p, s, table);
    link(b, table, s);
  });
  if (p.ahead != 0) {
    pool.run(stream_tasks(stream_blocks), [&](std::size_t t) {
      place(b, 0, k, stream_range(t, stream_blocks));
    });
  }
  table.first[b.count] = PairTable::kStripStart;
  for (const Strip& s : table.strips) {
    if (s.body_begin < s.body_end) table.first[s.body_begin] |= PairTable::kStripStart;
  }
}

void BroadPhase::select(BodyStore& b, float time, float slack, bool link_all,
                        const PairTable& candidates, PairTable& table,
                        const kernels::KernelTable& k, WorkerPool& pool) {
  const std::size_t strips = candidates.strips.size();
  table.first.reserve(std::size_t{candidates.body_count} + 1);
  picked_owner_.reserve(candidates.owner.capacity());
  picked_other_.reserve(candidates.other.capacity());
  table.body_count = candidates.body_count;
  table.large_begin = candidates.large_begin;
  table.strips.assign(candidates.strips.begin(), candidates.strips.end());
  make_singles(table, strips);
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    std::fill(b.linked.data() + std::size_t{r.begin} * kBlock,
              b.linked.data() + std::size_t{r.end} * kBlock,
              link_all ? std::uint8_t{0xFF} : std::uint8_t{0});
  });
  const kernels::BodyView view = b.view();
  kernels::PairSelection selection;
  selection.owner = candidates.owner.data();
  selection.other = candidates.other.data();
  selection.radius = b.radius.data();
  selection.pitch_x = static_cast<float>(lattice_->pitch_x());
  selection.pitch_y = static_cast<float>(lattice_->pitch_y());
  selection.time = time;
  selection.slack = slack;
  pool.run(strips, [&](std::size_t index) {
    Strip& s = table.strips[index];
    kernels::PairSelection mine = selection;
    mine.out_owner = picked_owner_.data() + s.pair_begin;
    mine.out_other = picked_other_.data() + s.pair_begin;
    s.pair_end = s.pair_begin + k.select_pairs(view, mine, s.pair_begin, s.pair_end);
  });
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
  pool.run(strips, [&](std::size_t index) {
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
  table.first[table.body_count] = PairTable::kStripStart;
  for (const Strip& s : table.strips) {
    if (s.body_begin < s.body_end) table.first[s.body_begin] |= PairTable::kStripStart;
  }
}

}  // namespace psim
