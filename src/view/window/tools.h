// The pointer and the keys: what they do to the view at once, and to the simulation by command.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/sim_thread.h"
#include "window/view_state.h"

namespace psim::view {

/// Where the pointer is and what it does; filled from SDL's events.
struct Pointer {
  double x = 0, y = 0;                     ///< pixels
  double dx = 0, dy = 0, wheel = 0;        ///< since the frame before
  bool down[3] = {};                       ///< left, right, middle
  bool pressed[3] = {}, released[3] = {};  ///< in this frame
};

class Tools {
 public:
  Tools(SimThread& sim, ViewState& state, std::vector<std::string> scenes);

  /// `captured`: the pointer is on a panel.
  void pointer(const Pointer& pointer, bool captured);
  /// One key, by SDL's name for it. False if it means nothing here.
  bool key(std::string_view name, const Status& status, std::size_t frames_kept);

  const std::vector<std::string>& scenes() const { return scenes_; }
  void next_scene(int step);
  void open_scene(std::size_t index);
  std::size_t scene_index() const { return scene_; }
  void set_scene(const std::string& name);
  void toggle_pause(bool paused);
  void step_back(std::size_t frames_kept);
  void step_forward();

 private:
  bool* overlay_of(std::string_view key);
  void press(Vec2 at);
  void hold(Vec2 at, double px, double py);

  SimThread& sim_;
  ViewState& state_;
  std::vector<std::string> scenes_;
  std::size_t scene_ = 0;
  bool working_ = false;            // the left button went down on the world
  double last_x_ = 0, last_y_ = 0;  // pixels: the end of the wall that is drawn
};

}  // namespace psim::view
