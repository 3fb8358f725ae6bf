// Population knows who is in a world: the moving bodies, the static ones, those that are frozen, and how many there are
// of each kind.
//
// In: descriptions and changes that were checked. Out: bodies by id and by slot, fixed geometry, Traits for the plan.
// Bodies that sleep keep their ids here; where they lie is known to Sleepers. Neither lists nor contacts nor joints
// are told of a change: the world does that.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/lattice.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "bodies/traits.h"
#include "psim/desc.h"
#include "psim/world.h"

namespace psim {

/// No body moves more lattice steps than this in a frame, so that none wraps around the lattice.
inline constexpr std::int32_t kFarSteps = 1 << 30;

/// The fastest speed of the engine in a step of dt seconds, m/s.
double speed_limit(const Lattice& lattice, double dt);

/// The speeds of a body, m/s.
struct Motion {
  float vx = 0, vy = 0, rim_speed = 0;
  /// No point of the body is faster.
  float fastest() const { return std::sqrt(vx * vx + vy * vy) + std::fabs(rim_speed); }
};

class Population {
 public:
  /// Keeps references to `desc` and `lattice`.
  Population(const WorldDesc& desc, const Lattice& lattice, MemoryMeter& meter);

  /// Adds a body whose description check() accepts. kNoBody, with a line in `error`, if its shape is refused.
  BodyId add(const BodyDesc& desc, std::string& error);
  /// Makes room for so many more bodies that move, or that are fixed and of one piece.
  void make_room(std::size_t count, bool fixed);
  /// The id that the next body gets.
  std::uint32_t next_id() const { return bodies.free_ids.empty() ? bodies.id_count : bodies.free_ids.back(); }

  /// Makes room for so many bodies that go, which need no memory then. `fixed`: they are static.
  void make_room_to_leave(std::size_t bodies, bool fixed);
  /// Forgets all bodies: there was no memory to read them.
  void lose_all();
  /// Takes a body out that does not sleep. Slots may change.
  void remove(std::uint32_t id);
  /// Takes a moving body out of the simulation, because its numbers are broken. It keeps its id, and `last` as its
  /// state.
  void freeze(const BodyState& last);

  bool is_valid(BodyId id) const {
    return id.index < bodies.id_count && bodies.info[id.index].place != Place::none &&
           bodies.info[id.index].generation == id.generation;
  }
  /// The id, type and radius of a body. Its place and its motion stay 0.
  BodyState bare_state(std::uint32_t id) const;
  /// The state of a body that does not sleep.
  BodyState state_of(std::uint32_t id) const;

  /// Puts a moving body at a place, turned by `angle`.
  void place(std::uint32_t id, Vec2 position, double angle);
  void set_velocity(std::uint32_t id, Vec2 velocity, double angular_velocity);
  /// Makes the columns for rotation. Comes before a body gets its first angle or angular velocity.
  void let_turn();

  Motion motion_of(std::size_t slot) const {
    return {bodies.vel[2 * slot], bodies.vel[2 * slot + 1], bodies.rim_speed_of(slot)};
  }
  float speed_of(std::size_t slot) const { return motion_of(slot).fastest(); }
  /// A velocity that exceeds the limit of the engine would carry a body past the lattice: it is cut to the limit.
  Vec2 capped(Vec2 velocity) const;

  /// Memory that the meter does not count.
  std::size_t bytes() const {
    return bodies.property_table.bytes() + bodies.hulls.bytes() + bodies.parts.bytes() + bodies.kinds.bytes() +
           fixed.capacity() * sizeof(FixedBody) + kinematics.bytes() + bullets.bytes() + restraints.bytes();
  }

  /// Traits of the bodies that there are.
  Traits recounted() const;

  BodyStore bodies;
  StaticShapes statics;
  std::vector<FixedBody> fixed;
  std::vector<BodyState> frozen;
  KinematicBodies kinematics;
  Bullets bullets;
  Restraints restraints;
  Traits traits;
  float first_radius = 0;           ///< of the first moving body: what Traits compares with
  BodyProperties first_properties;  ///< the same of the first disc
  float least_radius = 0;           ///< m: of all moving bodies that there ever were

 private:
  void reserve(const BodyDesc& desc, std::size_t pieces);
  void forget(const BodyKind& kind);
  void enter_columns(std::uint32_t id, const BodyDesc& desc);
  void enter_statics(std::uint32_t id, const BodyDesc& desc, std::vector<Piece>& pieces);
  void leave_columns(std::uint32_t id);
  void count(const BodyProperties& properties, int sign, Traits& to) const;
  void go_round(std::uint32_t id, Vec2 velocity);

  const WorldDesc& desc_;
  const Lattice& lattice_;
};

}  // namespace psim
