// Decides which pairs are manifolds, and takes them out of the lists that the broad phase made for all bodies.
#include <algorithm>

#include "base/tasks.h"
#include "manifolds/manifolds.h"

namespace psim {
namespace {

// Finds the impulses of a pair that is new to the lists because one of its sides fell asleep or woke.
void recall_touch(const BodyStore& b, const StaticShapes& statics, const TouchMemory& recent, ManifoldPair& pair) {
  const bool ground = pair.a == PairName::kNone && (pair.shape >= kWallLeft || !statics[pair.shape].asleep);
  const Touch* touch =
      recent.find(ground ? TouchKey::fixed(pair.id_b, pair.shape) : TouchKey::bodies(pair.id_a, pair.id_b));
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

}  // namespace

bool Manifolds::collide_at_all(const BodyStore& b, const Joined* joined, std::uint32_t i, std::uint32_t j) const {
  const std::uint32_t id = b.id[i], other = b.id[j];
  if (((kind_[i] | kind_[j]) & (kFiltered | kSensor)) != 0) {
    const BodyKind &mine = b.kind(id), &theirs = b.kind(other);
    if (mine.sensor || theirs.sensor || !meet(mine.filter, theirs.filter)) return false;
  }
  if ((kind_[i] & kKinematic) != 0 && (kind_[j] & kKinematic) != 0) return false;  // neither body can be moved
  return joined == nullptr || !(*joined)(id, other);
}

// Sorts the pairs of the last lists by owner. O(pairs + ids).
void Manifolds::index(const std::vector<ManifoldPair>& pairs, std::size_t count, std::uint32_t ids) {
  const std::size_t all = std::max<std::size_t>(first_.size(), std::size_t{ids} + 2);
  first_.assign(all, 0);
  for (std::size_t k = 0; k < count; ++k) ++first_[owner_[k] + 2];
  for (std::size_t k = 2; k < all; ++k) first_[k] += first_[k - 1];
  entries_.resize(count);
  for (std::uint32_t k = 0; k < count; ++k) {
    entries_[first_[owner_[k] + 1]++] = {pairs[k].mark(), k};
  }
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
      cuts_.push_back({s, from, to, 0, from == begin_[s] && to == end, to == end});
      from = to;
    } while (from < end);
  }
}

void Manifolds::spare(std::size_t pairs, std::size_t strips) {
  const auto touch = [](auto& column, std::size_t n) {  // reserves and touches the memory, so that it is there
    const std::size_t size = column.size();
    if (column.capacity() >= n) return;
    column.resize(n);
    column.resize(size);
  };
  touch(pairs_, pairs);
  touch(old_pairs_, pairs);
  touch(owner_, pairs);
  touch(entries_, pairs);
  if (found_.size() < strips) found_.resize(strips);
  if (strips_.size() < strips) strips_.resize(strips);
  const std::size_t each = 2 * pairs / strips + 64;
  for (Found& found : found_) {
    touch(found.pairs, each);
    touch(found.before, each);
  }
  for (StripBlocks& s : strips_) {
    touch(s.blocks, each / kernels::kBlock);
    touch(s.active, each);
    touch(s.laid, each);
  }
}

// Finds the place of a pair among those of the index.
std::uint32_t Manifolds::recall(const PairName& pair, const std::vector<ManifoldPair>& pairs) const {
  if (entries_.empty() || pair.owner + 1 >= first_.size()) return PairName::kNone;
  const std::uint32_t mark = pair.mark();
  for (std::uint32_t k = first_[pair.owner]; k < first_[pair.owner + 1]; ++k) {
    if (entries_[k].mark != mark) continue;
    const PairName& known = pairs[entries_[k].pair];
    if (known.same(pair) && !known.moved) return entries_[k].pair;
  }
  return PairName::kNone;
}

// Decides what becomes of a pair of the lists. Two discs stay in the lists.
Manifolds::Fate Manifolds::fate(const BodyStore& b, const Joined* joined, std::uint32_t i, std::uint32_t j) const {
  if ((kind_[i] | kind_[j]) == 0 && joined == nullptr) return Fate::stays;
  if (!collide_at_all(b, joined, i, j)) return Fate::goes;
  return ((kind_[i] | kind_[j]) & kShape) == 0 ? Fate::stays : Fate::manifold;
}

