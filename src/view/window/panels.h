// Dear ImGui's windows: what there is to see and to set. Reads the status, writes the view's state,
// posts commands.
#pragma once

#include <cstddef>

#include "model/frame_log.h"
#include "model/frame_times.h"
#include "model/sim_thread.h"
#include "window/scene_panel.h"
#include "window/tools.h"
#include "window/view_state.h"

namespace psim::view {

/// The frame of the picture: the newest, or one looked back at.
struct ShownFrame {
  std::uint64_t frame = 0, bodies = 0;
};

class Panels {
 public:
  Panels(SimThread& sim, ViewState& state, Tools& tools) : sim_(sim), state_(state), tools_(tools), scenes_(tools) {}

  /// Called every frame between begin_panels and draw_panels of the window.
  void show(const Status& status, const ShownFrame& shown, const FrameTimes& times, std::size_t frames_kept);

 private:
  void show_run(const Status& status, const ShownFrame& shown, const FrameTimes& times, std::size_t frames_kept);
  void show_counts(const Status& status, const ShownFrame& shown, const FrameTimes& times);
  void show_look(const Status& status);
  void show_settings(const Status& status);
  void show_tools();
  void show_help();
  void choose_collected();

  SimThread& sim_;
  ViewState& state_;
  Tools& tools_;
  ScenePanel scenes_;
  FrameLog log_;
  Settings draft_;  // of the sliders while one is held
  bool editing_ = false;
  Collect collected_;
};

}  // namespace psim::view
