#include "lists/heavy_loads.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/tasks.h"

namespace psim {
namespace {

// Contacts under heavy loads are swept sixteen times a pass, so a sixty-fourth of all contacts costs a quarter of a
// pass.
constexpr std::uint32_t kFewContacts = 512, kShare = 64;
constexpr double kFading = 0.95;  // factor a search on the cost of the costliest one

// The most contacts that may be under heavy loads, out of so many pairs.
std::uint32_t most_contacts(std::uint64_t pairs) {
  return std::max(kFewContacts, static_cast<std::uint32_t>(pairs) / kShare);
}

// By how many powers of two the ratio of two masses exceeds kLeastRatio; -1 if it does not. A kinematic
// body (inverse mass 0) is no load.
int ratio_class(float wa, float wb) {
  const float light = std::max(wa, wb), heavy = std::min(wa, wb);
  if (!(heavy > 0) || light < heavy * HeavyLoads::kLeastRatio) return -1;
  return std::ilogb(light / (heavy * HeavyLoads::kLeastRatio));
}

}  // namespace

bool HeavyLoads::heavy(std::uint32_t a, std::uint32_t b) const { return ratio_class(inv_mass_[a], inv_mass_[b]) >= 0; }

void HeavyLoads::begin(const BodyStore& b, const PairTable& table, WorkerPool& pool, bool sleeping) {
  if (!sleeping || b.awake() >= counted_) least_class_ = 0, least_cut_ = 1, counted_ = b.awake();
  any_ = false;
  inv_mass_.reserve(b.count);
  level_.reserve(b.count);
  pairs_ = looked_ = 0;
  for (const Strip& s : table.strips) pairs_ += s.pair_end - s.pair_begin;
  run_stream(b.blocks(), pool, [&](BlockRange r) {
    for (std::size_t i = std::size_t{r.begin} * kernels::kBlock;
         i < std::min<std::size_t>(std::size_t{r.end} * kernels::kBlock, b.count); ++i) {
      inv_mass_[i] = b.id[i] == kNoSlot ? 0.0f : b.properties(b.id[i]).inv_mass;
    }
  });
  strips_ = table.strips.size();
  for (auto& count : ratios_) count = 0;
  phase_ = Phase::ratios;
  done_ = 0;
}

std::uint32_t HeavyLoads::pairs_in(const PairTable& table, std::size_t piece) const {
  // The order of strips in a pass: even strips, then odd strips, then the group of large bodies.
  const std::size_t k = piece - done_, even = strips_ / 2;
  const std::size_t strip = k + 1 == strips_ ? k : k < even ? 2 * k : 2 * (k - even) + 1;
  const Strip& s = table.strips[strip];
  return phase_ == Phase::spread && idle(strip) ? 0 : s.pair_end - s.pair_begin;
}

void HeavyLoads::go_on(const PairTable& table, WorkerPool& pool, std::size_t from, std::size_t to) {
  run_phases(strips_, from - done_, to - done_, pool, [&](std::size_t strip) {
    switch (phase_) {
      case Phase::ratios:
        return count_ratios(table, strip);
      case Phase::mark:
        return mark(table, strip);
      case Phase::spread:
        return spread(table, strip);
      case Phase::none:
        break;
    }
  });
  if (to == pieces()) finish_pass(table);
}

// Relaxed: a sum of whole numbers has no order, and it is read after the run.
void HeavyLoads::count_ratios(const PairTable& table, std::size_t index) {
  const Strip& s = table.strips[index];
  std::array<std::uint32_t, kRatios> mine{};
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const int of = ratio_class(inv_mass_[table.owner[p]], inv_mass_[table.other[p]]);
    if (of >= 0) ++mine[static_cast<std::size_t>(std::min(of, kRatios - 1))];
  }
  for (std::size_t k = 0; k < kRatios; ++k) ratios_[k].fetch_add(mine[k], std::memory_order_relaxed);
}

void HeavyLoads::mark(const PairTable& table, std::size_t index) {
  const Strip& s = table.strips[index];
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t a = table.owner[p], b = table.other[p];
    const float wa = inv_mass_[a], wb = inv_mass_[b];
    const float heavy = std::min(wa, wb);
    if (!(heavy > 0) || std::max(wa, wb) < heavy * ratio_) continue;
    level_[wa > wb ? a : b] = kTop;
    next_[index] = 1;
  }
}

