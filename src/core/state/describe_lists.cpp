// The lists of who may meet: how they were made, which is all that making them again needs, and their strips.
#include <cmath>

#include "lists/broad_phase.h"
#include "lists/renewal.h"
#include "state/describe.h"

namespace psim {

template <class A>
void BroadPhase::describe(A& a, const BodyStore& bodies, bool periodic, bool cells) {
  BroadPhaseParams& p = params_;
  kernels::GridView& g = grid_.view;
  a.refuse_nan(true);
  numbers(a, p.margin.skin, p.margin.time, p.margin.common_x, p.margin.common_y, p.ahead, p.outer, p.sample, p.growth,
          p.walls, p.periodic, p.mixed_radii, p.link_all, p.bounds.xmin, p.bounds.ymin, p.bounds.xmax, p.bounds.ymax);
  numbers(a, all_.most, all_.extent[0], all_.extent[1], all_.extent[2], all_.extent[3], sorted_);
  numbers(a, g.mid_x, g.mid_y, g.scale_x, g.scale_y, g.offset_x, g.offset_y, g.cols, g.rows, g.stride);
  numbers(a, grid_.cell_x, grid_.cell_y, grid_.periodic, grid_.keys, listed_, large_, most_, box_, area_, density_,
          pad_reach_, next_pad_reach_, pairs_a_large_, near_pairs_, tests_, fixed_);
  for (std::vector<double>* guess : {&pairs_a_body_, &pairs_a_piece_, &near_a_body_}) {
    a.packed(*guess);
    if constexpr (A::kLoading) {
      a.require(std::all_of(guess->begin(), guess->end(), [](double x) { return x >= 0 && x <= kMostGuess; }));
    }
  }
  a.refuse_nan(false);
  sort_.listed().describe(a);
  if constexpr (!A::kLoading) return;
  a.require(p.margin.skin >= 0 && p.margin.time >= 0 && p.growth >= 0 && p.outer >= 0);
  a.require(most_ >= 0 && box_ >= 0 && area_ >= 0 && density_ >= 0 && tests_ >= 0 && pairs_a_large_ >= 0 &&
            pairs_a_large_ <= kMostGuess);
  if (!cells || !a.ok()) return;
  a.require(p.periodic == periodic && (listed_ ? sort_.listed().holds(bodies, periodic) : grid_fits(bodies, periodic)));
}

// Whether every cell that a body may get lies in the grid.
bool BroadPhase::grid_fits(const BodyStore& bodies, bool periodic) const {
  const kernels::GridView& g = grid_.view;
  const double room = 64.0 * bodies.count + 65536;
  return g.cols >= 1 && g.rows >= 1 && static_cast<double>(g.cols) * g.rows <= room &&
         g.stride == static_cast<std::uint32_t>(g.cols) + 1 &&
         grid_.keys == (static_cast<std::uint32_t>(g.rows) + 1) * g.stride + 3 && grid_.cell_x > 0 &&
         grid_.cell_y > 0 && grid_.periodic == periodic &&
         g.scale_x == static_cast<float>(lattice_.pitch_x() / grid_.cell_x) &&
         g.scale_y == static_cast<float>(lattice_.pitch_y() / grid_.cell_y) &&
         g.offset_x == static_cast<float>(g.cols) / 2 && g.offset_y == static_cast<float>(g.rows) / 2;
}

template <class A>
void CellList::describe(A& a) {
  for (Axis& axis : axis_) numbers(a, axis.low, axis.per, axis.cells, axis.width);
  numbers(a, row_axis_, stride_, rows_, periodic_, slot_bits_, stays_);
  a.require((row_axis_ == 0 || row_axis_ == 1) && (!stays_ || sound()));
  if constexpr (A::kLoading) sorted_ = 0;
}

// Whether the cells that are laid fit together.
bool CellList::sound() const {
  for (const Axis& x : axis_) {
    if (x.per < 1 || x.per > std::uint64_t{1} << 32 || x.cells < 1 || x.cells > x.per + 1) return false;
    if (x.width != 0x1p32 / static_cast<double>(x.per) || (periodic_ && x.cells != x.per)) return false;
  }
  return rows_ == axis_[row_axis_].cells && stride_ == axis_[1 - row_axis_].cells + 1 && slot_bits_ >= 0 &&
         slot_bits_ <= 32 &&
         static_cast<double>(rows_ + 1) * static_cast<double>(stride_) < std::ldexp(1.0, 64 - slot_bits_);
}

// Whether every body lies in one of them.
bool CellList::holds(const BodyStore& bodies, bool periodic) const {
  if (!sound() || periodic_ != periodic || bodies.count >= std::uint64_t{1} << slot_bits_) return false;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (std::size_t k = 0; k < bodies.count; ++k) {
      if (cell_at(axis_[axis], bodies.built[2 * k + axis]) >= axis_[axis].cells) return false;
    }
  }
  return true;
}

// Where renewed bodies were when all lists were made. Where they are looked for now, the bodies say.
template <class A>
void ListRenewal::describe(A& a, std::size_t slots) {
  a.list(renewed_, [&](Renewed& x) {
    a.index(slots, x.slot);
    numbers(a, x.x, x.y, x.reach);
  });
  a.packed(linked_, slots);
  a.value(time_);
  if constexpr (A::kLoading) mark_.reserve(slots);
}

template <class A>
void PairTable::describe(A& a) {
  numbers(a, body_count, large_begin);
  a.list(strips, [&](Strip& s) { numbers(a, s.body_begin, s.body_end, s.row_begin, s.row_end); });
  if constexpr (!A::kLoading) return;
  a.require(a.fits(body_count) && (body_count == 0 || (large_begin <= body_count && !strips.empty())));
  std::uint32_t at = 0;
  for (const Strip& strip : strips) {
    a.require(strip.body_begin == at && strip.body_end >= at && strip.body_end <= body_count);
    at = strip.body_end;
  }
  a.require(body_count == 0 || at == body_count);
}

PSIM_DESCRIBED(BroadPhase, const BodyStore&, bool, bool);
PSIM_DESCRIBED(ListRenewal, std::size_t);
template void PairTable::describe(Saver&);
template void PairTable::describe(Loader&);

}  // namespace psim
