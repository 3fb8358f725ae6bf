// The bodies that the solver works on. In dense scenes these are the world's columns themselves.
// In loose ones, where few bodies meet, the linked ones are copied into columns of their own, side
// by side, so that the passes touch a small memory again and again; afterwards they are copied back.
// The arithmetic is the same either way, so the bits are.
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "column.h"
#include "pair_table.h"
#include "tasks.h"
#include "worker_pool.h"

namespace psim {

class SolverBodies {
  friend struct Image;

 public:
  explicit SolverBodies(MemoryMeter& meter)
      : number_(meter), slot_(meter), pos_(meter), vel_(meter), disp_(meter), vel0_(meter),
        spin_(meter), spin0_(meter), event_time_(meter), linked_(meter) {}

  /// Chooses the bodies for the lists of `table`: the linked ones, numbered by slot (`compact`, if
  /// they are few enough), or all as they stand. `extra` records beyond them are kept at rest for padding lanes.
  void choose(BodyStore& bodies, const PairTable& table, bool compact, bool impacts,
              WorkerPool& pool);

  /// Makes room for copies of so many bodies to come.
  void spare(std::size_t bodies, bool turning, bool impacts);

  /// Copies places and motion in; after the solver, motion back out. Nothing if not compact.
  void load(const BodyStore& bodies, WorkerPool& pool);
  void store(BodyStore& bodies, WorkerPool& pool) const;

  /// The solver's number of a slot.
  std::uint32_t number(std::uint32_t slot) const { return compact_ ? number_[slot] : slot; }
  /// The slot of a solver's number.
  std::uint32_t slot(std::uint32_t number) const { return compact_ ? slot_[number] : number; }
  std::uint32_t count() const { return count_; }
  std::uint32_t blocks() const { return (count_ + kernels::kBlock - 1) / kernels::kBlock; }
  /// First of the resting records for padding, two a strip.
  std::uint32_t dummies() const { return blocks() * kernels::kBlock; }
  bool compact() const { return compact_; }

  /// Gives back what holds rotation or times of impact, where they are not wanted any more.
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
  // Not yet where the first body that turns came after the copies were chosen.
  bool turns(const BodyStore& b) const { return !b.spin.empty() && !spin_.empty(); }
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
