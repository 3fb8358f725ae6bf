// A world of bodies, stepped in fixed frames. Many worlds may live at once; none shares state.
// Nothing here throws on bad data, prints or exits: what is wrong comes back as a value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psim/desc.h"
#include "psim/events.h"
#include "psim/joint.h"
#include "psim/query.h"
#include "psim/report.h"

namespace psim {

/// A body as the outside sees it: doubles, by id.
struct BodyState {
  BodyId id;
  double x = 0, y = 0;   ///< metres: of its origin, BodyDesc::position
  double angle = 0;      ///< radians, not wrapped
  double vx = 0, vy = 0; ///< m/s: of the centre of mass; kinematic: of (x, y)
  double omega = 0;      ///< rad/s
  /// metres: of the circle about its centre of mass that holds it; static: 0 unless a disc
  double radius = 0;
  BodyType type = BodyType::dynamic_body;
};

/// Published columns in id order, valid until the next call that changes the world. Removed bodies
/// have no row; `id[k]` names the body of row k. All spans have the same length.
struct PublishedState {
  std::span<const std::uint32_t> id;
  std::span<const double> x, y, angle, vx, vy, omega, radius;
  std::span<const BodyType> type;
};

/// What a renderer reads, from any thread, while the next step runs: the newest complete frame.
/// `x_prev` and `x` are one step apart: draw x_prev + alpha (x - x_prev). Order is by id.
struct Snapshot {
  std::uint64_t frame = 0;
  std::vector<std::uint32_t> id;
  std::vector<float> x, y, x_prev, y_prev;  ///< metres from `origin`
  std::vector<float> angle, angle_prev, radius, speed;
  std::vector<std::uint8_t> asleep;  ///< 1: it sleeps
  Vec2 origin;
};

/// A host's own job system: psim calls `parallel_for(count, job)`; the host runs job(0..count-1) on
/// any of its threads in any order and returns when all are done.
struct JobSystem {
  std::function<void(std::size_t count, const std::function<void(std::size_t)>& job)> parallel_for;
  int workers = 1;  ///< how many of the host's threads may run jobs at once
};

/// One span of a stage on one thread, for traces. Times are nanoseconds from the first call of
/// World::start_trace.
struct TraceEvent {
  const char* name = "";
  int thread = 0;
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
};

class World {
 public:
  /// Checks the description and makes an empty world. On failure returns nothing and puts one
  /// line into `error`.
  static std::unique_ptr<World> create(const WorldDesc& desc, const RunOptions& options,
                                       std::string& error);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Adds a body; kNoBody and one line in `error` if the description is refused. Ids count from 0
  /// in the order of the calls. O(1) amortised.
  BodyId add_body(const BodyDesc& desc, std::string& error);

  /// Adds discs in bulk; returns the number added (all or none) and the first id's index in
  /// `first`; the ids are consecutive when no body was removed before. A million in well under a
  /// second.
  std::size_t add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error);

  /// Removes a body; false if the id is stale. What leaned on it falls.
  bool remove_body(BodyId id);

  bool is_valid(BodyId id) const;
  BodyId id_of(std::uint32_t index) const;
  std::optional<BodyState> body(BodyId id) const;
  /// Sets place or motion; false if the id is stale or the body static or frozen. A non-finite value
  /// is accepted and quarantines the body in the next step. In a world with walls a place beyond them
  /// becomes the nearest one within.
  bool set_transform(BodyId id, Vec2 position, double angle);
  bool set_velocity(BodyId id, Vec2 velocity, double angular_velocity);
  /// Adds impulse / mass to the velocity, N s.
  bool apply_impulse(BodyId id, Vec2 impulse);

