#include "lists/renewal.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>

#include "base/elementary.h"
#include "base/sort_keys.h"
#include "base/tasks.h"

namespace psim {
namespace {

using kernels::kBlock;

constexpr std::uint32_t kJob = 64;      // bodies that one job searches for
constexpr std::size_t kSeen = 256;      // first room for the bodies that one body sees
constexpr std::size_t kPairsABody = 8;  // most pairs a renewed body, on average

}  // namespace

// `beyond` calls its second argument for every slot of some blocks whose body goes beyond its margin.
template <class Beyond>
bool ListRenewal::find_beyond(const Beyond& beyond, std::span<const std::uint32_t> others) {
  const std::uint32_t most = b_.count / kShare;
  // Relaxed: each number gives one place of found_ to one job. Places are read and sorted after the run.
  std::atomic<std::uint32_t> count{0};
  const auto too_many = [&] { return count.load(std::memory_order_relaxed) > most; };
  found_.resize(most);
  run_stream(b_.blocks(), s_.pool, [&](BlockRange r) {
    if (too_many()) return;
    beyond(r, [&](std::uint32_t slot) {
      const std::uint32_t at = count.fetch_add(1, std::memory_order_relaxed);
      if (at < most) found_[at] = slot;
      return at < most;
    });
  });
  known_ = true;
  found_.resize(too_many() ? 0 : count.load());
  if (too_many() || others.size() > most) return false;
  found_.insert(found_.end(), others.begin(), others.end());
  sort_keys(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  const auto is_new = [&](std::uint32_t slot) { return renewed_.empty() || mark_[slot] == kListed; };
  return renewed_.size() + static_cast<std::size_t>(std::ranges::count_if(found_, is_new)) <= most;
}

bool ListRenewal::find(float time, std::span<const std::uint32_t> others) {
  const auto margin_of = [&](std::size_t i) { return b_.reach[i] - b_.radius[i]; };
  const auto each = [&](BlockRange r, const auto& do_one) {
    for (std::uint32_t slot = r.begin * kBlock; slot < std::min(b_.count, r.end * kBlock); ++slot) do_one(slot);
  };
  if (broad_.common().on()) {
    if (!broad_.update_common()) return false;
    const auto beyond = [&](BlockRange r, const auto& found) {
      each(r, [&](std::uint32_t slot) {
        if (broad_.common().use(slot, b_.built.data() + 2 * std::size_t{slot}, time) - margin_of(slot) > 0) found(slot);
      });
    };
    return find_beyond(beyond, others);
  }
  const auto any_beyond = broad_.beyond_margins(time);
  const auto px = static_cast<float>(s_.lattice.pitch_x()), py = static_cast<float>(s_.lattice.pitch_y());
  const auto beyond = [&](BlockRange r, const auto& found) {
    if (any_beyond(r.begin, r.end) <= 0) return;
    bool room = true;
    for (std::uint32_t block = r.begin; block < r.end && room; ++block) {
      if (any_beyond(block, block + 1) <= 0) continue;
      each({block, block + 1}, [&](std::uint32_t slot) {
        // The same arithmetic as in the list_age kernel.
        const std::size_t i = slot;
        const float x = static_cast<float>(wrap_sub(b_.pos[2 * i], b_.built[2 * i])) * px;
        const float y = static_cast<float>(wrap_sub(b_.pos[2 * i + 1], b_.built[2 * i + 1])) * py;
        const float u = b_.vel[2 * i], v = b_.vel[2 * i + 1];
        const float next = std::sqrt(u * u + v * v) * time;
        if (std::sqrt(x * x + y * y) + next - margin_of(i) > 0) room = found(slot);
      });
    }
  };
  return find_beyond(beyond, others);
}

void ListRenewal::spare(std::size_t bodies) {
  const std::size_t most = bodies / kShare + 1, pairs = kPairsABody * most;
  mark_.reserve(bodies);
  found_.reserve(most);
  renewed_.reserve(2 * most);
  places_.reserve(2 * most);
  linked_.reserve(2 * most);
  spare_renewed_.reserve(most);
  spare_keys_.reserve(pairs);
  pairs_.reserve(pairs);
  fresh_.reserve(pairs);
  scratch_.resize(std::max(scratch_.size(), (most + kJob - 1) / kJob));
  for (Scratch& s : scratch_) {
    s.owner.resize(std::max<std::size_t>(s.owner.size(), kSeen));
    s.other.resize(s.owner.size());
    s.pairs.reserve(kPairsABody * kJob);
  }
  statics_.reserve(kSeen);
  near_.reserve(kSeen);
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

// Finds the pairs of a found body that no strip has. Of two found bodies the one with the lower slot takes the pair.
void ListRenewal::search(const PairTable& table, std::uint32_t slot, Scratch& s) const {
  const HeldBodies& held = broad_.pairs().held();
  const auto keep = [&](std::uint32_t other) {
    if (held.at(slot) && held.at(other)) return;
    if (b_.id[other] == kNoSlot || table.find_listed(slot, other) != PairTable::kNoPair) return;
    s.pairs.push_back(pair_key(slot, other));
  };
  kernels::PairList list;
  for (;;) {
    list = {s.owner.data(), s.other.data(), nullptr, 0, static_cast<std::uint32_t>(s.owner.size())};
    if (broad_.pairs().around(slot, list)) break;
    s.owner.resize(2 * s.owner.size());
    s.other.resize(s.owner.size());
  }
  for (std::uint32_t n = 0; n < list.count; ++n) {
    if (mark_[list.other[n]] == kListed) keep(list.other[n]);
  }
  // Renewed bodies need not lie in their cells any more: they are searched along one axis.
  const auto px = static_cast<float>(s_.lattice.pitch_x()), py = static_cast<float>(s_.lattice.pitch_y());
  const double reach = static_cast<double>(b_.reach[slot]) + static_cast<double>(most_);
  const double steps = reach * 1.0001 / (broad_.cells().wide() ? s_.lattice.pitch_x() : s_.lattice.pitch_y()) + 2;
  const auto meet = [&](std::uint32_t other) {
    const std::size_t i = slot, j = other;
    if (i == j || (mark_[j] == kFound && j < i)) return;
    const float dx = static_cast<float>(wrap_sub(b_.built[2 * j], b_.built[2 * i])) * px;
    const float dy = static_cast<float>(wrap_sub(b_.built[2 * j + 1], b_.built[2 * i + 1])) * py;
    const float sum = b_.reach[i] + b_.reach[j];
    if (dx * dx + dy * dy < sum * sum) keep(other);
  };
  const auto along = [&](std::uint32_t from, std::uint32_t to) {
    auto at = std::lower_bound(places_.begin(), places_.end(), std::uint64_t{from} << 32);
    for (; at != places_.end() && *at >> 32 <= to; ++at) meet(static_cast<std::uint32_t>(*at));
  };
  if (steps >= 0x1p31) return along(0, 0xFFFFFFFFu);
  const auto half = static_cast<std::uint32_t>(steps);
  const std::uint32_t mid = along_axis(slot);
  if (mid - half <= mid + half) return along(mid - half, mid + half);
  along(0, mid + half);  // coordinates wrap around
  along(mid - half, 0xFFFFFFFFu);
}

// Puts the pairs behind those of the last strip, which move behind all others first.
void ListRenewal::put_pairs(PairTable& table) const {
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
  for (const std::uint32_t slot : found_) {
    std::vector<StaticPair>& list = table.static_contacts[table.strip_of(slot)];
    const auto [first, last] = contacts_of(near_, slot);
    const std::span<StaticPair> mine(std::to_address(first), static_cast<std::size_t>(last - first));
    const auto [begin, end] = contacts_of(list, slot);
    bool same = end - begin == std::ssize(mine);
    for (StaticPair& pair : mine) {
      const auto was = std::find_if(begin, end, [&](const StaticPair& s) { return s.shape == pair.shape; });
      pair.contact = was == end ? PairTable::kNoPair : was->contact;
      same = same && was - begin == &pair - &mine.front();
    }
    if (same) continue;
    statics_changed_ = true;
    list.insert(list.erase(begin, end), mine.begin(), mine.end());
  }
}

void ListRenewal::search_all(const PairTable& table) {
  std::erase_if(places_, [&](std::uint64_t place) { return mark_[static_cast<std::uint32_t>(place)] == kFound; });
  const std::size_t before = places_.size();
  for (const std::uint32_t slot : found_) {
    places_.push_back(std::uint64_t{along_axis(slot)} << 32 | slot);
    most_ = std::max(most_, b_.reach[slot]);
  }
  sort_keys(places_.begin() + static_cast<std::ptrdiff_t>(before), places_.end());
  merge_parts(places_, before, spare_keys_);
  const std::size_t jobs = (found_.size() + kJob - 1) / kJob;
  for (Scratch& s : scratch_) s.pairs.clear();
  s_.pool.run(jobs, [&](std::size_t job) {
    for (std::size_t n = job * kJob; n < std::min(found_.size(), (job + 1) * kJob); ++n) {
      search(table, found_[n], scratch_[job]);
    }
  });
  fresh_.clear();
  for (const Scratch& s : scratch_) fresh_.insert(fresh_.end(), s.pairs.begin(), s.pairs.end());
  sort_keys(fresh_.begin(), fresh_.end());
  near_.clear();
  for (const std::uint32_t slot : found_) broad_.near().near_body(slot, statics_, near_);
  const auto link = [&](std::uint32_t slot) {
    if (b_.linked[slot] != 0) return;
    b_.linked[slot] = 0xFF;
    linked_.push_back(slot);
  };
  for (const std::uint64_t pair : fresh_) {
    link(static_cast<std::uint32_t>(pair >> 32));
    link(static_cast<std::uint32_t>(pair));
  }
  for (const StaticPair& static_pair : near_) link(static_pair.body);
}

bool ListRenewal::look(const HeavyLoads* loads, const kernels::ReachParams& margin, const PairTable& table) {
  known_ = false;
  if (renewed_.empty()) spare(b_.count);
  const std::size_t before = renewed_.size();
  for (const std::uint32_t slot : found_) {
    const std::size_t i = slot;
    if (mark_[i] == kListed) renewed_.push_back(place_of(slot));
    mark_[i] = kFound;
    const float skin = margin.of_radius != 0 ? std::min(margin.of_radius * b_.radius[i], margin.skin) : margin.skin;
    if (broad_.common().on()) {
      std::int32_t at[2] = {b_.built[2 * i], b_.built[2 * i + 1]};
      broad_.common().find_place(slot, at);
      broad_.common().move_member(b_.built.data() + 2 * i, at);
      place({slot, at[0], at[1], b_.radius[i] + skin + greater(broad_.common().use(slot, at, margin.time), 0.0f)});
      continue;
    }
    const float u = b_.vel[2 * i], v = b_.vel[2 * i + 1];
    place({slot, b_.pos[2 * i], b_.pos[2 * i + 1], b_.radius[i] + skin + std::sqrt(u * u + v * v) * margin.time});
  }
  merge_parts(renewed_, before, spare_renewed_, [](const Renewed& a, const Renewed& b) { return a.slot < b.slot; });
  search_all(table);
  return loads == nullptr || std::none_of(fresh_.begin(), fresh_.end(), [&](std::uint64_t pair) {
           return loads->heavy(static_cast<std::uint32_t>(pair >> 32), static_cast<std::uint32_t>(pair));
         });
}

bool ListRenewal::put(PairTable& table) {
  pairs_.clear();
  for (std::uint32_t p = table.renewed_begin; p < table.strips.back().pair_end; ++p) {
    if (!found(table.owner[p]) && !found(table.other[p])) pairs_.push_back(table.key_of(p));
  }
  const std::size_t kept = pairs_.size();
  pairs_.insert(pairs_.end(), fresh_.begin(), fresh_.end());
  if (pairs_.size() > kPairsABody * (b_.count / kShare)) return false;
  merge_parts(pairs_, kept, spare_keys_);
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
  broad_.common().forget_members();
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
  for (const std::uint32_t slot : linked_) b_.linked[slot] = 0xFF;
  search_all(table);
}

std::size_t ListRenewal::bytes() const {
  std::size_t sum =
      mark_.bytes() + bytes_of(found_, renewed_, linked_, places_, pairs_, fresh_, near_, spare_renewed_, spare_keys_);
  for (const Scratch& s : scratch_) sum += bytes_of(s.owner, s.other, s.pairs);
  return sum;
}

}  // namespace psim
