// How full of a fluid the places of a grid are: what its surface is drawn from, in pictures and in the viewer.
//
// Every particle spreads its area, spacing^2, over a smooth kernel of 1.5 spacings. The sum is about 1 within the
// fluid, a half where a straight edge of it is, and 0 outside. Walls mirror the particles, and in a periodic world they
// are seen over the seam, so that the sum does not fall off there. Gaps between strings of particles are closed by the
// means over some spacings around. The surface is where the sum is kFluidEdge.
//
// In: places of one fluid, and the part of the world that is shown. Out: a grid that covers what is shown of it.
// Costs 40 to 60 ns a particle where a cell is one spacing or half of one (docs/view.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "psim/types.h"
#include "psim/world.h"

namespace psim::cli {

/// A particle alone is a drop of about half a spacing; a straight surface lies a quarter of a spacing outside.
inline constexpr float kFluidEdge = 0.32f;

/// The colour of a fluid, 0xRRGGBB: six, then again from the first.
std::uint32_t fluid_rgb(FluidId fluid);

struct FluidField {
  Vec2 origin;      ///< metres: node (0, 0)
  double cell = 0;  ///< metres from node to node
  int columns = 0, rows = 0;
  std::vector<float> fullness;  ///< of the nodes, row after row from the lowest
  std::vector<float> value;     ///< means of what the particles around a node have; empty unless asked for
  /// Numbers of particles that are less than an edge makes visible, as cells are larger than they are.
  std::vector<std::uint32_t> lone;

  std::vector<float> scratch[2];

  bool is_empty() const { return fullness.empty(); }
};

/// What is wanted.
struct FluidGrid {
  double spacing = 0;  ///< metres, of the fluid
  double pixel = 0;    ///< metres that a pixel is wide
  Bounds shown;        ///< metres: what lies outside may be left out
  Bounds world;        ///< as WorldDesc::bounds
  Boundary boundary = Boundary::open;
};

/// Makes the field of particles at these places. `values` has one number for each, or none. What `field` holds is lost;
/// its memory is used again. Places that are not finite are left out.
void make_fluid_field(std::span<const Vec2> places, std::span<const float> values, const FluidGrid& grid,
                      FluidField& field);

}  // namespace psim::cli
