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

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "bodies/surroundings.h"
#include "contacts/solver_bodies.h"
#include "joint_views.h"
#include "joints/articulations.h"
#include "joints/joint_cycles.h"
#include "joints/joint_jobs.h"
#include "joints/joint_lists.h"
#include "joints/linkages.h"
#include "joints/membranes.h"
#include "joints/spring_row.h"
#include "psim/joint.h"

namespace psim {

/// Whether an id of a joint's body stands for the world.
inline bool is_world(std::uint32_t id) { return id == kWorldBody.index; }

/// A body with joints, in this frame.
struct JointMember {
  std::uint32_t number = 0;  ///< the number that the solver uses for the body, or that of a resting record
  std::uint32_t swept = 0;   ///< the same for the sweeps over joints, which may have columns of their own
  bool rests = false;        ///< it has a resting record
  LatticePoint at;           ///< without the offset of a moving body, which kernels add
  double angle = 0;
  SineCosine turn;
  Vec2 centre;  ///< m: the centre of mass in the frame of the body
  double inverse_radius = 1, rim_gain = 0;
  double inverse_mass = 0;  ///< 1/kg; 0: it is not dynamic
};

class JointStore {
 public:
  void describe(class Archive& a);  ///< for saved states; behind the bodies

  explicit JointStore(const Surroundings& s) : s_(s) {}

  /// Adds a joint. Its description was checked, and all optional values but the limits are set.
  JointId add(const JointDesc& d);
  /// Gives a joint another description of the same type and bodies, checked and set likewise.
  void change(JointId id, const JointDesc& d);
  /// Removes a joint, and with it the gears that it is part of. False if the id is stale.
  bool remove(JointId id);
  /// Forgets all joints.
  void lose_all() {
    joints_.clear();
    extras_.clear();
    linkages_.clear();
    free_extras_.clear();
    gears_.clear();
    fragile_.clear();
    count_ = exclusions_ = 0;
  }
  void remove_of_body(std::uint32_t body);

  bool any_fragile() const { return !fragile_.empty(); }
  /// All indices of joints are below this one.
  std::uint32_t indices() const { return static_cast<std::uint32_t>(joints_.size()); }
  /// The handle of the joint of an index; kNoJoint if there is none.
  JointId id_of(std::uint32_t index) const {
    return joints_[index].alive ? JointId{index, joints_[index].generation} : kNoJoint;
  }
  bool is_valid(JointId id) const {
    return id.index < joints_.size() && joints_[id.index].alive && joints_[id.index].generation == id.generation;
  }
  JointDesc desc(JointId id) const;
  /// kg or kg m^2: what the spring of a joint of these bodies moves; 0: nothing.
  static double sprung_mass(const JointDesc& d, const JointMember& a, const JointMember& b, const Lattice& lattice);
  /// A joint that was loaded in the last step, in the mean, with more than it bears.
  struct Overload {
    std::uint32_t joint = 0;
    Vec2 force;
    double torque = 0;
    double share = 0;  ///< its load, in steps of a hundredth of what it bears
  };
  /// Lists the joints that break after the last step, by index: those that it overloaded, but of the joints of one moving
  /// body only the most loaded one. When that one goes, the others bear less: a rope breaks in one place. O(joints that
  /// may break).
  std::vector<Overload> overloads() const;
  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  std::size_t bytes() const;
  std::size_t column_bytes() const {
    return share_vel_.bytes() + share_rim_speed_.bytes() + push_vel_.bytes() + push_rim_speed_.bytes() +
           push0_vel_.bytes() + push0_rim_speed_.bytes() + cycles_.bytes();
  }

  /// Gives all memory back but the generations of ids. There is no joint.
  void release_blocks();
  /// About how many lanes the passes of a step work on. Solve and relax sweep over every block sweeps() times.
  std::uint64_t lane_operations(int substeps) const {
    if (empty()) return 0;
    return std::uint64_t{2} * cycles_.count * static_cast<std::uint64_t>(substeps * sweeps()) * work_blocks() * kBlock;
  }
  /// Counts the lanes of the blocks, and how many have a joint. O(lanes).
  void count_lanes(std::uint64_t& lanes, std::uint64_t& used) const {
    for (const auto& list : lanes_) {
      lanes += list.size();
      for (const std::uint32_t joint : list) used += joint != kNoSlot;
    }
  }

