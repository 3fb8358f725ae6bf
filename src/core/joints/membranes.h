// Joints that are membranes: a pressure pushes them to one side, and wind blows against them. docs/joints.md has the
// law.
//
//   lay_out      whenever the blocks are made: which joints are membranes,
//   prepare      once a step, for the present places of their bodies
//                and which close a ring
//   press        before the joints are solved and after the drift: half of what pressure and wind do in a substep
//
// A membrane is only what pushes. The joint that bears the push is solved as any other. O(membranes).
#pragma once

#include <cstdint>
#include <vector>

#include "base/rotor.h"
#include "base/tasks.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "psim/desc.h"
#include "psim/joint.h"
#include "views.h"

namespace psim {

/// Whether a description says something of pressure or wind.
inline bool tells_of_membrane(const JointDesc& d) {
  return d.pressure != 0 || d.wind_drag > 0 || d.wind_lift > 0 || d.area != 0;
}
/// Whether a joint is pushed by pressure or wind.
inline bool is_membrane(const JointDesc& d) {
  const bool line = d.type == JointType::distance || d.type == JointType::spring || d.type == JointType::rope;
  return (line || d.type == JointType::weld) && tells_of_membrane(d);
}

/// One end of a membrane.
struct MembraneEnd {
  std::uint32_t body = 0;  ///< the number that the solver uses
  Vec2 at;                 ///< m: the lattice point of its body; of the world: the anchor
  Vec2 arm;                ///< m: from the centre of mass to the anchor as the step begins
  double inverse_mass = 0, inverse_inertia = 0, inverse_radius = 1;
  double rate = 0;  ///< 1/kg: how fast the anchor gets if all membranes of its body push it with 1 N s

  // In the present pass.
  Vec2 off;       ///< m: the anchor, from the lattice point of the body
  Vec2 velocity;  ///< m/s, of the anchor
};

struct Membrane {
  std::uint32_t joint = 0;
  std::uint32_t member[2] = {0, 0};  ///< numbers of the bodies among those with joints
  std::uint32_t crowd[2] = {1, 1};   ///< how many membranes each body has
  std::uint32_t from = 0;            ///< the end that is at body a of the joint; the other one is at b
  bool bounds = false;               ///< the joint has an area
  std::uint32_t walk = kNoSlot;      ///< the membrane from where a search for rings came here
  MembraneEnd end[2];
  Vec2 base;            ///< m: from the lattice point of end 0 to that of end 1
  double pressure = 0;  ///< N/m, to the right of the way from end 0 to end 1
  double drag = 0, lift = 0;
  double area = 0;  ///< m^2

  // In the present pass.
  Vec2 way;       ///< m, from end 0 to end 1
  Vec2 push;      ///< N s, on each end
  Vec2 gap_push;  ///< N s, of a ring: on the end at b, and on the beginning of the next membrane, at the same body

  const MembraneEnd& first() const { return end[from]; }
  const MembraneEnd& last() const { return end[1 - from]; }
  Vec2 way_on() const { return from == 0 ? way : -1.0 * way; }  ///< from first to last
};

class Membranes {
 public:
  bool any() const { return !all_.empty(); }
  std::vector<Membrane>& all() { return all_; }
  void clear() {
    all_.clear();
    rings_.clear();
    in_rings_.clear();
  }
  /// `member`: the numbers of its ends. `from`: which of them is at body a. `bounds`: the joint has an area.
  void add(std::uint32_t joint, const std::uint32_t (&member)[2], std::uint32_t from, bool bounds);
  /// Once all are added: counts the membranes of each of so many bodies, and finds the rings.
  void lay_out(std::size_t members);

  /// Notes what blows in a step.
  void set_wind(const std::vector<Field>& fields);
  /// Adds what pressure and wind do in `time` seconds to the velocities, also to those before the kick, so that the next
  /// kick repeats nothing of it.
  void press(const kernels::BodyView& view, double time, WorkerPool& pool);

  std::size_t bytes() const;
  void release();

 private:
  void walk_from(std::uint32_t first);
  void stretch(const kernels::BodyView& view, Membrane& m, double time) const;
  void press_ring(BlockRange ring, double time);

  std::vector<Membrane> all_;            // in the order of the joints
  std::vector<std::uint32_t> crowds_;    // by member: its membranes
  std::vector<std::uint32_t> begins_;    // by member: the membrane with an area that begins there, or what is below
  std::vector<std::uint32_t> in_rings_;  // membranes, ring by ring, each in the order of its way round
  std::vector<BlockRange> rings_;        // in in_rings_
  std::vector<WindField> winds_;         // none if no membrane catches any
};

}  // namespace psim
