// A world of bodies, stepped in fixed frames. Many worlds may live at once; none shares state.
// Nothing here throws, prints or exits: what is wrong comes back as a value, want of memory too (out_of_memory()).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psim/api.h"
#include "psim/contact.h"
#include "psim/debug_draw.h"
#include "psim/desc.h"
#include "psim/events.h"
#include "psim/fluid.h"
#include "psim/jobs.h"
#include "psim/joint.h"
#include "psim/pre_solve.h"
#include "psim/query.h"
#include "psim/report.h"

namespace psim {

/// A body as the outside sees it: doubles, by id.
struct BodyState {
  BodyId id;         ///< its handle
  double x = 0;      ///< metres: of its origin, BodyDesc::position
  double y = 0;      ///< metres
  double angle = 0;  ///< radians, not wrapped
  double vx = 0;     ///< m/s: of the centre of mass; kinematic: of (x, y)
  double vy = 0;     ///< m/s
  double omega = 0;  ///< rad/s
  /// metres: of the circle about its centre of mass that holds it; static: 0 unless a disc
  double radius = 0;
  BodyType type = BodyType::dynamic_body;  ///< what moves it
};

/// Published columns in id order, valid until the next call that changes the world. Removed bodies
/// have no row; `id[k]` names the body of row k. All spans have the same length.
struct PublishedState {
  std::span<const std::uint32_t> id;  ///< BodyId::index
  std::span<const double> x;          ///< metres, as in BodyState
  std::span<const double> y;          ///< metres
  std::span<const double> angle;      ///< radians
  std::span<const double> vx;         ///< m/s
  std::span<const double> vy;         ///< m/s
  std::span<const double> omega;      ///< rad/s
  std::span<const double> radius;     ///< metres
  std::span<const BodyType> type;     ///< what moves it
};

/// What a renderer reads, from any thread, while the next step runs: the newest complete frame.
/// `x_prev` and `x` are one step apart: draw x_prev + alpha (x - x_prev). Order is by id.
struct Snapshot {
  std::uint64_t frame = 0;           ///< World::frame
  std::vector<std::uint32_t> id;     ///< BodyId::index
  std::vector<float> x;              ///< metres from `origin`
  std::vector<float> y;              ///< metres from `origin`
  std::vector<float> x_prev;         ///< metres: a step before
  std::vector<float> y_prev;         ///< metres
  std::vector<float> angle;          ///< radians
  std::vector<float> angle_prev;     ///< radians: a step before
  std::vector<float> radius;         ///< metres, as in BodyState
  std::vector<float> speed;          ///< m/s
  std::vector<std::uint8_t> asleep;  ///< 1: it sleeps
  Vec2 origin;                       ///< metres: the middle of the bounds
};

/// Bodies, joints and fields, and the step that moves them. One thread at a time uses a world; but between steps
/// and changes any number of threads may call its const functions at once, all but diagnostics and why_awake.
/// latest_snapshot: one other thread at any time.
class PSIM_API World {
 public:
  /// Checks the description and makes an empty world. On failure returns nothing and puts one
  /// line into `error`.
  static std::unique_ptr<World> create(const WorldDesc& desc, const RunOptions& options, std::string& error);
  /// Ends its workers. What it published is gone.
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

  /// Adds many, in their order, and writes their handles into `ids`, which has room for all. Returns how many: the first
  /// that is refused ends the call with one line in `error`, and those before it are there.
  std::size_t add_bodies(std::span<const BodyDesc> descs, std::span<BodyId> ids, std::string& error);

  /// Removes a body; false if the id is stale. What leaned on it falls.
  bool remove_body(BodyId id);

  /// Removes many; returns how many. Those whose id is stale are passed over. Bodies that sleep go together: only what
  /// touched them and stays wakes. If memory runs out (out_of_memory) some stay.
  std::size_t remove_bodies(std::span<const BodyId> ids);

