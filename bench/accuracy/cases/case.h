// A case: a scene, how it is watched, and the quantities that are held against a truth.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engines/engine.h"
#include "run.h"

namespace psim::accuracy {

/// What psim's error must stay below with so many substeps of 1/60 s.
struct Limit {
  int substeps = 4;
  double error = 0;
};

/// One error that a case yields, a diagram of its own.
struct Quantity {
  std::string name;  ///< `case` in the CSV
  std::string unit;
  std::string reference;  ///< where the truth comes from
  std::vector<Limit> limits;
};

struct Case {
  std::string name;
  std::string shows;
  std::vector<Quantity> quantities;
  Scale scale = Scale::small;
  /// Also other instruction sets and thread counts: the same errors, other times.
  bool machine_variants = true;
  double timed_seconds = 2;  ///< of the scene's beginning
  std::function<Scene()> scene;
  /// Drives the run to its end; one error a quantity, in their order.
  std::function<std::vector<double>(Run&)> measure;
};

std::vector<Case> flight_cases(Effort effort);
std::vector<Case> bounce_cases(Effort effort);
std::vector<Case> impact_cases(Effort effort);
std::vector<Case> friction_cases(Effort effort);
std::vector<Case> orbit_cases(Effort effort);
std::vector<Case> gas_cases(Effort effort);
std::vector<Case> fluid_cases(Effort effort);
std::vector<Case> cloud_cases(Effort effort);
std::vector<Case> rest_cases(Effort effort);
std::vector<Case> stack_cases(Effort effort);
std::vector<Case> box_cases(Effort effort);
std::vector<Case> joint_cases(Effort effort);
std::vector<Case> weight_cases(Effort effort);
std::vector<Case> elastic_cases(Effort effort);
std::vector<Case> stand_cases(Effort effort);
std::vector<Case> terrain_cases(Effort effort);
std::vector<Case> link_cases(Effort effort);
std::vector<Case> structure_cases(Effort effort);

std::vector<Case> all_cases(Effort effort);

}  // namespace psim::accuracy
