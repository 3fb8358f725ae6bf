// Pair search: bodies sorted by cell, row-major, cells at least as wide as the largest reach pair.
// Half of a body's neighbourhood is then two runs of bodies: the rest of its cell with the cell to
// the east, and the three cells above. i and j are a pair if |XJ - XI| pitch < reach_i + reach_j.
//
// The first vector holds 4 candidates of each run and is always computed: loops over the true
// counts mispredict, which costs more than the empty lanes (docs/kernels.md).
// O(candidates); partners come out in candidate order on every ISA: 4 own, 4 next, rest of own,
// rest of next, seam.
#pragma once

#include "lane_vec.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L>
class PairSearch {
 public:
  // The row and the list are copied: stores of body numbers could alias them otherwise, and every
  // one would make the compiler load all of it again.
  PairSearch(const PairRow& row, const PairList& list)
      : row_(row), list_(list), pitch_x_(row.pitch_x), pitch_y_(row.pitch_y) {}

  std::uint32_t count() const { return list_.count; }
  bool full() const { return list_.count + kBlock > list_.capacity; }

  PSIM_INLINE void among(std::uint32_t i, std::uint32_t j0, std::uint32_t j1) {
    aim(i);
    run(j0, j1);
  }

  PSIM_INLINE void body(std::uint32_t i) {
    aim(i);
    list_.first[i] = list_.count;
    const std::uint32_t key = row_.key[i];
    const std::int32_t above = static_cast<std::int32_t>(key) + row_.next_row;
    std::uint32_t own = i + 1;
    const std::uint32_t own_end = row_.start[key + 2];
    std::uint32_t next = row_.start[above - 1];
    const std::uint32_t next_end = row_.start[above + 2];
    take(own, own_end, next, next_end);
    own += 4;
    next += 4;
    run(own, own_end);
    run(next, next_end);
    if (key == row_.seam_first) {  // the cell above and across the west seam
      const std::int32_t far = above + static_cast<std::int32_t>(row_.seam_last - row_.seam_first);
      run(row_.start[far], row_.start[far + 1]);
    }
    if (key == row_.seam_last) {  // across the east seam: own row and the row above
      const std::int32_t near = static_cast<std::int32_t>(row_.seam_first);
      run(row_.start[near], row_.start[near + 1]);
      run(row_.start[near + row_.next_row], row_.start[near + row_.next_row + 1]);
    }
  }

 private:
  PSIM_INLINE void aim(std::uint32_t i) {
    i_ = i;
    x_ = I<L>(row_.pos[2 * std::size_t{i}]);
    y_ = I<L>(row_.pos[2 * std::size_t{i} + 1]);
    reach_ = row_.reach[i];
  }

  // Lanes whose body is within reach.
  PSIM_INLINE M<L> close(I<L> x, I<L> y, F<L> reach) const {
    const auto dx = to_float(x - x_) * pitch_x_;
    const auto dy = to_float(y - y_) * pitch_y_;
    const auto sum = reach_ + reach;
    return dx * dx + dy * dy < sum * sum;
  }

  /// Candidates j0 .. j0+3 below end0 and j1 .. j1+3 below end1.
  PSIM_INLINE void take(std::uint32_t j0, std::uint32_t end0, std::uint32_t j1, std::uint32_t end1) {
    const auto near = [&](I<L> x, I<L> y, F<L> reach) PSIM_INLINE_LAMBDA { return close(x, y, reach); };
    list_.count += L::four_and_four(row_.pos, row_.reach, j0, end0, j1, end1, i_, list_.owner + list_.count,
                                    list_.other + list_.count, near);
  }

  PSIM_INLINE void run(std::uint32_t j, std::uint32_t end) {
    for (; j < end; j += 8) {
      if (list_.count + kBlock > list_.capacity) {  // full: the caller sees it and grows the list
        list_.count = list_.capacity;
        return;
      }
      take(j, end, j + 4, end);
    }
  }

  const PairRow row_;
  PairList list_;
  std::uint32_t i_ = 0;
  F<L> pitch_x_, pitch_y_;
  I<L> x_{}, y_{};
  F<L> reach_{};
};

/// Partners of body i among the bodies j0..j1 (any run of slots), appended to the list.
template <class L>
bool find_near(const PairRow& row, std::uint32_t i, std::uint32_t j0, std::uint32_t j1, PairList& list) {
  PairSearch<L> search(row, list);
  search.among(i, j0, j1);
  list.count = search.count();
  return !search.full();
}

/// Searches the bodies begin..end of one row and appends to the list. False if the list is full
/// (then its content is of no use and the call is to be repeated with more room).
template <class L>
bool find_pairs(const PairRow& row, std::uint32_t begin, std::uint32_t end, PairList& list) {
  PairSearch<L> search(row, list);
  for (std::uint32_t i = begin; i < end && !search.full(); ++i) search.body(i);
  list.count = search.count();
  return !search.full();
}

/// Of pairs begin..end, those that can meet within the time at their present relative speed,
///   |d| < r_i + r_j + slack + |u| time,
/// written packed and in order. Returns how many.
template <class L>
std::uint32_t select_pairs(const BodyView& b, const PairSelection& s, std::uint32_t begin, std::uint32_t end) {
  const F<L> pitch_x = s.pitch_x, pitch_y = s.pitch_y;
  const F<L> time = s.time, slack = s.slack;
  std::uint32_t count = 0;
  for (std::uint32_t p = begin; p < end; p += L::width) {
    const std::uint32_t* i = s.owner + p;
    const std::uint32_t* j = s.other + p;
    const std::uint32_t left = end - p;
    std::uint32_t tail[2][L::width];
    if (left < L::width) {  // what lies beyond the end is no slot: repeat the first pair
      for (std::uint32_t l = 0; l < L::width; ++l) {
        tail[0][l] = i[l < left ? l : 0];
        tail[1][l] = j[l < left ? l : 0];
      }
      i = tail[0];
      j = tail[1];
    }
    I<L> xi, yi, xj, yj;
    L::template gather_int<1>(b.pos, i, xi, yi);
    L::template gather_int<1>(b.pos, j, xj, yj);
    F<L> ui, vi, uj, vj;
    L::template gather<1>(b.vel, i, ui, vi);
    L::template gather<1>(b.vel, j, uj, vj);
    const auto dx = to_float(xj - xi) * pitch_x;
    const auto dy = to_float(yj - yi) * pitch_y;
    const auto ux = uj - ui, uy = vj - vi;
    const auto speed = sqrt(ux * ux + uy * uy);
    const auto radii = L::template gather1<1>(s.radius, i) + L::template gather1<1>(s.radius, j);
    const auto reach = radii + slack + speed * time;
    const auto near = dx * dx + dy * dy < reach * reach;
    const std::uint32_t valid = (1u << (left < L::width ? left : L::width)) - 1u;
    const std::uint32_t mask = bits(near) & valid;
    L::pack(s.out_owner + count, i, mask);
    count += L::pack(s.out_other + count, j, mask);
  }
  return count;
}

}  // namespace
}  // namespace psim::kernels
