// What happened in a step: who began or ceased to touch, who hit whom, who entered a sensor.
//
// In: contacts before and after the solver, bodies after the step. Out: lists ordered by id, the same
// for any number of threads. Only where the host asks (World::set_event_options): else no array is
// made and no stage runs.
//
// Contacts of two discs are compared in place, a byte for eight of them, while the lists last; when
// they are made anew, the sets of touching pairs before and after are compared. All other contacts (with
// static bodies, of bodies that are not discs) are sorted where they changed: a pair may have several.
#pragma once

#include <cstdint>
#include <vector>

#include "body_store.h"
#include "contact_store.h"
#include "manifolds.h"
#include "psim/events.h"
#include "query_index.h"
#include "solver_bodies.h"
#include "static_shapes.h"
#include "worker_pool.h"

namespace psim {

/// What events are found from.
struct EventSource {
  const BodyStore& bodies;
  const SolverBodies& solved;
  const ContactStore& contacts;
  const Manifolds& manifolds;
  const StaticShapes& shapes;
  const Lattice& lattice;
  WorkerPool& pool;
  bool kinematic = false;  ///< some bodies are
  bool stepped = true;     ///< the contacts are those of this step: there was one
  bool slept = false;      ///< some bodies fell asleep or woke since the last step
};

class EventList {
  friend struct Image;

 public:
  void set_options(const EventOptions& options);
  bool on() const { return options_.contacts || options_.hits || options_.sensors; }

  /// A body was removed, or frozen (`same`: its id lives on).
  void body_left(BodyId id, bool same);

  /// Before the solver: who might hit. O(contacts), if hits are asked for.
  void approach(const EventSource& source, double dt);
  /// After the step. O(contacts) for touching, a ray's worth a sensor.
  void collect(const EventSource& source, const QueryIndex& index, const QuerySource& queries);

  /// Nothing happened in a step that waited.
  void clear();

  Events view() const { return {begin_, end_, hits_, sensor_begin_, sensor_end_}; }
  std::size_t bytes() const;

 private:
  using Keys = std::vector<std::uint64_t>;  // a << 32 | b

  // A contact whose bodies come near at speed.
  struct Candidate {
    enum Kind : std::uint8_t { kPair, kSingle, kManifold };
    std::uint32_t at = 0;                              // its lane; of a manifold its pair
    std::uint32_t slot_a = kNoSlot, slot_b = kNoSlot;  // kNoSlot: fixed
    std::uint32_t id_a = kNoSlot, id_b = kNoSlot;      // kNoSlot: a wall
    Kind kind = kPair;
    int corner = 0;         // point of a manifold
    bool meets = false;     // within the step, as they go
    double nx = 0, ny = 0;  // from a to b
    double speed = 0;       // m/s, of approach
    Vec2 point;             // m
  };

  void name_lanes(const EventSource& source);
  void compare_pairs(const EventSource& source);
  void compare_rest(const EventSource& source);
  void settle_sleepers(const EventSource& source);
  void gather_sensed(const EventSource& source, const QueryIndex& index,
                     const QuerySource& queries);
  // event_hits.cpp
  void keep_hits(const EventSource& source);
  static Vec2 closing(const EventSource& source, const Candidate& candidate);
  void consider(const EventSource& source, Candidate candidate, Vec2 d, double reach, double gap,
                double dt, std::vector<Candidate>& out) const;
  bool fast(const EventSource& source, std::uint32_t slot_a, std::uint32_t slot_b) const;
  void retire(Keys& before, Keys& ended) const;
  BodyId handle(const EventSource& source, std::uint32_t id, bool gone) const;
  void tell(const EventSource& source, Keys& keys, bool gone, std::vector<TouchEvent>& out) const;
  void sort(Keys& keys, std::uint32_t ids);

  EventOptions options_;
  std::vector<BodyId> removed_;  // since the last step, as they were called then
  bool left_ = false;            // some body was removed or frozen since the last step

  // Contacts of two discs, as of the last step.
  std::uint64_t build_ = 0;             // that the lanes are of
  Keys lane_key_;                       // by lane; kNoKey: padding
  std::vector<std::uint8_t> touching_;  // by block: a bit a lane
  Keys paired_;                         // the touching pairs when the lanes were made, sorted
  Keys toggled_;                        // and every change since
  // The others: keys of the touching ones as they were found, and sorted.
  Keys rest_found_, rest_;
  Keys slept_;  ///< touching pairs of which neither side moves, one or both asleep; sorted
  Keys sensed_;

  Keys before_, now_, began_, ended_, scratch_;
  std::vector<std::uint32_t> count_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<Candidate>> found_;  // by task

  std::vector<TouchEvent> begin_, end_, sensor_begin_, sensor_end_;
  std::vector<HitEvent> hits_;
};

}  // namespace psim
