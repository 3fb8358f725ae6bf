#include "window/view.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "output/text.h"
#include "output/user_error.h"
#include "picture/png_write.h"
#include "place/shape_size.h"
#include "window/scene_files.h"

namespace psim::view {
namespace {

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

View::View(const ViewOptions& options, std::unique_ptr<Simulation> simulation)
    : options_(options),
      script_(options.play.empty() ? std::vector<ScriptLine>() : load_script(options.play)),
      window_(options.width, options.height, options.lockstep()),
      sim_(std::move(simulation), options.lockstep()),
      tools_(sim_, state_, scene_names()),
      panels_(sim_, state_, tools_) {
  tools_.set_scene(options.settings.scene);
  status_ = sim_.status();
}

void View::run() {
  const std::uint64_t end = options_.after.value_or(std::numeric_limits<std::uint64_t>::max());
  for (std::uint64_t frame = 1; frame <= end; ++frame) {
    if (!read_input(frame)) break;
    if (options_.lockstep()) sim_.advance();
    draw();
    if (frame == end && !options_.shot.empty()) shots_.push_back(options_.shot);
    if (std::exchange(state_.take_picture, false)) {
      std::string name;
      do {
        name = fmt::format("psim-view-{:03}.png", ++pictures_);
      } while (std::filesystem::exists(name));
      shots_.push_back(name);
    }
    for (const std::string& path : std::exchange(shots_, {})) write_picture(path);
    window_.present();
    if (state_.quit) break;
  }
}

bool View::read_input(std::uint64_t frame) {
  keys_.clear();
  if (!window_.read_events(pointer_, keys_)) return false;
  if (!options_.play.empty()) play(frame);
  window_.begin_panels(pointer_, options_.lockstep());
  tools_.pointer(pointer_, window_.pointer_on_panel());
  for (const std::string& key : keys_) tools_.key(key, status_, history_.size());
  return true;
}

void View::play(std::uint64_t frame) {
  for (; script_at_ < script_.size() && script_[script_at_].frame <= frame; ++script_at_) {
    const ScriptLine& line = script_[script_at_];
    const auto button = static_cast<std::size_t>(line.button);
    switch (line.action) {
      case ScriptAction::key:
        if (SDL_GetKeyFromName(line.word.c_str()) == SDLK_UNKNOWN) {
          throw cli::UserError(
              fmt::format("--play {}: no key is called {}", cli::one_line(options_.play), cli::one_line(line.word)));
        }
        keys_.push_back(line.word);
        break;
      case ScriptAction::move:
        pointer_.dx += line.x - pointer_.x;
        pointer_.dy += line.y - pointer_.y;
        pointer_.x = line.x;
        pointer_.y = line.y;
        break;
      case ScriptAction::down:
        pointer_.down[button] = pointer_.pressed[button] = true;
        break;
      case ScriptAction::up:
        pointer_.down[button] = false;
        pointer_.released[button] = true;
        break;
      case ScriptAction::wheel:
        pointer_.wheel += line.x;
        break;
      case ScriptAction::shot:
        shots_.push_back(line.word);
        break;
      case ScriptAction::quit:
        state_.quit = true;
        break;
    }
  }
}

// The newest status and snapshot; what was seen of an older world is forgotten.
void View::look_at_simulation() {
  status_ = sim_.status();
  live_ = status_.still ? status_.still.get() : status_.world->latest_snapshot();
  if (live_ == nullptr) return;
  if (status_.scene_serial != seen_scene_) {
    seen_scene_ = status_.scene_serial;
    state_.go_home = true;
  }
  const bool new_world = status_.world_serial != seen_world_;
  if (new_world) {
    seen_world_ = status_.world_serial;
    state_.back = 0;
    history_.clear();
    overlays_.clear();
  }
  const bool new_frame = new_world || live_->frame != seen_frame_;
  if (new_frame) {
    seen_frame_ = live_->frame;
    seen_at_s_ = now_s();
    history_.record(*live_, status_.wells, status_.fluids);
    overlays_.note(status_);
  }
  state_.back = std::min(state_.back, history_.size() - 1);
  const Snapshot* const shown = state_.back > 0 ? &history_.at(state_.back) : live_;
  if (new_frame || shown != shown_ || status_.still) {
    shown_ = shown;
    bodies_.set(*shown, status_.catalogue);
    coloured_.reset();
  }
  if (state_.back == 0 && status_.touches && status_.touches != coloured_) {  // known of the newest frame only
    coloured_ = status_.touches;
    if (state_.colouring == Colouring::force) bodies_.set_forces(coloured_->forces);
    if (state_.colouring >= Colouring::strip) bodies_.set_groups(coloured_->groups);
  }
  if (state_.go_home) {
    state_.go_home = false;
    const bool beside = state_.panels && window_.width() > 2 * kPanelWidth;
    state_.camera.fit(home(), window_.width(), window_.height(), beside ? kPanelWidth : 0);
  }
}

// How far the picture is from the frame before to the newest.
float View::alpha() const {
  if (options_.lockstep() || status_.paused || status_.still || state_.back > 0) return 1;
  const double dt = status_.world->desc().dt / std::max(status_.speed, 1e-3);
  return static_cast<float>(std::clamp((now_s() - seen_at_s_) / dt, 0.0, 1.0));
}

// Particles of the frame that is shown.
const FluidLook* View::fluids() const {
  return (state_.back > 0 ? history_.fluids(state_.back) : status_.fluids).get();
}

void View::draw() {
  times_.interval_ms += 0.05 * (between_.lap_ms() - times_.interval_ms);
  state_.camera.resize(window_.width(), window_.height());
  Stopwatch watch;
  look_at_simulation();
  overlays_.build(status_, bodies_, state_.camera, alpha(), history_, state_.back, state_.overlays, state_.colouring);
  fluids_.build(fluids(), status_.world->desc(), state_.camera, alpha(), state_.fluids);
  if (!fluids_.parts().empty() && fluid_renderer_ == nullptr) fluid_renderer_ = std::make_unique<FluidRenderer>();
  const double prepare = watch.lap_ms();
  renderer_.upload(bodies_, state_.colouring);
  renderer_.upload(overlays_.below, overlays_.above);
  const double upload = watch.lap_ms();
  const ShownFrame shown = state_.back == 0 || shown_ == nullptr
                               ? ShownFrame{status_.frame, status_.bodies}
                               : ShownFrame{status_.first_frame + shown_->frame, bodies_.seen()};
  panels_.show(status_, shown, times_, history_.size());
  ImGui::Render();
  const double panels = watch.lap_ms();

  renderer_.clear(window_.width(), window_.height());
  renderer_.draw_below(state_.camera);
  if (fluid_renderer_ != nullptr) fluid_renderer_->draw(fluids_, state_.camera, status_.world->desc());
  renderer_.draw_bodies(state_.camera, alpha(), state_.colouring);
  renderer_.draw_above(state_.camera);
  window_.draw_panels();
  times_.gl.add(watch.lap_ms());
  times_.prepare.add(prepare);
  times_.upload.add(upload);
  times_.panels.add(panels);
  times_.last_ms = prepare + upload + panels;
  times_.all.add(times_.last_ms);
  window_.set_title(fmt::format("psim-view: {}", status_.scene->name));
}

void View::write_picture(const std::string& path) {
  cli::AtomicFile file("picture", path);
  cli::write_png(file, window_.width(), window_.height(), window_.read_pixels());
  file.commit();
}

// The world's sides, or what is in use if that is far smaller.
Bounds View::home() const {
  constexpr double kFar = std::numeric_limits<double>::infinity(), kMuchLess = 0.6;
  Bounds used{kFar, kFar, -kFar, -kFar};
  const auto include = [&used](Vec2 p, double r) {
    used = {std::min(used.xmin, p.x - r), std::min(used.ymin, p.y - r), std::max(used.xmax, p.x + r),
            std::max(used.ymax, p.y + r)};
  };
  const auto include_fluids = [&] {
    if (status_.fluids == nullptr) return;
    for (const FluidRows& rows : status_.fluids->fluids) {
      for (const Vec2& at : rows.place) {
        if (std::isfinite(at.x + at.y)) include(at, rows.spacing / 2);
      }
    }
  };
  for (const bool moving : {true, false}) {  // what stands still counts where nothing moves
    for (std::size_t row = 0; row < bodies_.size(); ++row) {
      const std::uint32_t look = bodies_.looks()[row];
      const Vec2 at = bodies_.place(row, 1);
      if (((look & kStaticBit) == 0) != moving || !std::isfinite(at.x + at.y)) continue;
      const Kind& kind = status_.catalogue->kinds()[look & kKindMask];
      include(at, kind.reach > 0 ? kind.reach : static_cast<double>(live_->radius[row]));
    }
    if (moving) include_fluids();
    if (used.xmin <= used.xmax) break;
  }
  Bounds view = status_.world->desc().bounds;
  if (!(used.xmin <= used.xmax)) return view;
  const auto fit = [](double low, double high, double& min, double& max) {
    if (high - low >= kMuchLess * (max - min)) return;
    min = std::max(min, low);
    max = std::min(max, high);
  };
  fit(used.xmin, used.xmax, view.xmin, view.xmax);
  fit(used.ymin, used.ymax, view.ymin, view.ymax);
  return view;
}

}  // namespace psim::view