  /// Whether the body is there.
  bool is_valid(BodyId id) const;
  /// The handle of the body of this index; kNoBody if there is none.
  BodyId id_of(std::uint32_t index) const;
  /// Place and motion; nothing if the id is stale. O(1).
  std::optional<BodyState> body(BodyId id) const;
  /// Where its mass is, metres; of a static body its place. Nothing if the id is stale.
  std::optional<Vec2> centre_of_mass(BodyId id) const;
  /// m/s: of the point of the body that is at `point`, metres. Nothing if the id is stale.
  std::optional<Vec2> velocity_at(BodyId id, Vec2 point) const;
  /// The smallest box about all its parts, metres; in a periodic world about the copies that are nearest to its place.
  /// Nothing if the id is stale. O(its parts).
  std::optional<Bounds> bounds_of(BodyId id) const;
  /// The parts of a body in its frame, with all that each has: as those of a CompoundShape they make such a body again.
  /// `position` is the first point of a part, of a disc its centre, and `angle` is 0; boxes come as polygons. Lines of one
  /// part end to end are a chain; of a chain whose segments have materials each is a part. `density`, of a dynamic body, is
  /// its mass over its area, the same in each part. Numbers are as the engine has them: coordinates and materials in floats.
  /// None if the id is stale. O(its parts).
  std::vector<ShapePart> shapes_of(BodyId id) const;
  /// The smallest box about one of them, metres. Nothing if there is none of this number. O(its parts).
  std::optional<Bounds> bounds_of_part(BodyId id, std::size_t number) const;
  /// Sets the place, metres and radians; false if the id is stale or the body static or frozen. A non-finite value
  /// is accepted and quarantines the body in the next step; a disabled body refuses one, and those out of
  /// their ranges (psim/limits.h). In a world with walls a place beyond them
  /// becomes the nearest one within.
  bool set_transform(BodyId id, Vec2 position, double angle);
  /// Sets the motion, m/s and rad/s; beyond the fastest that the lattice can carry it is cut to that. False as
  /// set_transform, and for numbers out of their ranges (psim/limits.h).
  bool set_velocity(BodyId id, Vec2 velocity, double angular_velocity);
  /// Adds impulse / mass to the velocity, N s. False as set_transform.
  bool apply_impulse(BodyId id, Vec2 impulse);

  /// Many bodies in one call: what the function for one does with ids[k] and the k-th values, in this order. Returns for
  /// how many it was true. 0, and nothing changes, if the spans differ in length. If memory runs out (out_of_memory) those
  /// that come later are as they were.
  ///@{
  std::size_t set_transforms(std::span<const BodyId> ids, std::span<const Vec2> positions,
                             std::span<const double> angles);
  std::size_t set_velocities(std::span<const BodyId> ids, std::span<const Vec2> velocities,
                             std::span<const double> angular_velocities);
  std::size_t apply_impulses(std::span<const BodyId> ids, std::span<const Vec2> impulses);
  std::size_t apply_forces(std::span<const BodyId> ids, std::span<const Vec2> forces);
  std::size_t set_traits_of(std::span<const BodyId> ids, std::span<const BodyTraits> traits);
  std::size_t set_enabled_of(std::span<const BodyId> ids, bool on);
  ///@}
  /// Place and motion of many bodies, into states[k] those of ids[k]; of a stale id a state whose id is kNoBody. Returns
  /// how many are there; 0, and nothing is written, if the spans differ in length.
  std::size_t states_of(std::span<const BodyId> ids, std::span<BodyState> states) const;

  /// N s at a world point, metres: turns the body too. False as set_transform.
  bool apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point);
  /// N m s: adds impulse / inertia to the angular velocity. False as set_transform.
  bool apply_angular_impulse(BodyId id, double impulse);

  /// Pushes a body at its centre of mass, N, until the next step is over, beside gravity and all other forces. Forces of
  /// several calls add up. The body wakes. False, and nothing changes, if the id is stale, the body static, disabled or
  /// frozen, or the force out of its range (psim/limits.h).
  bool apply_force(BodyId id, Vec2 force);
  /// The same at a world point, metres: turns the body too.
  bool apply_force_at(BodyId id, Vec2 force, Vec2 point);
  /// The same with a torque, N m.
  bool apply_torque(BodyId id, double torque);
  /// Pushes all dynamic bodies around a point away from it, at once, but for a disc whose centre is the point: it has no way
  /// to go. Returns how many; nothing if a number is out of its range (psim/limits.h).
  std::optional<std::size_t> explode(const Explosion& explosion);

