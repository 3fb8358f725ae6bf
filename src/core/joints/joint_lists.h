// The blocks of all joints: one list for every kind, and another one for its joints whose side A is not dynamic, since
// these have passes of their own (kernel_table.h).
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "joint_views.h"

namespace psim {

class JointLists {
 public:
  /// Calls each(blocks) with the vector of every list.
  template <class Self, class Each>
  static decltype(auto) visit(Self& self, std::uint32_t list, const Each& each) {
    const std::uint32_t held = list & 1u;
    switch (kind_of(list)) {
      case kernels::JointKind::rod:
        return each(self.rods_[held]);
      case kernels::JointKind::spring:
        return each(self.springs_[held]);
      case kernels::JointKind::pin:
        return each(self.pins_[held]);
      case kernels::JointKind::driven:
        return each(self.driven_[held]);
      case kernels::JointKind::slide:
        return each(self.slides_[held]);
      default:
        return each(self.welds_[held]);
    }
  }

  static constexpr std::uint32_t kCount = 2 * kernels::kJointKinds;

  static std::uint32_t list_of(kernels::JointKind kind, bool held) {
    return 2 * static_cast<std::uint32_t>(kind) + (held ? 1 : 0);
  }
  static kernels::JointKind kind_of(std::uint32_t list) { return static_cast<kernels::JointKind>(list / 2); }

  kernels::JointBlocks blocks(std::uint32_t list) {
    return visit(*this, list, [](auto& all) -> kernels::JointBlocks { return all.data(); });
  }
  kernels::JointBodies& block(std::uint32_t list, std::size_t i) {
    return visit(*this, list, [i](auto& all) -> kernels::JointBodies& { return all[i]; });
  }
  const kernels::JointBodies& block(std::uint32_t list, std::size_t i) const {
    return visit(*this, list, [i](auto& all) -> const kernels::JointBodies& { return all[i]; });
  }
  /// Replaces the blocks of a list by empty ones.
  void assign(std::uint32_t list, std::size_t count) {
    visit(*this, list, [count](auto& all) {
      using Block = typename std::remove_reference_t<decltype(all)>::value_type;
      all.resize(count);
      if (count != 0) std::memset(static_cast<void*>(all.data()), 0, count * sizeof(Block));
    });
  }
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (std::uint32_t list = 0; list < kCount; ++list) {
      visit(*this, list, [&](auto& all) { sum += all.capacity() * sizeof(all[0]); });
    }
    return sum;
  }

 private:
  std::vector<kernels::LineBlock> rods_[2], springs_[2];
  std::vector<kernels::PinBlock> pins_[2];
  std::vector<kernels::DrivenBlock> driven_[2];
  std::vector<kernels::SlideBlock> slides_[2];
  std::vector<kernels::WeldBlock> welds_[2];
};

}  // namespace psim
