#include "heavy_loads.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tasks.h"

namespace psim {
namespace {

// Their contacts are swept sixteen times a pass: a sixty-fourth of them all is a quarter of a pass more.
constexpr std::uint32_t kFewContacts = 512, kShare = 64;
constexpr double kFading = 0.95;  // a search, of what the costliest took

// Even strips, then odd ones, then the large bodies' group.
template <class Each>
void each_strip(const PairTable& table, WorkerPool& pool, const Each& each) {
  const std::size_t strips = table.strips.size() - 1;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    pool.run((strips + 1 - parity) / 2, [&](std::size_t k) { each(2 * k + parity); });
  }
  each(strips);
}

// Column by column, of the first n.
template <class Counts>
Counts sum_of(const std::vector<Counts>& by_strip, std::size_t n) {
  Counts sum{};
  for (std::size_t s = 0; s < n; ++s) {
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += by_strip[s][k];
  }
  return sum;
}

// By how many powers of two the ratio of two masses exceeds kLeastRatio; -1: it does not. Kinematic
// bodies (0) are no load.
int ratio_class(float wa, float wb) {
  const float light = std::max(wa, wb), heavy = std::min(wa, wb);
  if (!(heavy > 0) || light < heavy * HeavyLoads::kLeastRatio) return -1;
  return std::ilogb(light / (heavy * HeavyLoads::kLeastRatio));
}

}  // namespace

HeavyLoads::ByRatio HeavyLoads::count_ratios(const PairTable& table, WorkerPool& pool) {
  looked_ += pairs_;
  ratios_.resize(std::max(ratios_.size(), table.strips.size()));
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    ByRatio mine{};
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      const int c = ratio_class(inv_mass_[table.owner[p]], inv_mass_[table.other[p]]);
      if (c >= 0) ++mine[static_cast<std::size_t>(std::min(c, kRatios - 1))];
    }
    ratios_[index] = mine;
  });
  return sum_of(ratios_, table.strips.size());
}

void HeavyLoads::mark(const PairTable& table, float ratio, WorkerPool& pool) {
  std::fill_n(level_.data(), table.body_count, std::uint8_t{0});
  active_.assign(table.strips.size(), 0);
  next_ = active_;
  looked_ += pairs_;
  each_strip(table, pool, [&](std::size_t index) {
    const Strip& s = table.strips[index];
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      const std::uint32_t a = table.owner[p], b = table.other[p];
      const float wa = inv_mass_[a], wb = inv_mass_[b];
      const float heavy = std::min(wa, wb);
      if (!(heavy > 0) || std::max(wa, wb) < heavy * ratio) continue;
      level_[wa > wb ? a : b] = kTop;
      next_[index] = 1;
    }
  });
  activate();
  for (std::uint8_t level = kTop; level > 1; --level) spread(table, ratio, level, pool);
}

// From bodies of a level to their partners, one level less; not to the loads themselves. Only
// strips that have such bodies, or reach a strip that has.
void HeavyLoads::spread(const PairTable& table, float ratio, std::uint8_t level, WorkerPool& pool) {
  const std::size_t strips = table.strips.size() - 1;
  next_ = active_;
  const auto idle = [&](std::size_t index) {
    const std::size_t beyond = index + 1 < strips ? index + 1 : 0;
    return index != strips && active_[index] == 0 && active_[beyond] == 0;
  };
  for (std::size_t k = 0; k <= strips; ++k) {
    if (!idle(k)) looked_ += table.strips[k].pair_end - table.strips[k].pair_begin;
  }
  each_strip(table, pool, [&](std::size_t index) {
    if (idle(index)) return;
    const Strip& s = table.strips[index];
    const auto pass = [&](std::uint32_t from, std::uint32_t to) {
      if (level_[from] != level || level_[to] + 1 >= level) return;
      const float w = inv_mass_[to];
      if (!(w > 0) || inv_mass_[from] >= w * ratio) return;
      level_[to] = static_cast<std::uint8_t>(level - 1);
      next_[index] = 1;
    };
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      pass(table.owner[p], table.other[p]);
      pass(table.other[p], table.owner[p]);
    }
  });
  activate();
}

// The strips in `next_`, and those after them: a body may belong to the strip after the one whose
// pair reached it, and to any if that is the group of large ones.
void HeavyLoads::activate() {
  const std::size_t strips = next_.size() - 1;
  for (std::size_t k = 0; k < strips; ++k) {
    if (next_[k] != 0) active_[k] = active_[k + 1 < strips ? k + 1 : 0] = 1;
  }
  if (next_[strips] != 0) std::fill(active_.begin(), active_.end(), std::uint8_t{1});
}

HeavyLoads::ByLevel HeavyLoads::count_levels(const PairTable& table, WorkerPool& pool) {
  looked_ += pairs_;
  levels_.resize(std::max(levels_.size(), table.strips.size()));
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
    ByLevel mine{};
    for (std::uint32_t p = s.pair_begin; p < s.pair_end; ++p) {
      ++mine[std::max(level_[table.owner[p]], level_[table.other[p]])];
    }
    levels_[index] = mine;
  });
  return sum_of(levels_, table.strips.size());
}

void HeavyLoads::search(const BodyStore& b, const PairTable& table, WorkerPool& pool) {
  any_ = false;
  inv_mass_.reserve(b.count);
  level_.reserve(b.count);
  pairs_ = looked_ = 0;
  for (const Strip& s : table.strips) pairs_ += s.pair_end - s.pair_begin;
  const std::uint32_t blocks = b.blocks();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    for (std::size_t i = std::size_t{r.begin} * kernels::kBlock;
         i < std::min<std::size_t>(std::size_t{r.end} * kernels::kBlock, b.count); ++i) {
      inv_mass_[i] = b.id[i] == kNoSlot ? 0.0f : b.surface(b.id[i]).inv_mass;
    }
  });
  const ByRatio ratios = count_ratios(table, pool);
  const std::uint32_t most = std::max(kFewContacts, static_cast<std::uint32_t>(pairs_) / kShare);
  std::uint32_t contacts = 0;
  for (const std::uint32_t n : ratios) contacts += n;
  float ratio = kLeastRatio;
  for (std::size_t k = 0; contacts != 0; contacts -= ratios[k], ++k, ratio *= 2) {
    if (contacts > most) continue;
    mark(table, ratio, pool);
    const ByLevel levels = count_levels(table, pool);
    std::uint32_t sum = levels[kTop];
    if (sum > most) continue;
    for (cut_ = kTop; cut_ > 1 && sum + levels[cut_ - 1u] <= most; --cut_) sum += levels[cut_ - 1u];
    any_ = true;
    return;
  }
}

void HeavyLoads::find(const BodyStore& b, const PairTable& table, WorkerPool& pool) {
  search(b, table, pool);
  const double visits = static_cast<double>(looked_) / static_cast<double>(std::max<std::uint64_t>(pairs_, 1));
  visits_ = std::max(visits, 1 + kFading * (visits_ - 1));
}

void HeavyLoads::release() {
  forget();
  inv_mass_.release();
  level_.release();
  for (std::vector<std::uint8_t>* marks : {&active_, &next_}) std::vector<std::uint8_t>().swap(*marks);
  std::vector<ByRatio>().swap(ratios_);
  std::vector<ByLevel>().swap(levels_);
}

std::size_t HeavyLoads::bytes() const {
  return inv_mass_.bytes() + level_.bytes() + active_.capacity() + next_.capacity() +
         ratios_.capacity() * sizeof(ByRatio) + levels_.capacity() * sizeof(ByLevel);
}

}  // namespace psim
