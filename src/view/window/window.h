// The window, its OpenGL context and Dear ImGui: made together, gone together.
#pragma once

#include <SDL.h>

#include <cstdint>
#include <string>
#include <vector>

#include "window/tools.h"

namespace psim::view {

class Window {
 public:
  /// Throws UserError if there is no display or no OpenGL 3.3. `in_step` leaves the clock alone.
  Window(int width, int height, bool in_step);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Reads what happened: keys go to `keys`, by SDL's names. False once the window is closed.
  bool read_events(Pointer& pointer, std::vector<std::string>& keys);
  void begin_panels(const Pointer& pointer, bool scripted);
  bool pointer_on_panel() const;
  void draw_panels();
  /// Rows from the top, 3 bytes a pixel, of what was drawn since the last present().
  std::vector<std::uint8_t> read_pixels() const;
  void present();

  void set_title(const std::string& title);
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void begin_imgui();

  SDL_Window* window_ = nullptr;
  SDL_GLContext context_ = nullptr;
  int width_ = 0, height_ = 0;
  bool waits_ = false;  // the driver waits for the screen
  bool in_step_ = false;
  std::uint64_t last_present_ = 0;
  std::string title_;
};

}  // namespace psim::view