  /// The force and torque of a joint on body b in the last substep, N and N m. `line`, `axis`: from its anchor a to b, and
  /// the axis of a slide, in the world. O(1).
  void load_of(JointId id, Vec2 line, Vec2 axis, Vec2& force, double& torque) const;

  /// Calls each(a, b) with the ids of the two bodies of every joint that is not left out; one may be the world's.
  template <class Each>
  void each_pair(const Each& each) const {
    for (const Joint& j : joints_) {
      if (j.alive && !j.dormant) each(j.desc.a.index, j.desc.b.index);
    }
  }
  /// The same for joints that always hold: a rope may hang loose.
  template <class Each>
  void each_tie(const Each& each) const {
    for (const Joint& j : joints_) {
      const JointType type = j.desc.type;
      const bool holds = type != JointType::rope && type != JointType::motor && type != JointType::target &&
                         type != JointType::gear && type != JointType::pulley;
      if (j.alive && !j.dormant && holds) each(j.desc.a.index, j.desc.b.index);
    }
  }
  /// Calls each(index) for the joints of a body.
  template <class Each>
  void each_of(std::uint32_t body, const Each& each) const {
    for (std::uint32_t i = first_of(body); i != kNoSlot; i = joints_[i].next_of(body)) each(i);
  }
  /// Calls each(other) with the ids of the bodies to which a body is joined; one may be the world's.
  template <class Each>
  void each_joined(std::uint32_t body, const Each& each) const {
    for (std::uint32_t i = first_of(body); i != kNoSlot;) {
      if (joints_[i].kind != kernels::JointKind::none) each(joints_[i].other(body));
      i = joints_[i].next_of(body);
    }
  }
  /// Whether a body has joints.
  bool ties(std::uint32_t body) const { return first_of(body) != kNoSlot; }
  /// A body fell asleep or woke, was disabled or enabled, or its mass or locks changed: joints of which nothing can be
  /// moved, or a side sleeps or is disabled, are left out from now on. O(joints of the body).
  void follow(std::uint32_t body);

  /// The ids of bodies with joints that are not left out, ascending; the last may be that of the world. The solver must
  /// number these bodies.
  const std::vector<std::uint32_t>& bodies();

  /// Whether a joint keeps two bodies from colliding. O(joints of the body that has fewer).
  bool joined(std::uint32_t a, std::uint32_t b) const {
    std::uint32_t i = first_of(a), j = first_of(b);
    while (i != kNoSlot && j != kNoSlot) {
      const Joint &of_a = joints_[i], &of_b = joints_[j];
      if ((of_a.other(a) == b && !of_a.desc.collide) || (of_b.other(b) == a && !of_b.desc.collide)) return true;
      i = of_a.next_of(a);
      j = of_b.next_of(b);
    }
    return false;
  }
  bool any_exclusions() const { return exclusions_ != 0; }

  /// Prepares the blocks for a frame with substeps of h seconds. `coast`: the time for which forces act in them, less
  /// where motion is damped. `calm`: bodies may sleep. `fields`: of the world.
  void prepare(const std::vector<FixedBody>& fixed, const SolverBodies& solved, double h, int substeps, double coast,
               bool calm, const std::vector<Field>& fields);

  /// Pushes the bodies of membranes as pressure and wind do in half of a substep.
  void press(const kernels::BodyView& view) {
    if (membranes_.any()) membranes_.press(view, h_ / 2, s_.pool);
  }

  void warm(const kernels::BodyView& view, float factor);
  /// `drift` and `smooth_limit2` as Articulations::solve has them.
  void solve(const kernels::BodyView& view, float drift, float smooth_limit2);
  /// Around the drift.
  void hold(const kernels::BodyView& view, const kernels::StreamParams& drift) {
    if (!cycles_.on()) hold_sweeps(view, drift);
  }
  void let_go(const kernels::BodyView& view) {
    if (!cycles_.on()) let_go_sweeps(view);
  }
  void relax(const kernels::BodyView& view);

