#include "lists/broad_phase.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "base/tasks.h"

namespace psim {
namespace {

using kernels::kBlock;

// Bodies a strip: few enough for many strips a thread, enough for full blocks.
std::uint32_t strip_bodies(std::uint32_t n) { return std::clamp<std::uint32_t>(n / 192, 128, 1024); }

// Makes one list a strip, with room for the usual few entries so that warm steps do not allocate.
void make_statics(PairTable& table, std::size_t strips) {
  if (table.static_contacts.size() >= strips) return;
  const std::size_t before = table.static_contacts.size();
  table.static_contacts.resize(strips);
  table.found.resize(strips);
  for (std::size_t s = before; s < strips; ++s) table.static_contacts[s].reserve(64);
}

}  // namespace

bool BroadPhase::lists_serve(BodyStore& b, float time, const kernels::KernelTable& k, WorkerPool& pool) {
  const std::uint32_t blocks = b.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  kernels::StreamParams p;
  p.pitch_x = static_cast<float>(lattice_->pitch_x());
  p.pitch_y = static_cast<float>(lattice_->pitch_y());
  std::atomic<bool> serve{true};
  const kernels::BodyView view = b.view();
  pool.run(tasks, [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    if (!serve.load(std::memory_order_relaxed)) return;  // another task already found that the lists do not serve
    const float age = k.list_age(view, b.built.data(), b.radius.data(), b.reach.data(), p, time, r.begin, r.end);
    if (!(age <= 0)) serve.store(false, std::memory_order_relaxed);
  });
  return serve.load();
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
    const double cell = cells.cell_steps(0) * lattice_->pitch_x() * cells.cell_steps(1) * lattice_->pitch_y();
    density_ = std::max((cells.neighbours(sort_.keys(), table.large_begin) - 1) / (9 * cell), b.count / box_);
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

// Cuts the rows into strips of about equal numbers of bodies. O(rows); with listed cells O(strips log cells).
void BroadPhase::cut_strips(const BodyStore& b, PairTable& table) const {
  table.strips.clear();
  const std::uint32_t target = strip_bodies(b.count);
  if (listed_) {
    cut_listed_rows(target, table);
  } else {
    cut_rows(target, table);
  }
  // Across a periodic seam the last strip meets the first, so one must be even and the other odd.
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

// Writes into `built` the places at which the bodies are searched for.
void BroadPhase::place(BodyStore& b, float ahead, const kernels::KernelTable& k, BlockRange r) const {
  if (ahead == 0) {
    std::copy(b.pos.data() + std::size_t{r.begin} * 2 * kBlock, b.pos.data() + std::size_t{r.end} * 2 * kBlock,
              b.built.data() + std::size_t{r.begin} * 2 * kBlock);
    return;
  }
  kernels::StreamParams p;
  p.inv_pitch_x = static_cast<float>(1 / lattice_->pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / lattice_->pitch_y());
  k.look_ahead(b.view(), p, ahead, b.built.data(), r.begin, r.end);
}

void BroadPhase::build(BodyStore& b, StaticShapes& statics, const BroadPhaseParams& p, const kernels::KernelTable& k,
                       WorkerPool& pool, PairTable& table) {
  measure(b, statics, p, k, pool);
  count(b, k, pool);
  move(b, k, pool, table, 0, moves());
  find_lists(b, statics, k, pool, table);
  finish(b, k, pool);
}

void BroadPhase::build_again(BodyStore& b, StaticShapes& statics, const kernels::KernelTable& k, WorkerPool& pool,
                             PairTable& table) {
  fixed_ = statics.any();
  move_again(b, k, pool, table);
  find_lists(b, statics, k, pool, table);
}

void BroadPhase::count_again(const BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool) {
  if (!listed_) sort_.count(b, grid_, large_, k, pool);
}

void BroadPhase::move_again(BodyStore& b, const kernels::KernelTable& k, WorkerPool& pool, PairTable& table) {
  count_again(b, k, pool);
  table.large_begin =
      listed_ ? sort_.sort(b, large_, params_.mixed_radii, pool) : sort_.move(b, params_.mixed_radii, pool);
  open_lists(b, pool, table, true);
}

void BroadPhase::find_lists(BodyStore& b, const StaticShapes& statics, const kernels::KernelTable& k, WorkerPool& pool,
                            PairTable& table) {
  std::size_t done = 0;
  do {
    const std::size_t all = searches();
    search(b, k, pool, table, done, all);
    done = all;
  } while (done != searches());
  find_near(b, statics, pool, table, 0, nears());
}

// Measures how far the bodies reach, and their box.
void BroadPhase::measure(BodyStore& b, StaticShapes& statics, const BroadPhaseParams& p, const kernels::KernelTable& k,
                         WorkerPool& pool) {
  params_ = p;
  statics.build_grid();
  fixed_ = statics.any();
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

// Called when bodies lie in cell order: cuts strips and makes room for their pairs; with `again` as much as before.
void BroadPhase::open_lists(BodyStore& b, WorkerPool& pool, PairTable& table, bool again) {
  // Padding slots move with the last body and get its reach. In a small world they get the reach of the lists before
  // these, because new lists are cheap there and round less (docs/decisions/009-lists-that-last.md).
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
  make_statics(table, strips);
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    std::fill(b.linked.data() + std::size_t{r.begin} * kBlock, b.linked.data() + std::size_t{r.end} * kBlock,
              params_.link_all ? std::uint8_t{0xFF} : std::uint8_t{0});
  });
  if (!again) {
    if (params_.outer > 0) pairs_a_body_.assign(strips - 1, 2 * params_.outer * params_.outer * density_);
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

// Lists for one step used the places that bodies will have; from now on `built` holds their present places.
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
                        const PairTable& candidates, PairTable& table, const kernels::KernelTable& k, WorkerPool& pool,
                        std::size_t begin, std::size_t end) {
  if (begin == 0) {
    table.first.reserve(std::size_t{candidates.body_count} + 1);
    picked_owner_.reserve(candidates.owner.capacity());
    picked_other_.reserve(candidates.other.capacity());
    table.body_count = candidates.body_count;
    table.renewed_begin = PairTable::kNoneRenewed;
    table.large_begin = candidates.large_begin;
    table.strips.assign(candidates.strips.begin(), candidates.strips.end());
    make_statics(table, table.strips.size());
    const std::uint32_t blocks = b.blocks();
    pool.run(stream_tasks(blocks), [&](std::size_t t) {
      const BlockRange r = stream_range(t, blocks);
      std::fill(b.linked.data() + std::size_t{r.begin} * kBlock, b.linked.data() + std::size_t{r.end} * kBlock,
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
  for (Strip& s : table.strips) {  // candidates that are not selected take no room
    const std::uint32_t n = s.pair_end - s.pair_begin;
    s.pair_begin = total;
    s.pair_end = total += n;
  }
}

void BroadPhase::pack(BodyStore& b, const PairTable& candidates, PairTable& table, WorkerPool& pool, std::size_t begin,
                      std::size_t end) {
  pool.run(end - begin, [&](std::size_t n) {
    const std::size_t index = begin + n;
    const Strip& s = table.strips[index];
    const std::uint32_t from = candidates.strips[index].pair_begin;
    std::copy_n(picked_owner_.data() + from, s.pair_end - s.pair_begin, table.owner.data() + s.pair_begin);
    std::copy_n(picked_other_.data() + from, s.pair_end - s.pair_begin, table.other.data() + s.pair_begin);
    // Where the pairs of each body begin; a body without pairs begins where the next one does.
    std::uint32_t i = s.body_begin;
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      for (const std::uint32_t owner = table.owner[p]; i <= owner; ++i) table.first[i] = p;
    }
    for (; i < s.body_end; ++i) table.first[i] = s.pair_end;
    table.static_contacts[index].assign(candidates.static_contacts[index].begin(),
                                        candidates.static_contacts[index].end());
    link(b, table, index);
  });
  if (end == table.strips.size()) table.mark_strips();
}

}  // namespace psim
