// Moves the columns of bodies to a new order: each has another half, which is filled piece by piece and then swapped in.
#pragma once

#include "bodies/surroundings.h"

namespace psim {

class BodyMover {
 public:
  explicit BodyMover(const Surroundings& s) : b_(s.bodies), pool_(s.pool), meter_(s.memory) {}

  static constexpr std::size_t kPiece = 4096;  ///< bodies, a multiple of the block

  /// Fills slots [begin, end): slot k gets the body that lies in slot from[k].
  void move(const std::uint32_t* from, bool mixed_radii, std::size_t begin, std::size_t end);
  /// The columns change. `count` bodies are left, the others were dead.
  void finish(bool mixed_radii, std::uint32_t count);

  void spare(std::size_t slots) {
    pos_.reserve(2 * slots);
    vel_.reserve(2 * slots);
    disp_.reserve(2 * slots);
  }
  /// Gives back the other halves of radii or rotation if they are not needed any more.
  void forget(bool radii, bool rotation) {
    if (radii) radius_.release();
    if (rotation) give_back(rim_speed_, angle_);
  }
  std::size_t radii_bytes() const { return radius_.bytes(); }
  std::size_t rotation_bytes() const { return rim_speed_.bytes() + angle_.bytes(); }

 private:
  template <class Each>
  void each_column(bool radii, const Each& each);
  template <bool kRadii, bool kTurns>
  void gather(const BodyStore& b, const std::uint32_t* from, std::size_t begin, std::size_t end);

  BodyStore& b_;
  WorkerPool& pool_;
  MemoryMeter& meter_;
  Column<std::int32_t> pos_{meter_};
  Column<float> vel_{meter_}, disp_{meter_}, radius_{meter_}, reach_{meter_}, rim_speed_{meter_};
  Column<std::uint32_t> id_{meter_};
  Column<double> angle_{meter_};
};

}  // namespace psim