  /// Takes a body out of the simulation for a while, or lets it come back: nothing meets it, finds it or moves it, its
  /// joints do nothing, and it costs nothing. It keeps its id, its place and its velocity; set_transform and set_velocity
  /// change those of a moving body meanwhile. What leaned on it wakes, and so does what it comes upon. False if the id is
  /// stale or the body frozen.
  bool set_enabled(BodyId id, bool on);
  /// Whether the body takes part in the world at all.
  bool is_enabled(BodyId id) const;
  /// What can be changed of a body; nothing if the id is stale.
  std::optional<BodyTraits> traits(BodyId id) const;
  /// Changes what differs from traits(id), in all parts of the body. A mass that changes alone takes the inertia with it.
  /// The body and what it touches wake. False, and nothing changes, if the id is stale, the body frozen, a number out of
  /// its range (psim/limits.h), or a static body's sensor flag another one. O(1), and the lists are made anew.
  bool set_traits(BodyId id, const BodyTraits& to);
  /// How many parts a body has: of a compound, segments of a chain with materials of its own, in a kinematic body each
  /// segment; else 1. 0 if the id is stale.
  std::uint32_t part_count(BodyId id) const;
  /// What can be changed of a part; nothing if the id is stale or there is no such part.
  std::optional<PartTraits> part_traits(BodyId id, std::uint32_t part) const;
  /// Changes a part, as set_traits does all of them. False, and nothing changes, as set_traits; also of the sensors among
  /// the parts of a static body.
  bool set_part_traits(BodyId id, std::uint32_t part, const PartTraits& to);
  /// Gives a body another description, as add_body takes it: another type, shape or place, also of a static body. It
  /// keeps its handle and its joints, whose anchors stay where they are in its frame; a joint between two bodies that
  /// are not dynamic does nothing. What it touched and what it comes upon wakes. False and one line in `error`, and
  /// nothing changes, if the id is stale, the body frozen or the description refused. The lists are made anew.
  bool set_body(BodyId id, const BodyDesc& desc, std::string& error);
  /// 64 bits that the host keeps with a body; 0 of one that has none, or is not there.
  std::uint64_t user_data(BodyId id) const;
  /// Changes them; false if the id is stale. Wakes nobody, and changes no result.
  bool set_user_data(BodyId id, std::uint64_t value);

  /// Changes the world's gravity, m/s^2; everybody wakes. False if it is out of its range (psim/limits.h).
  bool set_gravity(Vec2 gravity);
  /// Changes WorldDesc::fields: wells and drag come, go or move; everybody wakes. False and one line in `error`, and
  /// nothing changes, if one is refused. O(fields), and the lists are made anew if wells or quadratic drag were not there
  /// before or are gone.
  bool set_fields(const std::vector<Field>& fields, std::string& error);
  /// Changes WorldDesc::skin: the next step makes its lists anew. False if it is not 0.25 to 4.
  bool set_skin(double factor);
  /// Changes WorldDesc::max_bytes; nothing is given back that the world has already. A recording does not hold it.
  void set_max_bytes(std::size_t bytes);
  /// Lets bodies sleep from now on, or wakes all and keeps them awake.
  void set_sleeping(bool on);
  /// Whether a body takes part in the steps; false for static, sleeping and frozen ones.
  bool is_awake(BodyId id) const;
  /// Wakes a body that sleeps, and what is joined to it; false if the id is stale.
  bool wake(BodyId id);
  /// Why a body is awake, in one line, or that it is not. Not beside another call.
  std::string why_awake(BodyId id) const;

  /// Ties two bodies; kNoJoint and one line in `error` if the description is refused.
  JointId add_joint(const JointDesc& desc, std::string& error);
  /// False if the id is stale. Removing a body removes its joints.
  bool remove_joint(JointId id);
  /// Whether the joint is there.
  bool is_valid_joint(JointId id) const;
  /// What it does, by the state after the last step; nothing if the id is stale.
  std::optional<JointState> joint(JointId id) const;
  /// Its description: the lengths, references, stiffness and damping that follow from others are set, and `frequency` is
  /// not; nothing if the id is stale.
  std::optional<JointDesc> joint_desc(JointId id) const;
  /// Gives a joint another description of the same type and bodies, with everything else as add_joint takes it. Both
  /// bodies wake. False and one line in `error`, and nothing changes, if the id is stale or the description refused.
  bool set_joint(JointId id, const JointDesc& desc, std::string& error);
  /// distance, revolute, prismatic, wheel: rad/s and N m, or m/s and N; a limit of 0 stops the motor. Both bodies wake.
  /// False if the id is stale, the joint of another type, or a number out of its range (psim/limits.h).
  bool set_motor(JointId id, double speed, double limit);
  /// target: moves the point of the world that pulls, metres. The body wakes. False as set_motor.
  bool set_target(JointId id, Vec2 point);
  /// All joints.
  std::size_t joint_count() const;
  /// Those of a body, by index; none if the id is stale.
  std::vector<JointId> joints_of(BodyId id) const;
  /// Returns the joints whose lines a segment crosses or touches, by index. Their lines are those that debug_draw draws, from
  /// anchor to anchor and from the bodies' places to their anchors. A host that removes them has cut a rope or a net. None if a number is
  /// not finite. O(joints).
  std::vector<JointId> joints_across(Vec2 from, Vec2 to) const;

