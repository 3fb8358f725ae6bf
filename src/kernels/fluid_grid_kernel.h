// The equations of a fluid's grid, tile by tile (fluid_views.h). Sums are taken in eight lanes and then in one order, so
// that they are the same for every instruction set.
#pragma once

#include "fluid_views.h"
#include "lane_vec.h"

namespace psim::kernels {
namespace {

/// Calls each(node) for every register of a tile's own nodes.
template <class L, class Each>
PSIM_INLINE inline void for_tile(const Each& each) {
  for (std::int32_t j = 0; j < kTile; ++j) {
    for (std::int32_t i = 0; i < kTile; i += static_cast<std::int32_t>(L::width)) each(tile_node(i, j));
  }
}

/// A sum of products over a tile's own nodes.
template <class L, class Product>
PSIM_INLINE inline double tile_sum(const Product& product) {
  constexpr std::int32_t kRegisters = static_cast<std::int32_t>(kBlock / L::width);
  F<L> sum[kRegisters];
  for (F<L>& s : sum) s = F<L>(0.0f);
  for (std::int32_t j = 0; j < kTile; ++j) {
    for (std::int32_t i = 0; i < kTile; i += static_cast<std::int32_t>(kBlock)) {
      for (std::int32_t r = 0; r < kRegisters; ++r) {
        sum[r] = sum[r] + product(tile_node(i + r * static_cast<std::int32_t>(L::width), j));
      }
    }
  }
  float lanes[kBlock];
  for (std::int32_t r = 0; r < kRegisters; ++r) L::store(lanes + r * static_cast<std::int32_t>(L::width), sum[r]);
  double total = 0;
  for (const float lane : lanes) total += static_cast<double>(lane);
  return total;
}

/// diagonal * x - (sum of link * x of a neighbour).
template <class L>
PSIM_INLINE inline F<L> operator_at(const FluidLevel& a, const float* x, std::size_t n) {
  const F<L> left = L::load(a.link_x + n) * L::load(x + n - 1), right = L::load(a.link_x + n + 1) * L::load(x + n + 1);
  const F<L> below = L::load(a.link_y + n) * L::load(x + n - kTilePitch);
  const F<L> above = L::load(a.link_y + n + kTilePitch) * L::load(x + n + kTilePitch);
  return L::load(a.diagonal + n) * L::load(x + n) - ((left + right) + (below + above));
}

/// Calls each(node) for every register of a tile's nodes and its halo.
template <class L, class Each>
PSIM_INLINE inline void for_halo(const Each& each) {
  static_assert(kTileFloats % L::width == 0);
  for (std::size_t n = 0; n < kTileFloats; n += L::width) each(n);
}

/// x = two smoothing sweeps that begin with zeros: first * right / diagonal, and then another. Needs the halo of `right` and
/// of the reciprocals.
template <class L>
void begin_fluid(const FluidLevel& a, const float* right, float first, float second, float* x) {
  float once[kTileFloats];
  const F<L> w1 = first, w2 = second;
  for_halo<L>([&](std::size_t n)
                  PSIM_INLINE_LAMBDA { L::store(once + n, w1 * L::load(a.reciprocal + n) * L::load(right + n)); });
  for_tile<L>([&](std::size_t n) PSIM_INLINE_LAMBDA {
    const F<L> residual = L::load(right + n) - operator_at<L>(a, once, n);
    L::store(x + n, L::load(once + n) + w2 * L::load(a.reciprocal + n) * residual);
  });
}

/// to = x + weight * (right - A x) / diagonal: a smoothing sweep. Returns right times `to`.
template <class L>
double smooth_fluid(const FluidLevel& a, const float* right, float weight, const float* x, float* to) {
  const F<L> w = weight;
  return tile_sum<L>([&](std::size_t n) PSIM_INLINE_LAMBDA {
    const F<L> r = L::load(right + n);
    const F<L> y = L::load(x + n) + w * L::load(a.reciprocal + n) * (r - operator_at<L>(a, x, n));
    L::store(to + n, y);
    return r * y;
  });
}

/// residual = right - A x.
template <class L>
void fluid_residual(const FluidLevel& a, const float* right, const float* x, float* residual) {
  for_tile<L>([&](std::size_t n) PSIM_INLINE_LAMBDA {
    const F<L> r = L::load(right + n) - operator_at<L>(a, x, n);
    L::store(residual + n, drop(L::load(a.diagonal + n) <= F<L>(0.0f), r));
  });
}

/// Adds to x what the coarser level says. There the node (i / 2, j / 2), counted from `coarse`, stands for two by two nodes,
/// those that have an equation.
template <class L>
void prolong_fluid(const FluidLevel& a, const float* coarse, float* x) {
  constexpr std::int32_t kNodes = 2 * static_cast<std::int32_t>(L::records);
  for (std::int32_t j = 0; j < kTile; ++j) {
    for (std::int32_t i = 0; i < kTile; i += kNodes) {
      const std::size_t n = tile_node(i, j);
      const Rec<L> more = L::spread(coarse + tile_node(i / 2, j / 2));
      L::store_rec(x + n, L::load_rec(x + n) + drop(L::load_rec(a.diagonal + n) <= Rec<L>(0, 0), more));
    }
  }
}

/// way = z + share * way, with the halo, which both have; change = A way. Returns way times `change`.
template <class L>
double turn_fluid(const FluidLevel& a, const float* z, float share, float* way, float* change) {
  const F<L> s = share;
  for_halo<L>([&](std::size_t n) PSIM_INLINE_LAMBDA { L::store(way + n, L::load(z + n) + s * L::load(way + n)); });
  return tile_sum<L>([&](std::size_t n) PSIM_INLINE_LAMBDA {
    const F<L> y = drop(L::load(a.diagonal + n) <= F<L>(0.0f), operator_at<L>(a, way, n));
    L::store(change + n, y);
    return L::load(way + n) * y;
  });
}

/// x += step * way, residual -= step * change; returns the largest of |residual|.
template <class L>
float advance_fluid(float step, const float* way, const float* change, float* x, float* residual) {
  const F<L> s = step;
  F<L> most = 0.0f;
  for_tile<L>([&](std::size_t n) PSIM_INLINE_LAMBDA {
    L::store(x + n, L::load(x + n) + s * L::load(way + n));
    const F<L> r = L::load(residual + n) - s * L::load(change + n);
    L::store(residual + n, r);
    most = max(abs(r), most);
  });
  float lanes[kBlock];
  L::store(lanes, most);
  for (std::uint32_t k = 1; k < L::width; ++k) lanes[0] = lanes[k] > lanes[0] ? lanes[k] : lanes[0];
  return lanes[0];
}

}  // namespace
}  // namespace psim::kernels
