// The way of one fast body through a step, from impact to impact.
//
// In: where the body was at the start of the step (pos, angle less angle_change) and where the substeps brought it (disp,
// angle). Out: the same, if nothing solid lies between; else the way up to the first impact, on from there as the body
// bounces, up to the next one, and so on. Velocities bounce likewise. A body is never left behind a surface.
//
// O(impacts x shapes along the way).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "joints/joint_store.h"
#include "manifolds/contacts.h"
#include "solver/approach.h"
#include "solver/rates.h"

namespace psim {

/// What all flights of a step share.
struct Airspace {
  const Contacts& contacts;
  const JointStore* joints;          ///< null if no joint keeps bodies from colliding
  bool filters = false;              ///< some bodies do not collide with others
  double dt = 0;                     ///< s
  Vec2 gravity;                      ///< m/s^2, where bodies have no accelerations of their own
  double restitution_threshold = 0;  ///< m/s: slower impacts do not bounce
  const Walls* walls = nullptr;      ///< null if the world has none
  bool surfaces = false;             ///< some surfaces run, resist rolling, are solid from one side or ask the host
  std::span<const std::uint32_t> kinematics = {};  ///< slots of the bodies that the host moves, discs and shapes
};

/// How far the points of a body went in the step at most, as seen from body k, which may turn. m
float way_against(const Surroundings& s, std::size_t i, std::size_t k);

class Flight {
 public:
  /// `pressed`: something may press the body through a kinematic one, however slowly.
  Flight(const Airspace& space, std::uint32_t slot, bool pressed);

  static constexpr float kFast = 0.5f;  ///< share of its inner radius by which a fast body moves in a step
  /// A body may come this deep, as a share of its inner radius: contacts see to less, and to bodies that only tip, slide
  /// or land.
  static constexpr float kDeep = 0.5f;

  /// Follows the body past fixed and kinematic shapes and, up to the first impact with one, past moving `partners`,
  /// whose velocities may change. `near` is scratch. Returns the number of impacts.
  int run(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners = {});
  std::uint32_t looks() const { return looks_; }  ///< pieces of fixed geometry near the way

 private:
  // The other side of an impact.
  struct Other {
    Course course;               // of the whole step
    Rates way, velocity;         // in the step; in a second
    std::uint32_t id = kNoSlot;  // of the body; a wall has none
    std::uint32_t part = 0;      // of the body; or the number of the wall
    Surface has;
    Vec2 one_way;                   // in world axes: what comes against it meets this side; 0: what comes from anywhere
    bool fixed = false;             // it is fixed, or moves straight on: the sweeps see to bodies that are not too fast
    std::uint32_t piece = kNoSlot;  // of fixed geometry
    std::uint32_t slot = kNoSlot;   // of a body that the impact moves
    float inner = 1e30f;            // m
    std::uint32_t held = kNoSlot;   // of a kinematic shape
  };
  static constexpr double kTolerance = 1e-3;  // share of the inner radius to which impacts are found
  struct Impact {
    double share = Approach::kNever;
    bool pressed = false;  // deep from the start of the leg
    Vec2 normal;           // of the surface through which the middle of a pressed hull would go, or 0
    Other other;
    Hull hull;  // of the other side
    const Hull* mine = nullptr;
  };

  bool may_collide_with(std::uint32_t id) const;
  bool collide(const Hull& mine, std::uint32_t id, std::uint32_t part) const;
  std::uint32_t number_of(const Hull& mine) const { return static_cast<std::uint32_t>(&mine - hulls_.data()); }
  Surface surface_of(const Hull& mine) const;
  ContactName name_with(const Other& other, const Hull& mine) const;
  Sides sides_with(const Other& other, const Hull& mine) const;
  bool is_let_through(const Other& other, const Hull& mine) const;
  Course leg() const;
  Course course_of(std::uint32_t slot, bool held) const;
  Course rest_of(const Course& c) const;
  void find(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners);
  void find_fixed(std::vector<std::uint32_t>& near);
  void find_walls();
  void find_moving(std::uint32_t slot, bool yields);
  void meet_hulls(std::uint32_t id, Other other);
  void meet_hull(const Hull& hull, const Other& other);
  bool passes(const Approach& pair) const;
  bool is_solid(const Approach& pair, const Other& other, const Hull& mine, double share) const;
  Vec2 one_way_of(std::uint32_t id, std::uint32_t part, double angle) const;
  void find_all(std::vector<std::uint32_t>& near, std::span<const std::uint32_t> partners);
  double strikes(const Approach& pair, const Hull& mine, float inner, bool& pressed, Vec2& normal);
  Vec2 smoothed(Vec2 n, std::span<const std::uint32_t> near) const;
  double parts(const Approach& pair, const Hull& mine, double tolerance) const;
  Hull seen(std::uint32_t piece, double way) const;
  template <class Each>
  void each_beside(std::span<const std::uint32_t> near, const Each& each) const;
  bool bounce(std::span<const std::uint32_t> near);
  bool is_alike(const Rates& before) const;
  void ride();
  void store() const;

  const Airspace& space_;
  const Surroundings& s_ = space_.contacts.surroundings;
  BodyStore& b_ = s_.bodies;
  const std::uint32_t slot_;
  const bool pressed_;
  const BodyKind& kind_;
  const BodyProperties& properties_;
  std::optional<Hull> disc_;  // of a body without hulls
  std::span<const Hull> hulls_;
  float inner_ = 0;  // m
  Vec2 at_;          // m, since the start of the step
  double angle_ = 0;
  double left_ = 1;       // share of the step
  Rates way_, velocity_;  // in the step; in a second
  Vec2 fall_;             // m/s: the velocity that gravity gives in the step
  static constexpr int kMostCuts = 5;
  double cuts_[kMostCuts] = {1};  // shares of the leg where it may end: there, what bounced must not have passed
  int cut_count_ = 1;
  double sunk_ = 0;  // m: how deep the body lies in something at the start of the leg
  Impact first_;
  std::uint32_t looks_ = 0;
};

}  // namespace psim
