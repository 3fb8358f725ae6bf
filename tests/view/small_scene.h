// A world for the viewer's tests, and what it tells.
#pragma once

#include <cstdint>
#include <optional>

#include "model/simulation.h"

namespace psim::view {

// Three discs at rest on a floor, far apart, and a box.
inline Scene small_scene() {
  Scene scene;
  scene.name = "small";
  scene.world.bounds = {-20, -10, 20, 30};
  for (const double x : {-6.0, 0.0, 6.0}) {
    BodyDesc body;
    body.shape = DiscShape{1};
    body.position = {x, -9};
    scene.bodies.push_back(body);
  }
  BodyDesc box;
  box.shape = BoxShape{2, 1};
  box.position = {12, -9.5};
  box.material.density = 3;
  scene.bodies.push_back(box);
  return scene;
}

inline Simulation make_simulation() { return {small_scene(), best_isa(), 1}; }

inline Status told(Simulation& simulation) {
  Status status;
  simulation.tell(status);
  return status;
}

inline std::optional<BodyState> body(Simulation& simulation, std::uint32_t index) {
  const Status status = told(simulation);
  return status.world->body(status.world->id_of(index));
}

}  // namespace psim::view