  /// Adds a fluid without particles; kNoFluid and one line in `error` if the description is refused. The first one
  /// decides how fine the grid is on which all are solved: none of a larger spacing can be added later, and the world's
  /// bounds must not have too many cells of it. Fluids stay as long as the world.
  FluidId add_fluid(const FluidDesc& desc, std::string& error);
  /// Adds particles at these places, metres, inside the world's bounds, as fast as `velocities` says, m/s, or at rest if
  /// there are none. Ids go on from those before. False and one line in `error`, and nothing changes, if there is no such
  /// fluid, the spans differ in length, a number is out of its range (psim/limits.h), or the world would have more than
  /// kMostParticles. Those within a body come out of it (docs/fluids.md). O(particles that are added).
  bool add_particles(FluidId fluid, std::span<const Vec2> positions, std::span<const Vec2> velocities,
                     std::string& error);
  /// All particles by id, into `out`, whose memory is used again. O(particles).
  void fluid_particles(std::vector<FluidParticleState>& out) const;
  /// Sums over all particles. O(particles).
  FluidReport fluid_report() const;
  /// Lets a fluid out of a segment from the end of the next step on; kNoEmitter and one line in `error` if the description
  /// is refused, or there are kMostEmitters. At the end of a step rows of particles appear where they have come to since
  /// they left the segment, with ids that go on from those before. Emitters take turns in the order of their ids.
  EmitterId add_emitter(const EmitterDesc& desc, std::string& error);
  /// False if there is no such emitter. The particles that it let out stay.
  bool remove_emitter(EmitterId id);
  /// Lets the fluid out at another speed, m/s, 0 to stop it; false if there is no such emitter, or the speed is out of its
  /// range (psim/limits.h).
  bool set_emitter_speed(EmitterId id, double speed);
  /// Removes at the end of each step the particles of all fluids that are within a rectangle, metres, which may reach out
  /// of the bounds; kNoDrain and one line in `error` if it is refused, or there are kMostDrains. What emitters let out in
  /// a step stays until the end of the next one.
  DrainId add_drain(const Bounds& region, std::string& error);
  /// False if there is no such drain.
  bool remove_drain(DrainId id);
  /// The particles of a fluid, or of all for kNoFluid, that are within a rectangle, metres. O(particles near it).
  FluidAmount fluid_in(const Bounds& region, FluidId fluid = kNoFluid) const;
  /// The particles of a fluid, or of all for kNoFluid, whose middle is within the sensor shapes of a body, where both are
  /// now; nothing if the id is stale. So a game waits until a bucket is full. O(particles near the body).
  std::optional<FluidAmount> fluid_in_sensor(BodyId id, FluidId fluid = kNoFluid) const;
  /// Returns what the pressure of fluids did to a body in the last step, 0 where it met none, or nothing if the id is stale.
  std::optional<FluidLoad> fluid_load(BodyId id) const;