 private:
  static constexpr std::uint32_t kBlock = kernels::kBlock;
  static constexpr std::uint32_t kLists = JointLists::kCount;
  static constexpr std::uint32_t kTether = 1u << 31;  // plus the number of a tether: as a lane has it

  /// Basics hold what most joints need of a JointDesc, under the same names; a net has a million of them.
  struct Basics {
    JointType type = JointType::distance;
    BodyId a, b;
    Vec2 anchor_a, anchor_b;
    std::optional<double> length;
    double stiffness = 0, damping = 0;
    Vec2 axis{1, 0};
    std::optional<double> reference, lower, upper;
    double motor_speed = 0, motor_limit = 0;
    bool collide = false;
  };
  /// An Extra holds what a few joints have besides: a linkage, a load that breaks it, data of the host.
  struct Extra {
    JointDesc desc;  ///< all of it
    std::uint32_t linkage = kNoSlot;
    Vec2 force;  ///< N: the sum over the substeps of the frame, of joints that may break
    double torque = 0;

    bool breaks() const { return desc.break_force > 0 || desc.break_torque > 0; }
    bool is_membrane() const { return psim::is_membrane(desc); }
  };

  struct Joint {
    std::uint32_t next[2] = {kNoSlot, kNoSlot};    ///< the next joint in the lists of the bodies a and b
    std::uint32_t before[2] = {kNoSlot, kNoSlot};  ///< the one before it
    Basics desc;
    std::uint32_t generation = 0;
    bool alive = false;
    bool swapped = false;  ///< side A is desc.b, because desc.b is not dynamic
    bool held = false;     ///< side A is not dynamic
    bool dormant = false;  ///< one of its bodies sleeps or is disabled, neither can be moved, or it does nothing
    kernels::JointKind kind = kernels::JointKind::rod;
    std::uint32_t lane = kNoSlot;               ///< 8 block + lane in its list
    std::uint32_t articulated = kNoSlot;        ///< its number in the articulations, if it is in one
    std::uint32_t extra = kNoSlot;              ///< in extras_, if it has more than the basics
    std::uint32_t body[2] = {0, 0};             ///< numbers in members_ of the sides A and B
    float impulse[JointLists::kImpulses] = {};  ///< in articulations, or while the blocks are made anew
    float gain = 0;                             ///< J: the account of an articulation

    std::uint32_t list() const { return JointLists::list_of(kind, held); }
    std::uint32_t other(std::uint32_t id) const { return desc.a.index == id ? desc.b.index : desc.a.index; }
    std::uint32_t next_of(std::uint32_t id) const { return next[desc.a.index == id ? 0 : 1]; }
    std::uint32_t& next_of(std::uint32_t id) { return next[desc.a.index == id ? 0 : 1]; }
    std::uint32_t& before_of(std::uint32_t id) { return before[desc.a.index == id ? 0 : 1]; }
    bool is_soft() const {
      return kind == kernels::JointKind::spring ||
             (desc.stiffness > 0 && (kind == kernels::JointKind::weld || kind == kernels::JointKind::linkage));
    }
    /// In the frame of the body at side A, 0, or B, 1.
    Vec2 anchor(std::uint32_t side) const { return (side != 0) == swapped ? desc.anchor_a : desc.anchor_b; }
  };

  /// The two ends that a lane joins. They lie in the order of the lanes, since a joint is large and lies elsewhere.
  struct Ends {
    std::uint32_t body[2] = {0, 0};  ///< numbers in members_
    Vec2 anchor[2];                  ///< m, in the frames of the bodies
    double length = 0;               ///< m, of rods and ropes
    bool rope = false;
  };

