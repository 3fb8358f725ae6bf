#include "lists/renewal.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "base/sort_keys.h"
#include "base/tasks.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kJob = 64;      // bodies that one job searches for
constexpr std::size_t kSeen = 256;      // first room for the bodies that one body sees
constexpr std::size_t kPairsABody = 8;  // most pairs a renewed body, on average

std::uint64_t key_of(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

}  // namespace

bool ListRenewal::find(float time) {
  const std::uint32_t blocks = b_.blocks(), most = b_.count / kShare;
  const std::size_t tasks = stream_tasks(blocks);
  const kernels::BodyView view = b_.view();
  kernels::StreamParams p;
  p.pitch_x = static_cast<float>(lattice_.pitch_x());
  p.pitch_y = static_cast<float>(lattice_.pitch_y());
  if (stale_.size() < tasks) stale_.resize(tasks);
  std::atomic<std::uint32_t> sum{0};
  pool_.run(tasks, [&](std::size_t t) {
    std::vector<std::uint32_t>& stale = stale_[t];
    stale.clear();
    const auto age = [&](std::uint32_t begin, std::uint32_t end) {
      return k_.list_age(view, b_.built.data(), b_.radius.data(), b_.reach.data(), p, time, begin, end);
    };
    const BlockRange r = stream_range(t, blocks);
    if (sum.load(std::memory_order_relaxed) > most || age(r.begin, r.end) <= 0) return;
    for (std::uint32_t block = r.begin; block < r.end; ++block) {
      if (age(block, block + 1) <= 0) continue;
      for (std::size_t i = std::size_t{block} * kBlock; i < std::min<std::size_t>(b_.count, (block + 1) * kBlock);
           ++i) {
        // The same arithmetic as in the list_age kernel.
        const float x = static_cast<float>(wrap_sub(b_.pos[2 * i], b_.built[2 * i])) * p.pitch_x;
        const float y = static_cast<float>(wrap_sub(b_.pos[2 * i + 1], b_.built[2 * i + 1])) * p.pitch_y;
        const float u = b_.vel[2 * i], v = b_.vel[2 * i + 1];
        const float next = std::sqrt(u * u + v * v) * time;
        if (std::sqrt(x * x + y * y) + next - (b_.reach[i] - b_.radius[i]) > 0) {
          stale.push_back(static_cast<std::uint32_t>(i));
        }
      }
    }
    sum.fetch_add(static_cast<std::uint32_t>(stale.size()), std::memory_order_relaxed);
  });
  found_.clear();
  time_ = time;
  known_ = true;
  if (sum.load() > most) return false;
  for (std::size_t t = 0; t < tasks; ++t) found_.insert(found_.end(), stale_[t].begin(), stale_[t].end());
  std::size_t both = found_.size() + renewed_.size();
  if (!renewed_.empty()) {
    for (const std::uint32_t slot : found_) both -= mark_[slot] != kListed ? 1 : 0;
  }
  return both <= most;
}

void ListRenewal::spare(std::size_t bodies) {
  const std::size_t most = bodies / kShare + 1, pairs = kPairsABody * most;
  mark_.reserve(bodies);
  found_.reserve(most);
  renewed_.reserve(2 * most);
  places_.reserve(2 * most);
  linked_.reserve(2 * most);
  pairs_.reserve(pairs);
  fresh_.reserve(pairs);
  if (scratch_.size() < (most + kJob - 1) / kJob) scratch_.resize((most + kJob - 1) / kJob);
  for (Scratch& s : scratch_) {
    s.owner.resize(std::max<std::size_t>(s.owner.size(), kSeen));
    s.other.resize(s.owner.size());
    s.pairs.reserve(kPairsABody * kJob);
  }
  statics_.reserve(kSeen);
  near_.reserve(kSeen);
  mine_.reserve(kSeen);
}

void ListRenewal::forget() {
  for (const Renewed& r : renewed_) mark_[r.slot] = kListed;
  renewed_.clear();
  places_.clear();
  linked_.clear();
  found_.clear();
  most_ = 0;
  known_ = false;
}

