// What the user has chosen to see and to do: written by keys, panels and tools, read by drawing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "model/body_columns.h"
#include "model/camera.h"
#include "model/fluid_drawing.h"
#include "window/overlays.h"

namespace psim::view {

enum class Tool : std::uint8_t { grab, spawn, explode, well, wall, erase };
inline constexpr const char* kToolNames[] = {"grab", "spawn", "explode", "well", "wall", "erase"};
inline constexpr int kToolCount = 6;

inline constexpr int kPanelWidth = 330;  // pixels, with its margins

struct ViewState {
  Camera camera;
  Colouring colouring = Colouring::speed;
  OverlayChoice overlays;
  FluidChoice fluids;
  bool panels = true, help = false;
  bool go_home = true;  ///< show the whole scene
  bool take_picture = false;
  bool quit = false;
  std::size_t back = 0;  ///< frames looked back; 0: live

  Tool tool = Tool::grab;
  SpawnShape spawn_shape = SpawnShape::disc;
  float size = 0.5f;    ///< metres: radius of what is spawned
  float reach = 10;     ///< metres: of explosions and wells
  float strength = 30;  ///< N s/m: of explosions; m/s^2 at its edge: of wells
};

}  // namespace psim::view
