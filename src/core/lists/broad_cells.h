// The cells of the broad phase: a grid over the bodies' box or, where most cells of a grid would be empty, a list of the
// cells that hold bodies (cell_list.h). Decides which of the two, how wide cells are and which bodies are too large for
// them, sorts the bodies, and finds the bodies around one.
#pragma once

#include <cstdint>
#include <span>

#include "bodies/surroundings.h"
#include "lists/body_mover.h"
#include "lists/cell_list.h"
#include "lists/grid_sort.h"
#include "lists/held_bodies.h"
#include "lists/pair_table.h"

namespace psim {

/// The settings of a build of the lists that come from the world.
struct BroadPhaseParams {
  kernels::ReachParams margin;
  float ahead = 0;      ///< s: the search uses the positions that bodies will have after this time
  double outer = 0;     ///< m: a typical distance of candidates; 0: the value of the last build
  bool sample = false;  ///< measure how many candidates a body is compared with
  double growth = 1;    ///< expected number of candidates over that of the last build
  bool walls = false;
  bool periodic = false;
  bool mixed_radii = false;
  bool link_all = false;  ///< every body takes substeps (fields)
  Bounds bounds;          ///< relative to the lattice centre, m
};

/// How far bodies reach at most, m, and their box {x low, y low, x high, y high}, lattice steps.
struct BodyExtent {
  float most = 0;
  std::int32_t box[4] = {INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN};
};

class BroadCells {
 public:
  explicit BroadCells(const Surroundings& s) : s_(s), sort_(s), list_(s), from_(s.memory), keys_(s.memory), mover_(s) {}

  /// Says how far the bodies reach and where they lie.
  void cover(const BodyExtent& extent) { extent_ = extent; }
  /// Chooses the cells, and finds the cell and the next slot of each body.
  void count(const BroadPhaseParams& params);
  /// The same with the cells as they are.
  void count_again();
  std::size_t moves() const { return (counted_.all() + BodyMover::kPiece - 1) / BodyMover::kPiece; }
  /// Moves the bodies to their next slots, in moves() pieces, in order, and drops dead ones. The columns change with the
  /// last piece, which returns true.
  bool move(bool mixed_radii, std::size_t begin, std::size_t end);
  /// Measures how dense the sorted bodies lie, for the next build.
  void note_density();

  /// By slot: the slot that the body had before the last sort.
  std::span<const std::uint32_t> from() const { return {from_.data(), sorted_}; }
  /// First slot of the bodies that are too large for the cells.
  std::uint32_t large_begin() const { return counted_.small; }
  /// The largest reach in the cells, m.
  float most() const { return most_; }
  /// Whether the bodies [begin, end) lie in one row of the grid whose cells, from the first body's to the last one's, are
  /// within `inner`. Bounds are relative to the lattice's centre, m.
  bool surely_within(std::uint32_t begin, std::uint32_t end, const Bounds& inner) const;

  /// Cuts the rows into strips of about equal numbers of bodies. O(rows); with listed cells O(strips log cells).
  void cut_strips(PairTable& table) const;
  /// Appends the pairs that the bodies of a strip form with those of the strip and of the next one, but for pairs of two
  /// `held` bodies. False if the list is full.
  bool find_pairs(const Strip& strip, const HeldBodies& held, kernels::PairList& list) const;
  /// Appends the bodies in cells within reach of any body. False if the list is full.
  bool find_around(std::uint32_t body, kernels::PairList& list) const;
  kernels::PairRow view() const;
  /// Counts the lanes of the search that made the lists, and the candidates in them, for every 64th body. Adds nothing
  /// where cells are listed.
  void sample_lanes(std::uint64_t& lanes, std::uint64_t& used) const;

  /// Whether only cells that hold bodies exist.
  bool listed() const { return listed_; }
  const CellList& list() const { return list_; }
  /// Number of cells of the grid.
  std::uint64_t cell_count() const { return listed_ ? 0 : grid_.keys; }
  /// Area of the bodies at the last build, m^2: their box, or, where cells are listed, the area that they would fill at
  /// the density around them. Before the first build: `bounds`, m^2, or in a far larger world an estimate from the
  /// neighbourhood of some bodies of mean radius `radius`.
  double area_about(double radius, double bounds) const;
  /// Mean number of bodies that a body is compared with.
  double tests() const { return !listed_ && tests_ > 0 ? tests_ : 4.5 * density_ * cell_area(); }
  /// Mean number of bodies per square metre around a body at the last build; 0 before the first.
  double density() const { return density_; }
  /// Whether the bodies' box is wider than high, at the last build.
  bool wide() const { return length(0) * s_.lattice.pitch_x() > length(1) * s_.lattice.pitch_y(); }

  BodyMover& mover() { return mover_; }
  /// Makes room for the cells of `bodies` bodies, and for moving `all` slots.
  void spare(std::size_t bodies, std::size_t all) {
    sort_.spare(bodies);
    mover_.spare(all);
  }

 private:
  friend class BroadPhase;  // describes it for saved states

  void order();
  double choose_reach(double area) const;
  void set_reach(double reach);
  double least_edge(double reach) const;
  void choose_grid(bool periodic);
  bool choose_list(double density);
  double waste(double density) const;
  double sample_density() const;
  double cell_area() const;
  /// The length of the box around all bodies along an axis, in lattice steps.
  double length(int axis) const { return static_cast<double>(extent_.box[axis + 2]) - extent_.box[axis]; }
  kernels::PairRow row_view(std::uint32_t row) const;
  bool find_listed(const Strip& strip, const HeldBodies& held, kernels::PairList& list) const;
  bool find_at_seam(std::uint32_t cell, const HeldBodies& held, kernels::PairList& list) const;
  bool find_run(const kernels::PairRow& row, std::uint32_t begin, std::uint32_t end, const HeldBodies& held,
                kernels::PairList& list) const;

  const Surroundings s_;
  GridSort sort_;
  CellList list_;
  SortCount counted_;
  Column<std::uint32_t> from_, keys_;  // by slot: the slot before, and the cell, or four times the listed cell
  BodyMover mover_;
  BodyExtent extent_;
  Grid grid_;
  bool listed_ = false;  // the cells are those of list_, not of grid_
  float large_ = 1e30f;  // m: a body with a longer reach is in no cell
  float most_ = 0;       // m: largest reach in the cells
  double box_ = 0;       // m^2: area of the box around all bodies
  double area_ = 0, density_ = 0;
  double tests_ = 0;          // comparisons a body, in a grid; 0: not known
  std::uint32_t sorted_ = 0;  // number of bodies after the last sort
};

}  // namespace psim
