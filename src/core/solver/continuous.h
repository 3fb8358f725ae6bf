// Continuous collision: nobody passes what is solid. Contacts foresee what lies straight ahead, once a step; this looks
// at the ways of bodies that went far for their size, or lie deep in something, after the substeps. Where such a way
// leads through fixed or kinematic geometry, the body goes up to the impact, bounces there and goes on (flight.h).
// Bullets do so at other moving bodies, too.
//
// In: the motion of the step (disp, angle_change). Out: the same motion, bent at impacts, and velocities. A shape that is
// slow for its size costs a comparison, and so does a contact of a disc with fixed geometry.
#pragma once

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "joints/joint_store.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"

namespace psim {

struct Airspace;

/// The bodies of a step for continuous collision.
struct ContinuousInput {
  const Contacts& contacts;
  const PairTable& table;
  const JointStore& joints;
  const KinematicBodies& kinematics;
  const Bullets& bullets;
  bool filters = false;              ///< some bodies do not collide with others
  double dt = 0;                     ///< s
  Vec2 gravity;                      ///< m/s^2
  double restitution_threshold = 0;  ///< m/s
  const Walls* walls = nullptr;      ///< null if the world has none
  bool surfaces = false;             ///< some surfaces run, resist rolling or are solid from one side
};

class Continuous {
 public:
  auto fields() { return std::tie(looked_); }  ///< for saved states

  /// Makes room for the bodies that stop() may have to look at: if no more than an eighth of all are fast at once, it
  /// allocates nothing.
  void make_room(const ContinuousInput& in);
  /// Bends the ways of fast bodies. Returns how many were bent.
  /// O(shapes + contacts of discs with fixed geometry), plus the shapes along the ways of fast bodies.
  std::uint32_t stop(const ContinuousInput& in);
  /// The number of fixed shapes that the last stop() tested against fast bodies.
  std::uint64_t looked() const { return looked_; }
  /// The number of bodies whose ways the last stop() looked at.
  std::uint32_t fast() const { return fast_count_; }

  void release() {
    give_back(jobs_, fast_, flying_, pressed_, partners_, kinematics_, part_boxes_, kinematic_slots_, others_);
  }
  std::size_t bytes() const {
    std::size_t sum =
        bytes_of(jobs_, fast_, flying_, pressed_, partners_, kinematics_, part_boxes_, kinematic_slots_, others_);
    for (const Job& job : jobs_) sum += bytes_of(job.found, job.near);
    return sum;
  }

 private:
  struct Job {
    std::vector<std::uint32_t> found;  // slots of bodies to look at
    std::vector<std::uint32_t> near;   // scratch of a flight
    std::uint32_t looks = 0, bent = 0;
    bool fast = false;  // somebody is
  };

  struct Kinematic {
    Bounds box;  // around its way, m from the centre of the lattice
    std::uint32_t slot;
    Bounds hull;                    // around its shape, m, in its own axes
    SineCosine turn;                // at the start of the step
    double change = 0;              // rad: how far it turns
    std::ptrdiff_t first_part = 0;  // its parts in part_boxes_
    std::ptrdiff_t parts = 0;
  };

  void note_kinematic(const Surroundings& s, std::uint32_t slot);
  void sort_kinematics(const ContinuousInput& in);
  bool may_come_upon(const Surroundings& s, std::size_t i) const;
  bool comes_upon(const Surroundings& s, std::size_t i, const Kinematic& k) const;
  void find(const ContinuousInput& in);
  void follow(const ContinuousInput& in);
  void find_shapes(const ContinuousInput& in);
  void find_deep_discs(const ContinuousInput& in);
  void find_fast_discs(const ContinuousInput& in);
  void find_pressed(const ContinuousInput& in);
  void find_bullets(const ContinuousInput& in);

  std::vector<Job> jobs_;
  std::vector<std::uint32_t> flying_;                              // slots of bodies that are looked at, ascending
  std::vector<std::uint32_t> pressed_;                             // slots of bodies deep in something, and of those
                                                                   // that kinematic bodies come upon; ascending
  std::vector<std::uint8_t> fast_;                                 // by slot: the body is a fast bullet
  std::vector<std::pair<std::uint32_t, std::uint32_t>> partners_;  // of fast bullets, by slot
  std::vector<Kinematic> kinematics_;                              // by left edge
  std::vector<Bounds> part_boxes_;                                 // around the parts of each, m, in its axes
  std::vector<std::uint32_t> kinematic_slots_, others_;            // `others_`: the partners of one bullet
  double widest_ = 0;                                              // m: their widest box
  std::uint64_t looked_ = 0;
  std::uint32_t fast_count_ = 0;
};

}  // namespace psim