// Sets the place at which a body was last searched for. Padding slots follow the last body.
void ListRenewal::place(const Renewed& at) {
  const std::size_t end = at.slot + 1 == b_.count ? kernels::round_up_block(b_.count) : at.slot + 1;
  for (std::size_t i = at.slot; i < end; ++i) {
    b_.built[2 * i] = at.x;
    b_.built[2 * i + 1] = at.y;
    b_.reach[i] = at.reach;
  }
}

// Counts the found bodies as renewed from now on.
void ListRenewal::admit() {
  if (renewed_.empty()) spare(b_.count);
  const auto before = static_cast<std::ptrdiff_t>(renewed_.size());
  for (const std::uint32_t slot : found_) {
    if (mark_[slot] == kListed) renewed_.push_back(place_of(slot));
    mark_[slot] = kFound;
  }
  std::inplace_merge(renewed_.begin(), renewed_.begin() + before, renewed_.end(),
                     [](const Renewed& x, const Renewed& y) { return x.slot < y.slot; });
}

void ListRenewal::sort_places() {
  const std::size_t axis = broad_.cells().wide() ? 0 : 1;
  std::erase_if(places_, [&](const Place& p) { return mark_[p.slot] == kFound; });
  const auto before = static_cast<std::ptrdiff_t>(places_.size());
  for (const std::uint32_t slot : found_) {
    places_.push_back({static_cast<std::uint32_t>(b_.built[2 * std::size_t{slot} + axis]), slot});
    most_ = std::max(most_, b_.reach[slot]);
  }
  const auto less = [](const Place& x, const Place& y) {
    return x.along != y.along ? x.along < y.along : x.slot < y.slot;
  };
  // Total order: a slot has one place.
  std::sort(places_.begin() + before, places_.end(), less);
  std::inplace_merge(places_.begin(), places_.begin() + before, places_.end(), less);
}

// Finds the pairs of a found body that no strip has. Of two found bodies the one with the lower slot takes the pair.
void ListRenewal::search(const PairTable& table, std::uint32_t slot, Scratch& s) const {
  const auto keep = [&](std::uint32_t other) {
    if (b_.id[other] == kNoSlot || table.find_listed(slot, other) != PairTable::kNoPair) return;
    s.pairs.push_back(key_of(slot, other));
  };
  kernels::PairList list;
  for (;;) {
    list = {s.owner.data(), s.other.data(), nullptr, 0, static_cast<std::uint32_t>(s.owner.size())};
    if (broad_.pairs().around(slot, table.large_begin, list)) break;
    s.owner.resize(2 * s.owner.size());
    s.other.resize(s.owner.size());
  }
  for (std::uint32_t n = 0; n < list.count; ++n) {
    if (mark_[list.other[n]] == kListed) keep(list.other[n]);
  }
  // Renewed bodies need not lie in their cells any more: they are searched along one axis.
  const std::size_t axis = broad_.cells().wide() ? 0 : 1;
  const auto px = static_cast<float>(lattice_.pitch_x()), py = static_cast<float>(lattice_.pitch_y());
  const double reach = static_cast<double>(b_.reach[slot]) + static_cast<double>(most_);
  const double steps = reach * 1.0001 / (axis == 0 ? lattice_.pitch_x() : lattice_.pitch_y()) + 2;
  const auto meet = [&](const Place& p) {
    const std::size_t i = slot, j = p.slot;
    if (i == j || (mark_[j] == kFound && j < i)) return;
    const float dx = static_cast<float>(wrap_sub(b_.built[2 * j], b_.built[2 * i])) * px;
    const float dy = static_cast<float>(wrap_sub(b_.built[2 * j + 1], b_.built[2 * i + 1])) * py;
    const float sum = b_.reach[i] + b_.reach[j];
    if (dx * dx + dy * dy < sum * sum) keep(p.slot);
  };
  const auto along = [&](std::uint32_t from, std::uint32_t to) {
    for (auto at = std::lower_bound(places_.begin(), places_.end(), from,
                                    [](const Place&p, std::uint32_t value) { return p.along < value; });
         at != places_.end() && at->along <= to; ++at) {
      meet(*at);
    }
  };
  if (steps >= 0x1p31) return along(0, 0xFFFFFFFFu);
  const auto half = static_cast<std::uint32_t>(steps);
  const auto mid = static_cast<std::uint32_t>(b_.built[2 * std::size_t{slot} + axis]);
  if (mid - half <= mid + half) return along(mid - half, mid + half);
  along(0, mid + half);  // coordinates wrap around
  along(mid - half, 0xFFFFFFFFu);
}

