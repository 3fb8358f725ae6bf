// Bodies that carry much heavier ones. One solve pass a substep brings a load down a contact or two;
// under a body a thousand times heavier it takes hundreds. The contacts of such bodies, and of what
// they rest on, are made stiffer and swept more often (docs/solver.md).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "body_store.h"
#include "column.h"
#include "pair_table.h"
#include "worker_pool.h"

namespace psim {

class HeavyLoads {
  friend struct Image;

 public:
  /// The least ratio of masses that counts.
  static constexpr float kLeastRatio = 8;
  /// Sweeps over contacts under heavy loads in a pass.
  static constexpr int kSweeps = 16;

  explicit HeavyLoads(MemoryMeter& meter) : inv_mass_(meter), level_(meter) {}

  /// Finds them among the pairs of `table`: bodies with a partner at least kLeastRatio heavier, and
  /// what is within five contacts of one. So that their contacts stay a small share of all, the
  /// ratio is doubled, or fewer contacts away count, until they are. After begin() come pieces [from, to) of
  /// pieces(), in order, until there are no more: a piece goes over the pairs of a strip, and how many pieces
  /// there are shows as they are done. O(pairs).
  void begin(const BodyStore& bodies, const PairTable& table, WorkerPool& pool);
  std::size_t pieces() const { return done_ + (phase_ == Phase::none ? 0 : strips_); }
  void go_on(const PairTable& table, WorkerPool& pool, std::size_t from, std::size_t to);
  /// Pairs that a piece looks at.
  std::uint32_t pairs_in(const PairTable& table, std::size_t piece) const;

  /// Nobody carries anything.
  void forget() { any_ = false; }
  /// Nor will: its memory is given back.
  void release();
  std::size_t bytes() const;

  bool any() const { return any_; }
  /// How often a pair was looked at in the costliest of the last searches, one that fades.
  double visits() const { return visits_; }
  void set_visits(double visits) { visits_ = visits; }
  /// Whether one of two bodies is so much heavier that it counts. Bodies lie as they did at the last search.
  bool heavy(std::uint32_t a, std::uint32_t b) const;
  /// Whether a body's contacts need it.
  bool at(std::uint32_t slot) const { return any_ && level_[slot] >= cut_; }

 private:
  // A body's level: kTop if a partner is much heavier, less by one a contact away, 0 beyond.
  static constexpr std::uint8_t kTop = 6;
  static constexpr int kRatios = 24;  // by powers of two from kLeastRatio
  using ByRatio = std::array<std::uint32_t, kRatios>;
  using ByLevel = std::array<std::uint32_t, kTop + 1>;

  // Every pass goes over all strips: how much heavier partners are, who has one that is heavy enough, who is how
  // many contacts away, how many contacts that makes.
  enum class Phase : std::uint8_t { none, ratios, mark, spread, levels };

  std::size_t strip_of(std::size_t piece) const;
  bool idle(std::size_t strip) const;
  void count_ratios(const PairTable& table, std::size_t strip);
  void mark(const PairTable& table, std::size_t strip);
  void spread(const PairTable& table, std::size_t strip);
  void count_levels(const PairTable& table, std::size_t strip);
  void activate();
  void finish_pass(const PairTable& table);
  void try_ratio(const PairTable& table);
  void begin_spread(const PairTable& table);
  void next_ratio();
  std::uint32_t most_contacts() const;
  void end(bool any);

  Column<float> inv_mass_;                   // by slot
  Column<std::uint8_t> level_;               // by slot
  std::vector<std::uint8_t> active_, next_;  // by strip: it has bodies of the level at hand
  std::vector<ByRatio> ratios_;              // by strip
  std::vector<ByLevel> levels_;
  Phase phase_ = Phase::none;     // of the search under way
  std::size_t strips_ = 0;        // there are
  std::size_t done_ = 0;          // pieces of the passes before this one
  std::uint8_t spreading_ = kTop; // level, in this pass
  std::size_t class_ = 0;         // of the ratio that is tried
  std::uint32_t contacts_ = 0;    // with that ratio
  float ratio_ = kLeastRatio;
  double visits_ = 1;
  std::uint64_t pairs_ = 0, looked_ = 0;  // there are, were looked at in this search
  std::uint8_t cut_ = 1;
  bool any_ = false;
};

}  // namespace psim