  /// N s at a world point: turns the body too.
  bool apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point);
  /// N m s.
  bool apply_angular_impulse(BodyId id, double impulse);

  /// Changes the world's gravity, m/s^2; everybody wakes. False if it is not finite.
  bool set_gravity(Vec2 gravity);
  /// Lets bodies sleep from now on, or wakes all and keeps them awake.
  void set_sleeping(bool on);
  /// Whether a body takes part in the steps; false for static, sleeping and frozen ones.
  bool is_awake(BodyId id) const;
  /// Wakes a body that sleeps, and what is joined to it; false if the id is stale.
  bool wake(BodyId id);
  /// Why a body is awake, in one line, or that it is not.
  std::string why_awake(BodyId id) const;

  /// Ties two bodies; kNoJoint and one line in `error` if the description is refused.
  JointId add_joint(const JointDesc& desc, std::string& error);
  /// False if the id is stale. Removing a body removes its joints.
  bool remove_joint(JointId id);
  bool is_valid_joint(JointId id) const;
  std::optional<JointState> joint(JointId id) const;
  /// Revolute and prismatic: rad/s and N m, or m/s and N; a limit of 0 stops the motor. False if the id
  /// is stale, the joint of another type, or a number not finite or the limit negative.
  bool set_motor(JointId id, double speed, double limit);
  std::size_t joint_count() const;

  /// The first body that the way from `from` to `to` enters.
  std::optional<RayHit> ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter = {}) const;
  /// All of them, nearest first, then by id.
  std::vector<RayHit> ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter = {}) const;
  /// Bodies that overlap a shape placed at (position, angle), by id.
  std::vector<BodyId> overlap(const Shape& shape, Vec2 position, double angle,
                              const QueryFilter& filter = {}) const;
  /// Bodies of which some part lies in the rectangle, by id.
  std::vector<BodyId> in_region(const Bounds& region, const QueryFilter& filter = {}) const;
  /// The body nearest to a point, none within `reach` metres: nothing; of several the least id.
  std::optional<ClosestHit> closest(Vec2 point, double reach, const QueryFilter& filter = {}) const;

  /// Chooses what steps tell; nothing at first.
  void set_event_options(const EventOptions& options);
  Events events() const;

  /// Sorts the bodies and makes the lists and arrays of a step without taking one, so that the first
  /// step costs no more than the later ones: for the end of loading. Changes no result.
  void prepare();

  /// Advances by desc.dt. Deterministic: the same calls give the same bits on every ISA and any
  /// number of threads.
  StepReport step();
  /// Advances by another dt (seconds, > 0, finite) with the same number of substeps.
  StepReport step(double dt);

  /// Writes all that the world must remember to go on with the same bits, into `out`, whose memory is used
  /// again: for going back some frames, or to send a world. 50 bytes for a disc of a pile
  /// (docs/saved-states.md). Changes no result.
  void save(std::vector<std::byte>& out);
  /// Goes back to a saved state; its world had the same bounds and boundary. False and one line in `error` if
  /// it had not, or the bytes are none of a state: then nothing changed. Settings of the host stay: governor,
  /// job system, snapshots, trace. Bytes must be as `save` wrote them; those that were in a file or on a wire
  /// come through `unpack_state` (psim/saved_state.h).
  bool restore(std::span<const std::byte> state, std::string& error);
  /// A world in a saved state.
  static std::unique_ptr<World> from_state(std::span<const std::byte> state, const RunOptions& options,
                                           std::string& error);

  /// Lets a governor keep the frame's budget from now on, or no more.
  void set_governor(const GovernorDesc& desc);
  /// Measures what work costs with these options, for worlds of about so many bodies. Takes about a tenth of
  /// a second for 10,000 bodies.
  static CostModel measure_costs(const RunOptions& options, std::size_t bodies);
  /// A step with the detail that a governor chose in another run (StepReport::detail): the same bits.
  StepReport replay(const StepDetail& detail);
  StepReport replay(const StepDetail& detail, double dt);

  std::size_t body_count() const;     ///< all living bodies
  std::size_t dynamic_count() const;  ///< of those, dynamic or kinematic
  std::size_t static_count() const;
  std::uint64_t frame() const;
  std::uint64_t escaped_total() const;
  const WorldDesc& desc() const;
  Isa isa() const;
  int threads() const;

  /// 64-bit hash over every living body's position, angle and velocities in id order; signed
  /// zeros are alike. The same for every ISA, thread count and compiler. Static bodies included.
  std::uint64_t state_hash() const;
  Diagnostics diagnostics() const;
  LaneCounts lane_counts() const;
  std::size_t memory_bytes() const;
  std::vector<PlanEntry> plan() const;
  /// How many frames each stage had nothing to do or was not in the plan: name and frames.
  std::vector<std::pair<std::string, std::uint64_t>> skipped() const;

  /// Columns of every living body, built on demand.
  PublishedState published();

  /// Turns the publish stage on (it is off until someone asks): after every step a snapshot is
  /// put into a lock-free buffer. `latest_snapshot` may be called from one other thread at any
  /// time; it returns nullptr before the first frame.
  void enable_snapshots(bool on);
  const Snapshot* latest_snapshot();

  /// Replaces the world's own workers by the host's; an empty parallel_for goes back.
  void set_job_system(JobSystem jobs);

  /// Starts recording stage spans; take_trace returns and clears what was recorded.
  void start_trace();
  std::vector<TraceEvent> take_trace();

 private:
  struct Impl;
  explicit World(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Bytes that `discs` dynamic discs need before the first step, an upper estimate for checks
/// before a run.
std::size_t estimate_memory_bytes(std::size_t discs);

}  // namespace psim
