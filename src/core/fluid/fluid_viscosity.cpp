#include "fluid/fluid_viscosity.h"

#include <algorithm>
#include <cmath>

#include "fluid/fluid_equations.h"

namespace psim {

using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

struct Names {
  S::Field speed, valid, slope, drag, open, solid;
};
constexpr Names names_of(Component of) {
  return of == Component::u ? Names{S::kU, S::kValidU, S::kSlopeX, S::kDragU, S::kOpenU, S::kSolidU}
                            : Names{S::kV, S::kValidV, S::kSlopeY, S::kDragV, S::kOpenV, S::kSolidV};
}

constexpr float kMostlyTaken = 0.5f;  // share of a face that is open: with less, it moves as the body does

}  // namespace

double Viscosity::theta() const {
  const double stiffest = 4 * (by_x + by_y);  // of the fastest decay, by a step
  return stiffest <= 2 ? 0.5 : 1 - 1 / stiffest;
}

float make_viscous_equations(FluidGrid& grid, std::size_t t, const FluidSpace& space, const Viscosity& by, Component of,
                             bool bodies) {
  const Names names = names_of(of);
  for (const S::Field f : {names.valid, names.slope}) grid.pull_near(f, t);
  for (const S::Field f : {names.open, names.solid}) {
    if (bodies) grid.pull_cross(f, t);
  }
  for (const S::Field f : {S::kLinkX, S::kLinkY, S::kDiagonal, S::kReciprocal, S::kUneven, S::kEven}) {
    std::fill_n(grid.field(f, t), kTileFloats, 0.0f);
  }
  const float *valid = grid.field(names.valid, t), *slope = grid.field(names.slope, t),
              *speed = grid.field(names.speed, t), *open = grid.field(names.open, t),
              *solid = grid.field(names.solid, t);
  const auto moves = [&](std::size_t n) { return valid[n] != 0 && slope[n] > 0; };
  const auto kx = static_cast<float>(by.by_x * by.theta()), ky = static_cast<float>(by.by_y * by.theta());
  const FluidTile& tile = grid.tiles[t];
  float largest = 0;
  for (std::int32_t j = 0; j <= tile.high; ++j) {
    for (std::int32_t i = 0; i <= tile.wide; ++i) {
      const std::size_t n = tile_node(i, j);
      if (!moves(n)) continue;
      if (moves(n - 1)) grid.field(S::kLinkX, t)[n] = kx;
      if (moves(n - kTilePitch)) grid.field(S::kLinkY, t)[n] = ky;
      if (i == tile.wide || j == tile.high) continue;
      // A wall beside the face is half a cell away, before or behind it a whole one.
      float held = 0;  // what bodies beside the face give to its right side
      const auto link = [&](std::size_t m, float k, bool wall, bool along) {
        if (bodies && valid[m] == 0 && open[m] < kMostlyTaken) {
          held += k * solid[m];
          return k;
        }
        return moves(m) || valid[m] != 0 ? k : wall ? (along ? 2 * k : k) : 0.0f;
      };
      const WallsBeside walls = walls_beside(space, tile, i, j);
      const bool is_u = of == Component::u;
      const float diagonal =
          (link(n - 1, kx, walls.left, !is_u) + link(n + 1, kx, walls.right, !is_u)) +
          (link(n - kTilePitch, ky, walls.below, is_u) + link(n + kTilePitch, ky, walls.above, is_u));
      grid.field(S::kDiagonal, t)[n] = 1 + diagonal;
      grid.field(S::kReciprocal, t)[n] = 1 / (1 + diagonal);
      grid.field(S::kUneven, t)[n] = speed[n] + held;
      grid.field(S::kEven, t)[n] = speed[n];
      largest = std::max(largest, std::fabs(speed[n]));
    }
  }
  return largest;
}

void drag_faces(FluidGrid& grid, std::size_t t, const Viscosity& by, Component of) {
  const Names names = names_of(of);
  const float *diagonal = grid.field(S::kDiagonal, t), *found = grid.field(S::kEven, t);
  float *speed = grid.field(names.speed, t), *drag = grid.field(names.drag, t);
  const auto per_theta = static_cast<float>(1 / by.theta());
  for (std::size_t n = 0; n < kTileFloats; ++n) {
    drag[n] = diagonal[n] > 0 ? (found[n] - speed[n]) * per_theta : 0;
    if (diagonal[n] > 0) speed[n] += drag[n];
  }
}

}  // namespace psim
