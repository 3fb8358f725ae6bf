#include "fluid/fluid_solver.h"

#include <algorithm>
#include <cmath>

namespace psim {

using kernels::kTile;
using kernels::tile_node;

namespace {

// Weights of two sweeps that damp what varies most: Chebyshev on [1/2, 2], where the largest eigenvalue of the equations
// divided by their diagonal is 2 at most.
constexpr float kFirstWeight = 0.56169f, kSecondWeight = 1.38953f;
// Sweeps of the coarsest level, and their weights: Chebyshev on [0.05, 2].
constexpr std::array<float, 8> kCoarsest = {0.50473f, 0.54476f, 0.63829f, 0.8229f,
                                            1.19791f, 2.06903f, 4.66598f, 14.54877f};
constexpr std::size_t kMostLevels = 7;

}  // namespace

void FluidSolver::coarsen(const FluidSpace& space) {
  levels_ = 1;
  each(finest_, [&](std::size_t t) { finest_.pull_active(kReciprocal, t); });
  for (std::size_t l = 1; l < kMostLevels && level(l - 1).active.size() > 1; ++l) {
    FluidGrid& fine = level(l - 1);
    keys_.clear();
    const auto key_of = [](const FluidTile& t) { return tile_key(t.x >> 1, t.y >> 1); };
    for (const std::uint32_t t : fine.active) keys_.push_back(key_of(fine.tiles[t]));
    std::ranges::sort(keys_);  // Total order: keys that are equal are the same.
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    if (keys_.size() == fine.active.size()) break;  // tiles lie apart
    if (coarser_.size() < l) coarser_.push_back(std::make_unique<FluidGrid>(meter_, kCoarseFields));
    FluidGrid& coarse = level(l);
    coarse.lay(keys_, space, static_cast<std::int32_t>(l));
    all_.resize(keys_.size());
    for (std::uint32_t t = 0; t < all_.size(); ++t) all_[t] = t;
    coarse.activate(all_);
    each(fine, [&](std::size_t t) { fine.tiles[t].coarse = coarse.find(key_of(fine.tiles[t])); });
    fill_coarse(fine, coarse);
    levels_ = l + 1;
  }
}

// A coarse link is half of the links that it stands for: as many, by twice the way.
void FluidSolver::fill_coarse(FluidGrid& fine, FluidGrid& coarse) {
  each(coarse, [&](std::size_t t) {
    for (const Field f : {kLinkX, kLinkY, kDiagonal, kReciprocal, kRight, kSolution, kOther}) {
      std::fill_n(coarse.field(f, t), kernels::kTileFloats, 0.0f);
    }
  });
  each(fine, [&](std::size_t t) {
    const FluidTile& tile = fine.tiles[t];
    const std::int32_t i0 = kTile / 2 * (tile.x & 1), j0 = kTile / 2 * (tile.y & 1);
    const float *x = fine.field(kLinkX, t), *y = fine.field(kLinkY, t), *d = fine.field(kDiagonal, t);
    float *cx = coarse.field(kLinkX, tile.coarse), *cy = coarse.field(kLinkY, tile.coarse);
    float* cd = coarse.field(kDiagonal, tile.coarse);
    for (std::int32_t j = 0; j < (tile.high + 1) / 2; ++j) {
      for (std::int32_t i = 0; i < (tile.wide + 1) / 2; ++i) {
        const std::size_t to = tile_node(i0 + i, j0 + j);
        float open = 0;  // what is left of the diagonal: links to places without an equation
        for (std::int32_t k = 0; k < 4; ++k) {
          const std::size_t n = tile_node(2 * i + (k & 1), 2 * j + (k >> 1));
          if (2 * i + (k & 1) >= tile.wide || 2 * j + (k >> 1) >= tile.high || d[n] <= 0) continue;
          open += d[n] - ((x[n] + x[n + 1]) + (y[n] + y[n + kernels::kTilePitch]));
          if ((k & 1) == 0) cx[to] += 0.5f * x[n];
          if ((k >> 1) == 0) cy[to] += 0.5f * y[n];
        }
        cd[to] = 0.5f * std::max(open, 0.0f);
      }
    }
  });
  each(coarse, [&](std::size_t t) {
    coarse.pull_active(kLinkX, t);
    coarse.pull_active(kLinkY, t);
    const float *cx = coarse.field(kLinkX, t), *cy = coarse.field(kLinkY, t);
    float *d = coarse.field(kDiagonal, t), *r = coarse.field(kReciprocal, t);
    for (std::int32_t j = 0; j < coarse.tiles[t].high; ++j) {
      for (std::int32_t i = 0; i < coarse.tiles[t].wide; ++i) {
        const std::size_t n = tile_node(i, j);
        d[n] += (cx[n] + cx[n + 1]) + (cy[n] + cy[n + kernels::kTilePitch]);
        r[n] = d[n] > 0 ? 1 / d[n] : 0;
      }
    }
  });
  each(coarse, [&](std::size_t t) { coarse.pull_active(kReciprocal, t); });
}

// The right side of the coarser level: sums of what is left of the right side in two by two cells.
void FluidSolver::restrict_residual(std::size_t l, std::size_t t, Field right) {
  FluidGrid& g = level(l);
  const FluidTile& tile = g.tiles[t];
  float r[kernels::kTileFloats];
  g.pull_active(kSolution, t);
  kernels_.fluid_residual(view(g, t), g.field(right, t), g.field(kSolution, t), r);
  const std::int32_t i0 = kTile / 2 * (tile.x & 1), j0 = kTile / 2 * (tile.y & 1);
  float* to = level(l + 1).field(kRight, tile.coarse);
  for (std::int32_t j = 0; j < kTile / 2; ++j) {
    for (std::int32_t i = 0; i < kTile / 2; ++i) {
      const std::size_t n = tile_node(2 * i, 2 * j);
      to[tile_node(i0 + i, j0 + j)] = (r[n] + r[n + 1]) + (r[n + kernels::kTilePitch] + r[n + kernels::kTilePitch + 1]);
    }
  }
}

// Adds the solution of the coarser level.
void FluidSolver::prolong(std::size_t l, std::size_t t) {
  FluidGrid& g = level(l);
  const FluidTile& tile = g.tiles[t];
  const std::int32_t i0 = kTile / 2 * (tile.x & 1), j0 = kTile / 2 * (tile.y & 1);
  const float* coarse = level(l + 1).field(kSolution, tile.coarse);
  kernels_.prolong_fluid(view(g, t), coarse + j0 * kernels::kTilePitch + i0, g.field(kSolution, t));
}

void FluidSolver::cycle(std::size_t l, Field right) {
  FluidGrid& g = level(l);
  const auto smooth = [&](Field from, Field to, float weight) {
    each(g, [&](std::size_t t) {
      g.pull_active(from, t);
      const double product =
          kernels_.smooth_fluid(view(g, t), g.field(right, t), weight, g.field(from, t), g.field(to, t));
      if (l == 0) parts_[t] = product;
    });
  };
  const bool coarsest = l + 1 == levels_;
  each(g, [&](std::size_t t) {
    g.pull_active(right, t);
    kernels_.begin_fluid(view(g, t), g.field(right, t), coarsest ? kCoarsest[0] : kFirstWeight,
                         coarsest ? kCoarsest[1] : kSecondWeight, g.field(kSolution, t));
    g.clear_halo(right, t);
  });
  if (coarsest) {
    for (std::size_t k = 2; k < kCoarsest.size(); k += 2) {
      smooth(kSolution, kOther, kCoarsest[k]);
      smooth(kOther, kSolution, kCoarsest[k + 1]);
    }
    return;
  }
  each(g, [&](std::size_t t) { restrict_residual(l, t, right); });
  cycle(l + 1, kRight);
  each(g, [&](std::size_t t) { prolong(l, t); });
  smooth(kSolution, kOther, kSecondWeight);
  smooth(kOther, kSolution, kFirstWeight);
}

std::size_t FluidSolver::bytes() const {
  std::size_t all = finest_.bytes();
  for (const auto& level : coarser_) all += level->bytes();
  return all;
}

double FluidSolver::sum() const {
  double total = 0;
  for (const std::uint32_t t : finest_.active) total += parts_[t];
  return total;
}

int FluidSolver::solve(Field x, Field right, float tolerance, int most, SolverRows* rows) {
  FluidGrid& g = finest_;
  const auto copy = [&](Field from, Field to) {
    each(g, [&](std::size_t t) { std::copy_n(g.field(from, t), kernels::kTileFloats, g.field(to, t)); });
  };
  copy(x, kFirst);
  const Way way = iterate(x, right, tolerance, most, rows);
  if (!way.lost) return way.steps;
  copy(kFirst, x);
  iterate(x, right, tolerance, way.best, rows);
  return way.steps + way.best;
}

FluidSolver::Way FluidSolver::iterate(Field x, Field right, float tolerance, int most, SolverRows* rows) {
  FluidGrid& g = finest_;
  parts_.resize(g.size());
  most_.resize(g.size());
  const auto largest = [&] {
    float found = 0;
    for (const std::uint32_t t : g.active) found = std::max(found, most_[t]);
    return found;
  };
  each(g, [&](std::size_t t) {
    std::fill_n(g.field(kWay, t), kernels::kTileFloats, 0.0f);
    std::fill_n(g.field(kChange, t), kernels::kTileFloats, 0.0f);
    g.pull_active(x, t);
    kernels_.fluid_residual(view(g, t), g.field(right, t), g.field(x, t), g.field(kResidual, t));
  });
  const float first = rows != nullptr ? 1 : 0;  // x += first * way, which is zero; residual -= first * change
  if (rows != nullptr) rows->apply(g, x, kChange);
  // A pass of its own, since it writes what neighbours have just read.
  each(g, [&](std::size_t t) {
    most_[t] =
        kernels_.advance_fluid(first, g.field(kWay, t), g.field(kChange, t), g.field(x, t), g.field(kResidual, t));
  });
  double before = 0;
  float least = 0;
  Way way;
  for (int k = 0;; ++k) {
    const float left = largest();
    way.steps = k;
    if (k == 0 || left < least) {
      least = left;
      way.best = k;
    }
    way.lost = left > kLost * least;
    if (!(left > tolerance) || k == most || way.lost) return way;
    cycle(0, kResidual);
    const double now = sum();
    if (!(now > 0)) return way;
    const auto share = static_cast<float>(k == 0 ? 0 : now / before);
    before = now;
    each(g, [&](std::size_t t) {
      g.pull_active(kSolution, t);
      parts_[t] = kernels_.turn_fluid(view(g, t), g.field(kSolution, t), share, g.field(kWay, t), g.field(kChange, t));
    });
    double bent = sum();
    if (rows != nullptr) bent += rows->apply(g, kWay, kChange);
    if (!(bent > 0)) return way;
    const auto step = static_cast<float>(now / bent);
    each(g, [&](std::size_t t) {
      most_[t] =
          kernels_.advance_fluid(step, g.field(kWay, t), g.field(kChange, t), g.field(x, t), g.field(kResidual, t));
    });
  }
}

}  // namespace psim
