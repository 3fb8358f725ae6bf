// The parts of a world. Each stage takes what it needs of them; none takes the world.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "body_store.h"
#include "broad_phase.h"
#include "columns.h"
#include "contact_list.h"
#include "continuous.h"
#include "contact_store.h"
#include "events.h"
#include "forces.h"
#include "governor.h"
#include "joint_store.h"
#include "kernel_select.h"
#include "manifolds.h"
#include "narrow_phase.h"
#include "plan.h"
#include "psim/world.h"
#include "publish.h"
#include "query_index.h"
#include "sleepers.h"
#include "solver.h"
#include "solver_bodies.h"
#include "static_shapes.h"
#include "strip_speeds.h"
#include "tasks.h"
#include "trace.h"
#include "renewal.h"
#include "saved.h"
#include "worker_pool.h"

namespace psim {

/// Counters in Impl::skipped_frames, see kSkipNames.
inline constexpr std::size_t kSkipCount = kSkipNames.size();

/// The work of a step before its substeps, in order (step_work.cpp).
enum class Part : std::uint8_t {
  check, renew, measure, count, move, search, near, select, pack, group, loads, gather, sort_out, keep, colour, lay_out,
  look, stand, done
};

/// How much of a step's work is done, where it is spread over frames.
struct Ahead {
  Part part = Part::check;     // the present one
  bool sorted = false;         // bodies lie in a new order that the contacts of the last step do not know
  bool swapped = false;        // `table` is new; the contacts of the last step lie as `old_table` says
  bool built = false;          // lists are made, for this step
  bool laid = false;           // contacts are laid out or will be, for this step
  bool spread = false;         // the work may take more than a frame
  std::uint8_t waits = 0;      // frames in which time stood still
  std::uint8_t spoiled = 0;    // times that the host made it begin again
  std::uint8_t horizon = 1;    // frames that its lists are for
  std::uint32_t at = 0;        // pieces of the part that are done
};

/// Seconds of a frame, and those that a step's lists are to serve.
struct Span {
  double frame = 0, step = 0;
};

/// omega r, m/s, within what floats can square.
float surface_speed(double omega, float radius);

/// One line of what is wrong with a description, or empty.
std::string check(const WorldDesc& desc, const RunOptions& options);

struct World::Impl {
  static constexpr double kMarginFrames = 1.25;  // of motion that the lists' margin adds

  Impl(const WorldDesc& d, const RunOptions& o);

  WorldDesc desc;
  RunOptions options;
  kernels::KernelTable kernels;
  Lattice lattice;
  MemoryMeter memory;
  BodyStore bodies;
  StaticShapes shapes;
  std::vector<FixedBody> fixed;
  std::vector<BodyState> frozen;
  BroadPhase broad;
  ListRenewal renewal;
  StripSpeeds speeds;
  std::vector<float> slack;  // m, by strip: what impacts within a step may do to gaps
  PairTable table, old_table;  // what the contacts are made from
  PairTable candidates;        // loose scenes: what `table` is selected from every step
  bool loose = false;          // bodies fly: few candidates meet within a step
  bool once = false;           // the lists are for one step
  double list_frames = 0;      // that loose lists are made for; 0: one, looking ahead
  double list_span = 1;        // frames of a step that they were made for
  double select_span = 1;      // and of the last one that was selected for
  double list_reach = 0;       // m: how far a body reaches in them, about
  double list_skin = 1;        // WorldDesc::skin when they were made
  double sampled_speed = 0;    // m/s, when the lists were made
  double crowding = 0.1;
  double impact_rate = 0;  // 1/s, of a body
  SolverBodies solved;
  HeavyLoads loads;
  ContactStore contacts;
  Manifolds manifolds;
  Columns columns;
  JointStore joints;
  Continuous continuous;
  Sleepers sleepers;
  Solver solver;
  std::unique_ptr<Forces> forces;
  Publisher publisher;
  QueryIndex queries;
  EventList events;
  ContactList touching;
  Tracer tracer;
  WorkerPool pool;
  Walls walls;