  struct Way;
  /// A rope from a support to a body, as long as the shortest way through joints (joint_tethers.cpp).
  struct Tether {
    std::array<std::uint32_t, 3> key;  ///< the last joint on the way, the side of the body in it, and the first joint
    std::uint32_t body[2] = {0, 0};    ///< numbers in members_
    Vec2 anchor[2];                    ///< m: in the frames of these
    double length = 0;                 ///< m
    float impulse = 0;                 ///< N s: while the blocks are made anew
    std::uint32_t lane = 0;            ///< in the list of rods that are held
  };
  /// The tethers whose ways go through a joint to its side.
  struct TetherRange {
    std::uint32_t joint = 0, side = 0;
    BlockRange tethers;
    bool operator<(const TetherRange& o) const {
      return joint != o.joint ? joint < o.joint : tethers.begin < o.tethers.begin;
    }
  };

  std::uint32_t first_of(std::uint32_t body) const { return body < first_.size() ? first_[body] : kNoSlot; }
  void link(std::uint32_t index, std::uint32_t body);
  void unlink(std::uint32_t index, std::uint32_t body);
  void link_room(const Basics& d);
  void set_desc(Joint& j, const JointDesc& d);
  void make_extra(Joint& j, const JointDesc& d);
  static kernels::JointKind kind_of(const JointDesc& d);
  void describe_extra(class Archive& a, Joint& j);
  void check(Archive& a, Joint& j);
  void drop_extra(Joint& j);
  JointId part_of_gear(const Joint& gear, int part) const {
    return part == 0 ? extras_[gear.extra].desc.joint_a : extras_[gear.extra].desc.joint_b;
  }
  std::uint32_t member_of(std::uint32_t id) const {
    return static_cast<std::uint32_t>(std::lower_bound(bodies_.begin(), bodies_.end(), id) - bodies_.begin());
  }
  float inverse_mass_of(std::uint32_t id) const { return is_world(id) ? 0 : s_.bodies.inv_mass_in_joints(id); }
  void find_ends(Linkage& l, const Joint& j) const;
  void set_membranes(const std::vector<Field>& fields);
  void lay_out_linkages();
  void set_linkages();
  void set_linkage(Linkage& l, const Joint& j) const;
  void set_drives(Linkage& l, const JointDesc& d, std::uint32_t crowd) const;
  /// A side of a joint in this frame. `world`: room for the world, which is where the anchor is.
  const JointMember& side_at(std::uint32_t member, Vec2 anchor, std::optional<JointMember>& world) const {
    if (member != world_) return members_[member];
    world = members_[member];
    world->at = s_.lattice.to_lattice(anchor);
    world->centre = anchor;
    return *world;
  }
  void add_loads();
  bool breaks_first(const Overload& load, std::span<const Overload> all) const;
  void enter(std::uint32_t index);
  void find_sides(Joint& j) const;
  void leave_lane(Joint& j);
  template <class Each>
  void each_lane(const Each& each);
  void save_impulses();
  void save_impulse(Joint& j);
  void find_articulations();
  std::vector<Way> find_ways() const;
  void find_tethers();
  void add_tethers();
  Vec2 tethered_load(std::uint32_t joint) const;
  void lay_out();
  void list_ends(std::uint32_t list);
  void count_springs(std::size_t members);
  std::vector<std::vector<std::uint32_t>> colour(std::size_t members);
  void add_jobs(const std::array<std::uint32_t, kLists>& begin, bool one_lane);
  std::uint32_t blocks_of(std::uint32_t list) const { return static_cast<std::uint32_t>(lanes_[list].size()) / kBlock; }
  std::uint32_t block_count() const {
    std::uint32_t sum = 0;
    for (std::uint32_t list = 0; list < kLists; ++list) sum += blocks_of(list);
    return sum;
  }
  int sweeps() const;
  /// Blocks, and linkages as if they were in some.
  std::uint32_t work_blocks() const { return block_count() + static_cast<std::uint32_t>(linkages_.count() + 7) / 8; }
  void find_members(const std::vector<FixedBody>& fixed, const SolverBodies& solved);
  void set_articulations(bool calm);
  void find_shares(std::uint32_t body_blocks);
  /// The most springs at one of the bodies of a joint.
  std::uint32_t crowd_of(const Joint& j) const { return std::max(springs_[j.body[0]], springs_[j.body[1]]); }
  SpringRow spring_of(double stiffness, double damping, double mass, std::uint32_t crowd) const;
  template <class Block>
  Vec2 fill_arms(Block& block, std::uint32_t lane, const Ends& ends) const;
  template <class Block>
  void fill_rows(Block& block, std::uint32_t lane, const Joint& joint, const Ends& ends) const;
  template <class Block>
  void fill_rod(Block& block, std::uint32_t lane, const Ends& ends) const;
  template <class Pass>
  void sweep(const kernels::BodyView& view, const Pass& pass, const kernels::JointParams& p, bool backwards,
             bool tethers);
  template <class Pass, class Link>
  void sweep_all(const kernels::BodyView& view, const Pass& pass, const Link& link, bool backwards);
  void part(const kernels::BodyView& view);
  void warm_sweeps(const kernels::BodyView& view, float factor);
  void solve_sweeps(const kernels::BodyView& view);
  void hold_sweeps(const kernels::BodyView& view, const kernels::StreamParams& drift);
  void let_go_sweeps(const kernels::BodyView& view);
  void relax_sweeps(const kernels::BodyView& view);
  double largest_load() const;
  bool swept_at_centres() const;
  std::uint32_t cycles_needed(double h, bool fresh) const;
  void set_cycles(double h, bool fresh, const SolverBodies& solved);
  void begin_cycles(const kernels::BodyView& view);
  void cycle(const kernels::BodyView& view, const kernels::StreamParams& drift, bool first);
  void end_cycles(const kernels::BodyView& view, double drift, double smooth_limit2);
  void run_cycles(const kernels::BodyView& view, float drift, float smooth_limit2);
  void leave_cycles(const kernels::BodyView& view);
  kernels::JointShare share() {
    return {share_vel_.data(),      share_rim_speed_.data(), push_vel_.data(),
            push_rim_speed_.data(), push0_vel_.data(),       push0_rim_speed_.data()};
  }

