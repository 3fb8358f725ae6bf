// Pair search over bodies in cell order, row by row, into a list with room enough; elements are
// bodies. PairSearch: a pile on a lattice of 1.02 m, about one disc a cell, margins of a resting
// world. PairSearchGas: 10 m^2 a disc at up to 10 m/s an axis, margins for three frames of motion.
// SelectPairs: which candidates of that gas can meet within a frame; elements are candidates.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "base/machine.h"
#include "fixtures.h"
#include "workload.h"

namespace psim::bench {
namespace {

using kernels::KernelTable;

constexpr double kCellsABody = 1.5;  // at most, as in the broad phase

struct Margin {
  const char* scene;
  float skin;  // m
  float time;  // s of a body's own motion
};

constexpr Margin kPile{"pile", 0.05f, 1.25f / 60};
constexpr Margin kGas{"discs", 0.62f, 0.019f};

class PairSearch : public Workload {
 public:
  PairSearch(const Margin& margin, std::uint32_t n) : discs_(scene_placement(margin.scene, n)) {
    const KernelTable& k = kernels_of(Isa::scalar);
    const float most = k.reaches(discs_.view(), discs_.radius.data(), {.skin = margin.skin, .time = margin.time},
                                 discs_.reach.data(), 0, discs_.blocks());
    choose_grid(k, most);
    sort_by_cell(k);
    first_.reserve(std::size_t{n} + 1);
    owner_.reserve(8 * std::size_t{n} + 64);
    other_.reserve(8 * std::size_t{n} + 64);
    row_.pos = discs_.pos.data();
    row_.reach = discs_.reach.data();
    row_.key = key_.data();
    row_.start = start_.data() + 1;
    row_.next_row = static_cast<std::int32_t>(grid_.stride);
    row_.pitch_x = static_cast<float>(discs_.lattice.pitch_x());
    row_.pitch_y = static_cast<float>(discs_.lattice.pitch_y());
    elements = n;
    PairSearch::pass(k);
    if (full_) throw std::runtime_error("PairSearch: the list is too short");
    // A body: place, reach, key and 4 cell starts, and its first pair written; 12 bytes a candidate
    // in its half of the neighbourhood; 8 a pair.
    bytes = 8 + 4 + 4 + 16 + 4 + 12 * candidates() / n + 8.0 * pairs_ / n;
  }

  void pass(const KernelTable& k) override {
    kernels::PairList list;
    list.owner = owner_.data();
    list.other = other_.data();
    list.first = first_.data();
    list.capacity = static_cast<std::uint32_t>(other_.capacity());
    full_ = false;
    for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(grid_.rows); ++row) {
      const std::uint32_t begin = row_.start[row * grid_.stride];
      const std::uint32_t end = row_.start[(row + 1) * grid_.stride];
      if (begin != end && !k.find_pairs(row_, begin, end, list)) full_ = true;
    }
    pairs_ = list.count;
  }

 protected:
  Discs discs_;
  Column<std::uint32_t> owner_{discs_.meter}, other_{discs_.meter};
  std::uint32_t pairs_ = 0;

 private:
  // Cells two reaches wide, or wider where the bodies are sparse, over the bodies' box.
  void choose_grid(const KernelTable& k, float most) {
    std::int32_t extent[4] = {discs_.pos[0], discs_.pos[1], discs_.pos[0], discs_.pos[1]};
    k.extent(discs_.pos.data(), extent, 0, discs_.count / kernels::kBlock);
    const double pitch = discs_.lattice.pitch_x();
    const double width = (static_cast<double>(extent[2]) - extent[0] + 1) * pitch;
    const double height = (static_cast<double>(extent[3]) - extent[1] + 1) * pitch;
    const double edge = std::max(2 * static_cast<double>(most) * 1.00001 + 4 * pitch,
                                 std::sqrt(width * height / (kCellsABody * discs_.count + 64)));
    grid_.cols = static_cast<std::int32_t>(width / edge) + 1;
    grid_.rows = static_cast<std::int32_t>(height / edge) + 1;
    grid_.mid_x = static_cast<std::int32_t>((std::int64_t{extent[0]} + extent[2]) / 2);
    grid_.mid_y = static_cast<std::int32_t>((std::int64_t{extent[1]} + extent[3]) / 2);
    grid_.scale_x = static_cast<float>(pitch / std::max(edge, width / grid_.cols));
    grid_.scale_y = static_cast<float>(pitch / std::max(edge, height / grid_.rows));
    grid_.offset_x = static_cast<float>(grid_.cols) / 2;
    grid_.offset_y = static_cast<float>(grid_.rows) / 2;
    grid_.stride = static_cast<std::uint32_t>(grid_.cols) + 1;
  }

