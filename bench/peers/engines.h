// The engines that are compared: those of the accuracy laboratory, and two of three dimensions held
// to a plane.
#pragma once

#include <string>
#include <vector>

#include "engines/engine.h"

namespace psim::peers {

using accuracy::Engine;
using accuracy::Setting;

Engine bullet_engine();
Engine ode_engine();

/// All of them, psim first, those not built in included.
std::vector<Engine> all_engines();

/// A point of an engine's curve.
struct NamedSetting {
  std::string name;
  Setting setting;
  /// What the engine's documentation tells its users to take; of psim and Chipmunk several.
  bool recommended = false;
};

/// From cheap to dear, those that its documentation recommends among them.
std::vector<NamedSetting> settings_of(const Engine& engine);

}  // namespace psim::peers
