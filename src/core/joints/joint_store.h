// Joints: their descriptions by id, and blocks of 8 lanes for the passes. docs/joints.md derives the passes.
//
//   add, remove     only note that the blocks are stale
//   prepare         once a frame: makes stale blocks anew, then sets every lane for the present places of its bodies
//   warm            applies stored impulses: in the first substep of a frame; with fields in every one
//   solve, relax    run in every substep
//   hold            runs before the drift (sign 1) and after it (sign -1), so that the drift moves bodies with half of
//                   what the joints did
//
// joint_store.cpp does what the host asks for, joint_layout.cpp makes the blocks, joint_prepare.cpp fills
// them, joint_passes.cpp runs the passes.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/column.h"
#include "base/lattice.h"
#include "base/tasks.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "contacts/solver_bodies.h"
#include "joint_views.h"
#include "joints/joint_lists.h"
#include "kernel_table.h"
#include "psim/joint.h"

namespace psim {

/// A body with joints, in this frame.
struct JointMember {
  std::uint32_t number = 0;  ///< the number that the solver uses for the body
  LatticePoint at;           ///< without the offset of a moving body, which kernels add
  double angle = 0;
  SineCosine turn;
  Vec2 centre;  ///< m: the centre of mass in the frame of the body
  double inverse_radius = 1, rim_gain = 0;
  bool fixed = false;
};

class JointStore {
 public:
  void describe(class Archive& a, const BodyStore& bodies);  ///< for saved states; behind the bodies

  explicit JointStore(MemoryMeter& meter)
      : share_vel_(meter), share_rim_speed_(meter), push_vel_(meter), push_rim_speed_(meter) {}

  /// Adds a joint. Its description was checked, and all optional values but the limits are set.
  JointId add(const JointDesc& d, const BodyStore& bodies);
  bool remove(JointId id);
  void remove_of_body(std::uint32_t body);

  bool is_valid(JointId id) const {
    return id.index < joints_.size() && joints_[id.index].alive && joints_[id.index].generation == id.generation;
  }
  const JointDesc& desc(JointId id) const { return joints_[id.index].desc; }
  bool set_motor(JointId id, double speed, double limit);
  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  std::size_t bytes() const {
    const auto of = [](const auto&... v) { return ((v.capacity() * sizeof(v[0])) + ...); };
    std::size_t sum = of(joints_, free_, first_, exclusive_, bodies_, members_, ranges_, share_ranges_, jobs_,
                         share_jobs_, phases_, marks_) +
                      exclusions_.size() * 32 + lists_.bytes();
    for (const auto& lanes : lanes_) sum += of(lanes);
    return sum;
  }

  /// Gives all memory back but the generations of ids. There is no joint.
  void release_blocks();
  /// About how many lanes the passes of a step work on. Every block is swept over sweeps_ times in solve and relax.
  std::uint64_t lane_operations(int substeps) const {
    return empty()
               ? 0
               : std::uint64_t{2} * static_cast<std::uint64_t>(substeps * sweeps_) * total_blocks_ * kernels::kBlock;
  }
  /// Counts the lanes of the blocks, and how many have a joint. O(lanes).
  void count_lanes(std::uint64_t& lanes, std::uint64_t& used) const {
    for (const auto& list : lanes_) {
      lanes += list.size();
      for (const std::uint32_t joint : list) used += joint != kNoSlot;
    }
  }
  std::size_t column_bytes() const {
    return share_vel_.bytes() + share_rim_speed_.bytes() + push_vel_.bytes() + push_rim_speed_.bytes();
  }

  /// The force and torque of a joint on body b in the last substep, N and N m. O(1).
  void load_of(JointId id, Vec2& force, double& torque) const;

  /// Calls each(a, b) with the ids of the two bodies of every joint.
  template <class Each>
  void each_pair(const Each& each) const {
    for (const Joint& j : joints_) {
      if (j.alive) each(j.desc.a.index, j.desc.b.index);
    }
  }
  /// Calls each(other) with the ids of the bodies to which a body is joined.
  template <class Each>
  void each_joined(std::uint32_t body, const Each& each) const {
    if (body >= first_.size()) return;
    for (std::uint32_t i = first_[body]; i != kNoSlot;) {
      const Joint& j = joints_[i];
      const bool is_a = j.desc.a.index == body;
      each(is_a ? j.desc.b.index : j.desc.a.index);
      i = j.next[is_a ? 0 : 1];
    }
  }
  /// Bodies fell asleep or woke: joints of bodies that sleep are left out from now on.
  void follow_sleep(const BodyStore& bodies);

  /// The ids of bodies with joints that are not left out, ascending. The solver must number these bodies.
  const std::vector<std::uint32_t>& bodies();

