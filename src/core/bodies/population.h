// Population knows who is in a world: the moving bodies, the static ones, those that are frozen, and how many there are
// of each kind.
//
// In: descriptions and changes that were checked. Out: bodies by id and by slot, fixed geometry, Traits for the plan.
// Bodies that sleep keep their ids here; where they lie is known to Sleepers. Neither lists nor contacts nor joints
// are told of a change: the world does that.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/lattice.h"
#include "base/room.h"
#include "bodies/body_desc.h"
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

/// A body that the host took out of the simulation for a while.
struct DisabledBody {
  BodyState last;                                 ///< as it was, or as the host changed it since
  float linear_damping = 0, angular_damping = 0;  ///< 1/s
  std::uint32_t first_shape = 0, pieces = 0;      ///< of a static body: its hidden pieces in StaticShapes
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
  /// Takes a body out, one that sleeps after Sleep::let_go(). Slots may change.
  void remove(std::uint32_t id);
  /// Makes room for one disabled body more.
  void make_room_to_disable() { disabled.reserve(roomier(disabled)); }
  /// Takes a body that does not sleep out of the simulation for a while. It keeps its id, its place and its velocity.
  void disable(std::uint32_t id);
  /// Makes room for a disabled body to come back, which then needs no memory.
  void make_room_to_enable(std::uint32_t id);
  void enable(std::uint32_t id);
  /// A body that is being given another description, and what is needed to give it the old one back.
  struct Change {
    DisabledBody before;
    std::uint32_t row = 0;  // of its properties
    bool was_disabled = false;
    std::uint64_t user_data = 0;
  };
  /// Gives a body that does not sleep another description. Nothing, with a line in `error`, if its shape is refused. A
  /// change is then either kept or taken back.
  std::optional<Change> change(std::uint32_t id, const BodyDesc& desc, std::string& error);
  void keep(const Change& change);
  void take_back(std::uint32_t id, const Change& change);
  BodyTraits traits_of(std::uint32_t id) const;
  /// Changes a body that does not sleep. False if its traits need more kinds than there may be, or, of a static body, it
  /// would become a sensor or cease to be one.
  bool set_traits(std::uint32_t id, const BodyTraits& to);
  /// How many parts a body tells, what one of them has, and the same as set_traits() of one. False, too, of sensors of static
  /// bodies.
  std::uint32_t told_parts(std::uint32_t id) const;
  PartTraits part_traits_of(std::uint32_t id, std::uint32_t part) const;
  bool set_part(std::uint32_t id, std::uint32_t part, const PartTraits& to);
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

  /// In a world with walls, the nearest place within them.
  Vec2 within_walls(Vec2 position) const;
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
    return disabled.capacity() * sizeof(DisabledBody) + bodies.property_table.bytes() + bodies.hulls.bytes() +
           bodies.parts.bytes() + bodies.kinds.bytes() + fixed.capacity() * sizeof(FixedBody) + kinematics.bytes() +
           bullets.bytes() + restraints.bytes() + applied.bytes() + user_values.bytes();
  }

  /// Counts anew, if the first bodies, with which others are compared, may not be as they were. O(bodies).
  void recount_if_changed();
  /// Traits of the bodies that there are.
  Traits recounted() const;

  BodyStore bodies;
  StaticShapes statics;
  std::vector<FixedBody> fixed;
  std::vector<BodyState> frozen;
  std::vector<DisabledBody> disabled;
  KinematicBodies kinematics;
  Bullets bullets;
  Restraints restraints;
  AppliedForces applied;
  std::vector<std::uint32_t> borne;  ///< bodies that lie still enough in a fluid to fall asleep, by id
  UserValues user_values;
  Traits traits;
  bool traits_changed = false;      ///< the host changed those of some body since they were counted
  float first_radius = 0;           ///< of the first moving body: what Traits compares with
  BodyProperties first_properties;  ///< the same of the first disc
  float least_radius = 0;           ///< m: of all moving bodies that there ever were

 private:
  // A body that is described, before it gets its id.
  struct Newcomer {
    std::uint32_t row = 0;
    std::vector<Piece> pieces;
  };
  std::optional<Newcomer> describe(const BodyDesc& desc, std::string& error);
  void enter(std::uint32_t id, const BodyDesc& desc, Newcomer& newcomer);
  void put_user_data(std::uint32_t id, std::uint64_t value);
  void reserve(const BodyDesc& desc, std::size_t pieces);
  void forget(const BodyKind& kind);
  void enter_columns(const DisabledBody& as);
  void enter_statics(std::uint32_t id, const BodyDesc& desc, std::vector<Piece>& pieces);
  void leave_columns(std::uint32_t id);
  void leave_lists(std::uint32_t id);
  template <class Entry>
  void leave_list(std::vector<Entry>& list, std::uint32_t id);
  std::uint32_t part_count(std::uint32_t id) const;
  std::vector<PartProperties> changed_parts(std::uint32_t id, const BodyTraits& from, const BodyTraits& to) const;
  NewBody changed_body(std::uint32_t id, const BodyTraits& from, const BodyTraits& to,
                       std::vector<PartProperties> parts) const;
  bool become(std::uint32_t id, const BodyTraits& to, NewBody body);
  std::uint32_t acquire(NewBody& body, std::string& error);
  void release(std::uint32_t row);
  void count(const BodyProperties& properties, int sign, Traits& to) const;
  void go_round(std::uint32_t id, Vec2 velocity);

  const WorldDesc& desc_;
  const Lattice& lattice_;
};

// Takes the entry of a body out of a list of those that do not move. The last one takes its place.
template <class Entry>
void Population::leave_list(std::vector<Entry>& list, std::uint32_t id) {
  const std::uint32_t at = bodies.info[id].slot;
  const auto id_of = [](const Entry& e) {
    if constexpr (requires { e.last; }) {
      return e.last.id.index;
    } else if constexpr (requires { e.id.index; }) {
      return e.id.index;
    } else {
      return e.id;
    }
  };
  bodies.info[id_of(list.back())].slot = at;
  list[at] = list.back();
  list.pop_back();
}

}  // namespace psim
