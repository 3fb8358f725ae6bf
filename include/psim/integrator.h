// How bodies move under smooth forces that change with place or speed: wells and drag.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "psim/api.h"

namespace psim {

/// One step of a method is one substep. Under uniform gravity and linear damping alone all of them
/// are the closed form, and the same bits. What each costs and reaches: docs/solver.md.
enum class Integrator : std::uint8_t {
  verlet,      ///< leapfrog, drift-kick-drift: order 2, symplectic, one evaluation of the forces
  euler,       ///< semi-implicit Euler: order 1, symplectic, one evaluation
  rk4,         ///< the classical Runge-Kutta method: order 4, four evaluations; loses energy
  symplectic4  ///< optimised Forest-Ruth (Omelyan, Mryglod, Folk 2002): order 4, symplectic, four
};

/// All of them.
inline constexpr Integrator kAllIntegrators[] = {Integrator::verlet, Integrator::euler, Integrator::rk4,
                                                 Integrator::symplectic4};

/// "verlet", "euler", "rk4" or "symplectic4": the words of scene files.
PSIM_API std::string_view integrator_name(Integrator integrator);

/// The reverse of integrator_name; nothing for any other text.
PSIM_API std::optional<Integrator> parse_integrator(std::string_view name);

}  // namespace psim
