// The work of a step in counts, which the governor turns into time. No clock is read.
#pragma once

#include <cstdint>

namespace psim {

/// A count as a factor of a cost.
template <class Count>
constexpr double n(Count count) {
  return static_cast<double>(count);
}

/// Moving bodies other than discs, and their manifolds.
struct ManifoldCounts {
  std::uint64_t pairs = 0;   ///< manifolds
  std::uint64_t lanes = 0;   ///< of manifolds in a pass of the solver
  std::uint64_t writes = 0;  ///< manifolds that are written into lanes
  std::uint64_t looks = 0;   ///< manifolds that will be looked at anew, at a guess
};

/// What making new lists goes through.
struct ListCounts {
  std::uint64_t candidates = 0;  ///< that a step selects from; 0: persistent lists
  std::uint64_t strips = 0;
  std::uint64_t cells = 0;  ///< of the grid
  double visits = 1;        ///< how often a contact is looked at to find who carries much heavier bodies
  double tests = 0;         ///< pairs of bodies that are looked at
  std::uint64_t near = 0;   ///< pairs of a body and a fixed shape
};

/// What is so in the world, or in this step.
struct WorkTraits {
  bool sorted = false;      ///< bodies have new slots
  bool fixed = false;       ///< there are fixed shapes or sleepers
  bool loads = false;       ///< some bodies may carry much heavier ones
  bool rough = false;       ///< friction
  bool mixed = false;       ///< bodies of several sizes fly about
  bool uneven = false;      ///< masses differ
  bool copies = false;      ///< the solver has copies of the bodies
  bool stops = false;       ///< fast shapes are stopped
  bool long_lists = false;  ///< the lists of this step serve several frames
};

struct WorkCounts {
  std::uint64_t bodies = 0;        ///< in the columns
  std::uint64_t solved = 0;        ///< that the solver has
  std::uint64_t contacts = 0;      ///< of discs
  std::uint64_t lanes = 0;         ///< of contacts of discs in a pass, empty ones among them
  std::uint64_t loaded_lanes = 0;  ///< of contacts under heavy loads, in all further sweeps of a pass
  std::uint64_t touching = 0;      ///< contacts that press, manifolds among them, at the end of the last step
  double sweeps = 0;               ///< over impacts, in a substep
  std::uint64_t joints = 0;        ///< joints x sweeps
  std::uint64_t sleep_looks = 0;   ///< bodies and contacts that sleep looks at
  std::uint64_t flights = 0;       ///< fixed shapes near the ways of fast shapes, in the last step
  ManifoldCounts manifolds;
  ListCounts lists;
  WorkTraits has;
};

/// The same with no more sweeps over impacts in a substep than `most`; 0: with as many as it takes.
inline WorkCounts with_sweeps(WorkCounts work, int most) {
  if (most != 0 && work.sweeps > most) work.sweeps = most;
  return work;
}

struct StepContext;

/// Counts the work of the present step.
WorkCounts count_work(const StepContext& c);

}  // namespace psim
