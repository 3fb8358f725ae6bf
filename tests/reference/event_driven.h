// Event-driven hard discs in double precision: free flight between exactly computed collisions,
// no time step. Frictionless, restitution 0..1, in a walled or a periodic box (0, 0)-(width,
// height); gravity (downwards) only with walls. O(n) per event, for a few hundred discs. The oracle
// for gases; it sees no engine code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "closed_forms.h"

namespace reference {

class EventDriven {
 public:
  struct Box {
    double width = 1;
    double height = 1;
    bool periodic = false;
    double gravity = 0;  ///< m/s^2 downwards
  };

  EventDriven(Box box, double restitution, std::vector<Disc> discs);

  const std::vector<Disc>& discs() const { return discs_; }
  double time() const { return now_; }
  std::uint64_t pair_collisions() const { return pair_collisions_; }
  std::uint64_t wall_collisions() const { return wall_collisions_; }
  /// Sum over pair collisions of impulse x distance of the centres.
  double virial() const { return virial_; }

  double energy() const;
  Vec momentum() const;

  void reverse();
  void advance(double duration);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr int kNobody = -1;
  enum Wall : int { left = -2, right = -3, bottom = -4, top = -5 };

  struct Event {
    double time = kNever;
    std::size_t disc = 0;
    int partner = kNobody;  ///< index of a disc, or a Wall
  };

  void drift(double t);
  Vec nearest(Vec d) const;
  /// Time until |d + u t| = reach while closing. Gravity is common to both and drops out.
  static double time_to_meet(Vec d, Vec u, double reach);
  double time_to_pair(const Disc& a, const Disc& b) const;
  /// Smallest t >= 0 with gap + v t + a t^2 / 2 = 0 and the gap closing then.
  static double time_to_close(double gap, double v, double a);
  Event predict(std::size_t i) const;
  void predict_all();
  Event earliest() const;
  void resolve(const Event& event);

  Box box_;
  double restitution_;
  std::vector<Disc> discs_;
  std::vector<Event> next_;
  double now_ = 0;
  double horizon_ = kNever;
  double virial_ = 0;
  std::uint64_t pair_collisions_ = 0;
  std::uint64_t wall_collisions_ = 0;
  std::uint64_t events_ = 0;
};

}  // namespace reference
