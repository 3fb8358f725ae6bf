// Decides how much of a step is done, from counts alone (psim/governor.h).
#pragma once

#include <cstdint>
#include <functional>

#include "psim/governor.h"

namespace psim {

/// Work in a step, counted.
struct WorkCounts {
  std::uint64_t bodies = 0;      ///< in the columns
  std::uint64_t solved = 0;      ///< that the solver has
  std::uint64_t candidates = 0;  ///< that a step selects from; 0: dense
  std::uint64_t contacts = 0;    ///< of discs
  std::uint64_t manifolds = 0;
  std::uint64_t lanes = 0;  ///< of contacts of discs in a pass, empty ones among them
  std::uint64_t loaded_lanes =
      0;  ///< of contacts under heavy loads, in all further sweeps of a pass
  std::uint64_t touching =
      0;              ///< contacts that press, manifolds among them, at the end of the last step
  double sweeps = 0;  ///< over impacts, in a substep
  std::uint64_t shape_lanes = 0;  ///< of manifolds
  std::uint64_t writes = 0;       ///< manifolds that are written into lanes
  std::uint64_t strips = 0;
  std::uint64_t cells = 0;   ///< of the grid
  double visits = 1;         ///< of a contact, when it is found who carries much heavier bodies
  double tests = 0;          ///< of two bodies, when lists are made
  std::uint64_t near = 0;    ///< pairs of a body and a fixed shape
  std::uint64_t looks = 0;   ///< manifolds that will be looked at anew, at a guess
  std::uint64_t joints = 0;  ///< joints x sweeps
  std::uint64_t sleep_looks = 0;  ///< bodies and contacts that sleep looks at
  std::uint64_t flights = 0;      ///< fixed shapes near the ways of fast shapes, in the last step
  bool sorted = false;            ///< bodies have new slots
  bool fixed = false;             ///< there are fixed shapes or sleepers
  bool loads = false;             ///< some bodies may carry much heavier ones
  bool rough = false;             ///< friction
  bool mixed = false;             ///< bodies of several sizes fly about
  bool uneven = false;            ///< masses differ
  bool copies = false;            ///< the solver has copies of the bodies
  bool stops = false;             ///< fast shapes are stopped
};

/// The same with no more sweeps over impacts in a substep than this; 0: with as many as it takes.
inline WorkCounts with_sweeps(WorkCounts work, int most) {
  if (most != 0 && work.sweeps > most) work.sweeps = most;
  return work;
}

class Governor {
 public:
  /// Frames that a step makes up for at most.
  static constexpr int kMostFrames = StepDetail::kMostFrames;
  /// Sweeps over impacts in a substep that has no time for as many as it takes.
  static constexpr int kFewSweeps = 1;

  void set(const GovernorDesc& desc) { desc_ = desc; }
  bool on() const { return desc_.on; }
  const CostModel& costs() const { return desc_.costs; }

  /// ns that may be predicted for a frame.
  double room_ns() const { return kShare * desc_.budget_ms * 1e6; }
  /// ns of everything ahead of the substeps if lists are made, of what is left then but substeps, and of one
  /// substep.
  double ahead_ns(const WorkCounts& work) const;
  double rest_ns(const WorkCounts& work) const;
  double substep_ns(const WorkCounts& work) const;
  double look_ns(const WorkCounts& work) const;
  /// The share of contacts that press, where bodies of several sizes bounce; else 0.
  static double crowded(const WorkCounts& work);
  double lay_out(const WorkCounts& work) const;  ///< of a contact of discs
  double select(const WorkCounts& work) const;   ///< of a candidate
  /// How fast bodies move in their strips, before a step selects.
  double speeds_ns(const WorkCounts& work) const;

  /// How many times as many candidates lists for more frames have as those that were counted, and how many times as
  /// long a step contacts are selected for: so many more are there, unless most candidates are contacts already.
  struct Growth {
    double candidates = 1, time = 1;
  };
  /// How many frames a step's lists should serve, if its work is to be spread; 1: it fits into one. growth(frames).
  int horizon(const WorkCounts& work, int most_substeps, const std::function<Growth(int)>& growth = {}) const;

  struct Choice {
    bool solves = false;  ///< in this frame; else the next one is better
    int substeps = 0, frames = 1;
    int sweeps = 0;  ///< over impacts in a substep, at most; 0: as many as it takes
  };
  /// For a frame that has `left` ns for what comes after the work ahead, the `elapsed`-th of its step. No
  /// substep is longer than a frame: time that they cannot make up for is lost. Sweeps over impacts are left out
  /// where less time is lost then.
  Choice choose(const WorkCounts& work, double left, int elapsed, int horizon,
                int most_substeps) const;

 private:
  /// Of the budget: what is left is for what the model does not know.
  static constexpr double kShare = 0.75;
  int fitting(const WorkCounts& work, double ns, int most) const;
  struct Lists {
    int frames = 1;      // that they serve
    double a_frame = 0;  // ns of a step's work for each of them
  };
  Lists lists_for(const WorkCounts& work, int most_substeps, const std::function<Growth(int)>& growth) const;
  struct Offer {
    Choice choice;
    double pace = 0;  // frames made up for in each that goes by; 0: not within the budget
  };
  Offer offer(const WorkCounts& work, double left, int elapsed, int horizon, int most_substeps) const;

  GovernorDesc desc_;
};

}  // namespace psim