  /// The first body that the way from `from` to `to` enters.
  std::optional<RayHit> ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter = {}) const;
  /// All of them, nearest first, then by id.
  std::vector<RayHit> ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter = {}) const;
  /// The first hits of many rays, on all threads of the world or the host's job system: hits[k] is what ray_cast says to
  /// rays[k], or a RayHit without a body. Returns how many rays met a body; 0, and nothing is written, if the spans differ
  /// in length. The same on any number of threads. Not beside another call.
  std::size_t ray_cast_batch(std::span<const RayInput> rays, std::span<RayHit> hits, const QueryFilter& filter = {});
  /// The first body that a convex shape, or one of the parts of a compound, meets on its way. The shape starts at `from`
  /// (metres), turned by `angle` (radians), goes `translation` (metres) and turns by `rotation` (radians, at most 1,000
  /// either way) evenly meanwhile about its own origin. Exact to 1e-6 m. Segments and chains are taken as lines.
  std::optional<ShapeCastHit> shape_cast(const Shape& shape, Vec2 from, double angle, Vec2 translation,
                                         double rotation = 0, const QueryFilter& filter = {}) const;
  /// What lies within `reach` metres of a shape placed at (position, angle), piece by piece: each segment of a chain, each
  /// part of a compound, each copy in a periodic world. The nearest come first, then by id. Writes as many as there is room
  /// for into `found` and returns how many there are.
  std::size_t nearby(const Shape& shape, Vec2 position, double angle, double reach, std::span<NearHit> found,
                     const QueryFilter& filter = {}) const;
  /// Bodies that overlap a shape placed at (position, angle), by id.
  std::vector<BodyId> overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter = {}) const;
  /// Bodies of which some part lies in the rectangle, by id.
  std::vector<BodyId> in_region(const Bounds& region, const QueryFilter& filter = {}) const;
  /// The body nearest to a point, none within `reach` metres: nothing; of several the least id.
  std::optional<ClosestHit> closest(Vec2 point, double reach, const QueryFilter& filter = {}) const;

  /// Chooses what steps tell; nothing at first.
  void set_event_options(const EventOptions& options);
  /// What the last step told.
  Events events() const;

  /// Lets the host decide new contacts of bodies that ask (BodyDesc::pre_solve), before the first step that solves them:
  /// let the parts go through each other, or change how they bounce and rub. In each step it is called at most once for
  /// all that are new, on the thread that steps, never beside another call, and the order is the same everywhere. A
  /// decision lasts until the parts are apart, and if one of the bodies sleeps, also until it woke. Numbers out of their
  /// ranges (psim/limits.h) change nothing. Contacts that touch already are new to a function that is set later. Empty:
  /// nobody is asked any more. The function may call const functions of this world that tell of one body, none that change
  /// it, and throws nothing but std::bad_alloc: then the step does not happen. A contact that only comes about within a
  /// step, after an impact with something else, is shown in the next one. It is not part of saved states, what it decided
  /// is.
  void set_pre_solve(PreSolve pre_solve);
  /// The function that was set.
  const PreSolve& pre_solve() const;

  /// What touches, as of the end of the last step: every contact that carries an impulse or overlaps, with walls
  /// and static bodies too, ordered by a, then b, then normal, then point; the same on every ISA and any number of
  /// threads. A contact's impulse is what it carried in the last substep, times the substeps: what a resting
  /// contact carries in a step, but not a blow that began and ended within it (EventOptions::hits). Sleeping
  /// bodies' contacts are told as they were when the bodies fell asleep. Places are those of now. None before the
  /// first step. Valid until the next call of this function or one that changes the world. O(contacts) a call;
  /// nothing where nobody calls.
  std::span<const Contact> contacts();
  /// Hands bodies, joints, contacts, forces, particles and bounds to the host's own drawing, as they are now: bounds first,
  /// then particles by id, bodies by id, joints by index, contacts in their order. False if a number in `options` is not finite or there was no
  /// memory; then not all is drawn. Changes no result. O(what is drawn), and contacts() if they or forces are wanted.
  bool debug_draw(DebugDraw& to, const DebugDrawOptions& options);
  /// By BodyId::index: the strip that the body lay in when the last step's lists were made. A strip is some rows of
  /// the broad phase's cells, or all large bodies; what a step does to one may run beside what it does to others
  /// (docs/step.md): even ones together, then odd ones. kNoStrip for who is in no list: static, sleeping, frozen, new,
  /// gone. The same on every ISA and any number of threads. Valid until the next call of this function or one that
  /// changes the world. O(bodies) a call.
  std::span<const std::uint32_t> strips();

  /// Makes the arrays of a step without taking one, and the lists of the first step, which then costs no more than
  /// later ones: for the end of loading, after everything was added. Changes no result: if the world is changed or
  /// asked for its contacts before the first step, that step makes the lists again. After the first step it does
  /// nothing, nor where there are contacts to be decided (set_pre_solve).
  void prepare();

  /// Advances by desc.dt. Deterministic: the same calls give the same bits on every ISA and any
  /// number of threads.
  StepReport step();
  /// Advances by another dt (seconds, > 0, at most 10: else nothing happens) with the same number of substeps.
  StepReport step(double dt);

  /// Writes all that the world must remember to go on with the same bits, into `out`, whose memory is used
  /// again: for going back some frames, or to send a world. At most 96 bytes for a disc of a pile
  /// (docs/saved-states.md). Changes no result.
  void save(std::vector<std::byte>& out);
  /// Goes back to a saved state; its world had the same bounds and boundary. False and one line in `error` if
  /// it had not, or the bytes are none of a state: then nothing changed. Settings of the host stay: governor,
  /// job system, snapshots, trace. All else is as it was saved, what steps tell, too: set_event_options of after the
  /// save has no effect any more. Bytes must be as `save` wrote them; those that were in a file or on a wire come
  /// through `unpack_state` (psim/saved_state.h).
  bool restore(std::span<const std::byte> state, std::string& error);
  /// A world in a saved state.
  static std::unique_ptr<World> from_state(std::span<const std::byte> state, const RunOptions& options,
                                           std::string& error);

  /// Lets a governor keep the frame's budget from now on, or no more.
  /// False, and nothing changes, if the budget is not above 0 or a cost is negative or not finite.
  bool set_governor(const GovernorDesc& desc);
  /// Measures what work costs with these options, for worlds of about so many bodies, of which so many are not
  /// discs. Takes about a tenth of a second for 10,000 bodies.
  static CostModel measure_costs(const RunOptions& options, std::size_t bodies, std::size_t shapes = 0);
  /// A step with the detail that a governor chose in another run (StepReport::detail): the same bits. One
  /// that none chooses (over 64 substeps, 0 or over 8 frames or frames of lists) does nothing.
  StepReport replay(const StepDetail& detail);
  /// The same by another dt, seconds.
  StepReport replay(const StepDetail& detail, double dt);

  std::size_t body_count() const;       ///< all living bodies
  std::size_t dynamic_count() const;    ///< of those that are enabled, dynamic or kinematic
  std::size_t shape_count() const;      ///< of those, not plain discs
  std::size_t static_count() const;     ///< of all that are enabled, static
  std::uint64_t frame() const;          ///< steps taken
  std::uint64_t escaped_total() const;  ///< bodies that left an open world
  const WorldDesc& desc() const;        ///< as created, with the present gravity, fields, skin and sleeping
  Isa isa() const;                      ///< that its kernels use
  int threads() const;                  ///< as created; fewer where the system starts no more

  /// 64-bit hash over every living body's position, angle and velocities in id order, and over those of every particle
  /// of a fluid; signed zeros are alike. The same for every ISA, thread count and compiler. Static bodies included.
  std::uint64_t state_hash() const;
  /// Energies, momenta and the deepest overlap. O(bodies + contacts). Not beside another call.
  Diagnostics diagnostics() const;
  /// Work done since the world was made.
  LaneCounts lane_counts() const;
  /// Counts how full the kernels' blocks are, in every 16th step from now on; nothing on Isa::scalar.
  void count_lane_use();
  /// What was counted.
  std::vector<LaneUse> lane_use() const;
  /// Bytes that the world holds.
  std::size_t memory_bytes() const;
  /// The stages and whether this world needs them.
  std::vector<PlanEntry> plan() const;
  /// How many frames each stage had nothing to do or was not in the plan: name and frames.
  std::vector<std::pair<std::string, std::uint64_t>> skipped() const;

  /// Columns of every living body, built on demand.
  PublishedState published();

  /// Turns the publish stage on (it is off until someone asks): after every step a snapshot is
  /// put into a lock-free buffer.
  void enable_snapshots(bool on);
  /// The newest snapshot, nullptr before the first. One other thread may call it at any time; what it got
  /// stays as it is until it calls again.
  const Snapshot* latest_snapshot();

  /// Replaces the world's own workers by the host's; an empty parallel_for goes back.
  void set_job_system(JobSystem jobs);

  /// Starts recording stage spans, on the first thread also its waits for the others ("wait").
  void start_trace();
  /// Steps record nothing until the next start_trace; what was recorded stays to be taken.
  void stop_trace();
  /// Returns and clears what was recorded.
  std::vector<TraceEvent> take_trace();

 private:
  struct PSIM_LOCAL Impl;
  PSIM_LOCAL explicit World(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Whether a call of this thread found no memory since it last asked here: the budget of a world (WorldDesc::max_bytes)
/// or the system gave none. Such a call changed nothing but that sleeping bodies may have woken, and its answer is empty:
/// false, none, no list. It can be made again. The one exception is StepReport::no_room_for "motion".
PSIM_API bool out_of_memory() noexcept;

/// Bytes that `discs` dynamic discs need before the first step, an upper estimate for checks
/// before a run.
PSIM_API std::size_t estimate_memory_bytes(std::size_t discs);

}  // namespace psim
