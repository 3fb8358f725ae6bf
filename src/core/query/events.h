// What happened in a step: who began or ceased to touch, who hit whom, who entered a sensor.
//
// In: contacts before and after the solver, bodies after the step. Out: lists ordered by id, the same
// for any number of threads. If the host does not ask (World::set_event_options), no array is made and no
// stage runs.
//
// Contacts of two discs are compared in place, a byte for eight of them, while the lists last; when
// they are made anew, the sets of touching pairs before and after are compared. All other contacts (with
// static bodies, of bodies that are not discs) are sorted if they changed, since a pair may have several.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "psim/events.h"
#include "query/contact_list.h"
#include "query/fluid_events.h"
#include "query/query_index.h"

namespace psim {

/// Contacts whose bodies approach fast before the solver, and those of them that an impulse answers (event_hits.cpp).
class HitList {
 public:
  struct Candidate {
    struct Side {
      std::uint32_t slot = kNoSlot;  // kNoSlot: fixed
      std::uint32_t id = kNoSlot;    // kNoSlot: a wall
      Vec2 arm{};                    // m: of a manifold, from the centre to the point
      std::uint32_t part = 0;
    };
    Side a, b;
    const Column<float>* impulses = nullptr;  // of the lanes of discs; null: a manifold
    std::uint32_t at = 0;                     // the lane; of a manifold the number of its pair
    Vec2 normal{};                            // from a to b
    bool meets = false;                       // the bodies meet within the step if they keep their velocities
    double speed = 0;                         // m/s, of approach
    // Of a manifold with two points, the other one:
    bool two = false;
    Vec2 arm_a{}, arm_b{};   // m, from the centres
    double other_speed = 0;  // m/s, of approach; may be negative
    Vec2 point{};            // m
  };

  /// Notes the contacts whose bodies come near faster than least_speed, m/s, in a step of dt seconds.
  void approach(const Observed& world, double least_speed, double dt);
  /// Keeps the contacts that were answered: each pair once, at the highest speed.
  void collect(const Observed& world);

  std::vector<HitEvent> hits;
  std::size_t bytes() const { return bytes_of(answered_, hits); }

 private:
  std::vector<std::vector<Candidate>> found_;  // by strip; then those of shapes
  std::vector<Candidate> answered_;
};

class EventList {
 public:
  void describe(class Archive& a, std::uint32_t ids);  ///< for saved states

  void set_options(const EventOptions& options);
  bool on() const {
    const EventOptions& o = options_;
    return o.contacts || o.hits || o.sensors || o.sleep || o.moves || o.fluids;
  }

  /// A body was removed, or frozen, which leaves its id valid (`same`).
  void body_left(BodyId id, bool same) {
    left_ = true;
    if (!same) removed_.push_back(id);
  }

  /// Makes room to be told of so many bodies that are removed.
  void make_room_to_leave(std::size_t bodies) {
    const std::size_t all = removed_.size() + bodies;
    if (on() && all > removed_.capacity()) removed_.reserve(2 * all);
  }

  /// Before the solver: notes which contacts may become hits. O(contacts), if the host asks for hits.
  void approach(const Observed& world, double dt) {
    if (options_.hits) hits_.approach(world, options_.hit_speed, dt);
  }
  /// After the step: finds all events but those of sleep. O(contacts) for touching; a query for each sensor.
  void collect(const Observed& world, const QueryIndex& index, const LastStep& last, const Fluids& fluids);
  /// After bodies fell asleep: who did, and who woke. `stepped`: bodies moved. O(sleepers) if any did, O(bodies) for moves.
  void collect_sleep(const Observed& world, bool stepped);

  /// Empties the lists: nothing happens in a step that waits.
  void clear();

  /// Forgets who touched: the next step tells of all that touch then, as if they began to.
  void start_over();

  Events view() const {
    return {begin_,       end_,  hits_.hits, sensor_begin_, sensor_end_, breaks,
            fell_asleep_, woke_, moves_,     fluids_.begin, fluids_.end};
  }

  std::vector<JointBreak> breaks;  ///< of the last step, told whether or not the host asks

  std::size_t bytes() const;

 private:
  using Keys = std::vector<std::uint64_t>;  // a << 32 | b; of a wall its number is b

  void compare_lanes(const Observed& world);
  void renew_lanes(const Observed& world, std::uint32_t blocks);
  void compare_rest(const Observed& world);
  void settle_sleepers(const Observed& world);
  void gather_sensed(const Observed& world, const QueryIndex& index);
  void tell_sensed(const Observed& world);
  void replace(Keys& known, std::uint32_t ids);
  std::vector<BodyId>::const_iterator removed(std::uint32_t index) const;
  BodyId last_handle(const Observed& world, std::uint32_t id) const;
  void retire(Keys& known);
  void tell(const Observed& world, std::vector<TouchEvent>& begin, std::vector<TouchEvent>& end);
  void find_points(const Observed& world, const LastStep& last);

  EventOptions options_;
  // Since the last step, with the generation that they had; for collect() by index, then by generation.
  std::vector<BodyId> removed_;
  bool left_ = false;  // some body was removed or frozen since the last step

  // Contacts of two discs after the last step.
  std::uint64_t build_ = 0;             // ContactStore::builds when the lanes were made
  Keys lane_key_;                       // by lane; kNoKey: padding
  std::vector<std::uint8_t> touching_;  // by block: a bit a lane
  Keys paired_;                         // the touching pairs when the lanes were made, sorted
  Keys toggled_;                        // every change since then
  // Keys of all other contacts that touch: as they were found, and sorted.
  Keys rest_found_, rest_;
  Keys slept_;  ///< touching pairs of bodies that do not move, one or both asleep; sorted
  // A sensor that feels a body: sensor << 32 | body, and the number of the part that feels. Both lists are sorted.
  using Felt = std::pair<std::uint64_t, std::uint32_t>;
  std::vector<Felt> sensed_, felt_;

  Keys now_, began_, ended_, scratch_;
  std::vector<std::uint32_t> count_;

  HitList hits_;
  std::vector<TouchEvent> begin_, end_, sensor_begin_, sensor_end_;
  std::vector<std::uint8_t> began_with_;  // by id: the body is in begin_
  ContactList contacts_;                  // of these bodies

  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  std::uint64_t slept_at_ = kNever;  // Sleepers::changes when sleepers_ was made
  std::vector<BodyId> sleepers_;     // by index, as the host was told of them
  std::vector<BodyId> asleep_before_, fell_asleep_, woke_;
  std::vector<MoveEvent> moves_;
  FluidEventList fluids_;
};

}  // namespace psim
