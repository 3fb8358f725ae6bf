#include <iterator>

#include "cases/case.h"

namespace psim::accuracy {

std::vector<Case> all_cases(Effort effort) {
  std::vector<Case> cases;
  for (const auto family : {flight_cases, bounce_cases, impact_cases, friction_cases, orbit_cases, gas_cases,
                            fluid_cases, cloud_cases, rest_cases, stack_cases, box_cases, joint_cases, weight_cases,
                            elastic_cases, stand_cases, terrain_cases, link_cases, structure_cases}) {
    std::vector<Case> made = family(effort);
    std::move(made.begin(), made.end(), std::back_inserter(cases));
  }
  return cases;
}

}  // namespace psim::accuracy
