#include "window/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <thread>

#include "output/text.h"
#include "window/frame_graph.h"

namespace psim::view {
namespace {

constexpr float kWidth = static_cast<float>(kPanelWidth - 20);

void text(const std::string& line) { ImGui::TextUnformatted(line.c_str()); }

template <class Choice, std::size_t N>
void choose(const char* label, Choice& choice, const char* const (&names)[N]) {
  int index = static_cast<int>(choice);
  if (ImGui::Combo(label, &index, names, static_cast<int>(N))) choice = static_cast<Choice>(index);
}

template <class Choice, std::size_t N>
void choose(const char* label, Choice& choice, const std::array<const char*, N>& names) {
  int index = static_cast<int>(choice);
  if (ImGui::Combo(label, &index, names.data(), static_cast<int>(N))) choice = static_cast<Choice>(index);
}

// True once the slider was let go with a new value.
bool slider(const char* label, double& value, double low, double high, const char* format, bool& held,
            ImGuiSliderFlags flags = 0) {
  auto v = static_cast<float>(value);
  if (ImGui::SliderFloat(label, &v, static_cast<float>(low), static_cast<float>(high), format, flags)) {
    value = static_cast<double>(v);
  }
  held = held || ImGui::IsItemActive();
  return ImGui::IsItemDeactivatedAfterEdit();
}

}  // namespace

void Panels::show(const Status& status, const ShownFrame& shown, const FrameTimes& times, std::size_t frames_kept) {
  log_.note(status);
  if (state_.panels) {
    ImGui::SetNextWindowPos({10, 10}, ImGuiCond_Once);
    ImGui::SetNextWindowSize({kWidth, 0}, ImGuiCond_Always);
    ImGui::Begin("psim", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::PushItemWidth(0.58f * kWidth);
    show_run(status, shown, times, frames_kept);
    if (ImGui::CollapsingHeader("frame time", ImGuiTreeNodeFlags_DefaultOpen)) {
      draw_frame_graph(log_, shown.frame, 1000 * status.world->desc().dt);
    }
    show_tools();
    show_look(status);
    show_settings(status);
    ImGui::PopItemWidth();
    ImGui::End();
  }
  if (state_.help) show_help();
  choose_collected();
}

// All of it of the frame that is shown.
void Panels::show_counts(const Status& status, const ShownFrame& shown, const FrameTimes& times) {
  const FrameValues* const values = log_.find(shown.frame);
  const StepReport* const step = values != nullptr && values->step ? &*values->step : nullptr;
  const auto count = [step](std::uint64_t StepReport::*which) {
    return step != nullptr ? cli::grouped(step->*which) : "-";
  };
  text(fmt::format("{} bodies, {} awake, {} joints", cli::grouped(shown.bodies), count(&StepReport::awake),
                   cli::grouped(status.joints->size())));
  if (status.fluids) text(fmt::format("{} particles", cli::grouped(status.fluids->particles)));
  text(fmt::format("{} pairs, {} contacts", count(&StepReport::pairs), count(&StepReport::contacts)));
  const double seconds = static_cast<double>(shown.frame) * status.world->desc().dt;
  text(fmt::format("frame {}, {:.2f} s{}", shown.frame, seconds,
                   state_.back > 0 ? fmt::format(", {} back", status.frame - shown.frame) : ""));
  const FrameValues* const hashed = log_.hashed(shown.frame);
  text(hashed == nullptr ? "hash -"
                         : fmt::format("hash {}{}", cli::hash_text(*hashed->hash),
                                       hashed == values ? "" : fmt::format(" ({})", hashed->frame)));
  text(fmt::format("step {} ms, picture {:.2f} ms, {:.0f} fps",
                   step != nullptr ? fmt::format("{:.2f}", step->total_ms) : "-", times.last_ms,
                   times.interval_ms > 0 ? 1000 / times.interval_ms : 0));
}

void Panels::show_run(const Status& status, const ShownFrame& shown, const FrameTimes& times, std::size_t frames_kept) {
  scenes_.show(status);
  show_counts(status, shown, times);
  if (ImGui::Button(status.paused ? "run" : "pause")) tools_.toggle_pause(status.paused);
  ImGui::SameLine();
  if (ImGui::Button("<")) tools_.step_back(frames_kept);
  ImGui::SameLine();
  if (ImGui::Button(">")) tools_.step_forward();
  ImGui::SameLine();
  if (ImGui::Button("restart")) sim_.post([](Simulation& s) { s.restart(); });
  ImGui::SameLine();
  if (ImGui::Button("help")) state_.help = !state_.help;
  auto speed = static_cast<float>(status.speed);
  if (ImGui::SliderFloat("speed", &speed, 0.05f, 4, "%.2f", ImGuiSliderFlags_Logarithmic)) {
    sim_.post([speed](Simulation& s) { s.speed = static_cast<double>(speed); });
  }
  if (!status.message.empty()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled("%s", status.message.c_str());
    ImGui::PopTextWrapPos();
  }
}

void Panels::show_look(const Status& status) {
  if (!ImGui::CollapsingHeader("look", ImGuiTreeNodeFlags_DefaultOpen)) return;
  choose("colour", state_.colouring, kColouringNames);
  if (status.fluids) {
    choose("fluids", state_.fluids.style, cli::kFluidStyleNames);
    choose("fluid colour", state_.fluids.colouring, cli::kFluidColouringNames);
  }
  OverlayChoice& o = state_.overlays;
  ImGui::Checkbox("grid", &o.grid);
  ImGui::SameLine(0.5f * kWidth);
  ImGui::Checkbox("joints", &o.joints);
  ImGui::Checkbox("contacts", &o.contacts);
  ImGui::SameLine(0.5f * kWidth);
  ImGui::Checkbox("hits", &o.hits);
  ImGui::Checkbox("trails", &o.trails);
  ImGui::SameLine(0.5f * kWidth);
  if (ImGui::Button("home")) state_.go_home = true;
}

void Panels::show_settings(const Status& status) {
  if (!ImGui::CollapsingHeader("settings", ImGuiTreeNodeFlags_DefaultOpen)) return;
  if (!editing_) draft_ = status.settings;
  bool held = false, remake = false;
  const bool x_set = slider("gravity x", draft_.gravity.x, -30, 30, "%.2f m/s2", held);
  const bool y_set = slider("gravity y", draft_.gravity.y, -30, 30, "%.2f m/s2", held);
  if (held || x_set || y_set) sim_.post([g = draft_.gravity](Simulation& s) { s.set_gravity(g); });
  bool skin_held = false;
  const bool skin_set = slider("skin", draft_.skin, 0.25, 4, "x %.2f", skin_held, ImGuiSliderFlags_Logarithmic);
  if (skin_held || skin_set) sim_.post([skin = draft_.skin](Simulation& s) { s.set_skin(skin); });
  held = held || skin_held;
  std::size_t steps = 0, made = 0;
  for (std::size_t k = first_graph_frame(log_); k < log_.frames().size(); ++k) {
    const FrameValues& values = log_.frames()[k];
    steps += values.step ? 1 : 0;
    made += values.step && values.step->rebuilt ? 1 : 0;
  }
  text(fmt::format("lists made in {} of {} steps", made, steps));

  ImGui::TextDisabled("these make a new world from this state:");
  ImGui::SliderInt("substeps", &draft_.substeps, 1, 16);
  held = held || ImGui::IsItemActive();
  remake = remake || ImGui::IsItemDeactivatedAfterEdit();
  const auto material = [&](const char* label, std::optional<double>& value, double most) {
    double number = value.value_or(-0.01);
    if (slider(label, number, -0.01, most, value ? "%.2f" : "the scene's", held)) remake = true;
    value = number < 0 ? std::optional<double>() : number;
  };
  material("restitution", draft_.restitution, 1);
  material("friction", draft_.friction, 2);
  if (ImGui::BeginCombo("ISA", std::string(isa_name(draft_.isa)).c_str())) {
    for (const Isa isa : kAllIsas) {
      if (!isa_available(isa)) continue;
      if (ImGui::Selectable(std::string(isa_name(isa)).c_str(), isa == draft_.isa)) {
        draft_.isa = isa;
        remake = true;
      }
    }
    ImGui::EndCombo();
  }
  const int cores = std::max(static_cast<int>(std::thread::hardware_concurrency()), 2);
  ImGui::SliderInt("threads", &draft_.threads, 1, cores);
  held = held || ImGui::IsItemActive();
  remake = remake || ImGui::IsItemDeactivatedAfterEdit();
  if (remake) sim_.post([draft = draft_](Simulation& s) { s.set_settings(draft); });
  editing_ = held;
}

void Panels::show_tools() {
  if (!ImGui::CollapsingHeader("left button", ImGuiTreeNodeFlags_DefaultOpen)) return;
  for (int k = 0; k < kToolCount; ++k) {
    if (k % 3 != 0) ImGui::SameLine(static_cast<float>(k % 3) * 0.32f * kWidth);
    if (ImGui::RadioButton(kToolNames[k], state_.tool == static_cast<Tool>(k))) {
      state_.tool = static_cast<Tool>(k);
    }
  }
  if (state_.tool == Tool::spawn) {
    choose("shape", state_.spawn_shape, kSpawnShapeNames);
    ImGui::SliderFloat("radius", &state_.size, 0.05f, 5, "%.2f m", ImGuiSliderFlags_Logarithmic);
  }
  if (state_.tool == Tool::explode || state_.tool == Tool::well) {
    ImGui::SliderFloat("reach", &state_.reach, 0.5f, 200, "%.1f m", ImGuiSliderFlags_Logarithmic);
    const char* const unit = state_.tool == Tool::explode ? "%.0f N s/m" : "%.0f m/s2";
    ImGui::SliderFloat("strength", &state_.strength, -200, 200, unit);
  }
}

void Panels::show_help() {
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({window.x - 10, window.y - 10}, ImGuiCond_Appearing, {1, 1});
  ImGui::SetNextWindowBgAlpha(0.55f);
  ImGui::Begin("keys", &state_.help, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted(
      "left button     the tool: 1 grab, 2 spawn, 3 explode, 4 well, 5 wall, 6 erase\n"
      "right button    move the picture\n"
      "wheel           zoom at the pointer\n"
      "P, Space        pause and run\n"
      "O, Right        one step\n"
      ", and .         back and forward through the frames that are kept\n"
      "R               restart\n"
      "[ and ]         scene before and after\n"
      "C               next colouring\n"
      "F V             fluids as surface or particles, their next colouring\n"
      "G J K H T       grid, joints, contacts with normals, hits, trails\n"
      "Home            show the whole scene\n"
      "Tab             panels on and off\n"
      "F1              this\n"
      "F12             picture: psim-view-NNN.png");
  ImGui::End();
}

// The simulation collects what some overlay shows, and nothing else.
void Panels::choose_collected() {
  const Collect wanted{.contacts = state_.overlays.contacts,
                       .forces = state_.colouring == Colouring::force,
                       .strips = state_.colouring == Colouring::strip,
                       .colours = state_.colouring == Colouring::solver,
                       .hits = state_.overlays.hits,
                       .hash = state_.panels};
  if (wanted == collected_) return;
  collected_ = wanted;
  sim_.post([wanted](Simulation& s) { s.set_collect(wanted); });
}

}  // namespace psim::view