// Merges the pairs of renewed bodies: old pairs that name no found body, and the new pairs of the found bodies.
void ListRenewal::join(const PairTable& table) {
  pairs_.clear();
  auto next = fresh_.begin();
  if (table.renewed_begin != PairTable::kNoneRenewed) {
    for (std::uint32_t p = table.renewed_begin; p < table.strips.back().pair_end; ++p) {
      if (mark_[table.owner[p]] == kFound || mark_[table.other[p]] == kFound) continue;
      const std::uint64_t pair = key_of(table.owner[p], table.other[p]);
      for (; next != fresh_.end() && *next < pair; ++next) pairs_.push_back(*next);
      pairs_.push_back(pair);
    }
  }
  pairs_.insert(pairs_.end(), next, fresh_.end());
}

void ListRenewal::link(std::uint32_t slot) {
  if (b_.linked[slot] != 0) return;
  b_.linked[slot] = 0xFF;
  linked_.push_back(slot);
}

// Puts the pairs behind those of the last strip, which move behind all others first.
void ListRenewal::put_pairs(PairTable& table) {
  Strip& last = table.strips.back();
  if (table.renewed_begin == PairTable::kNoneRenewed) {
    const std::uint32_t own = last.pair_end - last.pair_begin, from = last.pair_begin;
    std::uint32_t end = 0;
    for (std::size_t s = 0; s + 1 < table.strips.size(); ++s) end = std::max(end, table.strips[s].pair_end);
    if (own == 0 || end > from) {
      const std::uint32_t to = own == 0 ? end : std::max(end, last.pair_end), shift = to - from;
      for (auto* column : {&table.owner, &table.other, &table.contact}) {
        column->reserve_loosely(to + own + kBlock);
        std::memmove(column->data() + to, column->data() + from, own * sizeof(std::uint32_t));
      }
      for (std::uint32_t i = last.body_begin; i < last.body_end; ++i) table.first[i] += shift;
      last.pair_begin = to;
      last.pair_end = to + own;
    }
    table.renewed_begin = last.pair_end;
  }
  std::uint32_t p = table.renewed_begin;
  last.pair_end = p + static_cast<std::uint32_t>(pairs_.size());
  table.pair_room = std::max(table.pair_room, last.pair_end);
  for (auto* column : {&table.owner, &table.other, &table.contact}) column->reserve_loosely(last.pair_end + kBlock);
  for (const std::uint64_t pair : pairs_) {
    table.owner[p] = static_cast<std::uint32_t>(pair >> 32);
    table.other[p++] = static_cast<std::uint32_t>(pair);
  }
}

// Replaces the pairs of the found bodies with fixed shapes; pairs that were there before keep their contacts.
void ListRenewal::put_statics(PairTable& table) {
  statics_changed_ = false;
  auto near = near_.cbegin();
  for (const std::uint32_t slot : found_) {
    std::vector<StaticPair>& list = table.static_contacts[table.strip_of(slot)];
    mine_.clear();
    for (; near != near_.cend() && near->body == slot; ++near) mine_.push_back(*near);
    const auto [begin, end] = contacts_of(list, slot);
    bool same = static_cast<std::size_t>(end - begin) == mine_.size();
    for (std::size_t n = 0; n < mine_.size(); ++n) {
      StaticPair& mine = mine_[n];
      const auto was = std::find_if(begin, end, [&](const StaticPair& s) { return s.shape == mine.shape; });
      mine.contact = was == end ? PairTable::kNoPair : was->contact;
      same = same && was - begin == static_cast<std::ptrdiff_t>(n);
    }
    if (same) continue;
    statics_changed_ = true;
    const std::ptrdiff_t at = begin - list.begin();
    const auto more = static_cast<std::ptrdiff_t>(mine_.size()) - (end - begin);
    if (more > 0) {
      list.insert(end, static_cast<std::size_t>(more), StaticPair{});
    } else {
      list.erase(end + more, end);
    }
    std::copy(mine_.begin(), mine_.end(), list.begin() + at);
  }
}

