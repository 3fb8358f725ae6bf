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
#include <vector>

#include "base/tasks.h"
#include "psim/events.h"
#include "query/query_index.h"

namespace psim {

class EventList {
 public:
  void describe(class Archive& a, std::uint32_t ids);  ///< for saved states

  void set_options(const EventOptions& options);
  bool on() const { return options_.contacts || options_.hits || options_.sensors; }

  /// A body was removed, or frozen, which leaves its id valid (`same`).
  void body_left(BodyId id, bool same);

  /// Before the solver: notes which contacts may become hits. O(contacts), if the host asks for hits.
  void approach(const Observed& world, double dt);
  /// After the step: finds all events. O(contacts) for touching; a query for each sensor.
  void collect(const Observed& world, const QueryIndex& index);

  /// Empties the lists: nothing happens in a step that waits.
  void clear();

  Events view() const { return {begin_, end_, hits_, sensor_begin_, sensor_end_}; }
  std::size_t bytes() const;

 private:
  using Keys = std::vector<std::uint64_t>;  // a << 32 | b

  // A contact whose bodies come near at speed.
  struct Candidate {
    enum Kind : std::uint8_t { kPair, kStatic, kManifold };
    std::uint32_t at = 0;                              // the lane; of a manifold the number of its pair
    std::uint32_t slot_a = kNoSlot, slot_b = kNoSlot;  // kNoSlot: fixed
    std::uint32_t id_a = kNoSlot, id_b = kNoSlot;      // kNoSlot: a wall
    Kind kind = kPair;
    int corner = 0;         // the point of a manifold
    bool meets = false;     // the bodies meet within the step if they keep their velocities
    double nx = 0, ny = 0;  // from a to b
    double speed = 0;       // m/s, of approach
    Vec2 point;             // m
  };

  void name_lanes(const Observed& world);
  void compare_pairs(const Observed& world);
  void compare_rest(const Observed& world);
  void settle_sleepers(const Observed& world);
  void gather_sensed(const Observed& world, const QueryIndex& index);
  // event_hits.cpp
  void approach_pairs(const Observed& world, BlockRange blocks, double dt, std::vector<Candidate>& out) const;
  void approach_statics(const Observed& world, double dt);
  void approach_manifolds(const Observed& world, double dt);
  void keep_hits(const Observed& world);
  static Vec2 closing(const Observed& world, const Candidate& candidate);
  void consider(const Observed& world, Candidate candidate, Vec2 d, double reach, double gap, double dt,
                std::vector<Candidate>& out) const;
  bool fast(const Observed& world, std::uint32_t slot_a, std::uint32_t slot_b) const;
  void retire(Keys& before, Keys& ended) const;
  BodyId handle(const Observed& world, std::uint32_t id, bool gone) const;
  void tell(const Observed& world, Keys& keys, bool gone, std::vector<TouchEvent>& out) const;
  void sort(Keys& keys, std::uint32_t ids);

  EventOptions options_;
  std::vector<BodyId> removed_;  // since the last step, with the generation that they had
  bool left_ = false;            // some body was removed or frozen since the last step

  // Contacts of two discs after the last step.
  std::uint64_t build_ = 0;             // ContactStore::builds when the lanes were made
  Keys lane_key_;                       // by lane; kNoKey: padding
  std::vector<std::uint8_t> touching_;  // by block: a bit a lane
  Keys paired_;                         // the touching pairs when the lanes were made, sorted
  Keys toggled_;                        // every change since then
  // Keys of all other contacts that touch: as they were found, and sorted.
  Keys rest_found_, rest_;
  Keys slept_;  ///< touching pairs of bodies that do not move, one or both asleep; sorted
  Keys sensed_;

  Keys before_, now_, began_, ended_, scratch_;
  std::vector<std::uint32_t> count_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<Candidate>> found_;  // by task

  std::vector<TouchEvent> begin_, end_, sensor_begin_, sensor_end_;
  std::vector<HitEvent> hits_;
};

}  // namespace psim