  Traits traits;
  Plan plan, applied;       // applied: that the arrays are of
  bool sorted_out = false;  // manifolds had something
  float first_mass = 0, first_radius = 0;  // that Traits counts against
  Surface first_surface;
  float least_radius = 0;  // of all moving bodies so far, m
  bool plan_stale = true;
  bool lists_stale = true;
  Saved saved;
  std::unique_ptr<Impl> probe;    // what a state that comes back is read into first
  std::unique_ptr<Impl> waiting;  // and where its manifolds are until its lists are
  Ahead ahead;                  // what was done of the present step
  Governor governor;
  int substeps = 4;             // of this step
  bool detailed = false;        // this step goes by a detail: in pieces as they were with a governor
  bool kept_contacts = false;   // no list was made in this step
  std::uint64_t steps = 0;      // that did not wait
  bool forces_stale = true;
  bool placed = true;           // the host added or moved bodies since the last step
  bool impulses_valid = false;  // the table's impulses belong to the present model
  double last_substep = 0;
  std::array<float, 4> manifold_soft{};  // as their lanes have it: compliance and rate, alone and under heavy loads
  double stiff_substep = 0;  // s, that contact stiffness is for: follows the substep slowly
  std::vector<BodyId> doubtful;  // given NaN or infinity: frozen in the next step
  HeldBodies held;
  std::vector<std::uint32_t> bullets;  // ids

  std::uint64_t frame = 0;
  std::uint64_t escaped = 0;
  LaneCounts lanes;
  // world_lanes.cpp
  enum LaneKernels { kBodies, kSubsteps, kSearch, kSelection, kContacts, kFixed, kManifolds, kHulls, kJoints, kLaneKernels };
  struct Lanes {
    std::uint64_t lanes = 0, used = 0;
  };
  static constexpr std::uint64_t kLaneSteps = 16;
  std::array<Lanes, kLaneKernels> lane_use{};
  bool counting_lanes = false;
  void count_lanes(const StepReport& report);
  std::array<std::uint64_t, kSkipCount> skipped_frames{};

  // Published columns (world_state.cpp).
  std::vector<std::uint32_t> out_id;
  std::vector<double> out_x, out_y, out_angle, out_vx, out_vy, out_omega, out_radius;
  std::vector<BodyType> out_type;

  BodyId add_fixed(const BodyDesc& desc, std::string& error);  // world_fixed.cpp

  // world_plan.cpp
  void replan();
  void apply_plan();
  bool anyone_turns() const;
  Traits present_traits() const;

  // world_bodies.cpp
  BodyId add_moving(const BodyDesc& desc, std::string& error);
  std::uint32_t enter(const Surface& surface, const LatticePoint& at, double angle, Vec2 velocity,
                      double omega);
  LatticePoint lattice_centre(const Make& make, Vec2 place, double angle) const;
  void count_in(const Surface& info, int sign);
  void remove(std::uint32_t id);
  void freeze(std::uint32_t id, const BodyState& last);
  Vec2 capped(Vec2 velocity) const;

  // world_motion.cpp
  void go_round(std::uint32_t id, Vec2 velocity);
  bool can_move(const World& world, BodyId id);
  BodyState state_of(std::uint32_t id) const;

  // world_sleep.cpp
  struct EveryStrip {
    bool operator()(std::size_t) const { return true; }
  };
  template <class Each, class Wanted = EveryStrip>
  void each_contact(const Each& each, const Wanted& wanted = {}) const;
  void rest(double dt, StepReport& report);
  struct Motion {  // m/s
    float vx = 0, vy = 0, spin = 0;
    float fastest() const {
      return std::sqrt(vx * vx + vy * vy) + std::fabs(spin);
    }  ///< of its points
  };
  Motion motion_of(std::size_t slot) const {
    return {bodies.vel[2 * slot], bodies.vel[2 * slot + 1],
            bodies.spin.empty() ? 0.0f : bodies.spin[slot]};
  }
  float speed_of(std::size_t slot) const { return motion_of(slot).fastest(); }
  void room_for_sleepers();
  void choose_sleepers(double dt);
  template <class May>
  void keep_joined_awake(Column<std::uint8_t>& state, const May& may);
  void fall_asleep();
  void lie_down(std::uint32_t k);
  void wake_one(std::uint32_t id);
  bool wake(std::vector<Waking>& queue);
  bool wake_reached(double dt);
  void wake_around(std::int32_t x, std::int32_t y, float reach, std::uint32_t rings);
  void wake_touching_pieces(std::uint32_t first, std::uint32_t owner);
  void wake_all();
  std::string why_awake(std::uint32_t id) const;
  void carry_woken();
  void rouse(std::uint32_t id);
  void rouse_around(const BodyInfo& info, std::uint32_t id);

