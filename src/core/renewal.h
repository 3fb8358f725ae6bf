// Lists that last, made anew body by body: where a few bodies use up their margin before all others, those alone are
// looked for again, from where they are now (docs/decisions/014-lists-body-by-body.md).
//
// Their pairs that no strip has come behind the last strip's own (PairTable::renewed_begin); the other strips, their
// colours and impulses stay. Pairs that a renewed body had before stay in its strip: they are as good as any. What
// comes out depends on where each body was looked for last and on the lists of the last build, on nothing else.
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "broad_phase.h"
#include "column.h"
#include "heavy_loads.h"
#include "kernel_table.h"
#include "pair_table.h"
#include "static_shapes.h"
#include "worker_pool.h"

namespace psim {

class ListRenewal {
  friend struct Image;

 public:
  explicit ListRenewal(MemoryMeter& meter) : mark_(meter) {}

  /// Bodies of which no more than one in so many is renewed until all lists are made again: the pairs of renewed
  /// ones are one job of every pass.
  static constexpr std::uint32_t kShare = 32;

  /// Finds the bodies whose margin does not last for `time` seconds more. False if they and those that were renewed
  /// before are too many. O(bodies).
  bool find(BodyStore& bodies, const Lattice& lattice, float time, const kernels::KernelTable& k,
            WorkerPool& pool);
  bool any() const { return known_ && !found_.empty(); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(found_.size()); }
  /// What was found does not count: bodies may have other velocities now.
  void doubt() { known_ = false; }
  /// s: of the last find(); whether it still counts.
  float time() const { return time_; }
  bool known() const { return known_; }

  /// Looks for those that were found with margins of skin + |v| `margin.time`: pairs() and near() are theirs then.
  /// False, and all lists must be made again, if one of two bodies in them is much heavier. O(found log renewed).
  bool look(const BroadPhase& broad, BodyStore& bodies, const StaticShapes& shapes,
            const HeavyLoads* loads, const kernels::ReachParams& margin,
            const kernels::KernelTable& k, WorkerPool& pool, const PairTable& table);
  bool found(std::uint32_t slot) const { return mark_[slot] == kFound; }
  /// Pairs that no strip has, lower slot << 32 | higher one, ascending; fixed shapes near bodies, by body. What is not
  /// for the table is taken out by its owner.
  std::vector<std::uint64_t>& pairs() { return fresh_; }
  std::vector<SinglePair>& near() { return near_; }
  /// `table` has them then, as pairs of renewed bodies. False, and all lists must be made again, if those are too many.
  /// O(pairs of renewed bodies).
  bool put(BodyStore& bodies, PairTable& table);
  /// Those that were found are done.
  void finish();
  /// Whether a body is near other fixed shapes than before, or in another order.
  bool singles_changed() const { return singles_changed_; }
  std::uint32_t renewed() const { return static_cast<std::uint32_t>(renewed_.size()); }

  /// Makes room for as many of so many bodies as are renewed at most.
  void spare(std::size_t bodies);

  /// All lists are new.
  void forget();
  /// After a saved state came back: bodies as the lists were made by, then, once those are there, what was renewed.
  void turn_back(BodyStore& bodies);
  void look_again(const BroadPhase& broad, BodyStore& bodies, const StaticShapes& shapes,
                  const kernels::KernelTable& k, WorkerPool& pool, const PairTable& table);

  std::size_t bytes() const;

 private:
  struct Renewed {  // where a body was when all lists were made
    std::uint32_t slot = 0;
    std::int32_t x = 0, y = 0;  // lattice steps
    float reach = 0;            // m
  };
  struct Place {  // along the longer side of the bodies' box
    std::uint32_t along = 0, slot = 0;
  };
  struct Scratch {  // of a job
    std::vector<std::uint32_t> owner, other, first;
    std::vector<std::uint64_t> pairs;
  };
  enum Mark : std::uint8_t { kListed = 0, kRenewed = 1, kFound = 2 };

  static void place(BodyStore& bodies, std::uint32_t slot, std::int32_t x, std::int32_t y,
                    float reach);
  void admit(const BodyStore& bodies);
  void sort_places(const BroadPhase& broad, const BodyStore& bodies);
  void search(const BroadPhase& broad, const BodyStore& bodies, const kernels::KernelTable& k,
              const PairTable& table, std::uint32_t slot, Scratch& s) const;
  void join(const PairTable& table);
  void put_pairs(PairTable& table);
  void put_singles(PairTable& table);
  void link(BodyStore& bodies, std::uint32_t slot);
  void search_all(const BroadPhase& broad, BodyStore& bodies, const StaticShapes& shapes, const kernels::KernelTable& k,
                  WorkerPool& pool, const PairTable& table);

  std::vector<std::uint32_t> found_;          // slots, ascending
  std::vector<Renewed> renewed_;              // by slot, ascending
  std::vector<std::uint32_t> linked_;         // slots that no list of the last build names
  Column<std::uint8_t> mark_;                 // by slot
  std::vector<Place> places_;                 // of renewed bodies, ascending
  std::vector<std::uint64_t> pairs_, fresh_;  // lower slot << 32 | higher one, ascending
  std::vector<Scratch> scratch_;
  std::vector<std::vector<std::uint32_t>> stale_;  // by job of find()
  std::vector<SinglePair> near_, singles_;  // of all that were found, of one
  std::vector<std::uint32_t> shapes_;
  float time_ = 0, most_ = 0;  // s; m: largest reach of a renewed body
  bool known_ = false, singles_changed_ = false;
};

}  // namespace psim