void ListRenewal::search_all(const PairTable& table) {
  sort_places();
  const std::size_t jobs = (found_.size() + kJob - 1) / kJob;
  scratch_.resize(std::max(scratch_.size(), jobs));
  for (Scratch& s : scratch_) s.pairs.clear();
  pool_.run(jobs, [&](std::size_t job) {
    for (std::size_t n = job * kJob; n < std::min(found_.size(), (job + 1) * kJob); ++n) {
      search(table, found_[n], scratch_[job]);
    }
  });
  fresh_.clear();
  for (const Scratch& s : scratch_) fresh_.insert(fresh_.end(), s.pairs.begin(), s.pairs.end());
  sort_keys(fresh_.begin(), fresh_.end());
  for (const std::uint64_t pair : fresh_) {
    link(static_cast<std::uint32_t>(pair >> 32));
    link(static_cast<std::uint32_t>(pair));
  }
  near_.clear();
  for (const std::uint32_t slot : found_) broad_.near().near_body(slot, statics_, near_);
  for (const StaticPair& static_pair : near_) link(static_pair.body);
}

bool ListRenewal::look(const HeavyLoads* loads, const kernels::ReachParams& margin, const PairTable& table) {
  known_ = false;
  admit();
  for (const std::uint32_t slot : found_) {
    const std::size_t i = slot;
    const float u = b_.vel[2 * i], v = b_.vel[2 * i + 1];
    const float room = margin.skin + std::sqrt(u * u + v * v) * margin.time;
    place({slot, b_.pos[2 * i], b_.pos[2 * i + 1], b_.radius[i] + room});
  }
  search_all(table);
  return loads == nullptr || std::none_of(fresh_.begin(), fresh_.end(), [&](std::uint64_t pair) {
           return loads->heavy(static_cast<std::uint32_t>(pair >> 32), static_cast<std::uint32_t>(pair));
         });
}

bool ListRenewal::put(PairTable& table) {
  join(table);
  if (pairs_.size() > kPairsABody * (b_.count / kShare)) return false;
  put_pairs(table);
  put_statics(table);
  return true;
}

// Leaves in `renewed_` the places at which the bodies were last searched for.
void ListRenewal::turn_back() {
  for (Renewed& r : renewed_) {
    const Renewed now = place_of(r.slot);
    place(r);
    r = now;
  }
}

void ListRenewal::look_again(const PairTable& table) {
  turn_back();
  spare(b_.count);
  found_.clear();
  places_.clear();
  most_ = 0;
  for (const Renewed& r : renewed_) {
    found_.push_back(r.slot);
    mark_[r.slot] = kFound;
  }
  std::vector<std::uint32_t> linked;
  linked.swap(linked_);
  search_all(table);
  linked_.swap(linked);
  for (const std::uint32_t slot : linked_) b_.linked[slot] = 0xFF;
}

std::size_t ListRenewal::bytes() const {
  std::size_t sum = mark_.bytes() + found_.capacity() * sizeof found_[0] + renewed_.capacity() * sizeof renewed_[0] +
                    linked_.capacity() * sizeof linked_[0] + places_.capacity() * sizeof places_[0] +
                    (pairs_.capacity() + fresh_.capacity()) * sizeof pairs_[0] +
                    (near_.capacity() + mine_.capacity()) * sizeof near_[0];
  for (const Scratch& s : scratch_) {
    sum += (s.owner.capacity() + s.other.capacity()) * sizeof s.owner[0] + s.pairs.capacity() * sizeof s.pairs[0];
  }
  for (const std::vector<std::uint32_t>& s : stale_) sum += s.capacity() * sizeof s[0];
  return sum;
}

}  // namespace psim
