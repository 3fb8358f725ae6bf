// Passes over manifolds. The state is `size` unit boxes in rows of 64, each lying on the two below it,
// about two manifolds of two points a box, in eight colours; elements are manifolds. No gravity;
// velocities are small and random, and the state is put back every few passes.
#include <cstring>
#include <memory>
#include <vector>

#include "fixtures.h"
#include "workload.h"

namespace psim::bench {
namespace {

using kernels::BodyView;
using kernels::ContactParams;
using kernels::kBlock;
using kernels::KernelTable;
using kernels::ManifoldBlock;

constexpr std::uint32_t kRow = 64;
constexpr float kReach = 0.70710678f;  // m, of a unit box

int passes_for(std::uint32_t size) { return size <= 1'000 ? 64 : size <= 10'000 ? 32 : size <= 100'000 ? 8 : 2; }

Placement boxes(std::uint32_t n) {
  Random random(1);
  Placement p;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = i / kRow;
    p.x.push_back(i % kRow + 0.5 * (row % 2));
    p.y.push_back(row);
    p.vx.push_back(random.uniform(-0.01, 0.01));
    p.vy.push_back(random.uniform(-0.01, 0.01));
  }
  p.bounds = {-2, -2, kRow + 2.0, n / static_cast<double>(kRow) + 2};
  return p;
}

class Manifolds : public Workload {
 public:
  Manifolds(std::uint32_t n, bool relax)
      : bodies_(boxes(n), 2 * kBlock), relax_(relax), params_(contact_params(bodies_.lattice)) {
    turn_.reserve(2 * (std::size_t{n} + 4 * kBlock));
    view_ = bodies_.view();
    view_.arm_change = turn_.data();
    // A box above and to the left or right, of even or odd rows: four colours, by halves of a row.
    for (std::uint32_t colour = 0; colour < 4; ++colour) {
      for (std::uint32_t i = 0; i + kRow < n; ++i) {
        const std::uint32_t row = i / kRow, side = colour % 2;
        if (row % 2 != colour / 2) continue;
        const std::uint32_t across = i % kRow + (row % 2 == 0 ? side : 1 - side) * (row % 2);
        const std::uint32_t above = (row + 1) * kRow + (row % 2 == 0 ? i % kRow - side : across);
        if (row % 2 == 0 && side > i % kRow) continue;
        if (above >= n || above / kRow != row + 1) continue;
        add(i, above, row % 2 == 0 ? (side == 0 ? 0.5f : -0.5f) : (side == 0 ? 0.5f : -0.5f));
      }
      close();
    }
    for (ManifoldBlock& block : blocks_) saved_.push_back(block);
    start_.keep(bodies_.vel, 2 * std::size_t{n});
    start_.keep(bodies_.rim_speed, n);
    // A block's floats and slots read; impulses and, in the relax pass, friction written; motion of
    // two bodies read and written.
    bytes = static_cast<double>(sizeof(ManifoldBlock)) / kBlock + (relax ? 16 : 8) + 2 * 2 * 12 + (relax ? 0 : 32);
    passes_a_start = passes_for(n);
  }

  void pass(const KernelTable& k) override {
    const auto count = static_cast<std::uint32_t>(blocks_.size());
    if (relax_) {
      k.relax_manifolds[0][0][0](view_, blocks_.data(), nullptr, params_, 0, count);
    } else {
      k.solve_manifolds[0][0][0](view_, blocks_.data(), params_, 0, count);
    }
  }
  void restart() override {
    start_.restore();
    std::copy(saved_.begin(), saved_.end(), blocks_.begin());
  }

 private:
  // B lies on A, half a box to the right (0.5) or left of it.
  void add(std::uint32_t a, std::uint32_t b, float offset) {
    if (lane_ == 0) {
      blocks_.emplace_back();
      std::memset(static_cast<void*>(&blocks_.back()), 0, sizeof(ManifoldBlock));
    }
    ManifoldBlock& c = blocks_.back();
    const std::uint32_t l = lane_;
    c.body[2 * l] = a;
    c.body[2 * l + 1] = b;
    c.ny[l] = 1;
    for (int k = 0; k < 2; ++k) {
      ManifoldBlock::Point& p = c.point[k];
      const float from_a = k == 0 ? 0 : offset, from_b = from_a - offset;
      p.an[l] = 0.5f / kReach;
      p.bn[l] = -0.5f / kReach;
      p.at[l] = from_a / kReach;
      p.bt[l] = from_b / kReach;
      p.gap[l] = -0.001f;
      p.impulse[l] = 0.01f;
    }
    c.wa[l] = c.wb[l] = c.share_b[l] = 1;
    c.share_a[l] = 0.5f;
    c.ga[l] = c.gb[l] = 3;  // 0.5 / (1/6)
    c.mu[l] = 0.6f;
    c.soft[l] = 0.1f;
    c.rate[l] = 10;
    lane_ = (lane_ + 1) % kBlock;
    ++elements;
  }
  // The rest of a block are resting bodies, far apart.
  void close() {
    while (lane_ != 0) {
      ManifoldBlock& c = blocks_.back();
      const std::uint32_t l = lane_;
      c.body[2 * l] = bodies_.count + 2 * l;
      c.body[2 * l + 1] = bodies_.count + 2 * l + 1;
      c.ny[l] = c.wa[l] = c.wb[l] = c.share_a[l] = c.share_b[l] = 1;
      c.point[0].gap[l] = c.point[1].gap[l] = 1e6f;
      c.point[0].impulse[l] = c.point[1].impulse[l] = -0.0f;
      lane_ = (lane_ + 1) % kBlock;
    }
  }

  Discs bodies_;
  bool relax_;
  ContactParams params_;
  Column<float> turn_{bodies_.meter};
  BodyView view_;
  std::vector<ManifoldBlock> blocks_, saved_;
  std::uint32_t lane_ = 0;
  Saved start_;
};

}  // namespace

void register_manifold_kernels() {
  register_kernel("SolveManifolds", [](std::uint32_t n) { return std::make_unique<Manifolds>(n, false); });
  register_kernel("RelaxManifolds", [](std::uint32_t n) { return std::make_unique<Manifolds>(n, true); });
}

}  // namespace psim::bench
