#include "window/window.h"

#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string_view>

#include "output/text.h"
#include "output/user_error.h"
#include "window/gl.h"

namespace psim::view {
namespace {

[[noreturn]] void refuse(const char* what) {
  throw cli::UserError(
      fmt::format("{}: {}; without a display there are pictures only: psim-view --shot FILE.png, or by xvfb-run -a",
                  what, cli::one_line(SDL_GetError())));
}

// Where there is no display SDL would try Wayland, whose library then complains on stderr. Pictures need
// none. SDL_VIDEODRIVER of the user's wins.
void choose_driver(bool in_step) {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR"}) {
    const char* const value = std::getenv(name);
    if (value != nullptr && *value != 0) return;
  }
  SDL_SetHint(SDL_HINT_VIDEODRIVER, in_step ? "offscreen" : "x11");
}

int button_of(Uint8 button) { return button == SDL_BUTTON_LEFT ? 0 : button == SDL_BUTTON_RIGHT ? 1 : 2; }

// Whether a key that is held down acts again and again: those that step; a switch would flicker.
bool goes_on(SDL_Keycode key) { return key == SDLK_o || key == SDLK_RIGHT || key == SDLK_COMMA || key == SDLK_PERIOD; }

}  // namespace

Window::Window(int width, int height, bool in_step) : width_(width), height_(height), in_step_(in_step) {
  SDL_SetMainReady();
  choose_driver(in_step);
  if (SDL_Init(SDL_INIT_VIDEO) != 0) refuse("no window");
  const std::string_view driver = SDL_GetCurrentVideoDriver();
  if (!in_step && (driver == "offscreen" || driver == "dummy")) {
    SDL_SetError("no display was found");  // nobody would see it
    refuse("no window");
  }
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
  SDL_GL_SetAttribute(SDL_GL_DOUBLEBUFFER, 1);
  window_ = SDL_CreateWindow("psim-view", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, width, height,
                             SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE);
  if (window_ == nullptr) refuse("no window with OpenGL");
  context_ = SDL_GL_CreateContext(window_);
  if (context_ == nullptr) refuse("no OpenGL 3.3");
  waits_ = !in_step && SDL_GL_SetSwapInterval(1) == 0;
  if (in_step) SDL_GL_SetSwapInterval(0);
  SDL_GL_GetDrawableSize(window_, &width_, &height_);
  load_gl();
  begin_imgui();
}

void Window::begin_imgui() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 5;
  style.FrameRounding = 3;
  style.FramePadding = {4, 2};  // all panels fit into 800 pixels
  style.ItemSpacing = {8, 3};
  style.Colors[ImGuiCol_WindowBg].w = 0.88f;
  style.Colors[ImGuiCol_SliderGrab].w = 0.35f;  // the number under the knob can be read
  style.Colors[ImGuiCol_SliderGrabActive].w = 0.45f;
  ImGui_ImplSDL2_InitForOpenGL(window_, context_);
  ImGui_ImplOpenGL3_Init("#version 330");
}

Window::~Window() {
  if (ImGui::GetCurrentContext() != nullptr) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplSDL2_Shutdown();
    ImGui::DestroyContext();
  }
  if (context_ != nullptr) SDL_GL_DeleteContext(context_);
  if (window_ != nullptr) SDL_DestroyWindow(window_);
  SDL_Quit();
}

bool Window::read_events(Pointer& pointer, std::vector<std::string>& keys) {
  pointer.dx = pointer.dy = pointer.wheel = 0;
  for (int k = 0; k < 3; ++k) pointer.pressed[k] = pointer.released[k] = false;
  for (SDL_Event event; SDL_PollEvent(&event) != 0;) {
    ImGui_ImplSDL2_ProcessEvent(&event);
    switch (event.type) {
      case SDL_QUIT:
        return false;
      case SDL_KEYDOWN:
        if (ImGui::GetIO().WantTextInput) break;
        if (event.key.repeat != 0 && !goes_on(event.key.keysym.sym)) break;
        keys.emplace_back(SDL_GetKeyName(event.key.keysym.sym));
        break;
      case SDL_MOUSEMOTION:
        pointer.x = event.motion.x;
        pointer.y = event.motion.y;
        pointer.dx += event.motion.xrel;
        pointer.dy += event.motion.yrel;
        break;
      case SDL_MOUSEBUTTONDOWN:
        pointer.down[button_of(event.button.button)] = true;
        pointer.pressed[button_of(event.button.button)] = true;
        break;
      case SDL_MOUSEBUTTONUP:
        pointer.down[button_of(event.button.button)] = false;
        pointer.released[button_of(event.button.button)] = true;
        break;
      case SDL_MOUSEWHEEL:
        pointer.wheel += event.wheel.y;
        break;
      default:
        break;
    }
  }
  SDL_GL_GetDrawableSize(window_, &width_, &height_);
  return true;
}

void Window::begin_panels(const Pointer& pointer, bool scripted) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplSDL2_NewFrame();
  if (scripted) {  // the script's pointer, not that of the machine
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {static_cast<float>(pointer.x), static_cast<float>(pointer.y)};
    for (int k = 0; k < 3; ++k) io.MouseDown[k] = pointer.down[k];
    io.DeltaTime = 1.0f / 60;
  }
  ImGui::NewFrame();
}

bool Window::pointer_on_panel() const { return ImGui::GetIO().WantCaptureMouse; }

void Window::draw_panels() { ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData()); }

std::vector<std::uint8_t> Window::read_pixels() const {
  const auto row = static_cast<std::size_t>(width_) * 3;
  std::vector<std::uint8_t> pixels(row * static_cast<std::size_t>(height_));
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  for (std::size_t low = 0, high = static_cast<std::size_t>(height_) - 1; low < high; ++low, --high) {
    const auto from = pixels.begin() + static_cast<std::ptrdiff_t>(low * row);
    std::swap_ranges(from, from + static_cast<std::ptrdiff_t>(row),
                     pixels.begin() + static_cast<std::ptrdiff_t>(high * row));
  }
  return pixels;
}

void Window::present() {
  SDL_GL_SwapWindow(window_);
  if (waits_ || in_step_) return;
  constexpr std::uint64_t kFrameMs = 16;
  const std::uint64_t now = SDL_GetTicks64(), spent = now - last_present_;
  if (spent < kFrameMs) SDL_Delay(static_cast<Uint32>(kFrameMs - spent));
  last_present_ = SDL_GetTicks64();
}

void Window::set_title(const std::string& title) {
  if (title == title_) return;
  title_ = title;
  SDL_SetWindowTitle(window_, title.c_str());
}

}  // namespace psim::view
