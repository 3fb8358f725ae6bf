// Decides which joint lies in which lane: colours, blocks, and the jobs that sweep over them. This runs when joints
// come, go, fall asleep or wake. O(joints).
#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "joints/joint_store.h"

namespace psim {
namespace {

constexpr std::uint32_t kColours = 24;  // joints beyond these have blocks of one lane
constexpr std::uint32_t kTetherList = JointLists::list_of(kernels::JointKind::rod, true);
constexpr std::uint32_t kJobBlocks = 64;  // 512 joints: a job takes some microseconds

}  // namespace

// Calls each(joint, block, lane) for every lane that has a joint.
template <class Each>
void JointStore::each_lane(const Each& each) {
  for (std::uint32_t list = 0; list < kLists; ++list) {
    for (std::uint32_t lane = 0; lane < lanes_[list].size(); ++lane) {
      if (lanes_[list][lane] >= kTether) continue;
      Joint& j = joints_[lanes_[list][lane]];
      JointLists::visit_lane(lists_, list, lane, [&](auto& block, std::uint32_t k) { each(j, block, k); });
    }
  }
}

// Impulses are stored in the blocks. While the blocks are made anew, the joints keep them.
void JointStore::save_impulse(Joint& j) {
  if (j.lane == kNoSlot) return;
  JointLists::visit_lane(lists_, j.list(), j.lane, [&](auto& block, std::uint32_t k) {
    JointLists::each_impulse(block, k, [&](int i, float l) { j.impulse[i] = l; });
  });
}

void JointStore::save_impulses() {
  each_lane([](Joint& j, auto& block, std::uint32_t k) {
    JointLists::each_impulse(block, k, [&](int i, float l) { j.impulse[i] = l; });
  });
  const auto& rods = lists_.rods(true);
  for (std::size_t lane = 0; lane < lanes_[kTetherList].size(); ++lane) {
    const std::uint32_t i = lanes_[kTetherList][lane];
    if (i >= kTether && i != kNoSlot) tethers_[i - kTether].impulse = rods[lane / kBlock].l[lane % kBlock];
  }
}

void JointStore::find_articulations() {
  std::vector<Articulations::Candidate> candidates;
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    const Joint& j = joints_[i];
    if (!j.alive || j.dormant) continue;
    candidates.push_back({i, {j.body[0], j.body[1]}, {!j.held, true}, j.desc.lower || j.desc.upper, j.kind});
  }
  articulations_.lay_out(candidates);
  const std::span<const Articulations::Joint> all = articulations_.joints();
  for (std::uint32_t n = 0; n < all.size(); ++n) joints_[all[n].joint].articulated = n;
}

void JointStore::list_ends(std::uint32_t list) {
  ends_[list].assign(lanes_[list].size(), {});
  for (std::size_t lane = 0; lane < lanes_[list].size(); ++lane) {
    const std::uint32_t i = lanes_[list][lane];
    if (i == kNoSlot) continue;
    Ends& to = ends_[list][lane];
    for (const std::uint32_t side : {0u, 1u}) {
      to.body[side] = i < kTether ? joints_[i].body[side] : tethers_[i - kTether].body[side];
      to.anchor[side] = i < kTether ? joints_[i].anchor(side) : tethers_[i - kTether].anchor[side];
    }
    to.length = i < kTether ? joints_[i].desc.length.value_or(0) : tethers_[i - kTether].length;
    to.rope = i >= kTether || joints_[i].desc.type == JointType::rope;
  }
}

void JointStore::count_springs(std::size_t members) {
  springs_.assign(members, 0);
  for (const Joint& j : joints_) {
    if (!j.alive || j.dormant || !j.is_soft()) continue;
    ++springs_[j.body[1]];
    if (!j.held) ++springs_[j.body[0]];
  }
}

// Joints in blocks get the first colour that is free at both bodies, in the order of their ids, and are sorted by colour,
// then by kind: within a colour no two lanes share a dynamic body. The last class has the rest, in blocks of one lane.
std::vector<std::vector<std::uint32_t>> JointStore::colour(std::size_t members) {
  std::vector<std::vector<std::uint32_t>> of_class(kColours + 1);
  swept_.assign(members, 0);
  std::vector<std::uint32_t> used(members, 0);
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    Joint& j = joints_[i];
    if (!j.alive || j.dormant || j.articulated != kNoSlot || j.kind == kernels::JointKind::linkage) continue;
    swept_[j.body[0]] = swept_[j.body[1]] = 1;
    const std::uint32_t taken = used[j.body[1]] | (j.held ? 0 : used[j.body[0]]);
    const std::uint32_t free = std::min(static_cast<std::uint32_t>(std::countr_one(taken)), kColours);
    if (free < kColours) {
      used[j.body[1]] |= 1u << free;
      if (!j.held) used[j.body[0]] |= 1u << free;
    }
    of_class[free].push_back(i);
  }
  return of_class;
}