  // Places, velocities and reaches in cell order; start_[1 + key] is a cell's first body, with a
  // guard before the first cell and an empty row above the last.
  void sort_by_cell(const KernelTable& k) {
    const std::uint32_t n = discs_.count;
    key_.reserve(kernels::round_up_block(n));
    k.cell_keys(discs_.pos.data(), grid_, key_.data(), 0, discs_.blocks());
    std::vector<std::uint32_t> order(n), keys(key_.data(), key_.data() + n);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    const std::vector<std::int32_t> pos(discs_.pos.data(), discs_.pos.data() + 2 * std::size_t{n});
    const std::vector<float> vel(discs_.vel.data(), discs_.vel.data() + 2 * std::size_t{n});
    const std::vector<float> reach(discs_.reach.data(), discs_.reach.data() + n);
    const std::size_t cells = (static_cast<std::size_t>(grid_.rows) + 1) * grid_.stride + 3;
    start_.reserve(cells + 2);
    for (std::size_t to = 0; to < n; ++to) {
      const std::size_t from = order[to];
      for (std::size_t axis = 0; axis < 2; ++axis) {
        discs_.pos[2 * to + axis] = pos[2 * from + axis];
        discs_.vel[2 * to + axis] = vel[2 * from + axis];
      }
      discs_.reach[to] = reach[from];
      key_[to] = keys[from];
      ++start_[std::size_t{key_[to]} + 2];
    }
    for (std::size_t cell = 1; cell < cells + 2; ++cell) start_[cell] += start_[cell - 1];
  }

  double candidates() const {
    double sum = 0;
    for (std::uint32_t i = 0; i < discs_.count; ++i) {
      const std::uint32_t* own = row_.start + key_[i];
      const std::uint32_t* above = own + grid_.stride;
      sum += own[2] - (i + 1) + above[2] - above[-1];
    }
    return sum;
  }

  kernels::GridView grid_;
  Column<std::uint32_t> key_{discs_.meter}, start_{discs_.meter}, first_{discs_.meter};
  kernels::PairRow row_;
  bool full_ = false;
};

class SelectPairs : public PairSearch {
 public:
  explicit SelectPairs(std::uint32_t n) : PairSearch(kGas, n) {
    constexpr float kFrame = 1.0f / 60;  // s
    out_owner_.reserve(pairs_ + kernels::kBlock);
    out_other_.reserve(pairs_ + kernels::kBlock);
    selection_.owner = owner_.data();
    selection_.other = other_.data();
    selection_.radius = discs_.radius.data();
    selection_.pitch_x = static_cast<float>(discs_.lattice.pitch_x());
    selection_.pitch_y = static_cast<float>(discs_.lattice.pitch_y());
    selection_.time = 1.25f * kFrame;
    selection_.slack = 0.01f + 9.81f * kFrame * kFrame;
    selection_.out_owner = out_owner_.data();
    selection_.out_other = out_other_.data();
    elements = pairs_;
    SelectPairs::pass(kernels_of(Isa::scalar));
    // Two slots, and place, velocity and radius of both bodies; 8 a chosen pair.
    bytes = 8 + 2 * (8 + 8 + 4) + 8.0 * chosen_ / pairs_;
  }

  void pass(const KernelTable& k) override { chosen_ = k.select_pairs(discs_.view(), selection_, 0, pairs_); }

 private:
  Column<std::uint32_t> out_owner_{discs_.meter}, out_other_{discs_.meter};
  kernels::PairSelection selection_;
  std::uint32_t chosen_ = 0;
};

}  // namespace

void register_pair_kernels() {
  register_kernel("PairSearch", [](std::uint32_t n) { return std::make_unique<PairSearch>(kPile, n); });
  register_kernel("PairSearchGas", [](std::uint32_t n) { return std::make_unique<PairSearch>(kGas, n); });
  register_kernel("SelectPairs", [](std::uint32_t n) { return std::make_unique<SelectPairs>(n); });
}

}  // namespace psim::bench