// Decides what becomes of a pair of a body and a fixed shape.
Manifolds::Fate Manifolds::fate(const BodyStore& b, const StaticShapes& statics, const Joined* joined,
                                const StaticPair& static_pair) const {
  const std::uint8_t kind = kind_[static_pair.body];
  const bool shape = (kind & kShape) != 0;
  if ((kind & (kKinematic | kSensor)) != 0 && shape) return Fate::goes;
  if (static_pair.shape < kWallLeft) {
    const StaticShape& piece = statics[static_pair.shape];
    const std::uint32_t id = b.id[static_pair.body];
    if (shape ? piece.face : piece.whole) return Fate::goes;
    if (any_filter_ && !meet(b.kind(id).filter, b.kind(piece.owner).filter)) return Fate::goes;
    if (joined != nullptr && (*joined)(id, piece.owner)) return Fate::goes;
  }
  if ((kind & kSensor) != 0) return Fate::goes;
  return shape ? Fate::manifold : Fate::stays;
}

// Adds the manifold of the first parts of a pair. It is made in place, since a copy would wait for what was just
// written.
void Manifolds::name(const BodyStore& b, std::uint32_t i, std::uint32_t j, PairName& pair) const {
  const bool swap =
      (kind_[i] & kKinematic) != (kind_[j] & kKinematic) ? (kind_[j] & kKinematic) != 0 : b.id[j] < b.id[i];
  pair.a = swap ? j : i;
  pair.b = swap ? i : j;
  pair.id_a = b.id[pair.a];
  pair.id_b = b.id[pair.b];
  pair.fixed_a = (kind_[pair.a] & kKinematic) != 0;
  pair.owner = b.radius[pair.b] <= b.radius[pair.a] ? pair.id_b : pair.id_a;
}

void Manifolds::name(const BodyStore& b, const StaticShapes& statics, const StaticPair& static_pair, PairName& pair) {
  pair.b = static_pair.body;
  pair.id_b = b.id[static_pair.body];
  pair.shape = static_pair.shape;
  pair.id_a = static_pair.shape >= kWallLeft ? PairName::kNone : statics[static_pair.shape].owner;
  pair.fixed_a = true;
  // A body that hits a wall of sleepers may have hundreds of such pairs; each sleeper has few.
  const bool sleeper = pair.shape < kWallLeft && statics[pair.shape].asleep;
  pair.owner = sleeper ? pair.id_a : pair.id_b;
}

// Calls each(name) for the manifolds of the other parts of a pair.
template <class Each>
void Manifolds::each_other_part(const BodyStore& b, const PairName& pair, const Each& each) const {
  const auto parts = [&](std::uint32_t slot) {
    return kind_[slot] & kShape ? std::max(1u, b.kind(b.id[slot]).hull_count) : 1u;
  };
  const std::uint32_t parts_a = pair.a == PairName::kNone ? 1 : parts(pair.a), parts_b = parts(pair.b);
  if (parts_a * parts_b == 1) return;
  PairName other = pair;
  for (std::uint32_t k = 1; k < parts_a * parts_b; ++k) {
    other.part_a = static_cast<std::uint16_t>(k / parts_b);
    other.part_b = static_cast<std::uint16_t>(k % parts_b);
    each(other);
  }
}

// Sorts the pairs of one strip: pairs of two discs stay in the list and close up; the others become manifolds.
void Manifolds::sort_out_strip(const BodyStore& b, const StaticShapes& statics, const Joined* joined, PairTable& table,
                               std::size_t index) {
  Strip& s = table.strips[index];
  Found& out = found_[index];
  out.pairs.clear();
  out.before.clear();
  const auto recall_all = [&] {  // the pair that came last has its first parts only
    out.before.push_back(recall(out.pairs.back(), old_pairs_));
    each_other_part(b, out.pairs.back(), [&](const PairName& part) {
      out.pairs.push_back(part);
      out.before.push_back(recall(part, old_pairs_));
    });
  };
  // The pairs of a strip reach into the strip itself and into the next one; those of large bodies reach anywhere.
  const std::size_t last = table.strips.size() - 1, next = index + 1 < last ? index + 1 : 0;
  const bool plain = joined == nullptr && index != last && !special_[index] && !special_[next];
  std::uint32_t kept = plain ? s.pair_end : s.pair_begin, p = s.pair_begin;
  for (std::uint32_t i = s.body_begin; i < s.body_end && !plain; ++i) {
    const std::uint32_t mark = table.first[i] & PairTable::kStripStart;
    table.first[i] = kept | mark;
    for (; p < s.pair_end && table.owner[p] == i; ++p) {
      const std::uint32_t j = table.other[p];
      const Fate what = fate(b, joined, i, j);
      if (what == Fate::stays) {
        table.owner[kept] = i;
        table.other[kept++] = j;
      } else if (what == Fate::manifold) {
        name(b, i, j, out.pairs.emplace_back());
        recall_all();
      }
    }
  }
  s.pair_end = kept;

  std::erase_if(table.static_contacts[index], [&](const StaticPair& static_pair) {
    const Fate what = fate(b, statics, joined, static_pair);
    if (what == Fate::manifold) {
      name(b, statics, static_pair, out.pairs.emplace_back());
      recall_all();
    }
    return what != Fate::stays;
  });
}

