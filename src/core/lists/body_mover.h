// Moves the columns of bodies to a new order: each has another half, which is filled piece by piece and then swapped in.
#pragma once

#include "bodies/surroundings.h"

namespace psim {

class BodyMover {
 public:
  explicit BodyMover(const Surroundings& s) : s_(s), b_(s.bodies) {}

  static constexpr std::size_t kPiece = 4096;  ///< bodies, a multiple of the block

  /// Fills slots [begin, end): slot k gets the body that lies in slot from[k].
  void move(const std::uint32_t* from, bool mixed_radii, std::size_t begin, std::size_t end);
  /// The columns change. `count` bodies are left, the others were dead.
  void finish(bool mixed_radii, std::uint32_t count);

  void spare(std::size_t slots) { keep_if(true, 2 * slots, pos_, vel_, disp_); }
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
  void gather(const std::uint32_t* from, std::size_t begin, std::size_t end);

  const Surroundings s_;
  BodyStore& b_;
  Column<std::int32_t> pos_{s_.memory};
  Column<float> vel_{s_.memory}, disp_{s_.memory}, radius_{s_.memory}, reach_{s_.memory}, rim_speed_{s_.memory};
  Column<std::uint32_t> id_{s_.memory};
  Column<double> angle_{s_.memory};
};

}  // namespace psim
