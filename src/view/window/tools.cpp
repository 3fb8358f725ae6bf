#include "window/tools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace psim::view {
namespace {

constexpr double kZoomStep = 1.15;
constexpr double kReachPixels = 8;  // how near a click must be to a body

template <class Choice, std::size_t N>
Choice next_of(Choice choice, const std::array<const char*, N>&) {
  return static_cast<Choice>((static_cast<std::size_t>(choice) + 1) % N);
}

}  // namespace

Tools::Tools(SimThread& sim, ViewState& state, std::vector<std::string> scenes)
    : sim_(sim), state_(state), scenes_(std::move(scenes)) {}

void Tools::pointer(const Pointer& p, bool captured) {
  Camera& camera = state_.camera;
  if (!captured && p.wheel != 0) camera.zoom_at(p.x, p.y, std::pow(kZoomStep, p.wheel));
  if ((p.down[1] || p.down[2]) && !captured) camera.pan(p.dx, p.dy);

  const Vec2 at = camera.to_world(p.x, p.y);
  if (p.pressed[0] && !captured) {
    working_ = true;
    last_x_ = p.x;
    last_y_ = p.y;
    press(at);
  } else if (working_ && p.down[0]) {
    hold(at, p.x, p.y);
  }
  if (working_ && (p.released[0] || !p.down[0])) {
    working_ = false;
    sim_.post([](Simulation& s) { s.let_go(); });
  }
}

void Tools::press(Vec2 at) {
  const double reach = kReachPixels / state_.camera.pixels_per_metre();
  const double wide = static_cast<double>(state_.reach);
  const double strength = static_cast<double>(state_.strength);
  state_.back = 0;
  switch (state_.tool) {
    case Tool::grab:
      sim_.post([=](Simulation& s) { s.grab(at, reach); });
      break;
    case Tool::explode:
      sim_.post([=](Simulation& s) { s.explode(at, wide, strength); });
      break;
    case Tool::well:
      sim_.post([=](Simulation& s) { s.add_well(at, strength * wide, 10 * wide); });
      break;
    case Tool::erase:
      sim_.post([=](Simulation& s) { s.erase(at, reach); });
      break;
    case Tool::spawn:
      sim_.post([=, shape = state_.spawn_shape, size = static_cast<double>(state_.size)](Simulation& s) {
        s.spawn(at, shape, size);
      });
      break;
    case Tool::wall:
      break;
  }
}

void Tools::hold(Vec2 at, double px, double py) {
  constexpr double kWallPixels = 10;
  switch (state_.tool) {
    case Tool::grab:
      sim_.post([=](Simulation& s) { s.drag(at); });
      break;
    case Tool::spawn:
    case Tool::erase:
      press(at);
      break;
    case Tool::wall:
      if (std::hypot(px - last_x_, py - last_y_) < kWallPixels) break;
      sim_.post([=, from = state_.camera.to_world(last_x_, last_y_)](Simulation& s) { s.add_wall(from, at); });
      last_x_ = px;
      last_y_ = py;
      break;
    default:
      break;
  }
}

void Tools::toggle_pause(bool paused) {
  state_.back = 0;
  sim_.post([paused](Simulation& s) { s.paused = !paused; });
}

void Tools::step_back(std::size_t frames_kept) {
  sim_.post([](Simulation& s) { s.paused = true; });
  state_.back = std::min(state_.back + 1, frames_kept > 0 ? frames_kept - 1 : 0);
}

void Tools::step_forward() {
  if (state_.back > 0) {
    --state_.back;
  } else {
    sim_.post([](Simulation& s) { s.single_step(); });
  }
}

void Tools::open_scene(std::size_t index) {
  if (index >= scenes_.size()) return;
  scene_ = index;
  sim_.post([name = scenes_[index]](Simulation& s) { s.load(name); });
}

void Tools::next_scene(int step) {
  if (scenes_.empty()) return;
  open_scene((scene_ + scenes_.size() + static_cast<std::size_t>(step)) % scenes_.size());
}

void Tools::set_scene(const std::string& name) {
  const auto at = std::ranges::find(scenes_, name);
  if (at == scenes_.end()) {
    scenes_.insert(scenes_.begin(), name);
    scene_ = 0;
  } else {
    scene_ = static_cast<std::size_t>(at - scenes_.begin());
  }
}

bool* Tools::overlay_of(std::string_view key) {
  OverlayChoice& o = state_.overlays;
  if (key == "G") return &o.grid;
  if (key == "J") return &o.joints;
  if (key == "K") return &o.contacts;
  if (key == "H") return &o.hits;
  return key == "T" ? &o.trails : nullptr;
}

bool Tools::key(std::string_view name, const Status& status, std::size_t frames_kept) {
  if (name == "Space" || name == "P") {
    toggle_pause(status.paused);
  } else if (name == "O" || name == "Right" || name == ".") {
    step_forward();
  } else if (name == ",") {
    step_back(frames_kept);
  } else if (name == "R") {
    sim_.post([](Simulation& s) { s.restart(); });
  } else if (name == "[") {
    next_scene(-1);
  } else if (name == "]") {
    next_scene(1);
  } else if (name == "C") {
    const int next = (static_cast<int>(state_.colouring) + 1) % kColouringCount;
    state_.colouring = static_cast<Colouring>(next);
  } else if (name == "F") {
    state_.fluids.style = next_of(state_.fluids.style, cli::kFluidStyleNames);
  } else if (name == "V") {
    state_.fluids.colouring = next_of(state_.fluids.colouring, cli::kFluidColouringNames);
  } else if (bool* const overlay = overlay_of(name)) {
    *overlay = !*overlay;
  } else if (name == "Tab") {
    state_.panels = !state_.panels;
  } else if (name == "Home") {
    state_.go_home = true;
  } else if (name == "F1") {
    state_.help = !state_.help;
  } else if (name == "F12") {
    state_.take_picture = true;
  } else if (name.size() == 1 && name[0] >= '1' && name[0] < '1' + kToolCount) {
    state_.tool = static_cast<Tool>(name[0] - '1');
  } else {
    return false;
  }
  return true;
}

}  // namespace psim::view
