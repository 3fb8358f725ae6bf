// One picture after the other: input -> commands -> simulation -> snapshot -> columns and lines ->
// OpenGL.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "model/body_columns.h"
#include "model/frame_times.h"
#include "model/history.h"
#include "model/input_script.h"
#include "model/sim_thread.h"
#include "window/fluid_renderer.h"
#include "window/overlays.h"
#include "window/panels.h"
#include "window/renderer.h"
#include "window/tools.h"
#include "window/view_options.h"
#include "window/window.h"

namespace psim::view {

class View {
 public:
  /// Opens the window. Throws UserError.
  View(const ViewOptions& options, std::unique_ptr<Simulation> simulation);

  /// Until the window is closed, or as long as the options say.
  void run();
  const FrameTimes& times() const { return times_; }

 private:
  bool read_input(std::uint64_t frame);
  void play(std::uint64_t frame);
  void look_at_simulation();
  float alpha() const;
  const FluidLook* fluids() const;
  void draw();
  void write_picture(const std::string& path);
  Bounds home() const;

  const ViewOptions options_;
  std::vector<ScriptLine> script_;
  std::size_t script_at_ = 0;
  Window window_;
  Renderer renderer_;
  SimThread sim_;
  ViewState state_;
  Tools tools_;
  Panels panels_;

  Pointer pointer_;
  std::vector<std::string> keys_, shots_;
  Status status_;
  const Snapshot* live_ = nullptr;  // of status_
  std::uint64_t seen_frame_ = ~std::uint64_t{0}, seen_world_ = 0, seen_scene_ = 0;
  const Snapshot* shown_ = nullptr;
  std::shared_ptr<const TouchLists> coloured_;  // whose forces the bodies have
  double seen_at_s_ = 0;                        // when the newest frame came
  BodyColumns bodies_;
  History history_;
  Overlays overlays_;
  FluidDrawing fluids_;
  std::unique_ptr<FluidRenderer> fluid_renderer_;  // made for the first world with fluids
  FrameTimes times_;
  Stopwatch between_;
  int pictures_ = 0;
};

}  // namespace psim::view
