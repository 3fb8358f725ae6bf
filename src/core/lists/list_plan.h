// Decides how new neighbour lists are made: for how long, with which margins, and whether each step selects its pairs
// from them. In: a sample of the bodies' speeds and radii, the density of the last lists. Out: a ListPlan.
#pragma once

#include <cstdint>

#include "bodies/body_store.h"
#include "lists/broad_phase.h"
#include "psim/desc.h"

namespace psim {

/// How lists are kept (docs/step.md, "Two ways of keeping lists").
enum class ListMode : std::uint8_t {
  persistent,          ///< bodies rest or creep: the candidates are the contacts while the lists last
  selected_each_step,  ///< bodies fly: each step selects the pairs that can meet in it
  one_step,            ///< the same, and the lists serve one step alone
};

/// What the lists must know of the world.
struct ListSettings {
  const WorldDesc* desc = nullptr;
  const BroadPhase* broad = nullptr;
  float least_radius = 0;    ///< m, of all moving bodies
  bool uneven = false;       ///< masses differ: a heavy body may throw a light one
  bool restitution = false;  ///< impacts may speed bodies up
  bool mixed_radii = false;
  bool link_all = false;    ///< every body takes substeps (fields)
  bool governed = false;    ///< a governor counts how many bodies each is looked at with
  bool makes_room = false;  ///< more candidates than in the last lists are to be expected
  bool selected = false;    ///< the last lists were selected from in each step,
  double frames = 0;        ///< and were made for so many frames
};

struct ListPlan {
  ListMode mode = ListMode::persistent;
  double outer = 0;  ///< m: a typical distance up to which two bodies are candidates
  kernels::ReachParams margin;
  double frames = 0;      ///< that lists with a selection are made for; 0: one step, looking ahead
  float ahead = 0;        ///< s: not 0 for lists of one step, see BroadPhaseParams
  double speed = 0;       ///< m/s: root mean square of the sample about its mean
  double impacts = 0;     ///< 1/s: impacts of a body, if all were in flight
  double crowding = 0.1;  ///< 0.1 to 1: how likely one impact leads to another within a step
};

/// Plans lists for steps of dt seconds.
ListPlan plan_lists(const BodyStore& bodies, const ListSettings& world, double dt);

/// How far impacts within a step may move a body, m, at such a speed: little in a thin gas of equals, more where discs
/// are close (`close`, 0 to 1), much where a heavy body meets a light one.
double impact_slack(const ListSettings& world, double speed, double close, double dt);

}  // namespace psim
