// Decides which joint lies in which lane: colours, blocks, and the jobs that sweep over them. This runs when joints
// come, go, fall asleep or wake. O(joints).
#include <algorithm>
#include <bit>

#include "joints/joint_store.h"

namespace psim {
namespace {

constexpr std::uint32_t kColours = 24;    // joints beyond these have blocks of one lane
constexpr std::uint32_t kJobBlocks = 64;  // 512 joints: a job takes some microseconds

}  // namespace

// Calls each(joint, block, lane) for every lane that has a joint.
template <class Each>
void JointStore::each_lane(const Each& each) {
  for (std::uint32_t list = 0; list < kLists; ++list) {
    for (std::uint32_t lane = 0; lane < lanes_[list].size(); ++lane) {
      if (lanes_[list][lane] == kNoSlot) continue;
      Joint& j = joints_[lanes_[list][lane]];
      JointLists::visit_lane(lists_, list, lane, [&](auto& block, std::uint32_t k) { each(j, block, k); });
    }
  }
}

// Impulses are stored in the blocks. While the blocks are made anew, the joints keep them.
void JointStore::save_impulses() {
  each_lane([](Joint& j, auto& block, std::uint32_t k) {
    JointLists::each_impulse(block, k, [&](int i, float l) { j.impulse[i] = l; });
  });
}

// Joints get the first free colour in the order of their ids, and are sorted by colour, then by kind. Within a colour
// no two lanes share a dynamic body; after the last colour blocks hold one lane each.
void JointStore::lay_out() {
  save_impulses();
  const std::vector<std::uint32_t>& ids = bodies();
  const auto member = [&](std::uint32_t id) {
    return static_cast<std::uint32_t>(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
  };
  std::vector<std::uint32_t> used(ids.size(), 0);
  std::vector<std::uint32_t> of_class[kColours + 1];
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    Joint& j = joints_[i];
    if (!j.alive || j.dormant) {
      j.lane = kNoSlot;
      continue;
    }
    j.body[0] = member(j.swapped ? j.desc.b.index : j.desc.a.index);
    j.body[1] = member(j.swapped ? j.desc.a.index : j.desc.b.index);
    const std::uint32_t taken = used[j.body[1]] | (j.held ? 0 : used[j.body[0]]);
    const std::uint32_t colour = std::min(static_cast<std::uint32_t>(std::countr_one(taken)), kColours);
    if (colour < kColours) {
      used[j.body[1]] |= 1u << colour;
      if (!j.held) used[j.body[0]] |= 1u << colour;
    }
    of_class[colour].push_back(i);
  }
  for (auto& lanes : lanes_) lanes.clear();
  std::vector<std::uint32_t> begin_of_colour;
  const auto begin_colour = [&] {
    for (const auto& lanes : lanes_) begin_of_colour.push_back(static_cast<std::uint32_t>(lanes.size() / kBlock));
  };
  for (std::uint32_t colour = 0; colour <= kColours; ++colour) {
    begin_colour();
    for (const std::uint32_t i : of_class[colour]) {
      auto& lanes = lanes_[joints_[i].list()];
      if (colour == kColours) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
      joints_[i].lane = static_cast<std::uint32_t>(lanes.size());
      lanes.push_back(i);
    }
    for (auto& lanes : lanes_) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
  }
  begin_colour();
  for (std::uint32_t list = 0; list < kLists; ++list) lists_.assign(list, lanes_[list].size() / kBlock);
  each_lane([&](const Joint& j, auto& block, std::uint32_t k) {
    JointLists::each_impulse(block, k, [&](int i, float& l) { l = j.impulse[i]; });
    block.wa[k] = s_.bodies.properties(ids[j.body[0]]).inv_mass;
    block.wb[k] = s_.bodies.properties(ids[j.body[1]]).inv_mass;
  });
  make_jobs(begin_of_colour);
}

// The jobs of a colour run in parallel. Blocks with empty lanes are in one job, since empty lanes share a record.
void JointStore::make_jobs(const std::vector<std::uint32_t>& begin_of_colour) {
  jobs_.clear();
  phases_.clear();
  for (std::uint32_t colour = 0; colour <= kColours; ++colour) {
    const std::uint32_t* begin = &begin_of_colour[std::size_t{colour} * kLists];
    const std::uint32_t* end = begin + kLists;
    std::uint32_t blocks_here = 0;
    for (std::uint32_t list = 0; list < kLists; ++list) blocks_here += end[list] - begin[list];
    const bool whole = blocks_here <= kJobBlocks || colour == kColours;
    const std::uint32_t first = jobs_.count();
    std::vector<ListRange> rest;
    for (std::uint32_t list = 0; list < kLists; ++list) {
      std::uint32_t at = begin[list], last = end[list];
      if (at == last) continue;
      if (whole) {
        rest.push_back({list, at, last});
        continue;
      }
      if (lanes_[list][std::size_t{last} * kBlock - 1] == kNoSlot) rest.push_back({list, --last, last + 1});
      for (; at < last; at += kJobBlocks) {
        const ListRange some{list, at, std::min(last, at + kJobBlocks)};
        jobs_.add({&some, 1});
      }
    }
    if (!rest.empty()) jobs_.add(rest);
    if (first != jobs_.count()) phases_.push_back({first, jobs_.count()});
  }
}

}  // namespace psim
