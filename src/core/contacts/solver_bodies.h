// The bodies that the solver works on. In dense scenes these are the columns of the world. Where few bodies meet,
// the linked ones (those that may touch something) are copied into columns of their own, so that the passes work
// in a small memory again and again; afterwards they are copied back. The arithmetic is the same either way, and
// so are the bits.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "base/tasks.h"
#include "bodies/surroundings.h"
#include "lists/pair_table.h"

namespace psim {

class SolverBodies {
 public:
  auto fields() { return std::tie(count_, compact_); }  ///< for saved states

  explicit SolverBodies(const Surroundings& s) : b_(s.bodies), pool_(s.pool), meter_(s.memory) {}

  /// Chooses the bodies for the lists of `table`: copies of the linked ones, numbered in the order of their slots, if
  /// `compact` and there are few enough; else all bodies as they stand. Two records a strip beyond them stay at rest,
  /// for padding lanes.
  void choose(const PairTable& table, bool compact, bool impacts);

  /// Makes room for copies of so many bodies.
  void spare(std::size_t bodies, bool turning, bool impacts) {
    number_.reserve(kernels::round_up_block(bodies));
    make_room(bodies, bodies, turning, impacts);
  }

  /// Copies places and motion in before the solver, and motion out after it. Does nothing if not compact.
  void load();
  void store() const;

  /// The number that the solver uses for a slot.
  std::uint32_t number(std::uint32_t slot) const { return compact_ ? number_[slot] : slot; }
  /// The slot of a number of the solver.
  std::uint32_t slot(std::uint32_t number) const { return compact_ ? slot_[number] : number; }
  std::uint32_t count() const { return count_; }
  std::uint32_t blocks() const { return (count_ + kernels::kBlock - 1) / kernels::kBlock; }
  /// The first of the resting records for padding lanes; each strip has two.
  std::uint32_t dummies() const { return blocks() * kernels::kBlock; }
  std::uint32_t dummies_of(std::size_t strip) const { return dummies() + 2 * static_cast<std::uint32_t>(strip); }
  bool compact() const { return compact_; }

  /// Gives the columns of rotation or of impact times back where they are not wanted any more.
  void forget(bool rotation, bool impacts) {
    if (rotation) give_back(rim_speed_, rim_speed0_);
    if (impacts) event_time_.release();
    if (rotation || impacts) rim_way_.release();
  }
  std::size_t rotation_bytes() const { return rim_speed_.bytes() + rim_speed0_.bytes(); }
  std::size_t impact_bytes() const { return event_time_.bytes() + rim_way_.bytes(); }

  kernels::BodyView view();

 private:
  template <class Each>
  void each_copy(const Each& each) const;
  void take_all(std::size_t strips, bool impacts);
  void make_room(std::size_t bodies, std::size_t all, bool turning, bool impacts);
  // The columns are missing if the first body that turns came after the copies were chosen.
  bool turns() const { return !b_.rim_speed.empty() && !rim_speed_.empty(); }

  BodyStore& b_;
  WorkerPool& pool_;
  MemoryMeter& meter_;
  bool compact_ = false;
  std::uint32_t count_ = 0;
  Column<std::uint32_t> number_{meter_};  ///< by slot
  Column<std::uint32_t> slot_{meter_};    ///< by number
  Column<std::int32_t> pos_{meter_};
  Column<float> vel_{meter_}, disp_{meter_}, vel0_{meter_}, rim_speed_{meter_}, rim_speed0_{meter_},
      event_time_{meter_}, rim_way_{meter_};
  Column<std::uint8_t> linked_{meter_};
  std::vector<std::uint32_t> strip_begin_;  ///< by strip: the number of its first linked body
};

}  // namespace psim