  // world_saved.cpp, world_saved_contacts.cpp
  template <class A>
  void image(A& archive, bool& lists);
  std::array<Column<float>*, 7> carried();
  bool partners_are_near(std::size_t strip) const;
  Saved::Lengths place_contacts();
  void count_carried(bool lasting);
  template <class Each>
  void each_lane(std::size_t strip, std::size_t column, const Each& each) const;
  void write_carried(std::size_t strip);
  void write_names(std::size_t strip);
  void keep_carried(Loader& loader);
  void take_pairs(Loader& loader);
  void make_pairs_again();
  void read_names(std::size_t strip);
  void take_renewed();
  bool restore(std::span<const std::byte> state, std::string& error);
  void put_manifolds();
  /// After a state came back: its pairs, the lists that it had, if they are still missing, and what was done of its
  /// step.
  /// After prepare(): all as it was. Before anything changes.
  void settle_lists() {
    if (prepared()) unprepare();
    if (saved.named) make_pairs_again();
    if (saved.missing) make_lists_again();
    if (saved.shaped) put_manifolds();
    if (saved.undone) work_again();
  }
  void make_lists_again();
  void work_again();
  bool prepared() const { return !unprepared.empty(); }
  void unprepare();
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step

  // world_joints.cpp
  void count_joints();
  void remove_joints_of(std::uint32_t body);

  QuerySource query_source() const;  // world_queries.cpp
  EventSource event_source();  // world_queries.cpp

  // world_contacts.cpp
  class StripColours;
  void find_contacts();
  bool manifold_closed(std::size_t strip, const ManifoldPair& pair, int point);
  void find_moved();
  void find_kept();
  void write_contacts();

  // strays.cpp
  static constexpr std::int32_t kFarSteps = 1
                                            << 30;  // lattice steps that nobody exceeds in a frame
  double speed_limit(double dt) const;
  void settle_bad_bodies(double dt, StepReport& report);
  void freeze_doubtful(StepReport& report);
  bool walls_hold(BlockRange blocks) const;
  void remove_escaped(StepReport& report);
  void bring_back();

  // world_prepare.cpp
  void prepare();

  // list_plan.cpp
  struct ListPlan;
  double impact_slack(double speed, double close, double dt) const;
  void measure_speeds(double dt);
  double slack_of(std::size_t strip, double dt) const;
  ListPlan plan_lists(double dt) const;
  void measure_bodies(const Span& span);
  void move_bodies(std::size_t begin, std::size_t end);

  // step.cpp
  void save(std::vector<std::byte>& out);
  std::uint32_t settle_skips(const std::array<std::uint64_t, kSkipCount>& before, bool rebuilt);
  StepReport step(double dt);
  StepReport step(double dt, const StepDetail& detail, bool choose);
  void advance(double dt, const Span& span, bool choose, StepReport& report);
  void refresh_lists(double dt, const Span& span, StepReport& report);
  bool sorts_out() const;
  double next_stiff_substep(double h) const;
  ManifoldParams manifold_params(double dt) const;
  void lay_out_manifolds(double dt);
  void solve(double dt, StepReport& report);
  void integrate(double dt, StepReport& report);
  void count_contacts(StepReport& report);

  // step_work.cpp
  void spoil_lists();
  void turn_back();
  void accept_work();
  Part after_contacts() const { return plan.shapes ? Part::look : Part::done; }
  Part after_loads() const { return sorts_out() ? Part::gather : Part::colour; }
  Part after_check() const { return loose ? Part::select : after_contacts(); }  // if lists serve
  void pushed(std::uint32_t id, const Motion& before);
  void note_work(const Span& span);
  bool contacts_stand() const;
  std::size_t pieces() const;
  void work(const Span& span, StepReport& report, std::size_t end);
  void finish_part(StepReport& report);
  void finish_work(const Span& span, StepReport& report);
  bool lists_serve(double dt);
  void check_lists(const Span& span);
  bool may_renew() const;
  void renew_lists(const Span& span, StepReport& report);
  bool put_renewed();
  void choose_solved();

  // world_governor.cpp
  void choose_detail(double dt, StepReport& report);
  void spare_room();
  bool fits_again(StepReport& report) const;
  void work_ahead(double dt, StepReport& report);
  WorkCounts count_work() const;
  Governor::Growth list_growth(int frames) const;
  std::uint64_t loaded_shape_lanes() const;
  double piece_ns(const WorkCounts& counts, std::size_t piece) const;
};

}  // namespace psim
