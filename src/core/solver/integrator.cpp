// The names of the integrators, for scenes and reports.
#include "psim/integrator.h"

namespace psim {

std::string_view integrator_name(Integrator integrator) {
  switch (integrator) {
    case Integrator::verlet:
      return "verlet";
    case Integrator::euler:
      return "euler";
    case Integrator::rk4:
      return "rk4";
    case Integrator::symplectic4:
      return "symplectic4";
  }
  return "?";
}

std::optional<Integrator> parse_integrator(std::string_view name) {
  for (const Integrator integrator : kAllIntegrators) {
    if (name == integrator_name(integrator)) return integrator;
  }
  return std::nullopt;
}

}  // namespace psim
