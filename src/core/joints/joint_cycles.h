// Cycles: the steps of their own in which swept joints go through a substep when their loads are large. The bodies are
// copied into columns of their own for that, in the order of JointStore::bodies().
#pragma once

#include <cstdint>

#include "base/column.h"
#include "block_layout.h"
#include "views.h"

namespace psim {

struct JointCycles {
  explicit JointCycles(MemoryMeter& memory)
      : vel(memory),
        vel0(memory),
        disp(memory),
        acc(memory),
        start(memory),
        after(memory),
        arm_change(memory),
        rim_speed(memory),
        rim_speed0(memory),
        linked(memory) {}

  static constexpr std::uint32_t kMost = 12;

  std::uint32_t count = 1;   ///< cycles of a substep; 1: the sweeps work on the bodies of the solver
  std::uint32_t blocks = 0;  ///< of the columns; one more block has the resting records
  float scale = 1;           ///< the length of a cycle, of one in the step before
  float warm = 1;            ///< what the next warm start multiplies impulses with
  Column<float> vel, vel0, disp, acc;
  Column<float> start;       ///< m: `disp` as the substep begins
  Column<float> after;       ///< m/s: added to the velocities after the drift
  Column<float> arm_change;  ///< 0, as the speeds of rims are: joints at the centres turn nobody
  Column<float> rim_speed, rim_speed0;
  Column<std::uint8_t> linked;

  bool on() const { return count > 1; }
  /// Makes room for some bodies. All records but the resting ones are set by the cycles.
  void make_room(std::size_t bodies);
  std::size_t bytes() const {
    return vel.bytes() + vel0.bytes() + disp.bytes() + acc.bytes() + start.bytes() + after.bytes() +
           arm_change.bytes() + rim_speed.bytes() + rim_speed0.bytes() + linked.bytes();
  }
  void release() {
    give_back(vel, vel0, disp, acc, start, after, arm_change, rim_speed, rim_speed0, linked);
    count = 1;
    scale = warm = 1;
  }
  kernels::BodyView view(bool accelerated) {
    kernels::BodyView v;
    v.vel = vel.data(), v.vel0 = vel0.data(), v.disp = disp.data();
    v.acc = accelerated ? acc.data() : nullptr;
    v.rim_speed = rim_speed.data(), v.rim_speed0 = rim_speed0.data();
    v.arm_change = arm_change.data();
    v.linked = linked.data();
    return v;
  }
};

}  // namespace psim
