// The blocks of all joints: one list for every kind, and another one for its joints whose side A is not dynamic, since
// these have passes of their own (kernel_table.h).
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <tuple>
#include <vector>

#include "base/column.h"
#include "joint_views.h"

namespace psim {

class JointLists {
 public:
  static constexpr std::uint32_t kCount = 2 * kernels::kJointKinds;

  static constexpr std::uint32_t list_of(kernels::JointKind kind, bool held) {
    return 2 * static_cast<std::uint32_t>(kind) + (held ? 1 : 0);
  }

  /// Calls each(blocks) with the vector of a list.
  template <std::size_t kKind = 0, class Self, class Each>
  static decltype(auto) visit(Self& self, std::uint32_t list, const Each& each) {
    if constexpr (kKind + 1 < kernels::kJointKinds) {
      if (list / 2 != kKind) return visit<kKind + 1>(self, list, each);
    }
    return each(std::get<kKind>(self.blocks_)[list % 2]);
  }
  /// Calls each(block, lane) for a lane of a list.
  template <class Self, class Each>
  static void visit_lane(Self& self, std::uint32_t list, std::uint32_t lane, const Each& each) {
    visit(self, list, [&](auto& all) { each(all[lane / kernels::kBlock], lane % kernels::kBlock); });
  }
  static constexpr int kImpulses = 4;
  /// Calls each(i, impulse) for the stored impulses of a lane of a block: those of the anchors, then that of the angle,
  /// then those of the drive. There are at most kImpulses.
  template <class Block, class Each>
  static void each_impulse(Block& b, std::uint32_t lane, const Each& each) {
    int i = 0;
    if constexpr (requires { b.px; }) {
      each(i++, b.px[lane]);
      each(i++, b.py[lane]);
    }
    if constexpr (requires { b.l; }) each(i++, b.l[lane]);
    if constexpr (requires { b.turn_l; }) each(i++, b.turn_l[lane]);
    if constexpr (requires { b.drive; }) {
      each(i++, b.drive.limit_l[lane]);
      each(i++, b.drive.motor_l[lane]);
    }
  }

  std::vector<kernels::LineBlock>& rods(bool held) { return std::get<0>(blocks_)[held ? 1 : 0]; }
  const std::vector<kernels::LineBlock>& rods(bool held) const { return std::get<0>(blocks_)[held ? 1 : 0]; }

  kernels::JointBlocks blocks(std::uint32_t list) {
    return visit(*this, list, [](auto& all) -> kernels::JointBlocks { return all.data(); });
  }
  /// Replaces the blocks of a list by empty ones. Their padding is zero, too: saved states hold blocks as they are.
  void assign(std::uint32_t list, std::size_t count) {
    visit(*this, list, [count](auto& all) {
      all.resize(count);
      if (count > 0) std::memset(all.data(), 0, count * sizeof all[0]);
    });
  }
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (std::uint32_t list = 0; list < kCount; ++list) {
      visit(*this, list, [&](const auto& all) { sum += bytes_of(all); });
    }
    return sum;
  }

 private:
  template <class Block>
  using Lists = std::array<std::vector<Block>, 2>;

  // By JointKind.
  std::tuple<Lists<kernels::LineBlock>, Lists<kernels::LineBlock>, Lists<kernels::PinBlock>,
             Lists<kernels::DrivenBlock>, Lists<kernels::SlideBlock>, Lists<kernels::WeldBlock>>
      blocks_;
};

}  // namespace psim
