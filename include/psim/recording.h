// A run written down: the state that it began with, what the host did in between, and hashes now and then. Replayed it
// gives the same bits on every ISA and number of threads, or says at which hash it does not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "psim/api.h"
#include "psim/world.h"

namespace psim {

/// Writes down what is done to a world through it. Each call does what the call of World by that name does. What
/// changes the world past the recorder is missing from the recording, and a replay will say so. A call that finds no
/// memory (out_of_memory()) ends the recording: it holds what was done before.
class PSIM_API Recorder {
 public:
  /// From the world's present state on, with a hash of the state after every `every` steps (at least 1) and at
  /// the end. The world must outlive it.
  explicit Recorder(World& world, std::uint64_t every = 60);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// As World has it.
  ///@{
  StepReport step();
  StepReport step(double dt);
  BodyId add_body(const BodyDesc& desc, std::string& error);
  std::size_t add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error);
  std::size_t add_bodies(std::span<const BodyDesc> descs, std::span<BodyId> ids, std::string& error);
  bool remove_body(BodyId id);
  std::size_t remove_bodies(std::span<const BodyId> ids);
  bool set_transform(BodyId id, Vec2 position, double angle);
  bool set_velocity(BodyId id, Vec2 velocity, double angular_velocity);
  bool apply_impulse(BodyId id, Vec2 impulse);
  std::size_t set_transforms(std::span<const BodyId> ids, std::span<const Vec2> positions,
                             std::span<const double> angles);
  std::size_t set_velocities(std::span<const BodyId> ids, std::span<const Vec2> velocities,
                             std::span<const double> angular_velocities);
  std::size_t apply_impulses(std::span<const BodyId> ids, std::span<const Vec2> impulses);
  std::size_t apply_forces(std::span<const BodyId> ids, std::span<const Vec2> forces);
  std::size_t set_traits_of(std::span<const BodyId> ids, std::span<const BodyTraits> traits);
  std::size_t set_enabled_of(std::span<const BodyId> ids, bool on);
  bool apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point);
  bool apply_angular_impulse(BodyId id, double impulse);
  bool set_body(BodyId id, const BodyDesc& desc, std::string& error);
  bool apply_force(BodyId id, Vec2 force);
  bool apply_force_at(BodyId id, Vec2 force, Vec2 point);
  bool apply_torque(BodyId id, double torque);
  std::optional<std::size_t> explode(const Explosion& explosion);
  bool set_fields(const std::vector<Field>& fields, std::string& error);
  bool set_enabled(BodyId id, bool on);
  bool set_traits(BodyId id, const BodyTraits& to);
  bool set_part_traits(BodyId id, std::uint32_t part, const PartTraits& to);
  bool set_user_data(BodyId id, std::uint64_t value);
  bool set_gravity(Vec2 gravity);
  bool set_skin(double factor);
  void set_sleeping(bool on);
  bool wake(BodyId id);
  JointId add_joint(const JointDesc& desc, std::string& error);
  bool remove_joint(JointId id);
  bool set_joint(JointId id, const JointDesc& desc, std::string& error);
  bool set_motor(JointId id, double speed, double limit);
  bool set_target(JointId id, Vec2 point);
  FluidId add_fluid(const FluidDesc& desc, std::string& error);
  bool add_particles(FluidId fluid, std::span<const Vec2> positions, std::span<const Vec2> velocities,
                     std::string& error);
  EmitterId add_emitter(const EmitterDesc& desc, std::string& error);
  bool remove_emitter(EmitterId id);
  bool set_emitter_speed(EmitterId id, double speed);
  DrainId add_drain(const Bounds& region, std::string& error);
  bool remove_drain(DrainId id);
  /// The world's present function is taken over at the start, and handed back at the end. What it decides is recorded.
  void set_pre_solve(PreSolve pre_solve);
  ///@}
  /// A detail that a governor chose in another run.
  StepReport replay(const StepDetail& detail);
  /// The same by another dt, seconds.
  StepReport replay(const StepDetail& detail, double dt);

  /// The recording up to now, with a checksum over every byte: the starting state and 48 bytes,
  /// 19 a step, 9 a hash, and what the host did.
  std::vector<std::byte> recording() const;

 private:
  struct PSIM_LOCAL Log;
  World& world_;
  std::unique_ptr<Log> log_;
};

/// Runs a recording in a world of its own.
class PSIM_API Replay {
 public:
  /// Nothing and one line in `error` if the bytes are no recording, of another format, cut or damaged.
  static std::unique_ptr<Replay> open(std::span<const std::byte> recording, const RunOptions& options,
                                      std::string& error);
  ~Replay();

  /// Does what the host did and one step; false at the end.
  bool next();
  /// The world that it runs in, in the state after the last step.
  World& world();
  std::uint64_t steps() const;         ///< done
  std::uint64_t steps_in_all() const;  ///< in the recording
  std::uint64_t hashes() const;        ///< that were compared
  /// The first step with a hash after which the state was another than recorded; 0: none yet. The first step that was
  /// another is this one or one since the hash before it: Recorder's `every` says how many those can be. 1 also if the
  /// state that it began with is another.
  std::uint64_t differs_at() const;
  /// True once all was run, as many steps as the recording says, and the last state was compared. If next() is false
  /// and this too, the recording is damaged.
  bool complete() const;

 private:
  struct PSIM_LOCAL State;
  PSIM_LOCAL explicit Replay(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Files of recordings and packed states. A file is written beside `path` under no name or one that nobody has, brought
/// to the disk, and then takes its name: whoever reads gets the old one or the new one, several that write disturb
/// nobody, and nothing is left of one that fails. It keeps the mode of the file that it replaces; behind a symbolic
/// link the file is replaced, not the link. Devices and pipes are written as they are. A file that the caller may not
/// write is refused, as is one in a folder that he may not write. False and one line in `error` that names the file.
PSIM_API bool write_bytes(const std::string& path, std::span<const std::byte> bytes, std::string& error);
/// Reads a file, or a pipe up to its end, which may have 4 GiB; devices and folders are refused.
PSIM_API bool read_bytes(const std::string& path, std::vector<std::byte>& bytes, std::string& error);

}  // namespace psim
