#include "options/picture_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "options/settings_options.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

constexpr int kLeastSide = 16, kMostSide = 8192;

// The numbers of a list; empty if there is anything else in it.
template <class Number>
std::vector<Number> numbers(std::string_view text, char between) {
  std::vector<Number> values;
  while (true) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc()) return {};
    values.push_back(value);
    if (stopped == end) return values;
    if (*stopped != between) return {};
    text.remove_prefix(static_cast<std::size_t>(stopped + 1 - text.data()));
  }
}

PictureSize read_size(const std::string& text) {
  const std::vector<int> sides = numbers<int>(text, 'x');
  const auto fits = [](int side) { return side >= kLeastSide && side <= kMostSide; };
  if (sides.size() != 2 || !fits(sides[0]) || !fits(sides[1])) {
    refuse("--image-size", text,
           fmt::format("must be WIDTHxHEIGHT, each {} to {}, as 1920x1080", kLeastSide, kMostSide));
  }
  return {sides[0], sides[1]};
}

Bounds read_view(const std::string& text) {
  constexpr double kMost = 1e9, kLeast = 1e-9;  // metres
  const std::vector<double> sides = numbers<double>(text, ',');
  bool good = sides.size() == 4;
  for (const double side : sides) good = good && std::fabs(side) <= kMost;
  if (!good) {
    refuse("--view", text, "must be xmin,ymin,xmax,ymax in metres, as -10,0,10,5.5");
  }
  if (!(sides[2] - sides[0] >= kLeast)) refuse("--view", text, "xmin must be less than xmax");
  if (!(sides[3] - sides[1] >= kLeast)) refuse("--view", text, "ymin must be less than ymax");
  return {sides[0], sides[1], sides[2], sides[3]};
}

// The value of this name; `rule` says what may be chosen.
template <class Choice, std::size_t N>
Choice read_choice(const char* option, const std::string& text, const std::array<const char*, N>& names,
                   const char* rule) {
  for (std::size_t k = 0; k < N; ++k) {
    if (text == names[k]) return static_cast<Choice>(k);
  }
  refuse(option, text, rule);
}

}  // namespace

void declare_pictures(CLI::App& app, TypedPictures& typed) {
  const auto value = [&app](const char* name, std::string& target, const char* type, const char* what) {
    add_value(app, name, target, type, "Pictures", what);
  };
  value("--frames-dir", typed.frames_dir, "DIR", "write a film as pictures, DIR/frame_000000.png and so on");
  value("--video", typed.video, "FILE.mp4", "write a film (needs the program ffmpeg)");
  value("--fps", typed.fps, "N", "pictures per second of a film (60)");
  value("--image-size", typed.size, "WxH", "size in pixels (films 1920x1080; --image: 1600 on the longer side)");
  value("--view", typed.view, "x0,y0,x1,y1", "part of the world to show, in metres");
  value("--colour", typed.colour, "WHAT",
        "what colours show: speed, direction, sleep, spin, body, type, force, strip or solver (speed)");
  value("--fluid-look", typed.fluid_look, "LOOK", "how fluids are drawn: surface or particles (surface)");
  value("--fluid-colour", typed.fluid_colour, "WHAT", "what colours of fluids show: fluid, speed or pressure (fluid)");
}

PictureOptions read_pictures(const CLI::App& app, const TypedPictures& typed, std::optional<std::uint64_t> every) {
  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  for (const char* name : {"--frames-dir", "--video"}) {
    if (given(name) && app.get_option(name)->as<std::string>().empty()) {
      refuse(name, "", name[2] == 'v' ? "needs a file name" : "needs a directory");
    }
  }
  if (given("--video")) require_ending("--video", typed.video, ".mp4");
  PictureOptions options;
  options.frames_dir = typed.frames_dir;
  options.video = typed.video;
  options.every = every;
  if (given("--fps") && !options.is_film()) {
    throw UserError("--fps: has a meaning only with --frames-dir DIR or --video FILE");
  }
  for (const char* name : {"--image-size", "--view", "--colour", "--fluid-look", "--fluid-colour"}) {
    if (given(name) && !options.is_film() && !given("--image")) {
      throw UserError(fmt::format("{}: has a meaning only with --image, --frames-dir or --video", name));
    }
  }
  if (given("--image-size")) options.size = read_size(typed.size);
  if (given("--view")) options.view = read_view(typed.view);
  if (given("--colour")) {
    options.colouring =
        read_choice<Colouring>("--colour", typed.colour, kColouringNames,
                               "must be speed, direction, sleep, spin, body, type, force, strip or solver");
  }
  if (given("--fluid-look")) {
    options.fluid_style =
        read_choice<FluidStyle>("--fluid-look", typed.fluid_look, kFluidStyleNames, "must be surface or particles");
  }
  if (given("--fluid-colour")) {
    options.fluid_colouring = read_choice<FluidColouring>("--fluid-colour", typed.fluid_colour, kFluidColouringNames,
                                                          "must be fluid, speed or pressure");
  }
  options.fps = number<double>("--fps", typed.fps, given("--fps"), 0.1, 1000,
                               "must be a number of pictures a second, 0.1 to 1000")
                    .value_or(options.fps);
  if (options.size && !options.video.empty() && (options.size->width % 2 != 0 || options.size->height % 2 != 0)) {
    refuse("--image-size", typed.size, "both sides must be even for --video");
  }
  return options;
}

}  // namespace psim::cli
