#include "lists/broad_phase.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include "base/tasks.h"

namespace psim {

using kernels::kBlock;

bool BroadPhase::lists_serve(float time) const {
  const auto beyond = beyond_margins(time);
  std::atomic<bool> serve{true};  // relaxed: read during the run it only saves work, and it is read again after it
  run_stream(s_.bodies.blocks(), s_.pool, [&](BlockRange r) {
    if (!serve.load(std::memory_order_relaxed)) return;  // another task already found that the lists do not serve
    if (!(beyond(r.begin, r.end) <= 0)) serve.store(false, std::memory_order_relaxed);
  });
  return serve.load();
}

// Measures how far the bodies reach, and their box.
void BroadPhase::measure(const BroadPhaseParams& p) {
  BodyStore& b = s_.bodies;
  params_ = p;
  s_.statics.build_grid();
  b.reach.reserve(kernels::round_up_block(b.count));
  b.built.reserve(2 * kernels::round_up_block(b.count));
  BodyExtent all;
  std::mutex one_at_a_time;
  run_stream(b.blocks(), s_.pool, [&](BlockRange r) {
    place(p.ahead, r);
    const float most = common_.on()
                           ? reach_beyond_common(r)
                           : s_.kernels.reaches(b.view(), b.radius.data(), p.margin, b.reach.data(), r.begin, r.end);
    BodyExtent mine;
    s_.kernels.extent(b.built.data(), mine.box, r.begin, r.end);
    const std::lock_guard lock(one_at_a_time);
    all.most = std::max(all.most, most);
    for (const int axis : {0, 1}) {
      all.box[axis] = std::min(all.box[axis], mine.box[axis]);
      all.box[2 + axis] = std::max(all.box[2 + axis], mine.box[2 + axis]);
    }
  });
  cells_.cover(all);
  pad_reach_ = next_pad_reach_;
  if (b.count % kBlock == 0) return;
  // That of a body at rest with no radius; where skins go by radius, with the skin of the last body, whose moves it makes.
  const kernels::ReachParams& m = p.margin;
  next_pad_reach_ = m.of_radius != 0 ? std::min(m.of_radius * b.radius[b.count - 1], m.skin) : b.reach[b.count];
}

// How far bodies reach that have something in common: by what they move beside it. Returns the largest.
float BroadPhase::reach_beyond_common(BlockRange r) const {
  BodyStore& b = s_.bodies;
  const kernels::ReachParams& m = params_.margin;
  float most = 0;
  for (std::uint32_t i = r.begin * kBlock; i < r.end * kBlock; ++i) {
    const float skin = m.of_radius != 0 ? std::min(m.of_radius * b.radius[i], m.skin) : m.skin;
    b.reach[i] = b.radius[i] + skin + common_.use(i, b.built.data() + 2 * std::size_t{i}, m.time);
    most = std::max(most, b.reach[i]);
  }
  return most;
}

// Writes into `built` the places at which the bodies are searched for.
void BroadPhase::place(float ahead, BlockRange r) const {
  BodyStore& b = s_.bodies;
  if (ahead == 0) {
    std::copy(b.pos.data() + std::size_t{r.begin} * 2 * kBlock, b.pos.data() + std::size_t{r.end} * 2 * kBlock,
              b.built.data() + std::size_t{r.begin} * 2 * kBlock);
    return;
  }
  kernels::StreamParams p;
  p.inv_pitch_x = static_cast<float>(1 / s_.lattice.pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / s_.lattice.pitch_y());
  s_.kernels.look_ahead(b.view(), p, ahead, b.built.data(), r.begin, r.end);
}

void BroadPhase::move(std::size_t begin, std::size_t end) {
  if (begin == 0) origin.make_room(s_.bodies.count);
  if (!cells_.move(params_.mixed_radii, begin, end)) return;
  origin.follow();
  run_stream(s_.bodies.blocks(), s_.pool, [&](BlockRange r) { place(params_.ahead, r); });
}

void BroadPhase::open(PairTable& table) {
  cells_.note_density();
  open_lists(table, 2 * params_.outer * params_.outer * cells_.density(), params_.growth);
}

void BroadPhase::move_again(PairTable& table) {
  count_again();
  cells_.move(params_.mixed_radii, 0, cells_.moves());
  open_lists(table, 0, 1);
}

// Called when bodies lie in cell order: cuts strips and makes room for their pairs (PairSearch::begin).
void BroadPhase::open_lists(PairTable& table, double pairs_a_body, double growth) {
  // Padding slots move with the last body and get its reach. In a small world they get the reach of the lists before
  // these, because new lists are cheap there and round less (docs/decisions/009-lists-that-last.md).
  BodyStore& b = s_.bodies;
  b.reserve_slots(0);  // both halves of every swapped pair must have room for what comes next
  for (std::size_t i = b.count; i < kernels::round_up_block(b.count); ++i) {
    b.built[2 * i] = b.built[2 * std::size_t{b.count - 1}];
    b.built[2 * i + 1] = b.built[2 * std::size_t{b.count - 1} + 1];
    b.reach[i] = b.count < kSmallWorld ? pad_reach_ : b.reach[b.count - 1];
  }
  table.large_begin = cells_.large_begin();
  cells_.cut_strips(table);
  begin_table(table, b.count, params_.link_all);
  search_.begin(table, pairs_a_body, growth);
}

void BroadPhase::begin_table(PairTable& table, std::uint32_t bodies, bool link_all) const {
  table.body_count = bodies;
  table.renewed_begin = PairTable::kNoneRenewed;
  table.first.reserve(std::size_t{bodies} + 1);
  const std::size_t before = table.static_contacts.size(), strips = std::max(before, table.strips.size());
  table.static_contacts.resize(strips);
  table.near_scratch.resize(strips);
  for (std::size_t s = before; s < strips; ++s) table.static_contacts[s].reserve(64);
  std::fill_n(s_.bodies.linked.data(), kernels::round_up_block(s_.bodies.count),
              static_cast<std::uint8_t>(link_all ? 0xFF : 0));
}

void BroadPhase::search(PairTable& table, std::size_t begin, std::size_t end) {
  if (search_.run(table, begin, end)) near_.begin(table);
}

void BroadPhase::find_near(PairTable& table, bool links, std::size_t begin, std::size_t end) {
  if (near_.run(table, links, begin, end)) table.mark_strips();
}

// Lists for one step used the places that bodies will have; from now on `built` holds their present places.
void BroadPhase::finish() const {
  if (params_.ahead == 0) return;
  run_stream(s_.bodies.blocks(), s_.pool, [&](BlockRange r) { place(0, r); });
}

void BroadPhase::find_lists(PairTable& table) {
  std::size_t done = 0;
  do {
    const std::size_t all = search_.searches();
    search(table, done, all);
    done = all;
  } while (done != search_.searches());
  find_near(table, true, 0, near_.pieces());
}

void BroadPhase::build_again(PairTable& table) {
  move_again(table);
  find_lists(table);
}

}  // namespace psim
