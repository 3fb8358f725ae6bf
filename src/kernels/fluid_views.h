// What the kernels of fluids work on: particles, and a grid in tiles.
//
// A tile is a square of 16 x 16 cells. Each field of a tile is a square of 20 x 20 floats, for the nodes -1 to 18 both
// ways: a tile's own nodes, and copies of its neighbours' (the halo). The node (i, j) of a field lies in the middle of
// cell (i, j), or, for velocities in x, on its left face, or, for velocities in y, on its lower face.
#pragma once

#include <cstddef>
#include <cstdint>

namespace psim::kernels {

inline constexpr std::int32_t kTile = 16;        // cells a side
inline constexpr std::int32_t kTilePitch = 20;   // floats a row of a field
inline constexpr std::size_t kTileFloats = 400;  // floats of a field
/// The place of a node in a field, -1 <= i, j <= 18.
constexpr std::size_t tile_node(std::int32_t i, std::int32_t j) {
  const std::int32_t n = (j + 1) * kTilePitch + i + 1;
  return static_cast<std::size_t>(n);
}

/// The fine grid has two nodes a cell both ways: the nodes -1 to 34 of a tile, 36 x 36 floats.
inline constexpr std::int32_t kFinePitch = 36;
inline constexpr std::size_t kFineFloats = 1296;
constexpr std::size_t fine_node(std::int32_t i, std::int32_t j) {
  const std::int32_t n = (j + 1) * kFinePitch + i + 1;
  return static_cast<std::size_t>(n);
}

/// A particle of a fluid. Its place is counted in cells from the corner of its tile, so that precision is the same
/// everywhere.
struct FluidParticle {
  float x, y;               // cells
  float u, v;               // velocity, m/s
  float push_x, push_y;     // mean acceleration by pressure in the last steps, m/s^2
  float ux, uy, vx, vy;     // gradient of the velocity, 1/s: ux is du/dx
  std::uint32_t id, fluid;  // number of the particle, number of its fluid
};

/// How particles move in a step.
struct FluidMotion {
  float dt;                    // s
  float gravity_x, gravity_y;  // m/s^2
  float history;               // share of a particle's push that it feels before pressure is known
  float calming;               // share of what neighbours do not have in common that is lost in a step
  float spreading;             // how far particles move out of dense places: spacings by a density of 1 a spacing
  float strain;                // 1 / the strain of a step with which they move so far; with less they move less
  float cell_x, cell_y;        // width and height of a cell, m
  float per_cell_x, per_cell_y;
  const float* volume;  // of a particle, in cells, by fluid
  const float* mass;    // of a particle, kg by the reference density and the area of a cell, by fluid
};

/// Sums over particles at the nodes of a tile.
struct FluidSums {
  float *mass_u, *momentum_u;  // at left faces
  float *mass_v, *momentum_v;  // at lower faces
  float* volume;               // in cells' middles
  float* fine;                 // particles a spacing, on the fine grid
};

/// What particles take from the nodes of a tile.
struct FluidFields {
  const float *u, *v;              // new velocity, m/s
  const float *gain_u, *gain_v;    // what pressure gave to it in this step
  const float *shift_u, *shift_v;  // displacement that makes the density even, m
  const float* volume;             // share of a cell that is fluid or solid
  const float* edge;               // of a cell: 1 if it or one beside it is not full
  const float* fine;               // particles a spacing, on the fine grid
  const float *drag_u, *drag_v;    // what viscosity gave; null without it
};

/// The equation of one level of the grid, a tile of it: diagonal * x - (sum of link * x of a neighbour) = right.
struct FluidLevel {
  const float *link_x, *link_y;        // to the left, and below
  const float *diagonal, *reciprocal;  // 0 where there is no equation
};

}  // namespace psim::kernels