void Manifolds::begin_collect(const BodyStore& b, bool any_filter, const PairTable& table, bool sorted,
                              WorkerPool& pool) {
  keep_impulses(pool);
  any_filter_ = any_filter;
  const std::size_t strips = table.strips.size();
  found_.resize(std::max(found_.size(), strips));
  kind_.reserve(kernels::round_up_block(b.count));
  rotor_.reserve(2 * kernels::round_up_block(b.count));
  inner_.reserve(kernels::round_up_block(b.count));
  used_.reserve(kernels::round_up_block(b.count));
  if (sorted) {
    shaped_.clear();
    for (std::uint32_t i = 0; i < b.count; ++i) {
      kind_[i] = kDisc;
      if (b.id[i] == kNoSlot) continue;
      const BodyProperties& properties = b.properties(b.id[i]);
      const bool held = properties.type == BodyType::kinematic_body;
      if (properties.kind == 0) {
        if (held) kind_[i] = kKinematic;
        continue;
      }
      const BodyKind& kind = b.kinds[properties.kind];
      const bool shape = kind.hull_count != 0;
      kind_[i] = static_cast<std::uint8_t>((shape ? kShape : 0) | (kind.filter != Filter{} ? kFiltered : 0) |
                                           (kind.sensor ? kSensor : 0) | (held ? kKinematic : 0));
      if (shape) shaped_.push_back(i);
    }
  }
  new_pairs_ = 0;
  old_pairs_.swap(pairs_);
  both_ = collecting_ = true;
  index(old_pairs_, old_pairs_.size(), b.id_count);
  indexed_ = false;
  special_.resize(std::max(special_.size(), strips));
  for (std::size_t s = 0; s < strips; ++s) {
    const std::uint8_t* const begin = kind_.data() + table.strips[s].body_begin;
    const std::uint8_t* const end = kind_.data() + table.strips[s].body_end;
    special_[s] = std::any_of(begin, end, [](std::uint8_t kind) { return kind != kDisc; });
  }
}

void Manifolds::sort_out(const BodyStore& b, const StaticShapes& statics, const Joined* joined, PairTable& table,
                         std::size_t begin, std::size_t end, WorkerPool& pool) {
  pool.run(end - begin, [&](std::size_t n) { sort_out_strip(b, statics, joined, table, begin + n); });
  if (end == table.strips.size()) place_pairs(end);
}

// Makes room for the pairs that were found.
void Manifolds::place_pairs(std::size_t strips) {
  begin_.assign(strips + 1, 0);
  for (std::size_t s = 0; s < strips; ++s) {
    begin_[s + 1] = begin_[s] + static_cast<std::uint32_t>(found_[s].pairs.size());
    const std::vector<std::uint32_t>& before = found_[s].before;
    new_pairs_ += static_cast<std::uint64_t>(std::count(before.begin(), before.end(), PairName::kNone));
  }
  if (begin_[strips] > pairs_.capacity()) {  // their contents are not needed any more
    pairs_.clear();
    pairs_.reserve(begin_[strips] + begin_[strips] / 2);
  }
  own_end_ = begin_[strips];
  cut();
  pairs_.resize(begin_[strips]);
  owner_.resize(begin_[strips]);
  strips_.resize(std::max(strips_.size(), strips));
  for (std::size_t s = strips; s < strips_.size(); ++s) {
    strips_[s].blocks.clear();
    std::fill(std::begin(strips_[s].end), std::end(strips_[s].end), 0u);
  }
  for (StripBlocks& s : strips_) s.laid.clear();
  stale_.assign(strips_.size(), 1);
}

