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

BroadPhase::BroadPhase(const Surroundings& s)
    : lattice_(s.lattice),
      b_(s.bodies),
      statics_(s.statics),
      k_(s.kernels),
      pool_(s.pool),
      sort_(s),
      large_cells_(s.memory),
      picked_owner_(s.memory),
      picked_other_(s.memory) {}

bool BroadPhase::lists_serve(float time) {
  const std::uint32_t blocks = b_.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  kernels::StreamParams p;
  p.pitch_x = static_cast<float>(lattice_.pitch_x());
  p.pitch_y = static_cast<float>(lattice_.pitch_y());
  std::atomic<bool> serve{true};
  const kernels::BodyView view = b_.view();
  pool_.run(tasks, [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    if (!serve.load(std::memory_order_relaxed)) return;  // another task already found that the lists do not serve
    const float age = k_.list_age(view, b_.built.data(), b_.radius.data(), b_.reach.data(), p, time, r.begin, r.end);
    if (!(age <= 0)) serve.store(false, std::memory_order_relaxed);
  });
  return serve.load();
}

// Sorts the bodies into their cells.
void BroadPhase::move(PairTable& table, std::size_t begin, std::size_t end) {
  if (!listed_) {
    const std::uint32_t small = sort_.move(params_.mixed_radii, begin, end);
    if (end != sort_.moves()) return;
    table.large_begin = small;
    density_ = sample_density(small);
  } else {
    table.large_begin = sort_.sort(large_, params_.mixed_radii);
    const CellList& cells = sort_.listed();
    const double cell = cells.cell_steps(0) * lattice_.pitch_x() * cells.cell_steps(1) * lattice_.pitch_y();
    density_ = std::max((cells.neighbours(sort_.keys(), table.large_begin) - 1) / (9 * cell), b_.count / box_);
    area_ = b_.count / density_;
  }
  sorted_ = b_.count;
  if (chained_) {
    next_origin_.resize(b_.count);
    for (std::size_t i = 0; i < b_.count; ++i) {
      const std::uint32_t at = from()[i];
      next_origin_[i] = at < origin_.size() ? origin_[at] : kNoSlot;
    }
    origin_.swap(next_origin_);
  }
  place(params_.ahead);
  open_lists(table, false);
}

