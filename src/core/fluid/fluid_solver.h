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
  /// Makes the coarser levels for the equations in the finest one.
  void coarsen(const FluidSpace& space);
  /// Solves for `x`, which holds a first guess, with the right sides `right`, until no residual is larger than `tolerance`.
  /// Returns the number of iterations.
  /// `rows`: of bodies that move with pressure, or null.
  int solve(Field x, Field right, float tolerance, int most, SolverRows* rows = nullptr);

  /// Calls job(tile) for every tile of the finest level, on all threads.
  template <class Job>
  void each_tile(const Job& job) {
    each(finest_, job);
  }

 private:
  static constexpr std::size_t kTilesAJob = 4;

  template <class Job>
  void each(FluidGrid& level, const Job& job) {
    const std::size_t tiles = level.size();
    if (tiles < 2 * kTilesAJob) {
      for (std::size_t t = 0; t < tiles; ++t) job(t);
      return;
    }
    pool_.run((tiles + kTilesAJob - 1) / kTilesAJob, [&](std::size_t k) {
      for (std::size_t t = k * kTilesAJob; t < std::min(tiles, (k + 1) * kTilesAJob); ++t) job(t);
    });
  }
  FluidGrid& level(std::size_t l) { return l == 0 ? finest_ : *coarser_[l - 1]; }
  kernels::FluidLevel view(FluidGrid& of, std::size_t tile) {
    return {of.field(kLinkX, tile), of.field(kLinkY, tile), of.field(kDiagonal, tile), of.field(kReciprocal, tile)};
  }
  /// kSolution = about the inverse of the equations times the field `right`.
  void cycle(std::size_t l, Field right);
  double sum(const std::vector<double>& parts) const;

  const kernels::KernelTable& kernels_;
  WorkerPool& pool_;
  MemoryMeter& meter_;
  FluidGrid finest_;
  std::vector<std::unique_ptr<FluidGrid>> coarser_;
  std::size_t levels_ = 1;
  std::vector<std::uint64_t> keys_;
  std::vector<double> parts_;
  std::vector<float> most_;
};

}  // namespace psim
