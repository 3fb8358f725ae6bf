// The equations of pressure and of even density: diagonal * x - (sum of link * x of a neighbour) = right, one for each
// cell that is full of fluid. They are solved by conjugate gradients with a multigrid cycle as preconditioner (Tatebe
// 1993; McAdams, Sifakis & Teran 2010), whose smoother is two Chebyshev sweeps.
#pragma once

#include <memory>
#include <vector>

#include "base/worker_pool.h"
#include "fluid/fluid_tiles.h"
#include "kernel_table.h"

namespace psim {

/// More that the equations hold: a symmetric matrix of few rows.
class SolverRows {
 public:
  virtual ~SolverRows() = default;
  /// change += the matrix times x; returns x times that.
  virtual double apply(FluidGrid& grid, std::size_t x, std::size_t change) = 0;
};

class FluidSolver {
 public:
  /// The fields of a level. Those from kResidual on are of the finest level only.
  enum Field : std::size_t {
    kLinkX,
    kLinkY,
    kDiagonal,
    kReciprocal,
    kRight,
    kSolution,
    kOther,
    kCoarseFields,
    kResidual = kCoarseFields,
    kWay,
    kChange,
    kPressure,
    kEven,
    kUneven,
    kError,
    kFirst,
    // The fluid's step uses those that follow (fluids.cpp).
    kMassU,
    kU,
    kMassV,
    kV,
    kVolume,
    kSlopeX,
    kSlopeY,
    kValidU,
    kValidV,
    kNewU,
    kNewV,
    kLightU = kNewU,  // until new velocities are found (fluid_mixture.h)
    kLightV = kNewV,
    kGainU,
    kGainV,
    kShiftU,
    kShiftV,
    kDragU,
    kDragV,
    kFill,
    kEdge,
    // Shares that bodies leave open, and the velocity of what they take (fluid_cut.h).
    kOpenU,
    kOpenV,
    kSeen,
    kShare,
    kSolidU,
    kSolidV,
    kFine,
    kFields = kFine + 4
  };

  FluidSolver(MemoryMeter& meter, const kernels::KernelTable& kernels, WorkerPool& pool)
      : kernels_(kernels), pool_(pool), meter_(meter), finest_(meter, kFields) {}

  FluidGrid& grid() { return finest_; }
  const FluidGrid& grid() const { return finest_; }
  std::size_t bytes() const;
  /// Makes the coarser levels for the equations of the finest one, which are those of its active tiles.
  void coarsen(const FluidSpace& space);
  /// Solves for `x`, which holds a first guess, with the right sides `right`, until no residual is larger than `tolerance`.
  /// Returns the number of iterations.
  /// `rows`: of bodies that move with pressure, or null.
  int solve(Field x, Field right, float tolerance, int most, SolverRows* rows = nullptr);

  /// Calls job(tile) for every tile of the finest level, on all threads.
  template <class Job>
  void each_tile(const Job& job) {
    run(finest_.size(), job);
  }
  /// Calls job(tile) for these tiles.
  template <class Job>
  void each_of(const std::vector<std::uint32_t>& tiles, const Job& job) {
    run(tiles.size(), [&](std::size_t k) { job(std::size_t{tiles[k]}); });
  }

 private:
  static constexpr std::size_t kTilesAJob = 4;
  static constexpr float kLost = 100;  // of the least residual
  /// How far conjugate gradients came. They are lost if residuals grow without end, as they do where bodies shut in a few
  /// cells, whose equations then have no solution. The step before which the least was left is the best.
  struct Way {
    int steps = 0, best = 0;
    bool lost = false;
  };
  Way iterate(Field x, Field right, float tolerance, int most, SolverRows* rows);

  template <class Job>
  void run(std::size_t n, const Job& job) {
    if (n < 2 * kTilesAJob) {
      for (std::size_t k = 0; k < n; ++k) job(k);
      return;
    }
    pool_.run((n + kTilesAJob - 1) / kTilesAJob, [&](std::size_t part) {
      for (std::size_t k = part * kTilesAJob; k < std::min(n, (part + 1) * kTilesAJob); ++k) job(k);
    });
  }
  /// The active tiles of a level.
  template <class Job>
  void each(FluidGrid& level, const Job& job) {
    each_of(level.active, job);
  }
  FluidGrid& level(std::size_t l) { return l == 0 ? finest_ : *coarser_[l - 1]; }
  kernels::FluidLevel view(FluidGrid& of, std::size_t tile) {
    return {of.field(kLinkX, tile), of.field(kLinkY, tile), of.field(kDiagonal, tile), of.field(kReciprocal, tile)};
  }
  /// kSolution = about the inverse of the equations times the field `right`. Of the finest level, parts_ hold the products of
  /// the two.
  void cycle(std::size_t l, Field right);
  void restrict_residual(std::size_t l, std::size_t tile, Field right);
  void prolong(std::size_t l, std::size_t tile);
  void fill_coarse(FluidGrid& fine, FluidGrid& coarse);
  double sum() const;

  const kernels::KernelTable& kernels_;
  WorkerPool& pool_;
  MemoryMeter& meter_;
  FluidGrid finest_;
  std::vector<std::unique_ptr<FluidGrid>> coarser_;
  std::size_t levels_ = 1;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> all_;  // tiles of a coarser level
  std::vector<double> parts_;       // of sums, by tile
  std::vector<float> most_;         // by tile
};

}  // namespace psim
