// Elastic hard discs in a walled box by brute force: all pairs and walls are asked anew after every
// event, and no event is kept. Far slower than EventDriven, and so simple that it can judge it.
// Double precision; it sees no engine code.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "closed_forms.h"

namespace reference {

class TimeStepped {
 public:
  TimeStepped(double width, double height, std::vector<Disc> discs)
      : width_(width), height_(height), discs_(std::move(discs)) {}

  const std::vector<Disc>& discs() const { return discs_; }
  int collisions() const { return collisions_; }

  /// In steps of dt, each cut at every exact time of contact within it.
  void advance(double duration, double dt);

 private:
  struct Contact {
    double in = 0;
    std::size_t a = 0, b = 0;  ///< a == b: a wall
    bool sideways = false;
  };

  void step(double dt);
  bool find_before(double limit, Contact& next) const;
  static double wall_time(double x, double v, double radius, double size);
  // The smaller root of |d + u t|^2 = reach^2, in the textbook's form.
  static double pair_time(const Disc& a, const Disc& b);
  void resolve(const Contact& c);

  double width_;
  double height_;
  std::vector<Disc> discs_;
  int collisions_ = 0;
};

}  // namespace reference