void JointStore::lay_out() {
  save_impulses();
  const std::vector<std::uint32_t>& ids = bodies();
  fragile_.clear();
  membranes_.clear();
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    Joint& j = joints_[i];
    j.lane = j.articulated = kNoSlot;
    if (!j.alive || j.dormant) continue;
    j.body[0] = member_of(j.swapped ? j.desc.b.index : j.desc.a.index);
    j.body[1] = member_of(j.swapped ? j.desc.a.index : j.desc.b.index);
    if (j.extra != kNoSlot && extras_[j.extra].breaks()) fragile_.push_back(i);
    if (j.extra != kNoSlot && extras_[j.extra].is_membrane())
      membranes_.add(i, j.body, j.swapped ? 1 : 0, extras_[j.extra].desc.area != 0);
  }
  membranes_.lay_out(ids.size());
  find_articulations();
  find_tethers();
  count_springs(ids.size());
  const std::vector<std::vector<std::uint32_t>> of_class = colour(ids.size());
  for (auto& lanes : lanes_) lanes.clear();
  jobs_.clear();
  phases_.clear();
  for (std::uint32_t of = 0; of <= kColours; ++of) {
    std::array<std::uint32_t, kLists> begin;
    for (std::uint32_t list = 0; list < kLists; ++list) begin[list] = blocks_of(list);
    for (const std::uint32_t i : of_class[of]) {
      auto& lanes = lanes_[joints_[i].list()];
      if (of == kColours) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
      joints_[i].lane = static_cast<std::uint32_t>(lanes.size());
      lanes.push_back(i);
    }
    for (auto& lanes : lanes_) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
    add_jobs(begin, of == kColours);
  }
  joint_phases_ = phases_.size();
  lay_out_linkages();
  add_tethers();
  for (std::uint32_t list = 0; list < kLists; ++list) lists_.assign(list, blocks_of(list));
  for (std::uint32_t list = 0; list < kLists; ++list) list_ends(list);
  each_lane([&](const Joint& j, auto& block, std::uint32_t k) {
    JointLists::each_impulse(block, k, [&](int i, float& l) { l = j.impulse[i]; });
    block.wa[k] = inverse_mass_of(ids[j.body[0]]);
    block.wb[k] = inverse_mass_of(ids[j.body[1]]);
  });
  for (const Tether& t : tethers_) {
    kernels::LineBlock& block = lists_.rods(true)[t.lane / kBlock];
    block.l[t.lane % kBlock] = t.impulse;
    block.wb[t.lane % kBlock] = s_.bodies.inv_mass_in_joints(ids[t.body[1]]);
  }
}

// Tethers follow all joints: one of each body, then the second ones of bodies that have two.
void JointStore::add_tethers() {
  std::vector<std::uint8_t> has(bodies_.size());
  std::vector<std::uint32_t> waiting(tethers_.size());
  std::iota(waiting.begin(), waiting.end(), 0u);
  while (!waiting.empty()) {
    std::array<std::uint32_t, kLists> begin;
    for (std::uint32_t list = 0; list < kLists; ++list) begin[list] = blocks_of(list);
    auto& lanes = lanes_[kTetherList];
    std::fill(has.begin(), has.end(), std::uint8_t{0});
    std::erase_if(waiting, [&](std::uint32_t n) {
      Tether& t = tethers_[n];
      if (std::exchange(has[t.body[1]], std::uint8_t{1}) != 0) return false;
      t.lane = static_cast<std::uint32_t>(lanes.size());
      lanes.push_back(kTether + n);
      return true;
    });
    lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
    add_jobs(begin, false);
  }
}

// The jobs of a colour, whose blocks begin at `begin`, run in parallel; but all of those with one lane are one job. So
// are blocks with empty lanes, since empty lanes share a record.
void JointStore::add_jobs(const std::array<std::uint32_t, kLists>& begin, bool one_lane) {
  const std::uint32_t blocks_here = block_count() - std::accumulate(begin.begin(), begin.end(), 0u);
  const bool whole = blocks_here <= kJobBlocks || one_lane;
  const std::uint32_t first = jobs_.count();
  std::vector<ListRange> rest;
  for (std::uint32_t list = 0; list < kLists; ++list) {
    std::uint32_t at = begin[list], last = blocks_of(list);
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

}  // namespace psim
