// The bodies that the solver works on. In dense scenes these are the columns of the world. Where few bodies meet,
// the linked ones (those that may touch something) are copied into columns of their own, so that the passes work
// in a small memory again and again; afterwards they are copied back. The arithmetic is the same either way, and
// so are the bits.
#pragma once

#include <cstdint>
#include <vector>

#include "base/column.h"
#include "base/tasks.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "lists/pair_table.h"

namespace psim {

class SolverBodies {
 public:
  template <class A>
  void describe(A& a);  ///< for saved states

  explicit SolverBodies(MemoryMeter& meter)
      : number_(meter),
        slot_(meter),
        pos_(meter),
        vel_(meter),
        disp_(meter),
        vel0_(meter),
        spin_(meter),
        spin0_(meter),
        event_time_(meter),
        linked_(meter) {}

  /// Chooses the bodies for the lists of `table`: copies of the linked ones, numbered in the order of their slots, if
  /// `compact` and there are few enough; else all bodies as they stand. `extra` records beyond them stay at rest for
  /// padding lanes.
  void choose(BodyStore& bodies, const PairTable& table, bool compact, bool impacts, WorkerPool& pool);

  /// Makes room for copies of so many bodies.
  void spare(std::size_t bodies, bool turning, bool impacts);

  /// Copies places and motion in before the solver, and motion out after it. Does nothing if not compact.
  void load(const BodyStore& bodies, WorkerPool& pool);
  void store(BodyStore& bodies, WorkerPool& pool) const;

  /// The number that the solver uses for a slot.
  std::uint32_t number(std::uint32_t slot) const { return compact_ ? number_[slot] : slot; }
  /// The slot of a number of the solver.
  std::uint32_t slot(std::uint32_t number) const { return compact_ ? slot_[number] : number; }
  std::uint32_t count() const { return count_; }
  std::uint32_t blocks() const { return (count_ + kernels::kBlock - 1) / kernels::kBlock; }
  /// The first of the resting records for padding lanes; each strip has two.
  std::uint32_t dummies() const { return blocks() * kernels::kBlock; }
  bool compact() const { return compact_; }

  /// Gives the columns of rotation or of impact times back where they are not wanted any more.
  void forget(bool rotation, bool impacts);
  std::size_t rotation_bytes() const { return spin_.bytes() + spin0_.bytes(); }
  std::size_t impact_bytes() const { return event_time_.bytes(); }

  kernels::BodyView view(BodyStore& bodies);

 private:
  template <bool kTurns>
  void load_range(const BodyStore& bodies, BlockRange range);
  template <bool kTurns>
  void store_range(BodyStore& bodies, BlockRange range) const;
  void take_all(BodyStore& bodies, std::size_t strips, bool impacts);
  void make_room(std::size_t all, bool turning, bool impacts);
  // The columns are missing if the first body that turns came after the copies were chosen.
  bool turns(const BodyStore& b) const { return !b.rim_speed.empty() && !spin_.empty(); }
  void count_linked(const BodyStore& bodies, const PairTable& table, WorkerPool& pool);

  bool compact_ = false;
  std::uint32_t count_ = 0;
  Column<std::uint32_t> number_;  ///< by slot
  Column<std::uint32_t> slot_;    ///< by number
  Column<std::int32_t> pos_;
  Column<float> vel_, disp_, vel0_, spin_, spin0_, event_time_;
  Column<std::uint8_t> linked_;
  std::vector<std::uint32_t> strip_begin_;
};

}  // namespace psim
