// Decides which pairs are manifolds, and takes them out of the lists that the broad phase made for all bodies.
#include <algorithm>
#include <iterator>

#include "base/tasks.h"

#include "manifolds/manifold_sorter.h"

namespace psim {
namespace {

// Finds the impulses of a pair that is new to the lists because one of its sides fell asleep or woke.
void recall_touch(const BodyStore& b, const StaticShapes& statics, const TouchMemory& recent, ManifoldPair& pair) {
  const bool sleeper = pair.of_sleeper(statics), ground = pair.of_piece() && !sleeper;
  const std::uint32_t part_a = sleeper ? statics[pair.shape].part : pair.part_a;
  const Touch* touch =
      ground ? recent.find(fixed_key(pair.id_b, pair.shape), {part_number(pair.part_b), 0})
             : recent.find(pair_key(pair.id_a, pair.id_b), touch_parts(pair.id_a, part_a, pair.id_b, pair.part_b));
  if (touch == nullptr) return;
  pair.recalled = static_cast<std::uint8_t>(touch->points);
  // If the other side was a sleeping shape, a disc had this contact in the lists of discs.
  const bool disc_a = !ground && b.kind(pair.id_a).hull_count == 0;
  const float unit = touch->times(false, b.properties(disc_a ? pair.id_a : pair.id_b).mass);
  for (int k = 0; k < 2; ++k) {
    pair.impulse[k] = unit * touch->impulse[k];
    pair.friction[k] = unit * touch->friction[k];
  }
}

// Reserves and touches memory, so that it is there.
void touch_ahead(auto& column, std::size_t n) {
  const std::size_t size = column.size();
  if (column.capacity() >= n) return;
  column.resize(n);
  column.resize(size);
}

}  // namespace

// The pairs are long: what of them counts is read by all threads, and then sorted by one.
void PairIndex::make(std::span<const ManifoldPair> pairs, std::uint32_t ids, WorkerPool& pool) {
  constexpr std::size_t kPairs = 1024;  // a job
  owned_.resize(pairs.size());
  run_each(pairs.size(), kPairs, pool, [&](std::size_t k, std::size_t) {
    owned_[k] = {pairs[k].owner, pairs[k].mark()};
  });
  const std::size_t all = std::max<std::size_t>(first_.size(), std::size_t{ids} + 2);
  first_.assign(all, 0);
  for (const Owned& pair : owned_) ++first_[pair.owner + 2];
  for (std::size_t k = 2; k < all; ++k) first_[k] += first_[k - 1];
  entries_.resize(pairs.size());
  for (std::uint32_t k = 0; k < owned_.size(); ++k) entries_[first_[owned_[k].owner + 1]++] = {owned_[k].mark, k};
}

std::uint32_t PairIndex::find(const PairName& pair, const std::vector<ManifoldPair>& pairs) const {
  if (entries_.empty() || pair.owner + 1 >= first_.size()) return PairName::kNone;
  const std::uint32_t mark = pair.mark();
  for (std::uint32_t k = first_[pair.owner]; k < first_[pair.owner + 1]; ++k) {
    if (entries_[k].mark != mark) continue;
    const PairName& known = pairs[entries_[k].pair];
    if (known.same(pair) && !known.moved) return entries_[k].pair;
  }
  return PairName::kNone;
}

// The group of large bodies may have most pairs, for example those of a drum in which all others lie.
void Manifolds::cut() {
  constexpr std::uint32_t kPairs = 512;  // pairs in a piece
  cuts_.clear();
  for (std::uint32_t s = 0; s + 1 < begin_.size(); ++s) {
    const std::uint32_t end = begin_[s + 1];
    std::uint32_t from = begin_[s];
    do {
      const std::uint32_t to = std::min(end, from + kPairs);
      cuts_.push_back({s, from, to, {}});
      from = to;
    } while (from < end);
  }
}

void PairIndex::spare(std::size_t pairs) {
  touch_ahead(entries_, pairs);
  touch_ahead(owned_, pairs);
}

void Manifolds::spare(std::size_t pairs, std::size_t strips) {
  touch_ahead(pairs_, pairs);
  touch_ahead(old_pairs_, pairs);
  index_.spare(pairs);
  touch_ahead(known_lane_, pairs);
  if (found_.size() < strips) found_.resize(strips);
  if (strips_.size() < strips) strips_.resize(strips);
  const std::size_t each = 2 * pairs / strips + 64;
  for (std::vector<FoundPair>& found : found_) touch_ahead(found, each);
  for (StripBlocks& s : strips_) {
    touch_ahead(s.blocks, each / kernels::kBlock);
    touch_ahead(s.active, each);
    touch_ahead(s.laid, each);
  }
}

// Whether a circle says too little of a body.
static bool is_long(const BodyKind& kind, float radius) {
  constexpr float kLong = 0.6f;  // the inner radius is less than this share of the reach
  return kind.hull_count > 1 || kind.inner < kLong * radius;
}

void Manifolds::begin_collect(const CollectSettings& settings, const PairTable& table, bool sorted) {
  const BodyStore& b = s_.bodies;
  keep_impulses();
  any_filter_ = settings.any_filter;
  step_ = settings.step;
  gravity_ = kernels::snapped(length_of(settings.gravity));
  wall_special_ = settings.wall_special;
  walls_ = settings.walls;
  const std::size_t strips = table.strips.size(), slots = kernels::round_up_block(b.count);
  found_.resize(std::max(found_.size(), strips));
  counts_.resize(found_.size());
  ranges_.resize(found_.size());
  kind_.reserve(slots);
  rotor_.reserve(2 * slots);
  inner_.reserve(slots);
  used_.reserve(slots);
  stood_.resize(std::max(stood_.size(), slots));
  if (sorted) {
    shaped_.clear();
    long_.clear();
    for (std::uint32_t i = 0; i < b.count; ++i) {
      kind_[i] = kDisc;
      if (b.id[i] == kNoSlot) continue;
      const BodyProperties& properties = b.properties(b.id[i]);
      const bool held = properties.type() == BodyType::kinematic_body;
      const BodyKind& kind = b.kinds[properties.kind];
      const bool shape = kind.hull_count != 0;
      kind_[i] = static_cast<std::uint8_t>((shape ? kShape : 0) | (kind.filter != Filter{} ? kFiltered : 0) |
                                           (kind.sensor ? kSensor : 0) | (kind.first_part != 0 ? kParts : 0) |
                                           (held ? kKinematic : 0));
      if (!shape) continue;
      shaped_.push_back(i);
      if (step_ > 0 && is_long(kind, b.radius[i])) long_.push_back(i);
    }
    parts_.note(shaped_, settings.margin, settings.ahead, step_ == 0);
    boxed_ = false;
    long_known_ = true;
  }
  parts_.prepare();
  if (step_ > 0) {
    box_shapes();
  } else {
    box_parts();
  }
  new_pairs_ = 0;
  old_pairs_.swap(pairs_);
  both_ = collecting_ = true;
  index_.make(old_pairs_, b.id_count, s_.pool);
  indexed_ = false;
  special_.resize(std::max(special_.size(), strips));
  for (std::size_t s = 0; s < strips; ++s) {
    const Strip& strip = table.strips[s];
    const std::span kinds(kind_.data() + strip.body_begin, kind_.data() + strip.body_end);
    special_[s] =
        settings.surfaces || std::ranges::any_of(kinds, [](std::uint8_t kind) { return (kind & ~kTied) != kDisc; });
  }
}

// Finds the boxes of long shapes and of bodies of several parts as they lie now. Of all others a circle says enough.
void Manifolds::box_shapes() {
  constexpr std::size_t kBodies = 1024;  // a job
  if (!long_known_) {                    // a state came back
    long_.clear();
    std::ranges::copy_if(shaped_, std::back_inserter(long_), [&](std::uint32_t slot) {
      return is_long(s_.bodies.kind(s_.bodies.id[slot]), s_.bodies.radius[slot]);
    });
  }
  long_known_ = true;
  if (long_.empty()) return;
  if (!boxed_) {
    boxes_.begin(kernels::round_up_block(s_.bodies.count));
    for (const std::uint32_t slot : long_) boxes_.add(slot);
  }
  boxed_ = true;
  run_each(long_.size(), kBodies, s_.pool,
           [&](std::size_t n, std::size_t) { boxes_.place(long_[n], rotor_of(s_.bodies.angle[long_[n]]), 0); });
}

// Finds the boxes of the bodies of a few parts as the lists know them.
void Manifolds::box_parts() {
  if (boxed_ || parts_.few().empty()) return;
  boxes_.begin(kernels::round_up_block(s_.bodies.count));
  for (const PartSearch::Noted& n : parts_.few()) boxes_.add(n.slot);
  constexpr std::size_t kBodies = 1024;  // a job
  run_each(parts_.few().size(), kBodies, s_.pool, [&](std::size_t k, std::size_t) {
    const PartSearch::Noted& n = parts_.few()[k];
    boxes_.place(n.slot, rotor_of(n.angle), n.turn);
  });
  boxed_ = true;
}

// The pairs of a strip that stay in the lists close up.
void Manifolds::sort_out(const Joined* joined, PairTable& table, std::size_t begin, std::size_t end) {
  s_.pool.run(end - begin, [&](std::size_t n) {
    const std::size_t index = end - 1 - n;  // the last one, which may take longest, comes first
    Strip& s = table.strips[index];
    ranges_[index] = {s.body_begin, s.body_end};
    found_[index].clear();
    const Sorter sorter{*this, joined, old_pairs_, found_[index]};
    // The pairs of a strip reach into the strip itself and into the next one; those of large bodies reach anywhere.
    const std::size_t last = table.strips.size() - 1, next = index + 1 < last ? index + 1 : 0;
    const bool plain = joined == nullptr && index != last && !special_[index] && !special_[next];
    std::uint32_t kept = plain ? s.pair_end : s.pair_begin, p = s.pair_begin;
    for (std::uint32_t i = s.body_begin; i < s.body_end && !plain; ++i) {
      table.first[i] = kept | (table.first[i] & PairTable::kStripStart);
      for (; p < s.pair_end && table.owner[p] == i; ++p) {
        const std::uint32_t j = table.other[p];
        if (sorter.leaves(i, j)) continue;
        table.owner[kept] = i;
        table.other[kept++] = j;
      }
    }
    s.pair_end = kept;
    std::erase_if(table.static_contacts[index], [&](const StaticPair& pair) { return sorter.leaves(pair); });
    counts_[index] = {};
    for (const FoundPair& pair : found_[index]) {
      counts_[index].fresh += pair.before == PairName::kNone ? 1 : 0;
      counts_[index].fixed |= pair.fixed_a;
      counts_[index].kinematic |= pair.of_kinematic();
    }
  });
  if (end == table.strips.size()) place_pairs(end);
}

// Makes room for the pairs that were found.
void Manifolds::place_pairs(std::size_t strips) {
  begin_.assign(strips + 1, 0);
  any_kinematic_ = false;
  for (std::size_t s = 0; s < strips; ++s) {
    begin_[s + 1] = begin_[s] + static_cast<std::uint32_t>(found_[s].size());
    new_pairs_ += counts_[s].fresh;
    any_kinematic_ |= counts_[s].kinematic;
  }
  list_fixed([&](const auto& each) {
    for (std::size_t s = 0; s < strips; ++s) {
      std::uint32_t k = begin_[s];
      if (!counts_[s].fixed) continue;
      for (const FoundPair& pair : found_[s]) each(pair, k++);
    }
  });
  if (begin_[strips] > pairs_.capacity()) {  // their contents are not needed any more
    pairs_.clear();
    pairs_.reserve(begin_[strips] + begin_[strips] / 2);
  }
  own_end_ = begin_[strips];
  cut();
  pairs_.resize(begin_[strips]);
  known_lane_.reserve(pairs_.capacity());
  known_lane_.assign(begin_[strips], PairName::kNone);
  strips_.resize(std::max(strips_.size(), strips));
  for (std::size_t s = strips; s < strips_.size(); ++s) {
    strips_[s].blocks.clear();
    strips_[s].surfaces.clear();
    std::ranges::fill(strips_[s].end, 0u);
  }
  for (StripBlocks& s : strips_) {
    s.laid.clear();
    s.lasting.clear();
  }
  stood_known_ = false;
  stale_.assign(strips_.size(), 1);
}

void Manifolds::keep(const TouchMemory& recent, std::size_t begin, std::size_t end) {
  s_.pool.run(end - begin, [&](std::size_t n) {
    std::uint32_t k = begin_[begin + n];
    for (const FoundPair& found : found_[begin + n]) {
      ManifoldPair& pair = pairs_[k++];
      const bool known = found.before != PairName::kNone;
      if (known) {
        pair = old_pairs_[found.before];
      } else {
        pair = {};
      }
      static_cast<PairName&>(pair) = found;
      pair.lane = PairName::kNone;
      if (!known && !recent.empty()) recall_touch(s_.bodies, s_.statics, recent, pair);
      pair.stands |= pair.recalled != 0;  // bodies fall asleep where they stand
    }
  });
  if (end + 1 == begin_.size()) collecting_ = false;
}

// ---- Lists that are made anew body by body (renewal.h). Manifolds that belong to no strip lie behind those of the
// last strip, from own_end_ on: first those of two bodies, by the lower and the higher slot; then those of a body and
// fixed pieces, by its slot.

namespace {

constexpr std::uint64_t kFixedPieces = std::uint64_t{1} << 63;

std::uint64_t rank(const PairName& p) {
  if (p.of_piece()) return kFixedPieces | p.b;
  return pair_key(p.a, p.b);
}

}  // namespace

void Manifolds::note_renewed(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin) {
  box_parts();
  parts_.note_again(slots, margin);
  for (const std::uint32_t slot : slots) {
    const PartSearch::Noted* const n = parts_.few_of(slot);
    if (n != nullptr) boxes_.place(slot, rotor_of(n->angle), n->turn);
  }
}

void Manifolds::sort_out_renewed(const Joined* joined, std::vector<std::uint64_t>& pairs,
                                 std::vector<StaticPair>& near) {
  keep_impulses();
  if (!indexed_) index_.make(std::span(pairs_).first(own_end_), s_.bodies.id_count, s_.pool);
  indexed_ = true;
  parts_.prepare();
  renewed_.clear();
  const Sorter sorter{*this, joined, pairs_, renewed_};
  std::erase_if(pairs, [&](std::uint64_t pair) {
    return sorter.leaves(static_cast<std::uint32_t>(pair >> 32), static_cast<std::uint32_t>(pair));
  });
  std::erase_if(near, [&](const StaticPair& pair) { return sorter.leaves(pair); });
  // Pairs that strips have stay there. But all fixed pieces of a body stay together, since see_fixed() needs all of them
  // to find which ones count.
  std::erase_if(renewed_, [](const FoundPair& p) { return p.before != PairName::kNone && !p.of_piece(); });
}

void Manifolds::put_renewed(const std::function<bool(std::uint32_t)>& found) {
  const std::size_t last = begin_.size() - 2;
  before_.assign(pairs_.begin() + own_end_, pairs_.end());
  pairs_.resize(own_end_);
  auto kept = before_.cbegin(), known = before_.cbegin();
  const auto keep_up_to = [&](std::uint64_t end) {
    for (; kept != before_.cend() && rank(*kept) < end; ++kept) {
      if (!found(kept->b) && (kept->of_piece() || !found(kept->a))) pairs_.push_back(*kept);
    }
  };
  for (const FoundPair& pair : renewed_) {
    const std::uint64_t at = rank(pair);
    keep_up_to(at);
    while (known != before_.cend() && rank(*known) < at) ++known;
    const auto sought = [&](const ManifoldPair& p) { return rank(p) != at || p.same(pair); };
    const auto mine = std::find_if(known, before_.cend(), sought);
    const bool in_strip = pair.before != PairName::kNone;
    if (mine != before_.cend() && rank(*mine) == at) {
      pairs_.push_back(*mine);
    } else if (in_strip) {
      pairs_.push_back(pairs_[pair.before]);
      pairs_.back().lane = PairName::kNone;
    } else {
      pairs_.emplace_back();
      ++new_pairs_;
    }
    if (in_strip) {
      forget_steady(pair.before, strip_of(pair.before));
      pairs_[pair.before].moved = true;
      pairs_[pair.before].active = pairs_[pair.before].ahead = false;
    }
    static_cast<PairName&>(pairs_.back()) = pair;
  }
  keep_up_to(~std::uint64_t{0});
  begin_[last + 1] = static_cast<std::uint32_t>(pairs_.size());
  fixed_known_ = stood_known_ = false;
  // Lanes of the blocks stay as they are until the next layout.
  known_lane_.reserve(pairs_.capacity());
  known_lane_.resize(pairs_.size(), PairName::kNone);
  forget_steady(last);
  StripBlocks& strip = strips_[last];
  strip.active.clear();
  strip.laid.clear();
  for (std::uint32_t k = begin_[last]; k < pairs_.size(); ++k) {
    if (pairs_[k].active) strip.active.push_back(k);
    if (pairs_[k].lane != PairName::kNone) strip.laid.push_back(k);
  }
  stale_[last] = 1;
  cut();
}

void Manifolds::remember() {
  keep_impulses();
  old_pairs_ = pairs_;
  both_ = true;
}

}  // namespace psim
