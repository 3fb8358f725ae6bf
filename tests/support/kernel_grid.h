// What the kernels of pair search work on: bodies in cell order, and room for the pairs that are found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernel_support.h"

namespace psim::test {

/// Bodies in cell order, as pair search wants them. The lattice spans the int32 range where the
/// grid is periodic, so that differences wrap as the world does.
struct Grid {
  std::uint32_t cols, rows, stride;
  bool periodic;
  float pitch;
  std::vector<std::int32_t> pos;
  std::vector<float> reach;
  std::vector<std::uint32_t> key;
  std::vector<std::uint32_t> start_store;  // start[-1] is read too
  std::vector<std::uint32_t> row_begin;    // first body of each row, and the end

  Grid(Random& random, std::uint32_t columns, std::uint32_t lines, std::size_t n, bool wraps)
      : cols(columns),
        rows(lines),
        stride(columns + 1),
        periodic(wraps),
        pitch(wraps ? static_cast<float>(columns * 0x1p-32) : 0x1p-20f) {
    struct Body {
      std::int32_t x, y;
      std::uint32_t key;
    };
    std::vector<Body> bodies;  // cells of 1 m; periodic grids are square
    for (std::size_t i = 0; i < n; ++i) {
      const double cx = random.uniform(0, cols), cy = random.uniform(0, rows);
      const auto at = [&](double c) {
        const double lattice = c / double{pitch} - (periodic ? 0x1p31 : 0);
        return static_cast<std::int32_t>(std::floor(std::min(lattice, 0x1p31 - 1)));
      };
      bodies.push_back({at(cx), at(cy), static_cast<std::uint32_t>(cy) * stride + static_cast<std::uint32_t>(cx)});
      if (i > 0 && random.chance(0.1)) bodies.back() = bodies[i - 1];  // coincident
    }
    std::stable_sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) { return a.key < b.key; });
    start_store.assign(std::size_t{rows + 1} * stride + 5, 0);
    for (const Body& b : bodies) {
      pos.push_back(b.x);
      pos.push_back(b.y);
      key.push_back(b.key);
      reach.push_back(uniform(random, 0.2, 0.499));
      for (std::size_t k = b.key + 2; k < start_store.size(); ++k) ++start_store[k];
    }
    for (std::uint32_t r = 0; r <= rows; ++r) {
      row_begin.push_back(start_store[std::size_t{r} * stride + 1]);
    }
    pos.resize(2 * (n + kernels::kReadPad));
    reach.resize(n + kernels::kReadPad);
  }

  std::size_t size() const { return key.size(); }

  kernels::PairRow row(std::uint32_t r) const {
    kernels::PairRow v;
    v.pos = pos.data();
    v.reach = reach.data();
    v.key = key.data();
    v.start = start_store.data() + 1;
    v.pitch_x = v.pitch_y = pitch;
    const auto step = static_cast<std::int32_t>(stride);
    v.next_row = step;
    if (periodic) {
      if (r + 1 == rows) v.next_row = -step * static_cast<std::int32_t>(rows - 1);
      v.seam_first = r * stride;
      v.seam_last = r * stride + cols - 1;
    }
    return v;
  }
};

/// Room for found pairs; what lies beyond the capacity must stay as it is.
struct Found {
  static constexpr std::uint32_t kGuard = 0xABCD1234u;
  std::vector<std::uint32_t> owner, other, first;
  std::uint32_t capacity;
  std::uint32_t count = 0;
  bool complete = false;

  Found(std::uint32_t room, std::size_t bodies)
      : owner(room + 16, kGuard), other(room + 16, kGuard), first(bodies, kGuard), capacity(room) {}

  kernels::PairList list() {
    kernels::PairList l;
    l.owner = owner.data();
    l.other = other.data();
    l.first = first.data();
    l.count = count;
    l.capacity = capacity;
    return l;
  }
};

}  // namespace psim::test
