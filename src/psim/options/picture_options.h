// What pictures show and how large they are, as chosen on the command line.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "psim/types.h"

namespace CLI {
class App;
}

namespace psim::cli {

/// What the colours of bodies mean, as in the viewer.
enum class Colouring : std::uint8_t { speed, direction, sleep, spin, body, type, force, strip, solver };
inline constexpr std::array<const char*, 9> kColouringNames = {"speed", "direction", "sleep", "spin",  "body",
                                                               "type",  "force",     "strip", "solver"};

/// How fluids are drawn: as an area with a smooth outline, or particle by particle.
enum class FluidStyle : std::uint8_t { surface, particles };
inline constexpr std::array<const char*, 2> kFluidStyleNames = {"surface", "particles"};
/// What the colours of fluids mean.
enum class FluidColouring : std::uint8_t { fluid, speed, pressure };
inline constexpr std::array<const char*, 3> kFluidColouringNames = {"fluid", "speed", "pressure"};

/// Pixels.
struct PictureSize {
  int width = 0, height = 0;
};

struct PictureOptions {
  std::optional<PictureSize> size;
  std::optional<Bounds> view;  ///< metres; nothing: what the scene fills
  Colouring colouring = Colouring::speed;
  FluidStyle fluid_style = FluidStyle::surface;
  FluidColouring fluid_colouring = FluidColouring::fluid;

  // Films.
  std::string frames_dir, video;  ///< empty: not wanted
  double fps = 60;                ///< pictures a second of the film
  /// Frames between pictures, as in a trajectory; nothing: pictures follow the simulated time, 1 / fps apart.
  std::optional<std::uint64_t> every;
  bool is_film() const { return !frames_dir.empty() || !video.empty(); }
};

/// The words as they were typed.
struct TypedPictures {
  std::string size, view, colour, fluid_look, fluid_colour, frames_dir, video, fps;
};

/// Declares --image-size, --view, --colour, --fluid-look, --fluid-colour, --frames-dir, --video and --fps.
void declare_pictures(CLI::App& app, TypedPictures& typed);

/// Their values; `every` is that of --every, if it was given. Throws UserError.
PictureOptions read_pictures(const CLI::App& app, const TypedPictures& typed, std::optional<std::uint64_t> every);

}  // namespace psim::cli