// A strip is idle if neither it nor a strip that it reaches has bodies of the level.
bool HeavyLoads::idle(std::size_t index) const {
  const std::size_t grid = strips_ - 1, beyond = index + 1 < grid ? index + 1 : 0;
  return index != grid && active_[index] == 0 && active_[beyond] == 0;
}

// Spreads a level to the partners of its bodies, as one level less, but not to the heavy partners themselves. Counts the
// contacts of the level. Relaxed: a sum of whole numbers has no order, and it is read after the run.
void HeavyLoads::spread(const PairTable& table, std::size_t index) {
  if (idle(index)) return;
  const Strip& s = table.strips[index];
  const std::uint8_t level = spreading_;
  const auto pass = [&](std::uint32_t from, std::uint32_t to) {
    if (level_[to] + 1 >= level) return;
    const float w = inv_mass_[to];
    if (!(w > 0) || inv_mass_[from] >= w * ratio_) return;
    level_[to] = static_cast<std::uint8_t>(level - 1);
    next_[index] = 1;
  };
  std::uint32_t contacts = 0;
  for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
    const std::uint32_t a = table.owner[p], b = table.other[p];
    const std::uint8_t of_a = level_[a], of_b = level_[b];
    if (of_a != level && of_b != level) continue;
    contacts += std::max(of_a, of_b) == level ? 1 : 0;
    if (of_a == level) pass(a, b);
    if (of_b == level) pass(b, a);
  }
  of_level_.fetch_add(contacts, std::memory_order_relaxed);
}

// Chooses the next pass, after all strips were gone over.
void HeavyLoads::finish_pass(const PairTable& table) {
  done_ += strips_;
  if (phase_ != Phase::spread) looked_ += pairs_;
  switch (phase_) {
    case Phase::ratios:
      class_ = least_class_;
      return try_ratio(table);
    case Phase::mark:
      return begin_spread(table);
    case Phase::spread:
      return finish_level(table);
    case Phase::none:
      break;
  }
}

// The contacts of a level are chosen if they leave few enough; then the next level has its turn.
void HeavyLoads::finish_level(const PairTable& table) {
  chosen_ += of_level_;
  const bool fits = chosen_ <= most_contacts(pairs_);
  if (spreading_ == kTop && !fits) {
    ++class_;
    return try_ratio(table);
  }
  if (fits) cut_ = spreading_;
  const std::uint8_t least = class_ == least_class_ ? least_cut_ : std::uint8_t{1};
  if (!fits || spreading_ == least) return end(true);
  --spreading_;
  begin_spread(table);
}

// Goes on to the next ratio that leaves few enough contacts, or ends the search.
void HeavyLoads::try_ratio(const PairTable& table) {
  const auto contacts = [&] { return std::accumulate(ratios_.begin() + class_, ratios_.end(), 0u); };
  while (contacts() > most_contacts(pairs_)) ++class_;
  if (contacts() == 0) return end(false);
  ratio_ = std::ldexp(kLeastRatio, class_);
  spreading_ = kTop;
  chosen_ = 0;
  std::fill_n(level_.data(), table.body_count, std::uint8_t{0});
  active_.assign(strips_, 0);
  next_ = active_;
  phase_ = Phase::mark;
}

// Activates the strips in `next_` and the strips after them: a pair may reach a body of the next strip, and a pair
// of the large bodies' group a body of any strip.
void HeavyLoads::begin_spread(const PairTable& table) {
  const std::size_t grid = strips_ - 1;
  for (std::size_t k = 0; k < grid; ++k) {
    if (next_[k] != 0) active_[k] = active_[k + 1 < grid ? k + 1 : 0] = 1;
  }
  if (next_[grid] != 0) std::fill(active_.begin(), active_.end(), std::uint8_t{1});
  of_level_ = 0;
  phase_ = Phase::spread;
  next_ = active_;
  for (std::size_t k = 0; k < strips_; ++k) {
    if (!idle(k)) looked_ += table.strips[k].pair_end - table.strips[k].pair_begin;
  }
}

void HeavyLoads::end(bool any) {
  any_ = any;
  least_cut_ = any ? cut_ : std::uint8_t{1};
  least_class_ = class_;
  phase_ = Phase::none;
  const double now = static_cast<double>(looked_) / static_cast<double>(std::max<std::uint64_t>(pairs_, 1));
  visits = std::max(now, 1 + kFading * (visits - 1));
}

void HeavyLoads::release() {
  forget();
  give_back(inv_mass_, level_, active_, next_);
}

}  // namespace psim