  /// Whether a joint keeps two bodies from colliding.
  bool joined(std::uint32_t a, std::uint32_t b) const {
    return a < exclusive_.size() && b < exclusive_.size() && exclusive_[a] != 0 && exclusive_[b] != 0 &&
           exclusions_.count(pair_key(a, b)) != 0;
  }
  bool any_exclusions() const { return !exclusions_.empty(); }

  /// Prepares the blocks for a frame with substeps of h seconds.
  void prepare(const BodyStore& bodies, const std::vector<FixedBody>& fixed, const SolverBodies& numbers,
               const Lattice& lattice, double h, WorkerPool& pool);

  void warm(const kernels::BodyView& view, const kernels::KernelTable& k, float factor, WorkerPool& pool);
  void solve(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool);
  void hold(const kernels::BodyView& view, const kernels::KernelTable& k, float sign, WorkerPool& pool);
  void relax(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool);

 private:
  static constexpr std::uint32_t kColours = 24;  // joints beyond these have blocks of one lane
  static constexpr std::uint32_t kLists = JointLists::kCount;

  struct Joint {
    JointDesc desc;
    std::uint32_t generation = 0;
    bool alive = false;
    bool swapped = false;  ///< side A is desc.b, because desc.b is not dynamic
    bool dormant = false;  ///< one of its bodies sleeps, and the other one sleeps, too, or is not dynamic
    kernels::JointKind kind = kernels::JointKind::rod;
    std::uint32_t next[2] = {kNoSlot, kNoSlot};  ///< the next joint in the lists of the bodies a and b
    std::uint32_t list = 0, lane = 0;            ///< the lane is 8 block + lane
    std::uint32_t body[2] = {0, 0};              ///< numbers in members_ of the sides A and B
    float impulse[JointLists::kImpulses] = {};   ///< kept while the blocks are made anew
  };
  struct ListRange {
    std::uint32_t list = 0, begin = 0, end = 0;
  };

  static std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
    return a < b ? (std::uint64_t{a} << 32 | b) : (std::uint64_t{b} << 32 | a);
  }
  void tie_all(const BodyStore& bodies);
  std::uint32_t* link_to(std::uint32_t index, std::uint32_t body);
  void tie(std::uint32_t index);
  void untie(std::uint32_t index);
  void exclude(const JointDesc& d, int sign);
  void save_impulses();
  void lay_out(const BodyStore& bodies);
  void make_jobs(const std::vector<std::uint32_t>& begin_of_colour);
  void find_members(const BodyStore& bodies, const std::vector<FixedBody>& fixed, const SolverBodies& numbers,
                    const Lattice& lattice, WorkerPool& pool);
  void find_shares(const SolverBodies& numbers);
  void fill(std::uint32_t list, std::uint32_t block);
  template <class Block>
  void fill_rows(Block& block, std::uint32_t lane, const Joint& joint) const;
  template <class Pass>
  void sweep(const kernels::BodyView& view, const Pass& pass, const kernels::JointParams& p, bool backwards,
             WorkerPool& pool);
  template <class Pass>
  void sweep_all(const kernels::BodyView& view, const Pass& pass, bool backwards, WorkerPool& pool);
  template <class Each>
  void for_shares(const Each& each, WorkerPool& pool);
  void part(const kernels::BodyView& view, const kernels::KernelTable& k, WorkerPool& pool);
  kernels::JointShare share() {
    return {share_vel_.data(), share_rim_speed_.data(), push_vel_.data(), push_rim_speed_.data()};
  }

  std::vector<Joint> joints_;
  std::vector<std::uint32_t> free_;
  std::size_t count_ = 0;
  std::unordered_map<std::uint64_t, std::uint32_t> exclusions_;  // look-up only: no order matters
  std::vector<std::uint32_t> first_;                             // by body id: the first of its joints
  std::vector<std::uint32_t> exclusive_;  // by body id: how many of its joints exclude collisions

  bool stale_ = true, bodies_stale_ = true;
  std::vector<std::uint32_t> bodies_;  // ids, ascending
  std::vector<JointMember> members_;   // in the order of bodies_
  JointLists lists_;
  std::vector<std::uint32_t> lanes_[kLists];  // by lane: the joint, or kNoSlot
  std::vector<ListRange> ranges_, share_ranges_;
  std::vector<BlockRange> jobs_, share_jobs_;  // in the ranges
  std::vector<BlockRange> phases_;             // in jobs_
  std::vector<std::uint8_t> marks_;
  std::uint32_t total_blocks_ = 0;

  std::uint32_t static_record_ = 0, padding_ = 0;
  const Lattice* lattice_ = nullptr;  // that of the last prepare
  double h_ = 0;
  int sweeps_ = 1;
  bool parted_ = false;  // true between the two calls of part_joints in a pass
  kernels::JointParams params_;
  Column<float> share_vel_, share_rim_speed_, push_vel_, push_rim_speed_;
};

}  // namespace psim
