// What of fluids is drawn in a picture: for each fluid the grid of its surface, or its particles as discs.
//
// In: the particles of a frame. Out: parts, ready for the GPU. Everything is made anew for each picture, 40 to 60 ns a
// particle (docs/view.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/camera.h"
#include "model/fluid_look.h"
#include "options/picture_options.h"
#include "surface/fluid_field.h"

namespace psim::view {

struct FluidChoice {
  cli::FluidStyle style = cli::FluidStyle::surface;
  cli::FluidColouring colouring = cli::FluidColouring::fluid;
};

class FluidDrawing {
 public:
  struct Disc {
    float x, y;   ///< metres from the middle of the window
    float share;  ///< of the brightest, 0 to 1; below 0: the fluid's colour
  };
  struct Part {
    std::uint32_t rgb = 0;  ///< 0xRRGGBB of the fluid
    cli::FluidField field;  ///< empty if discs show all; its values are shares of the brightest
    std::vector<Disc> discs;
    float radius = 0;  ///< metres, of the discs
  };

  /// `alpha`: 0 where particles were a frame ago, 1 where they are; between, straight on by their velocity.
  void build(const FluidLook* look, const WorldDesc& world, const Camera& camera, float alpha,
             const FluidChoice& choice);
  std::span<const Part> parts() const { return {parts_.data(), count_}; }

 private:
  void build_part(const FluidRows& rows, const std::vector<float>& values, const WorldDesc& world, const Camera& camera,
                  cli::FluidStyle style, Part& part) const;
  void find_values(const FluidLook& look, cli::FluidColouring colouring);

  std::vector<Part> parts_;  // the first count_ are of this picture; others keep their memory
  std::size_t count_ = 0;
  std::vector<Vec2> places_;                // of the fluid at work
  std::vector<std::vector<float>> values_;  // by fluid; empty where colours are those of the fluids
  std::vector<float> sample_;
  float bright_ = 0;                                           // m/s or N/m; follows slowly, so that nothing flickers
  cli::FluidColouring followed_ = cli::FluidColouring::fluid;  // what bright_ is of
};

}  // namespace psim::view
