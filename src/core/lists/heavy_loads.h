// Bodies that carry much heavier bodies. One solve pass a substep passes a load on by a contact or two;
// under a body a thousand times heavier it would take hundreds of passes. The contacts of such bodies, and
// of the bodies that they rest on, are made stiffer and swept more often (docs/solver.md).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <tuple>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "lists/pair_table.h"

namespace psim {

class HeavyLoads {
 public:
  /// For saved states.
  auto fields() { return std::tie(visits, least_class_, least_cut_, counted_); }
  bool sound() const { return least_class_ >= 0 && least_class_ <= kRatios && least_cut_ >= 1 && least_cut_ <= kTop; }

  /// The least ratio of masses that counts as heavy.
  static constexpr float kLeastRatio = 8;
  /// Sweeps over contacts under heavy loads in a pass.
  static constexpr int kSweeps = 16;

  explicit HeavyLoads(MemoryMeter& meter) : inv_mass_(meter), level_(meter) {}

  /// Finds the loaded bodies among the pairs of `table`: bodies with a partner at least kLeastRatio heavier, and
  /// all bodies within five contacts of one. Their contacts must stay a small share of all: until they are, the
  /// ratio is doubled, or bodies fewer contacts away count. After begin() run pieces [from, to) of pieces(), in
  /// order, until none is left: a piece goes over the pairs of one strip, and pieces() grows with the passes that
  /// turn out to be needed. O(pairs).
  /// `sleeping`: some bodies sleep. Their contacts are in no list, but count.
  void begin(const BodyStore& bodies, const PairTable& table, WorkerPool& pool, bool sleeping = false);
  std::size_t pieces() const { return done_ + (phase_ == Phase::none ? 0 : strips_); }
  void go_on(const PairTable& table, WorkerPool& pool, std::size_t from, std::size_t to);
  /// Number of pairs that a piece looks at.
  std::uint32_t pairs_in(const PairTable& table, std::size_t piece) const;

  /// Declares that nobody carries a heavy load.
  void forget() { any_ = false; }
  /// Gives the memory back, when no body can carry a heavy load any more.
  void release();
  std::size_t bytes() const { return inv_mass_.bytes() + level_.bytes() + bytes_of(active_, next_); }

  bool any() const { return any_; }
  /// Whether one of two bodies is heavy relative to the other. Slots must be those of the last search.
  bool heavy(std::uint32_t a, std::uint32_t b) const;
  /// Whether the contacts of a body are under a heavy load.
  bool at(std::uint32_t slot) const { return any_ && level_[slot] >= cut_; }

  /// Whether a partner of a body is heavy for it.
  bool pressed(std::uint32_t slot) const { return any_ && level_[slot] == kTop; }
  /// Whether a body with inverse mass `wa` is heavy for one with `wb`, or fixed.
  static bool is_heavy(double wa, double wb) { return wb >= double{kLeastRatio} * wa; }

  double visits = 1;  ///< how often a pair was looked at in the costliest search; older searches fade

 private:
  // The level of a body: kTop if a partner is much heavier, one less for each contact away, 0 beyond.
  static constexpr std::uint8_t kTop = 6;
  static constexpr int kRatios = 24;  // by powers of two from kLeastRatio

  // Every pass goes over all strips:
  //   ratios  how much heavier partners are
  //   mark    which bodies have a partner that is heavy enough
  //   spread  which bodies are one contact further away, and how many contacts those before them have
  enum class Phase : std::uint8_t { none, ratios, mark, spread };

  bool idle(std::size_t strip) const;
  void count_ratios(const PairTable& table, std::size_t strip);
  void mark(const PairTable& table, std::size_t strip);
  void spread(const PairTable& table, std::size_t strip);
  void finish_pass(const PairTable& table);
  void finish_level(const PairTable& table);
  void try_ratio(const PairTable& table);
  void begin_spread(const PairTable& table);
  void end(bool any);

  Column<float> inv_mass_;                                  // by slot
  Column<std::uint8_t> level_;                              // by slot
  std::vector<std::uint8_t> active_, next_;                 // by strip: it has bodies of the level that spreads
  std::array<std::atomic<std::uint32_t>, kRatios> ratios_;  // pairs of each class
  std::atomic<std::uint32_t> of_level_ = 0;                 // contacts of the level that this pass spreads
  Phase phase_ = Phase::none;                               // the pass of the search that runs
  std::size_t strips_ = 0;                                  // number of strips
  std::size_t done_ = 0;                                    // number of pieces in the passes before this one
  std::uint8_t spreading_ = kTop;                           // the level that this pass spreads
  int class_ = 0;                                           // the power of two of the ratio that is tried
  // These two are the choice of the search that saw the most bodies since one slept. While bodies sleep, a search sees
  // fewer contacts. If that let it choose more of them, contacts at rest would become stiff, and throw off what their
  // overlaps carry.
  int least_class_ = 0;
  std::uint8_t least_cut_ = 1;
  std::uint32_t counted_ = 0;             // bodies that were awake
  float ratio_ = kLeastRatio;             // that ratio
  std::uint64_t pairs_ = 0, looked_ = 0;  // number of pairs, number of looks in this search
  std::uint64_t chosen_ = 0;              // contacts of the levels up to this one
  std::uint8_t cut_ = 1;
  bool any_ = false;
};

}  // namespace psim