void Manifolds::keep(const BodyStore& b, const StaticShapes& statics, const TouchMemory& recent, std::size_t begin,
                     std::size_t end, WorkerPool& pool) {
  pool.run(end - begin, [&](std::size_t n) {
    const std::size_t s = begin + n;
    const Found& found = found_[s];
    for (std::size_t k = 0; k < found.pairs.size(); ++k) {
      ManifoldPair& pair = pairs_[begin_[s] + k];
      pair = found.before[k] == PairName::kNone ? ManifoldPair{} : old_pairs_[found.before[k]];
      static_cast<PairName&>(pair) = found.pairs[k];
      pair.lane = PairName::kNone;
      if (found.before[k] == PairName::kNone && !recent.empty()) recall_touch(b, statics, recent, pair);
      owner_[begin_[s] + k] = pair.owner;
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
  if (p.a == PairName::kNone) return kFixedPieces | p.b;
  return std::uint64_t{std::min(p.a, p.b)} << 32 | std::max(p.a, p.b);
}

}  // namespace

void Manifolds::sort_out_renewed(const BodyStore& b, const StaticShapes& statics, const Joined* joined,
                                 std::vector<std::uint64_t>& pairs, std::vector<StaticPair>& static_contacts,
                                 WorkerPool& pool) {
  keep_impulses(pool);
  if (!indexed_) index(pairs_, own_end_, b.id_count);
  indexed_ = true;
  renewed_.clear();
  // Returns whether the pair leaves the lists. All fixed pieces of a body stay together, also those that strips have,
  // since see_fixed() needs all of them to find which ones count.
  const auto leaves = [&](Fate what, const auto&... sides) {
    if (what != Fate::manifold) return what == Fate::goes;
    const auto put = [&](const PairName& part) {
      const std::uint32_t before = recall(part, pairs_);
      if (before == PairName::kNone || part.a == PairName::kNone) renewed_.push_back({part, before});
    };
    PairName first;
    name(b, sides..., first);
    put(first);
    each_other_part(b, first, put);
    return true;
  };
  std::erase_if(pairs, [&](std::uint64_t pair) {
    const auto i = static_cast<std::uint32_t>(pair >> 32), j = static_cast<std::uint32_t>(pair);
    return leaves(fate(b, joined, i, j), i, j);
  });
  std::erase_if(static_contacts, [&](const StaticPair& static_pair) {
    return leaves(fate(b, statics, joined, static_pair), statics, static_pair);
  });
}

void Manifolds::put_renewed(const std::function<bool(std::uint32_t)>& found) {
  const std::size_t last = begin_.size() - 2;
  before_.assign(pairs_.begin() + own_end_, pairs_.end());
  pairs_.resize(own_end_);
  auto kept = before_.cbegin(), known = before_.cbegin();
  const auto keep_up_to = [&](std::uint64_t end) {
    for (; kept != before_.cend() && rank(*kept) < end; ++kept) {
      if (!found(kept->b) && (kept->a == PairName::kNone || !found(kept->a))) pairs_.push_back(*kept);
    }
  };
  for (const Renewed& pair : renewed_) {
    const std::uint64_t at = rank(pair);
    keep_up_to(at);
    while (known != before_.cend() && rank(*known) < at) ++known;
    auto mine = known;
    while (mine != before_.cend() && rank(*mine) == at && !mine->same(pair)) ++mine;
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
      pairs_[pair.before].moved = true;
      pairs_[pair.before].active = pairs_[pair.before].ahead = false;
    }
    static_cast<PairName&>(pairs_.back()) = pair;
  }
  keep_up_to(~std::uint64_t{0});
  begin_[last + 1] = static_cast<std::uint32_t>(pairs_.size());
  owner_.resize(pairs_.size());
  // Lanes of the blocks stay as they are until the next layout.
  StripBlocks& strip = strips_[last];
  strip.active.clear();
  strip.laid.clear();
  for (std::uint32_t k = begin_[last]; k < pairs_.size(); ++k) {
    owner_[k] = pairs_[k].owner;
    if (pairs_[k].active) strip.active.push_back(k);
    if (pairs_[k].lane != PairName::kNone) strip.laid.push_back(k);
  }
  stale_[last] = 1;
  cut();
}

void Manifolds::remember(WorkerPool& pool) {
  keep_impulses(pool);
  old_pairs_ = pairs_;
  both_ = true;
}

void Manifolds::swap_pairs() {
  old_pairs_.swap(pairs_);
  owner_.resize(pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) owner_[k] = pairs_[k].owner;
}

}  // namespace psim
