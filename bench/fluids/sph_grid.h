// Particles of the smoothed-particle solver in cells, as its sums read them.
//
// Fluid, walls and periodic copies share one set of columns, in the order of square cells a little wider than the kernel
// reaches. The three cells next to each other in a row are then one run of the columns, so a sum over neighbours reads
// three runs. A run may be read a few particles beyond its end: those are in cells that the kernel does not reach, or
// the empty slots behind each row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "flow.h"

namespace psim::fluids {

/// Sums take eight particles at once.
inline constexpr std::size_t kLanes = 8;

/// A particle of the fluid. Sums are in floats, what they add to is in doubles.
struct SphParticle {
  double x, y;              ///< metres from the lower left corner of the bounds
  double vx, vy;            ///< m/s
  double drift_x, drift_y;  ///< m/s: by how much a particle moves faster than its fluid (transport velocity)
  double strain;            ///< density / kDensity - 1
  double ax, ay;            ///< m/s^2
  double shift_x, shift_y;  ///< m/s^2: of the background pressure (transport velocity)
  std::uint32_t id;
};

/// What sums read, a column a quantity, by slot.
struct SphColumns {
  std::vector<float> x, y, vx, vy, drift_x, drift_y, strain, volume, pressure;
  std::vector<float> fluid;  ///< 1 for fluid and its periodic copies, 0 for walls
  void resize(std::size_t slots);
};

class SphGrid {
 public:
  SphGrid(const Flow& flow, double reach);

  /// Sorts the particles by cell and lays out the columns. Positions of periodic flows come back into the bounds.
  void sort(std::vector<SphParticle>& particles);
  /// Copies positions, velocities and strains from the particles to the columns.
  void load(const std::vector<SphParticle>& particles);
  /// Copies the columns that particles do not hold, volume and pressure, to the periodic copies.
  void load_copies();
  /// Whether a particle has moved so far since the last sort that a neighbour could be missed.
  bool stale(const std::vector<SphParticle>& particles) const;

  SphColumns columns;
  std::vector<std::uint32_t> start;      ///< by cell: its first slot
  std::vector<std::uint32_t> slot;       ///< by particle
  std::vector<std::uint32_t> cell;       ///< by particle
  std::vector<std::uint32_t> wall_slot;  ///< by particle of the walls
  std::vector<std::uint32_t> wall_cell;
  std::uint32_t across = 0;  ///< cells in a row

 private:
  struct Copy {
    std::uint32_t particle;
    double shift_x, shift_y;
    std::uint32_t slot;
  };

  void make_walls(const Flow& flow, double reach);
  void make_copies(std::vector<SphParticle>& particles);
  std::uint32_t cell_of(double x, double y) const;

  bool periodic_;
  double width_, height_;  ///< of the bounds
  float wall_volume_;      ///< of a particle of the walls, m^2
  double side_;            ///< of a cell
  double margin_;          ///< the grid begins so far outside of the bounds
  double slack_;           ///< particles may move so far before they must be sorted again
  std::uint32_t up_ = 0;   ///< rows of cells
  std::vector<Vec2> walls_;
  std::vector<Copy> copies_;
  std::vector<Vec2> sorted_at_;
};

}  // namespace psim::fluids