  const Surroundings s_;

  std::vector<Joint> joints_;
  std::vector<std::uint32_t> free_;
  std::vector<Extra> extras_;
  std::vector<std::uint32_t> free_extras_;
  Linkages linkages_;
  Membranes membranes_;
  std::vector<std::uint32_t> gears_;    // joints
  std::vector<std::uint32_t> fragile_;  // joints that may break and are not dormant, by index
  std::vector<std::uint32_t> first_;    // by body id: the first of its joints
  std::size_t count_ = 0;
  std::size_t exclusions_ = 0;  // number of joints whose bodies do not collide

  bool stale_ = true;                  // the blocks are not those of the joints
  std::vector<std::uint32_t> bodies_;  // ids, ascending
  std::vector<JointMember> members_;   // in the order of bodies_
  Articulations articulations_;
  std::vector<Tether> tethers_;
  std::vector<TetherRange> tether_ranges_;
  std::vector<std::uint8_t> swept_;     // by member: whether it has joints in blocks
  std::vector<std::uint32_t> springs_;  // by member: how many it has, but 0 if it is not dynamic
  JointLists lists_;
  std::array<std::vector<std::uint32_t>, kLists> lanes_;  // by lane: the joint, kTether for a tether, or kNoSlot
  std::array<std::vector<Ends>, kLists> ends_;            // by lane
  JointJobs jobs_;
  std::vector<BlockRange> phases_;  // in jobs_
  std::size_t joint_phases_ = 0;    // those behind are of tethers
  JointJobs shares_;                // blocks of bodies that have joints; all are of list 0
  std::vector<std::uint8_t> marks_;

  double h_ = 0;                   // s: the substep of the last prepare
  int in_step_ = 1;                // substeps of a step
  std::uint32_t world_ = kNoSlot;  // in members_
  int substeps_ = 0;               // since then
  double acting_ = 1;              // how long forces act in it, of h
  bool parted_ = false;            // true between the two calls of part_joints in a pass
  kernels::JointParams params_;
  JointCycles cycles_{s_.memory};
  Column<float> share_vel_{s_.memory}, share_rim_speed_{s_.memory}, push_vel_{s_.memory}, push_rim_speed_{s_.memory},
      push0_vel_{s_.memory}, push0_rim_speed_{s_.memory};
};

}  // namespace psim