// Cuts the rows into strips of about equal numbers of bodies. O(rows); with listed cells O(strips log cells).
void BroadPhase::cut_strips(PairTable& table) const {
  table.strips.clear();
  const std::uint32_t target = strip_bodies(b_.count);
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
  large.body_end = b_.count;
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
void BroadPhase::place(float ahead) const {
  const std::uint32_t blocks = b_.blocks();
  pool_.run(stream_tasks(blocks), [&](std::size_t t) { place(ahead, stream_range(t, blocks)); });
}

void BroadPhase::place(float ahead, BlockRange r) const {
  if (ahead == 0) {
    std::copy(b_.pos.data() + std::size_t{r.begin} * 2 * kBlock, b_.pos.data() + std::size_t{r.end} * 2 * kBlock,
              b_.built.data() + std::size_t{r.begin} * 2 * kBlock);
    return;
  }
  kernels::StreamParams p;
  p.inv_pitch_x = static_cast<float>(1 / lattice_.pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / lattice_.pitch_y());
  k_.look_ahead(b_.view(), p, ahead, b_.built.data(), r.begin, r.end);
}

void BroadPhase::build_again(PairTable& table) {
  fixed_ = statics_.any();
  move_again(table);
  find_lists(table);
}

void BroadPhase::count_again() {
  if (!listed_) sort_.count(grid_, large_);
}

void BroadPhase::move_again(PairTable& table) {
  count_again();
  table.large_begin =
      listed_ ? sort_.sort(large_, params_.mixed_radii) : sort_.move(params_.mixed_radii, 0, sort_.moves());
  open_lists(table, true);
}

void BroadPhase::find_lists(PairTable& table) {
  std::size_t done = 0;
  do {
    const std::size_t all = searches();
    search(table, done, all);
    done = all;
  } while (done != searches());
  find_near(table, 0, nears());
}

// Measures how far the bodies reach, and their box.
void BroadPhase::measure(const BroadPhaseParams& p) {
  params_ = p;
  statics_.build_grid();
  fixed_ = statics_.any();
  b_.reach.reserve(kernels::round_up_block(b_.count));
  b_.built.reserve(2 * kernels::round_up_block(b_.count));
  const kernels::BodyView view = b_.view();
  const std::uint32_t blocks = b_.blocks();
  const std::size_t tasks = stream_tasks(blocks);
  measures_.resize(tasks);
  pool_.run(tasks, [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    Measure& m = measures_[t];
    m.most = k_.reaches(view, b_.radius.data(), p.margin, b_.reach.data(), r.begin, r.end);
    place(p.ahead, r);
    const std::int32_t* at = b_.built.data() + 2 * std::size_t{r.begin} * kBlock;
    m.extent[0] = m.extent[2] = at[0];
    m.extent[1] = m.extent[3] = at[1];
    k_.extent(b_.built.data(), m.extent, r.begin, r.end);
  });
  pad_reach_ = next_pad_reach_;
  if (b_.count % kBlock != 0) next_pad_reach_ = b_.reach[b_.count];
  all_ = measures_[0];
  for (const Measure& m : measures_) {
    all_.most = std::max(all_.most, m.most);
    for (const int axis : {0, 1}) {
      all_.extent[axis] = std::min(all_.extent[axis], m.extent[axis]);
      all_.extent[2 + axis] = std::max(all_.extent[2 + axis], m.extent[2 + axis]);
    }
  }
}

// Called when bodies lie in cell order: cuts strips and makes room for their pairs; with `again` as much as before.
void BroadPhase::open_lists(PairTable& table, bool again) {
  // Padding slots move with the last body and get its reach. In a small world they get the reach of the lists before
  // these, because new lists are cheap there and round less (docs/decisions/009-lists-that-last.md).
  for (std::size_t i = b_.count; i < kernels::round_up_block(b_.count); ++i) {
    b_.built[2 * i] = b_.built[2 * std::size_t{b_.count - 1}];
    b_.built[2 * i + 1] = b_.built[2 * std::size_t{b_.count - 1} + 1];
    b_.reach[i] = b_.count < kSmallWorld ? pad_reach_ : b_.reach[b_.count - 1];
  }
  table.body_count = b_.count;
  table.renewed_begin = PairTable::kNoneRenewed;
  table.first.reserve(std::size_t{b_.count} + 1);
  cut_strips(table);
  const std::size_t strips = table.strips.size();
  make_statics(table, strips);
  link_none_or_all(params_.link_all);
  if (!again) {
    if (params_.outer > 0) pairs_a_body_.assign(strips - 1, 2 * params_.outer * params_.outer * density_);
    for (double& pairs : pairs_a_body_) pairs *= params_.growth;
    for (double& pairs : pairs_a_piece_) pairs *= params_.growth;
  }
  large_pieces_.clear();
  for (std::uint32_t i = table.large_begin; i < b_.count; i += kLargePiece) {
    large_pieces_.push_back({i, std::min(i + kLargePiece, b_.count), 0, 0});
  }
  large_cells_.build(b_.built.data(), b_.reach.data(), table.large_begin, b_.count, lattice_);
  pending_.resize(strips - 1 + large_pieces_.size());
  std::iota(pending_.begin(), pending_.end(), 0u);
  full_.assign(pending_.size(), 0);
  searched_ = 0;
  give_first_room(table);
}

// What bodies are marked as before the lists link them.
void BroadPhase::link_none_or_all(bool all) const {
  const std::uint32_t blocks = b_.blocks();
  pool_.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    std::fill(b_.linked.data() + std::size_t{r.begin} * kBlock, b_.linked.data() + std::size_t{r.end} * kBlock,
              all ? std::uint8_t{0xFF} : std::uint8_t{0});
  });
}

// Lists for one step used the places that bodies will have; from now on `built` holds their present places.
void BroadPhase::finish() const {
  if (params_.ahead != 0) place(0);
}

void BroadPhase::select(float time, const std::vector<float>& slack, bool link_all, const PairTable& candidates,
                        PairTable& table, std::size_t begin, std::size_t end) {
  if (begin == 0) {
    table.first.reserve(std::size_t{candidates.body_count} + 1);
    picked_owner_.reserve(candidates.owner.capacity());
    picked_other_.reserve(candidates.other.capacity());
    table.body_count = candidates.body_count;
    table.renewed_begin = PairTable::kNoneRenewed;
    table.large_begin = candidates.large_begin;
    table.strips.assign(candidates.strips.begin(), candidates.strips.end());
    make_statics(table, table.strips.size());
    link_none_or_all(link_all);
  }
  const kernels::BodyView view = b_.view();
  kernels::PairSelection selection;
  selection.owner = candidates.owner.data();
  selection.other = candidates.other.data();
  selection.radius = b_.radius.data();
  selection.pitch_x = static_cast<float>(lattice_.pitch_x());
  selection.pitch_y = static_cast<float>(lattice_.pitch_y());
  selection.time = time;
  pool_.run(end - begin, [&](std::size_t n) {
    Strip& s = table.strips[begin + n];
    kernels::PairSelection mine = selection;
    mine.slack = slack[begin + n];
    mine.out_owner = picked_owner_.data() + s.pair_begin;
    mine.out_other = picked_other_.data() + s.pair_begin;
    s.pair_end = s.pair_begin + k_.select_pairs(view, mine, s.pair_begin, s.pair_end);
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

void BroadPhase::pack(const PairTable& candidates, PairTable& table, std::size_t begin, std::size_t end) {
  pool_.run(end - begin, [&](std::size_t n) {
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
    link(table, index);
  });
  if (end == table.strips.size()) table.mark_strips();
}

}  // namespace psim
